#include "calibrate/knowledge/foreign_replicates.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "calibrate/compare/pooled_rule.h"
#include "calibrate/compare/repeated_rule.h"
#include "calibrate/compare/start_poses.h"
#include "calibrate/knowledge/rotation_test.h"

namespace graintruth::calibrate {

namespace {

using Places = std::vector<std::size_t>;

constexpr double far_beyond_others = 3.0;  // times the distance of the others from each other
constexpr double far_beyond_errors = 5.0;  // standard deviations

// What a condition shows of one quantity: a row a replicate, of the values that all of them know,
// as differences from the first so that directions are single-valued.
struct Shown {
  Places replicates;
  Eigen::MatrixXd rows;
  Eigen::VectorXd first;                    // the values that rows are counted from
  std::vector<Difference> difference;       // of the columns
  std::vector<std::vector<double>> errors;  // of the rows; empty where none are known
};

std::optional<Shown> shown_by(const RepeatedCondition& condition,
                              const RepeatedQuantity& quantity) {
  Shown shown;
  for (const std::size_t r : condition.replicates) {
    if (!quantity.values[r].empty()) shown.replicates.push_back(r);
  }
  if (shown.replicates.size() < 2) return std::nullopt;
  const std::vector<double>& first = quantity.values[shown.replicates.front()];
  Places known;
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (std::all_of(shown.replicates.begin(), shown.replicates.end(), [&](std::size_t r) {
          return quantity.values[r].size() == first.size() && std::isfinite(quantity.values[r][i]);
        }))
      known.push_back(i);
  }
  if (known.empty()) return std::nullopt;
  const auto columns = static_cast<Eigen::Index>(known.size());
  shown.rows.resize(static_cast<Eigen::Index>(shown.replicates.size()), columns);
  shown.first.resize(columns);
  bool has_errors = !quantity.errors.empty();
  for (std::size_t row = 0; row < shown.replicates.size(); ++row) {
    const std::size_t r = shown.replicates[row];
    std::vector<double> errors;
    for (std::size_t k = 0; k < known.size(); ++k) {
      const std::size_t i = known[k];
      const auto column = static_cast<Eigen::Index>(k);
      const Difference kind = quantity.difference[i % quantity.difference.size()];
      if (row == 0) {
        shown.first[column] = first[i];
        shown.difference.push_back(kind);
      }
      shown.rows(static_cast<Eigen::Index>(row), column) =
          difference(kind, quantity.values[r][i], first[i]);
      has_errors = has_errors && quantity.errors[r].size() == first.size() &&
                   std::isfinite(quantity.errors[r][i]);
      if (has_errors) errors.push_back(quantity.errors[r][i]);
    }
    shown.errors.push_back(std::move(errors));
  }
  if (!has_errors) shown.errors.clear();
  return shown;
}

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

Eigen::MatrixXd without(const Eigen::MatrixXd& rows, Eigen::Index left_out) {
  Eigen::MatrixXd rest(rows.rows() - 1, rows.cols());
  rest << rows.topRows(left_out), rows.bottomRows(rows.rows() - left_out - 1);
  return rest;
}

// Independent contrasts of repeats about their unknown mean: n - 1 rows (Helmert).
Eigen::MatrixXd contrasts(const Eigen::MatrixXd& rows) {
  Eigen::MatrixXd made(std::max<Eigen::Index>(0, rows.rows() - 1), rows.cols());
  for (Eigen::Index k = 1; k < rows.rows(); ++k) {
    const auto before = static_cast<double>(k);
    made.row(k - 1) =
        std::sqrt(before / (before + 1.0)) * (rows.row(k) - rows.topRows(k).colwise().mean());
  }
  return made;
}

// By what differences of a condition are divided before conditions are pooled.
double scale_of(const Shown& shown, const RepeatedQuantity& quantity) {
  if (!quantity.is_pooled || !quantity.is_relative) return 1.0;
  const double scale = rms(shown.first + shown.rows.colwise().mean().transpose());
  return scale > 0.0 ? scale : 1.0;
}

// Contrasts that are smaller than what replicates say of their own errors become as long as these,
// in the direction in which they count most.
Eigen::MatrixXd not_below_errors(Eigen::MatrixXd rows,
                                 const Shown& shown,
                                 const Eigen::RowVectorXd& direction,
                                 const RepeatedQuantity& quantity) {
  if (shown.errors.empty() || !(direction.norm() > 0.0)) return rows;
  double squares = 0.0;
  for (const std::vector<double>& errors : shown.errors) {
    for (const double error : errors)
      squares += error * error / static_cast<double>(shown.errors.size());
  }
  const double least = std::sqrt(squares) / scale_of(shown, quantity);
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    if (rows.row(row).norm() < least) rows.row(row) = least * direction.normalized();
  }
  return rows;
}

// The test of one replicate: its contrast with the mean of the others first, then all contrasts of
// others, of every condition that scatters alike.
double chance_of(const std::vector<Shown>& all,
                 std::size_t condition,
                 Eigen::Index row,
                 const RepeatedQuantity& quantity) {
  const Eigen::MatrixXd own = all[condition].rows / scale_of(all[condition], quantity);
  const Eigen::MatrixXd others = without(own, row);
  const auto count = static_cast<double>(others.rows());
  const Eigen::RowVectorXd apart =
      std::sqrt(count / (count + 1.0)) * (own.row(row) - others.colwise().mean());
  std::vector<Eigen::MatrixXd> parts = {
      apart, not_below_errors(contrasts(others), all[condition], apart, quantity)};
  for (std::size_t c = 0; quantity.is_pooled && c < all.size(); ++c) {
    const Shown& other = all[c];
    if (c == condition || other.rows.cols() != own.cols()) continue;
    parts.push_back(not_below_errors(
        contrasts(other.rows / scale_of(other, quantity)), other, apart, quantity));
  }
  Eigen::Index rows = 0;
  for (const Eigen::MatrixXd& part : parts) rows += part.rows();
  Eigen::MatrixXd stacked(rows, own.cols());
  rows = 0;
  for (const Eigen::MatrixXd& part : parts) {
    stacked.middleRows(rows, part.rows()) = part;
    rows += part.rows();
  }
  return rotation_test(std::move(stacked));
}

// The columns that are plain: places, where others are directions.
Eigen::VectorXd plain_of(const Shown& shown, const Eigen::VectorXd& values) {
  std::vector<double> plain;
  for (std::size_t k = 0; k < shown.difference.size(); ++k) {
    if (shown.difference[k] == Difference::plain)
      plain.push_back(values[static_cast<Eigen::Index>(k)]);
  }
  return Eigen::Map<Eigen::VectorXd>(plain.data(), static_cast<Eigen::Index>(plain.size()));
}

double distance(const Shown& shown, Eigen::Index a, Eigen::Index b) {
  return rms(plain_of(shown, (shown.rows.row(a) - shown.rows.row(b)).transpose()));
}

// Whether a place is held against the width of a grain and found to be elsewhere.
bool is_elsewhere(const Shown& shown, Eigen::Index row, double width) {
  double nearest = std::numeric_limits<double>::infinity(), among_others = 0.0;
  for (Eigen::Index a = 0; a < shown.rows.rows(); ++a) {
    if (a == row) continue;
    nearest = std::min(nearest, distance(shown, row, a));
    for (Eigen::Index b = 0; b < a; ++b) {
      if (b != row) among_others = std::max(among_others, distance(shown, a, b));
    }
  }
  return nearest > width && nearest > far_beyond_others * among_others;
}

// The root mean square of a difference over its errors.
double errors_apart(const Shown& shown) {
  double sum = 0.0;
  for (std::size_t k = 0; k < shown.errors[0].size(); ++k) {
    const double apart =
        shown.rows(0, static_cast<Eigen::Index>(k)) - shown.rows(1, static_cast<Eigen::Index>(k));
    sum += apart * apart / (std::pow(shown.errors[0][k], 2) + std::pow(shown.errors[1][k], 2));
  }
  return std::sqrt(sum / static_cast<double>(shown.errors[0].size()));
}

// A number with its unit, lengths in mm.
std::string with_unit(double value, const std::string& unit) {
  if (unit == "m") return fmt::format("{:.3g} mm", 1e3 * value);
  return unit.empty() || unit == "-" ? fmt::format("{:.3g}", value)
                                     : fmt::format("{:.3g} {}", value, unit);
}

// What the replicate shows beside the others, and where the mean is with it and without.
std::string words_on(const RepeatedQuantity& quantity, const Shown& shown, Eigen::Index row) {
  const Eigen::MatrixXd others = without(shown.rows, row);
  const Eigen::VectorXd mean = others.colwise().mean();
  const auto count = static_cast<double>(others.rows());
  if (mean.size() == 1) {
    const double of_others = shown.first[0] + mean[0];
    const double own = shown.first[0] + shown.rows(row, 0);
    return fmt::format(
        "its {} is {}, where the other {} have {} in the mean; with it the mean is {}",
        quantity.name,
        with_unit(own, quantity.unit),
        others.rows(),
        with_unit(of_others, quantity.unit),
        with_unit((count * of_others + own) / (count + 1.0), quantity.unit));
  }
  const double apart = rms(plain_of(shown, shown.rows.row(row).transpose() - mean));
  double scatter = 0.0;
  for (Eigen::Index r = 0; r < others.rows(); ++r)
    scatter += std::pow(rms(plain_of(shown, others.row(r).transpose() - mean)), 2) / count;
  return fmt::format(
      "in {} it differs from the mean of the other {} by {} (rms), and these from it by {}; with "
      "it "
      "the mean moves by {}",
      quantity.name,
      others.rows(),
      with_unit(apart, quantity.unit),
      with_unit(std::sqrt(scatter), quantity.unit),
      with_unit(apart / (count + 1.0), quantity.unit));
}

// What makes two replicates disagree; empty where nothing does.
std::string words_on_pair(const RepeatedQuantity& quantity, const Shown& shown, bool by_chance) {
  const double apart = distance(shown, 0, 1);
  if (quantity.width && apart > *quantity.width) {
    return fmt::format(
        "they differ in {} by {} (rms), which is more than {}, the half width of a grain",
        quantity.name,
        with_unit(apart, quantity.unit),
        with_unit(*quantity.width, quantity.unit));
  }
  if (by_chance) {
    return fmt::format("they differ in {} by {}, more than replicates of the other conditions do",
                       quantity.name,
                       with_unit(apart, quantity.unit));
  }
  if (quantity.width || shown.errors.empty()) return "";
  const double errors = errors_apart(shown);
  if (!(errors > far_beyond_errors)) return "";
  return fmt::format("they differ in {} by {}, {:.0f} times what their errors explain",
                     quantity.name,
                     with_unit(apart, quantity.unit),
                     errors);
}

// One test of one replicate.
struct Test {
  std::size_t quantity = 0, condition = 0;
  Eigen::Index row = 0;
  double chance = 1.0;
};

// Those that stay when all are held against the false alarm together (Holm 1979).
std::vector<Test> significant(std::vector<Test> tests) {
  std::stable_sort(
      tests.begin(), tests.end(), [](const Test& a, const Test& b) { return a.chance < b.chance; });
  std::size_t stay = 0;
  while (stay < tests.size() &&
         tests[stay].chance <= false_alarm / static_cast<double>(tests.size() - stay))
    ++stay;
  tests.resize(stay);
  return tests;
}

}  // namespace

std::vector<datasets::Warning> foreign_replicates(const std::vector<std::string>& names,
                                                  std::span<const RepeatedCondition> conditions,
                                                  std::span<const RepeatedQuantity> quantities) {
  // 1. What every condition shows of every quantity, and every test
  std::vector<std::vector<Shown>> shown(quantities.size());
  std::vector<std::vector<const RepeatedCondition*>> whose(quantities.size());
  std::vector<Test> tests;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    for (const RepeatedCondition& condition : conditions) {
      if (auto one = shown_by(condition, quantities[q])) {
        shown[q].push_back(*std::move(one));
        whose[q].push_back(&condition);
      }
    }
    for (std::size_t c = 0; c < shown[q].size(); ++c) {
      const Eigen::Index rows = shown[q][c].rows.rows();
      // The two of a pair are as far from each other: one test
      for (Eigen::Index row = 0; row < (rows == 2 ? 1 : rows); ++row)
        tests.push_back({q, c, row, chance_of(shown[q], c, row, quantities[q])});
    }
  }
  const std::vector<Test> found = significant(tests);
  // 2. What is said of whom, in the order of the replicates
  std::map<Places, std::vector<std::string>> reasons;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    for (std::size_t c = 0; c < shown[q].size(); ++c) {
      const Shown& one = shown[q][c];
      const auto is_found = [&](Eigen::Index row) {
        return std::any_of(found.begin(), found.end(), [&](const Test& test) {
          return test.quantity == q && test.condition == c && test.row == row;
        });
      };
      if (one.rows.rows() == 2) {
        std::string words = words_on_pair(quantities[q], one, is_found(0));
        if (!words.empty()) reasons[one.replicates].push_back(std::move(words));
        continue;
      }
      for (Eigen::Index row = 0; row < one.rows.rows(); ++row) {
        if (!is_found(row) &&
            !(quantities[q].width && is_elsewhere(one, row, *quantities[q].width)))
          continue;
        reasons[{one.replicates[static_cast<std::size_t>(row)]}].push_back(
            words_on(quantities[q], one, row));
      }
    }
  }
  std::vector<datasets::Warning> warnings;
  for (const auto& [replicates, words] : reasons) {
    const std::string& name = names[replicates.front()];
    if (replicates.size() == 1) {
      warnings.push_back(datasets::first_line(
          fmt::format("{} may not belong to the other replicates: {}. Look at its recording, its "
                      "start event and its settings, and leave it out if it shows another "
                      "experiment.",
                      name,
                      fmt::join(words, "; ")),
          fmt::format("{} may not belong to the other replicates", name),
          fmt::format("Look at {}, and leave it out if it is foreign", name)));
    } else {
      const std::string& other = names[replicates.back()];
      warnings.push_back(datasets::first_line(
          fmt::format("{} and {} may not show the same experiment: {}. Two replicates cannot tell "
                      "which of them is wrong; look at both, and add a third.",
                      name,
                      other,
                      fmt::join(words, "; ")),
          fmt::format("{} and {} may not show the same experiment", name, other),
          fmt::format("Look at {} and {}, and add a third", name, other)));
    }
  }
  return warnings;
}

RepeatedQuantity starting_places(const datasets::Experiment& experiment,
                                 std::span<const datasets::Recording> recordings) {
  RepeatedQuantity places{.name = "starting places",
                          .unit = "m",
                          .difference = {Difference::plain, Difference::plain},
                          .width = experiment.particle.half_width};
  for (const datasets::Recording& recording : recordings) {
    std::vector<double>& values = places.values.emplace_back();
    if (!recording.tracks) continue;
    for (const datasets::Pose& pose : start_places(*recording.tracks)) {
      values.push_back(pose.x);
      values.push_back(pose.z);
    }
  }
  return places;
}

std::vector<datasets::Warning> foreign_replicates(const Problem& problem,
                                                  std::span<const datasets::Recording> recordings,
                                                  std::span<const RepeatedQuantity> more) {
  const datasets::Experiment& experiment = problem.experiment;
  std::vector<RepeatedQuantity> quantities;
  if (experiment.rig.begins_from == datasets::BeginsFrom::mean_of_replicates)
    quantities.push_back(starting_places(experiment, recordings));
  for (const auto& [place, weight] : problem.observables->compared()) {
    const Observable& observable = *problem.observables->all()[place];
    RepeatedQuantity quantity{.name = observable.name()};
    const Rule* rule = problem.all->rule_of(quantity.name);
    const auto repeats = rule != nullptr ? rule->repeats() : std::nullopt;
    if (repeats && !repeats->is_pooled) quantity.difference = repeats->shape.difference;
    if (repeats && repeats->is_pooled) {
      if (repeats->shape.resolution > 0.0) continue;
      quantity.is_pooled = true;
      quantity.is_relative = repeats->shape.relative != Relative::absolute;
    }
    // The first unit is that of what differs plainly
    const std::string unit = observable.words().unit;
    quantity.unit = unit.substr(0, unit.find(','));
    if (quantity.unit == "m") quantity.width = experiment.particle.half_width;
    for (const std::vector<Channel>& channels : problem.measured) {
      quantity.values.push_back(channels[place].values);
      quantity.errors.push_back(channels[place].errors);
    }
    quantities.push_back(std::move(quantity));
  }
  quantities.insert(quantities.end(), more.begin(), more.end());
  std::vector<RepeatedCondition> conditions;
  for (const Condition& condition : problem.conditions)
    conditions.push_back({condition.name, condition.replicates});
  std::vector<std::string> names;
  for (const datasets::Replicate& replicate : experiment.replicates)
    names.push_back(replicate.name);
  return foreign_replicates(names, conditions, quantities);
}

}  // namespace graintruth::calibrate
