// Runs out of a bin, filmed and simulated, compared by what was measured of them: steady rates,
// what stays behind, and velocity profiles. Every simulation starts from the bed of one film and is
// compared with that film's orifice.
#pragma once

#include <string>

#include "calibrate/bulk_measure.h"
#include "calibrate/comparison.h"

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
  // scatter alike. A kind counts once, however many numbers it has.
  double objective(std::span<const SimulatedRun> runs) const override;
  std::vector<double> residuals(std::span<const SimulatedRun> runs) const override;
  double noise(std::span<const SimulatedRun> runs) const override;
  RunScore score_run(const SimulatedRun& run, std::size_t scene) const override;
  // Residuals of films against their simulations, about the mean of their orifice, are drawn anew
  // for every orifice from all orifices together: with three films each, an orifice alone has too
  // few to draw from.
  std::vector<std::vector<double>> draw_objectives(std::span<const Evaluation> evaluations,
                                                   const BootstrapOptions& options) const override;
  double significance() const override;
  double allowed_excess(const Evaluation& best,
                        const Evaluation& evaluation,
                        double roughness,
                        const BootstrapOptions& options) const override;
  // Null: an evaluation has one simulation of every film, and none to spare.
  std::unique_ptr<Comparison> with_replicates(std::span<const SimulatedRun> runs) const override;

  // Shares of J at these runs: rates, remaining, velocities.
  struct Shares {
    double rate = 0.0, remaining = 0.0, velocity = 0.0;
    int kinds = 3;  // 2 where no velocities are known
    double total() const { return (rate + remaining + velocity) / kinds; }
  };
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
  // z of one orifice: its rate, its remaining particles, its velocities (NaN where none was seen).
  std::vector<double> residuals_of(const Differences& difference, const OrificeMean& orifice) const;
  Shares shares_of(const std::vector<Differences>& of_orifices) const;

  std::vector<FilmedBin> films_;
  std::vector<BinNumbers> numbers_;  // of the films
  std::vector<OrificeMean> orifices_;
  BinScatter scatter_;
};

}  // namespace graintruth::calibrate
