// Twins of a bin whose every result is known: truth in, truth out within the stated interval; and
// what the comparison makes of films and runs that agree, differ, fail and jam.
#include "calibrate/bin_calibration.h"

#include <gtest/gtest.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "calibrate/beverloo.h"
#include "datasets/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

constexpr int particles = 200;

BulkRig rig(double orifice) {
  return {.width = 0.15,
          .orifice = orifice,
          .particle_area = 1.149e-4,
          .particle_diameter = 0.0121,
          .particle_mass = 0.332e-3};
}

// Particles that leave at regular times: the rate falls with the friction between particles, what
// stays behind grows with that of the wall, and every run has offsets of its own.
BinMeasurement run_of(const ParameterSet& parameters,
                      double orifice,
                      double noise,
                      std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal(0.0, noise);
  const double rate = 0.1 * std::pow((orifice - 0.012) / 0.088, 1.5) *
                      (1.0 - parameters.friction_particle_particle) * (1.0 + normal(generator));
  const double gap = 0.332e-3 / rate;
  const double remaining =
      5.0 + 40.0 * parameters.friction_particle_wall + 50.0 * normal(generator);
  BinMeasurement run;
  run.discharge.particles = particles;
  run.discharge.to = 3.0;
  for (int i = 0; i < particles - static_cast<int>(std::lround(remaining)); ++i) {
    if (gap * (i + 1) < run.discharge.to) run.discharge.times.push_back(gap * (i + 1));
  }
  run.flowing_density = 6.0;
  run.profile.height = 0.08;
  const double shift = 1.0 + normal(generator);
  for (std::size_t bin = 0; bin < profile_bins(rig(orifice)); ++bin) {
    const double x = 0.15 * ((static_cast<double>(bin) + 0.5) / 12.0 - 0.5);
    run.profile.samples.push_back({x, rate * shift * std::exp(-x * x / 0.002), 0.0});
  }
  return run;
}

// Every film has a bed of its own, so runs of different films scatter on their own.
Simulator simulator(double orifice, double noise, std::uint64_t film) {
  return [=](const SimulationRequest& request) {
    return SimulatedRun{.bin = run_of(request.parameters, orifice, noise, request.seed + film),
                        .time_step = 1e-5};
  };
}

constexpr std::array orifices = {0.05, 0.075, 0.085, 0.1};

// Three films an orifice at the truth; the narrowest is held out.
BinProblem problem_of(const ParameterSet& truth, double noise, std::uint64_t seed) {
  BinProblem problem;
  problem.experiment.name = "toy";
  problem.experiment.particle.count = particles;
  problem.experiment.material = {.elastic_modulus = 1e9,
                                 .poisson_ratio = 0.3,
                                 .friction_particle_particle = {0.5, 0.0},
                                 .friction_particle_wall = {0.4, 0.0},
                                 .restitution = {0.8, 0.0}};
  problem.experiment.tuned = {{"friction_particle_particle", 0.0, 0.7},
                              {"friction_particle_wall", 0.0, 0.7},
                              {"restitution", 0.3, 0.95}};
  std::vector<FilmedBin> films, calibrated;
  const auto seeds = make_seeds(seed, "films", 12);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const double orifice = orifices[i / 3];
    films.push_back({std::to_string(i), rig(orifice), run_of(truth, orifice, noise, seeds[i])});
    problem.starts.push_back({.rig = rig(orifice), .held_out = orifice < 0.06});
    problem.starts.back().experiment = problem.experiment;
    if (orifice < 0.06) continue;
    calibrated.push_back(films.back());
    problem.calibrated_films.push_back(i);
  }
  problem.all = std::make_shared<BinComparison>(films);
  problem.calibrated = std::make_shared<BinComparison>(calibrated);
  return problem;
}

BinCalibrationResult calibrated(const BinProblem& problem, double noise, std::uint64_t seed) {
  const TemporaryFolder folder;
  Journal journal(folder / "j.db");
  std::vector<Scene> scenes, all;
  for (std::size_t i = 0; i < problem.starts.size(); ++i) {
    const Scene scene{std::to_string(i), simulator(problem.starts[i].rig.orifice, noise, i)};
    all.push_back(scene);
    if (!problem.starts[i].held_out) scenes.push_back(scene);
  }
  Ensemble searched(scenes, journal, problem.calibrated, 2);
  Ensemble every(all, journal, problem.all, 2);
  CalibrationOptions options = bin_options();
  options.seed = seed;
  options.jobs = 2;
  options.largest_time_step_fraction = 0.05;
  return calibrate_bin(problem, searched, every, options);
}

std::vector<SimulatedRun> runs_of(const BinComparison& films) {
  std::vector<SimulatedRun> runs;
  for (const FilmedBin& film : films.films()) runs.push_back({.bin = film.measured});
  return runs;
}

TEST(BinComparison, RunsThatEqualTheFilmsHaveNoObjective) {
  const BinProblem problem = problem_of({0.3, 0.3, 0.7}, 0.03, 1);
  EXPECT_NEAR(problem.all->objective(runs_of(*problem.all)), 0.0, 1e-15);
}

// z = (S - D)/(s sqrt(2/n)) for the rates alone, all other quantities being equal.
TEST(BinComparison, RatesCountByTheirOwnScatter) {
  const BinProblem problem = problem_of({0.3, 0.3, 0.7}, 0.03, 1);
  std::vector<SimulatedRun> runs = runs_of(*problem.all);
  const double change = 0.05;
  for (SimulatedRun& run : runs) {
    for (double& time : run.bin.discharge.times) time /= 1.0 + change;
  }
  const double z = change / (problem.all->scatter().relative_rate * std::sqrt(2.0 / 3.0));
  EXPECT_NEAR(problem.all->shares(runs)[0].value, pseudo_huber(z), 1e-9);
  EXPECT_EQ(problem.all->shares(runs)[1].value, 0.0);
  EXPECT_EQ(problem.all->scatter().freedom, 8);
}

TEST(BinComparison, FailedAndJammedRunsAreResults) {
  const BinProblem problem = problem_of({0.3, 0.3, 0.7}, 0.03, 1);
  std::vector<SimulatedRun> runs = runs_of(*problem.all);
  double last = problem.all->objective(runs);
  for (SimulatedRun& run : runs) {
    run.status = RunStatus::unstable;
    run.bin = {};
    const double objective = problem.all->objective(runs);
    ASSERT_TRUE(std::isfinite(objective));
    EXPECT_GT(objective, last);
    last = objective;
  }
  EXPECT_TRUE(std::isfinite(problem.all->noise(runs)));
  // A jam after ten particles
  for (SimulatedRun& run : runs) {
    run.status = RunStatus::completed;
    run.bin.discharge = {
        .particles = particles, .over_orifice = 30, .to = 3.0, .times = {0.01, 0.02, 0.03}};
  }
  EXPECT_GT(problem.all->objective(runs), 1.0);
  EXPECT_TRUE(std::isfinite(problem.all->score_run(runs[0], 0).objective));
}

// Rates that all change by the same share change C by that share and nothing else.
TEST(BinComparison, ComparesLawsInTheRequestedForm) {
  const BinProblem problem = problem_of({0.3, 0.3, 0.7}, 0.03, 1);
  const auto laws = problem.calibrated->with_form(datasets::ObjectiveForm::requested);
  ASSERT_NE(laws, nullptr);
  std::vector<SimulatedRun> runs = runs_of(*problem.calibrated);
  EXPECT_NEAR(laws->objective(runs), 0.0, 1e-12);
  const double change = 0.05;
  for (SimulatedRun& run : runs) {
    for (double& time : run.bin.discharge.times) time /= 1.0 + change;
  }
  const std::vector<double> z = laws->residuals(runs);
  ASSERT_EQ(z.size(), 2U + 3U);  // C, k, and B of three orifices
  // The standard error of C as the fit to the films' means states it; both means scatter alike.
  std::vector<DischargeRate> rates;
  for (const OrificeMean& orifice : problem.calibrated->orifices()) {
    rates.push_back({.orifice = orifice.orifice,
                     .rate = orifice.mean.rate,
                     .density = orifice.mean.density,
                     .particle_diameter = rig(orifice.orifice).particle_diameter,
                     .standard_uncertainty = problem.calibrated->scatter().relative_rate *
                                             orifice.mean.rate / std::sqrt(3.0)});
  }
  const LeastSquaresFit fit = fit_beverloo(BeverlooLaw::slot, rates, rig(0.1).gravity);
  const double expected = change * fit.parameters[0] / (std::sqrt(2.0) * fit.standard_error(0));
  EXPECT_NEAR(z[0], expected, 0.02 * expected);
  EXPECT_NEAR(z[1], 0.0, 1e-3);
  for (std::size_t i = 2; i < z.size(); ++i) EXPECT_NEAR(z[i], 0.0, 1e-9);
  EXPECT_EQ(laws->loss(z), laws->objective(runs));
  const Comparison& smooth = *problem.calibrated;
  EXPECT_EQ(smooth.loss(smooth.residuals(runs)), smooth.objective(runs));
  EXPECT_NEAR(laws->objective(runs), pseudo_huber(z[0]) / 3.0, 1e-6);
  EXPECT_GT(laws->noise(runs), 0.0);
  // Profiles twice as wide have a larger B, and nothing else changes
  runs = runs_of(*problem.calibrated);
  for (SimulatedRun& run : runs) {
    for (VelocitySample& sample : run.bin.profile.samples)
      sample.velocity = std::sqrt(std::max(sample.velocity, 0.0));
  }
  const std::vector<double> wide = laws->residuals(runs);
  EXPECT_NEAR(wide[0], 0.0, 1e-9);
  for (std::size_t i = 2; i < wide.size(); ++i) EXPECT_GT(wide[i], 1.0);
}

TEST(BinComparison, ScoresJamsByTheirLawsAndRefusesCurvesThatTellNone) {
  BinProblem problem = problem_of({0.3, 0.3, 0.7}, 0.03, 1);
  const auto laws = problem.calibrated->with_form(datasets::ObjectiveForm::requested);
  std::vector<SimulatedRun> runs = runs_of(*problem.calibrated);
  double last = 0.0;
  for (SimulatedRun& run : runs) {
    run.status = RunStatus::unstable;
    run.bin = {};
    const double objective = laws->objective(runs);
    ASSERT_TRUE(std::isfinite(objective));
    last = objective;
  }
  EXPECT_GT(last, 1.0);
  EXPECT_TRUE(std::isfinite(laws->noise(runs)));
  std::vector<FilmedBin> curves = problem.calibrated->films();
  for (FilmedBin& film : curves) film.measured.flowing_density = 0.0;
  EXPECT_EQ(BinComparison(curves).with_form(datasets::ObjectiveForm::requested), nullptr);
  EXPECT_NE(BinComparison(curves).with_form(datasets::ObjectiveForm::smooth), nullptr);
}

TEST(BinCalibration, RecoversAKnownTruthAndPredictsWhatWasHeldOut) {
  const ParameterSet truth{0.25, 0.35, 0.7};
  const BinCalibrationResult result = calibrated(problem_of(truth, 0.02, 7), 0.02, 3);
  for (const CalibratedParameter& parameter : result.calibrated) {
    if (parameter.name == "restitution") {
      EXPECT_EQ(parameter.status, ParameterStatus::not_identified);
      continue;
    }
    const double expected = value_of(truth, parameter.name);
    ASSERT_TRUE(parameter.interval.has_value()) << parameter.name;
    EXPECT_LE(parameter.interval->lower, expected) << parameter.name;
    EXPECT_GE(parameter.interval->upper, expected) << parameter.name;
  }
  ASSERT_EQ(result.score.orifices.size(), orifices.size());
  for (const OrificeComparison& row : result.score.orifices) {
    EXPECT_EQ(row.held_out, row.orifice < 0.06);
    EXPECT_LE(std::abs(row.error()), 3.0 * row.validation_uncertainty()) << row.orifice;
    EXPECT_GT(row.curve_inside, 0.9) << row.orifice;
    EXPECT_EQ(row.simulated_jams.happened, 0);
  }
  ASSERT_TRUE(result.score.filmed.beverloo && result.score.simulated.beverloo);
}

TEST(BinCalibration, CountsAPrior) {
  const ParameterSet truth{0.25, 0.35, 0.7};
  BinProblem problem = problem_of(truth, 0.02, 7);
  problem.experiment.tuned[0].prior = {0.25, 0.01};
  const BinCalibrationResult result = calibrated(problem, 0.02, 3);
  const CalibratedParameter& particle = result.calibrated[0];
  ASSERT_TRUE(particle.data_alone.has_value());
  ASSERT_TRUE(particle.interval.has_value());
  EXPECT_LT(particle.interval->upper - particle.interval->lower,
            particle.data_alone->interval.upper - particle.data_alone->interval.lower);
  EXPECT_NEAR(particle.value, 0.25, 0.01);
  EXPECT_LE(particle.interval->lower, 0.25);
  EXPECT_GE(particle.interval->upper, 0.25);
}

TEST(BinCalibration, ItsIntervalsHoldTheTruthAboutAsOftenAsTheySay) {
  constexpr int twins = 12;
  int held = 0, asked = 0;
  for (int twin = 0; twin < twins; ++twin) {
    const double share = (twin + 0.5) / twins;
    const ParameterSet truth{0.1 + 0.5 * share, 0.6 - 0.5 * share, 0.7};
    const auto seed = static_cast<std::uint64_t>(twin);
    const BinCalibrationResult result = calibrated(problem_of(truth, 0.02, 50 + seed), 0.02, seed);
    for (const CalibratedParameter& parameter : result.calibrated) {
      if (!parameter.interval) continue;
      const double expected = value_of(truth, parameter.name);
      ++asked;
      held += parameter.interval->lower <= expected && expected <= parameter.interval->upper;
    }
  }
  // Of 24 intervals at 95 %, fewer than 19 hold the truth with probability 0.1 % (binomial).
  EXPECT_GE(asked, 22);
  EXPECT_GE(held, asked * 19 / 24) << held << " of " << asked;
}

TEST(Probability, IsJeffreysInterval) {
  // Brown, Cai and DasGupta (2001), table 5: n = 7, x = 0 and x = 2
  EXPECT_NEAR(probability_of(0, 7).upper, 0.292, 5e-4);
  EXPECT_EQ(probability_of(0, 7).lower, 0.0);
  EXPECT_NEAR(probability_of(2, 7).lower, 0.065, 5e-4);
  EXPECT_NEAR(probability_of(2, 7).upper, 0.648, 5e-4);
}

}  // namespace
}  // namespace graintruth::calibrate
