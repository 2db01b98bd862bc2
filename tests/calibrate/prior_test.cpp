// Priors where everything is known in closed form: an objective that is a parabola about what the
// replicates ask for, and replicates that ask for it with a known standard deviation s. With a
// prior m +- u the answer is the mean weighted by 1/s^2 and 1/u^2.
#include "calibrate/knowledge/prior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibrate/parameters.h"
#include "calibrate/search/search.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

constexpr double t = 1.96;

// J = J0 + h/2 (((pp - b)/s)^2 + ((pw - b)/s)^2), or of their sum alone; restitution has no effect.
struct Parabola {
  double b_particle = 0.25, s_particle = 0.02;
  double b_wall = 0.3, s_wall = 0.03;
  bool of_the_sum = false;

  std::vector<double> residuals(const ParameterSet& p) const {
    const double particle = p.of("friction_particle_particle") - b_particle;
    const double wall = p.of("friction_particle_wall") - b_wall;
    if (of_the_sum) return {(particle + wall) / s_wall};
    return {particle / s_particle, wall / s_wall};
  }
  static double of(std::span<const double> residuals) {
    constexpr double lowest = 0.05, steepness = 0.02;
    double squares = 0.0;
    for (const double z : residuals) squares += z * z;
    return lowest + 0.5 * steepness * squares;
  }
  double operator()(const ParameterSet& p) const { return of(residuals(p)); }
};

// A run's tracks are one pose that holds its parameters.
const toy::ClosedEngine engine([](const SimulationSpec& spec) {
  datasets::Trajectories tracks = datasets::make_trajectories(1, 1, false);
  tracks.poses[0] = {spec.parameters.of("friction_particle_particle"),
                     spec.parameters.of("friction_particle_wall"),
                     0.0};
  return toy::as_run(std::move(tracks));
});

class ParabolaComparison final : public Comparison {
 public:
  explicit ParabolaComparison(const Parabola& parabola) : parabola_(parabola) {}
  double objective(std::span<const SimulatedRun> runs) const override {
    return parabola_(parameters_of(runs));
  }
  std::vector<double> residuals(std::span<const SimulatedRun> runs) const override {
    return parabola_.residuals(parameters_of(runs));
  }
  std::size_t residual_count() const override {
    return parabola_.residuals(toy::parameters(0.0, 0.0, 0.5)).size();
  }
  double loss(std::span<const double> residuals) const override { return Parabola::of(residuals); }
  double noise(std::span<const SimulatedRun>) const override { return 1e-5; }
  RunScore score_run(const SimulatedRun& run, std::size_t) const override {
    return {objective({&run, 1}), std::nan("")};
  }
  // The replicates' own place is known to s: the difference of two objectives has the standard
  // deviation that moving it by one s makes.
  double half_width_of_difference(const Evaluation& first,
                                  const Evaluation& second,
                                  const PooledChance& chance) const override {
    const auto change = [&](double particle, double wall) {
      Parabola moved = parabola_;
      moved.b_particle += moved.of_the_sum ? 0.0 : particle * moved.s_particle;
      moved.b_wall += wall * moved.s_wall;
      Parabola other = parabola_;
      other.b_particle -= other.of_the_sum ? 0.0 : particle * other.s_particle;
      other.b_wall -= wall * other.s_wall;
      return 0.5 * (moved(first.parameters) - moved(second.parameters) - other(first.parameters) +
                    other(second.parameters));
    };
    return t * std::hypot(change(1.0, 0.0),
                          change(0.0, 1.0),
                          chance.roughness * std::hypot(first.objective, second.objective));
  }
  double allowed_excess(const Evaluation& best,
                        const Evaluation& evaluation,
                        const PooledChance& chance) const override {
    Parabola between = parabola_;
    between.b_particle = evaluation.parameters.of("friction_particle_particle");
    between.b_wall = evaluation.parameters.of("friction_particle_wall");
    const double distance = between(best.parameters) - between(evaluation.parameters);
    return std::max(0.0, half_width_of_difference(best, evaluation, chance) - distance);
  }
  std::unique_ptr<Comparison> with_replicates(std::span<const SimulatedRun>) const override {
    return nullptr;
  }

 private:
  static ParameterSet parameters_of(std::span<const SimulatedRun> runs) {
    const std::vector<double>& pose = runs.front().channels[0].values;
    return toy::parameters(pose[0], pose[1], 0.5);
  }
  Parabola parabola_;
};

datasets::Experiment experiment() {
  datasets::Experiment made = toy::experiment(2);
  made.material.bench = {{"friction_particle_particle", {0.4, 0.0}},
                         {"friction_particle_wall", {0.36, 0.03}},
                         {"restitution", {0.8, 0.02}}};
  return made;
}

struct Outcome {
  SearchResult result;
  int simulated = 0;
};

Outcome search(const datasets::Experiment& made, const Parabola& parabola, Journal& journal) {
  const auto executor = make_executor("threads", 1);
  const Scene scene{.problem = "parabola",
                    .engine = &engine,
                    .spec =
                        [](const ParameterSet& parameters, double fraction, std::uint64_t seed) {
                          return SimulationSpec{.parameters = parameters,
                                                .time_step_fraction = fraction,
                                                .seed = seed};
                        },
                    .measure =
                        [](const datasets::Recording& recording) {
                          const datasets::Pose& pose = recording.tracks->poses[0];
                          return std::vector{Channel{.values = {pose.x, pose.z}}};
                        }};
  Ensemble ensemble({scene}, journal, std::make_shared<ParabolaComparison>(parabola), *executor);
  const CalibrationOptions options{.search_seeds = 1, .confirmation_seeds = 2};
  Search one(made, ensemble, options, 0);
  one.run();
  return {one.finish(), ensemble.simulated()};
}

SearchResult search(const datasets::Experiment& made, const Parabola& parabola = {}) {
  Journal journal(":memory:");
  return search(made, parabola, journal).result;
}

datasets::Experiment with_wall_prior(double mean, double uncertainty) {
  datasets::Experiment made = experiment();
  made.tuned[1].prior = {mean, uncertainty};
  return made;
}

bool is_said(const SearchResult& result, const std::string& part) {
  return std::any_of(result.warnings.begin(), result.warnings.end(), [&](const auto& warning) {
    return warning.text.find(part) != std::string::npos;
  });
}

TEST(Prior, CostsWhatTheDataAllowAtItsOwnInterval) {
  Prior prior(with_wall_prior(0.3, 0.02).tuned);
  ParameterSet place = toy::parameters(0.1, 0.3 + 1.96 * 0.02, 0.9);
  EXPECT_EQ(prior.penalty(place), 0.0);  // not weighed
  prior.weigh(0.04);
  EXPECT_NEAR(prior.penalty(place), 0.04, 0.04 * 1e-3);  // 1.96^2 = 3.8416, 2 * 1.92 = 3.84
  EXPECT_NEAR(
      prior.reach(with_wall_prior(0.3, 0.02).tuned[1], prior.penalty(place)), 1.96 * 0.02, 1e-12);
  // exp(-1.92 J/allowed) of the penalty is the Gaussian exp(-z^2/2)
  place.set("friction_particle_wall", 0.33);
  EXPECT_NEAR(log_likelihood(prior.penalty(place), 0.04), -0.5 * 1.5 * 1.5, 1e-12);
  EXPECT_FALSE(Prior(experiment().tuned).is_stated());
}

TEST(PriorOfASearch, GivesTheMeanWeightedByPrecisions) {
  const Parabola data;
  const double m = 0.34, u = 0.02;
  const SearchResult result = search(with_wall_prior(m, u), data);
  const double precision = 1.0 / (data.s_wall * data.s_wall) + 1.0 / (u * u);
  const double mean = (data.b_wall / (data.s_wall * data.s_wall) + m / (u * u)) / precision;
  const double sigma = std::sqrt(1.0 / precision);
  const CalibratedParameter& wall = result.calibrated[1];
  EXPECT_EQ(wall.status, ParameterStatus::tuned);
  EXPECT_NEAR(wall.value, mean, 0.1 * sigma);
  ASSERT_TRUE(wall.interval.has_value());
  EXPECT_NEAR(wall.interval->lower, mean - t * sigma, 0.25 * sigma);
  EXPECT_NEAR(wall.interval->upper, mean + t * sigma, 0.25 * sigma);
  // What the data alone say stands beside it
  ASSERT_TRUE(wall.data_alone.has_value());
  EXPECT_NEAR(wall.data_alone->value, data.b_wall, 0.3 * data.s_wall);
  EXPECT_NEAR(wall.data_alone->interval.lower, data.b_wall - t * data.s_wall, 0.3 * data.s_wall);
  EXPECT_NEAR(wall.data_alone->interval.upper, data.b_wall + t * data.s_wall, 0.3 * data.s_wall);
  // So does the posterior
  ASSERT_EQ(result.posterior.size(), 3U);
  EXPECT_NEAR(result.posterior[1].mean, mean, 0.15 * sigma);
  EXPECT_NEAR(result.posterior[1].standard_deviation, sigma, 0.15 * sigma);
  // The other parameter has none and keeps its own
  const CalibratedParameter& particle = result.calibrated[0];
  EXPECT_NEAR(particle.value, data.b_particle, 0.3 * data.s_particle);
  EXPECT_NEAR(particle.interval->upper - particle.interval->lower,
              2.0 * t * data.s_particle,
              0.8 * data.s_particle);
  EXPECT_FALSE(is_said(result, "so the value is a compromise"));
}

TEST(PriorOfASearch, NarrowsWhereItAgreesAndChangesNothingWhereItIsWide) {
  const Parabola data;
  const SearchResult none = search(experiment(), data);
  const SearchResult agreeing = search(with_wall_prior(0.3, 0.02), data);
  const SearchResult wide = search(with_wall_prior(0.3, 3.0), data);
  const auto width = [](const SearchResult& result) {
    return result.calibrated[1].interval->upper - result.calibrated[1].interval->lower;
  };
  EXPECT_LT(width(agreeing), 0.7 * width(none));  // 1/sqrt(1 + (3/2)^2) = 0.55
  EXPECT_NEAR(wide.calibrated[1].value, none.calibrated[1].value, 0.1 * data.s_wall);
  EXPECT_NEAR(
      wide.calibrated[1].interval->lower, none.calibrated[1].interval->lower, 0.3 * data.s_wall);
  EXPECT_NEAR(
      wide.calibrated[1].interval->upper, none.calibrated[1].interval->upper, 0.3 * data.s_wall);
}

TEST(PriorOfASearch, SaysWhereItContradictsTheData) {
  const SearchResult result = search(with_wall_prior(0.5, 0.02));
  EXPECT_TRUE(is_said(result, "friction_particle_wall: The data alone give"));
  // sqrt(0.03^2 + 0.02^2) = 0.036: 5.5 of them
  EXPECT_NEAR(*deviation_from(result.calibrated[1], {0.5, 0.02}), -0.2 / 0.036, 1.0);
  EXPECT_GT(result.calibrated[1].value, 0.4);
}

TEST(PriorOfASearch, NeverSaysThatTheDataIdentifyWhatTheyDoNot) {
  datasets::Experiment made = experiment();
  made.tuned[2].prior = {0.8, 0.02};
  const SearchResult result = search(made);
  const CalibratedParameter& restitution = result.calibrated[2];
  EXPECT_EQ(restitution.status, ParameterStatus::not_identified);
  EXPECT_EQ(restitution.value, 0.8);
  ASSERT_TRUE(restitution.interval.has_value());
  EXPECT_NEAR(restitution.interval->lower, 0.8 - 1.96 * 0.02, 1e-12);
  EXPECT_NEAR(restitution.interval->upper, 0.8 + 1.96 * 0.02, 1e-12);
  EXPECT_FALSE(restitution.data_alone.has_value());
  EXPECT_TRUE(is_said(result, "restitution is not identified"));
  EXPECT_TRUE(is_said(result, "its value and interval are the prior's"));
}

// Only the sum is known, 0.6 +- 0.03. With the wall's friction known otherwise the particles' is
// their difference.
TEST(PriorOfASearch, SeparatesWhatTradesOffAndSaysThatItDoes) {
  const Parabola data{.b_wall = 0.35, .of_the_sum = true};
  datasets::Experiment made = with_wall_prior(0.2, 0.02);
  made.tuned[1].upper = 0.6;
  const SearchResult result = search(made, data);
  for (const std::size_t i : {0U, 1U})
    EXPECT_EQ(result.calibrated[i].status, ParameterStatus::not_identified);
  const CalibratedParameter& particle = result.calibrated[0];
  const double sigma = std::hypot(0.03, 0.02);
  EXPECT_NEAR(particle.value, 0.4, 0.5 * sigma);
  ASSERT_TRUE(particle.interval.has_value());
  EXPECT_NEAR(particle.interval->lower, 0.4 - t * sigma, 0.4 * sigma);
  EXPECT_NEAR(particle.interval->upper, 0.4 + t * sigma, 0.4 * sigma);
  EXPECT_TRUE(is_said(result, "trade off"));
  EXPECT_TRUE(is_said(result, "Here the prior of friction_particle_wall does."));
  EXPECT_TRUE(
      is_said(result, "its value and interval rest on the prior of friction_particle_wall"));
}

TEST(PriorOfASearch, IsTheSameFromTheJournal) {
  Journal journal(":memory:");
  const Outcome first = search(with_wall_prior(0.34, 0.02), {}, journal);
  const Outcome again = search(with_wall_prior(0.34, 0.02), {}, journal);
  EXPECT_GT(first.simulated, 0);
  EXPECT_EQ(again.simulated, 0);
  EXPECT_LE(first.result.evaluations.size(), 120U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(again.result.calibrated[i].value, first.result.calibrated[i].value);
    ASSERT_EQ(again.result.calibrated[i].interval.has_value(),
              first.result.calibrated[i].interval.has_value());
    if (!first.result.calibrated[i].interval) continue;
    EXPECT_EQ(again.result.calibrated[i].interval->lower,
              first.result.calibrated[i].interval->lower);
  }
  EXPECT_EQ(again.result.warnings, first.result.warnings);
}

}  // namespace
}  // namespace graintruth::calibrate
