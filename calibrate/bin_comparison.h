// Runs out of a bin, filmed and simulated, compared by what was measured of them: steady rates,
// what stays behind, and velocity profiles; or by the constants of the laws that the thesis fits to
// these. Every simulation starts from the bed of one film and is compared with that film's orifice.
#pragma once

#include <optional>
#include <string>

#include "calibrate/bulk_measure.h"
#include "calibrate/comparison.h"
#include "calibrate/flow_laws.h"

namespace graintruth::calibrate {

// One film of a bin.
struct FilmedBin {
  std::string name;
  BulkRig rig;
  BinMeasurement measured;
};

// The numbers by which a run is compared. Never NaN but where no particle passed a bin of the
// velocity profile.
struct BinNumbers {
  double rate = 0.0;             // kg/s; steady, or mean over the run where nothing was steady
  double remaining = 0.0;        // particles in the bin at the end
  double density = 0.0;          // kg/m2, of the flowing bed; 0 where it is not known
  std::vector<double> velocity;  // m/s, downwards; one a bin across, see measure_profile
};
BinNumbers numbers_of(const BinMeasurement& measured, const BulkRig& rig);

// How exactly replicates repeat each other, pooled over orifices: standard deviations of one film.
struct BinScatter {
  double relative_rate = 0.0;      // of the orifice's mean rate
  double remaining = 0.0;          // particles
  double relative_velocity = 0.0;  // of the orifice's largest mean velocity
  int freedom = 0;
};

// All films of one orifice, averaged.
struct OrificeMean {
  double orifice = 0.0;            // m
  std::vector<std::size_t> films;  // of the comparison
  BinNumbers mean;
  double largest_velocity = 0.0;  // m/s
};

class BinComparison final : public Comparison {
 public:
  // At least one orifice needs two films: their scatter is the only measure of how exactly a rate
  // is known. Scenes of the ensemble are the films, in this order.
  explicit BinComparison(std::vector<FilmedBin> films);

  const std::vector<FilmedBin>& films() const { return films_; }
  const std::vector<OrificeMean>& orifices() const { return orifices_; }
  const BinScatter& scatter() const { return scatter_; }

  // J = mean over the kinds (velocities only where any film has them) of the mean of rho(z), z =
  // (S - D)/u, rho of objective.h, with D
  // and S the means over an orifice's films and their simulations, and u = s sqrt(2/n): both
  // scatter alike. A kind counts once, however many numbers it has. Kinds of the smooth form are
  // rates, remaining particles and velocities; of the requested one Beverloo's C, his k, and the
  // kinematic B of each orifice.
  double objective(std::span<const SimulatedRun> runs) const override;
  std::vector<double> residuals(std::span<const SimulatedRun> runs) const override;
  std::size_t residual_count() const override { return kinds_.size(); }
  double loss(std::span<const double> residuals) const override;
  double noise(std::span<const SimulatedRun> runs) const override;
  // By the smooth form: one orifice tells no law.
  RunScore score_run(const SimulatedRun& run, std::size_t scene) const override;
  // Objectives of the same evaluations, [draw][evaluation], when films could have been others:
  // residuals of films against their simulations, about the mean of their orifice, are drawn anew
  // for every orifice from all orifices together, because with three films each an orifice alone
  // has too few to draw from.
  std::vector<std::vector<double>> draw_objectives(std::span<const Evaluation> evaluations,
                                                   const BootstrapOptions& options) const;
  double half_width_of_difference(const Evaluation& first,
                                  const Evaluation& second,
                                  const PooledChance& chance,
                                  const BootstrapOptions& options) const override;
  double allowed_excess(const Evaluation& best,
                        const Evaluation& evaluation,
                        const PooledChance& chance,
                        const BootstrapOptions& options) const override;
  // Null: an evaluation has one simulation of every film, and none to spare.
  std::unique_ptr<Comparison> with_replicates(std::span<const SimulatedRun> runs) const override;
  std::unique_ptr<Comparison> with_form(datasets::ObjectiveForm form) const override;
  datasets::ObjectiveForm form() const override {
    return laws_ ? datasets::ObjectiveForm::requested : datasets::ObjectiveForm::smooth;
  }

  // What each kind of quantity adds to J at these runs: the mean of its rho(z). J is their mean.
  struct Share {
    std::string_view kind;
    double value = 0.0;
  };
  using Shares = std::vector<Share>;
  Shares shares(std::span<const SimulatedRun> runs) const;
  // Mean over the simulations of an orifice's films, kg/s; a run that did not complete counts as 0.
  double simulated_rate(const OrificeMean& orifice, std::span<const SimulatedRun> runs) const;

 private:
  struct Differences;
  std::vector<Differences> differences(std::span<const SimulatedRun> runs) const;
  Differences mean_difference(const std::vector<Differences>& of_runs,
                              const OrificeMean& orifice,
                              std::size_t seeds,
                              std::size_t left_out) const;
  std::vector<Differences> mean_differences(std::span<const SimulatedRun> runs) const;
  // What is compared, orifice after orifice, and its z. How many there are, and of what, depends on
  // the films alone.
  struct Residual {
    std::string_view kind;
    double z = 0.0;
  };
  std::vector<Residual> residuals_of(const std::vector<Differences>& of_orifices) const;
  static Shares shares_of(const std::vector<Residual>& residuals);
  double objective_of(const std::vector<Differences>& of_orifices) const;
  // The means of the films, or with these differences those of their simulations.
  std::vector<MeanFlow> mean_flows(const std::vector<Differences>* of_orifices) const;
  // The laws of the films, and the scatter of what is compared of them.
  struct Laws {
    FlowLaws filmed;
    BeverlooUncertainty uncertainty;  // of C and k of one mean
    double relative_B = 0.0;          // standard deviation of one film, pooled over orifices
  };
  // Whether the films tell the constants of the flow's laws, which the requested form needs: two
  // orifices through which particles flow, and how densely the bed lies.
  bool tells_laws() const;
  // None where no constants fit the films.
  std::optional<Laws> learn_laws() const;
  std::vector<Residual> law_residuals(const std::vector<Differences>& of_orifices) const;
  void learn_kinds();

  std::vector<FilmedBin> films_;
  std::vector<BinNumbers> numbers_;  // of the films
  std::vector<OrificeMean> orifices_;
  BinScatter scatter_;
  std::optional<Laws> laws_;             // of the requested form alone
  std::vector<std::string_view> kinds_;  // of the residuals
};

}  // namespace graintruth::calibrate
