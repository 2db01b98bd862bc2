#include "calibrate/knowledge/identifiability.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "datasets/parameters/parameter.h"

namespace graintruth::calibrate {

namespace {

constexpr double telling_correlation = 0.9;
constexpr double open_share = 0.25;  // of the range of the search

// What fits as well as the best: an interval, or all of the range where a parameter has an effect
// that others make up for. Nothing where it has none, or the search had no time to look.
std::optional<Interval> fitting_values(const CalibratedParameter& parameter) {
  if (const auto& data = parameter.data_alone) {
    if (data->below == EndKind::search_ended || data->above == EndKind::search_ended)
      return std::nullopt;
    return data->interval;
  }
  if (parameter.status != ParameterStatus::not_identified || !parameter.shows_effect)
    return std::nullopt;
  return Interval{parameter.lower_bound, parameter.upper_bound};
}

bool is_open(const CalibratedParameter& parameter) {
  const auto interval = fitting_values(parameter);
  return interval && interval->upper - interval->lower >=
                         open_share * (parameter.upper_bound - parameter.lower_bound);
}

TradeOff trade_off_of(const std::vector<ParameterSet>& region,
                      const std::string& first,
                      const std::string& second) {
  Eigen::MatrixX2d points(static_cast<Eigen::Index>(region.size()), 2);
  for (std::size_t i = 0; i < region.size(); ++i) {
    points.row(static_cast<Eigen::Index>(i)) << value_of(region[i], first),
        value_of(region[i], second);
  }
  points.rowwise() -= points.colwise().mean().eval();
  const Eigen::Matrix2d moments = points.transpose() * points;
  // The long axis of the region lies at half the angle of (m_xx - m_yy, 2 m_xy): |angle| <= pi/2
  const double angle = 0.5 * std::atan2(2.0 * moments(0, 1), moments(0, 0) - moments(1, 1));
  const Eigen::Vector2d axis(std::cos(angle), std::sin(angle));
  Eigen::VectorXd along = points * axis;
  std::sort(along.begin(), along.end());
  const Eigen::Index tail = along.size() / 40;  // 2.5 % at either end
  const double scale = std::sqrt(moments(0, 0) * moments(1, 1));
  return {.first = first,
          .second = second,
          .first_share = axis.x(),
          .second_share = axis.y(),
          .half_length = 0.5 * (along(along.size() - 1 - tail) - along(tail)),
          .correlation = scale > 0.0 ? moments(0, 1) / scale : 0.0};
}

// The bench test that fixes one of the two.
std::string separating_test(const std::string& second) {
  return fmt::format("{}, with {} held at what it gives,",
                     datasets::parameter_named(second).kind->bench_test,
                     second);
}

std::string sentence_start(std::string words) {
  words.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(words.front())));
  return words;
}

}  // namespace

std::vector<TradeOff> find_trade_offs(const ParameterSpace& space, const Posterior& posterior) {
  std::vector<ParameterSet> draws;
  for (const UnitPoint& draw : posterior.draws) draws.push_back(space.from_unit(draw));
  std::vector<TradeOff> found;
  for (std::size_t i = 0; i < space.dimension(); ++i) {
    for (std::size_t j = i + 1; j < space.dimension(); ++j) {
      const TradeOff trade_off = trade_off_of(draws, space.tuned()[i].name, space.tuned()[j].name);
      if (std::abs(trade_off.correlation) >= telling_correlation) found.push_back(trade_off);
    }
  }
  return found;
}

std::vector<OpenPair> find_open_pairs(std::span<const CalibratedParameter> parameters,
                                      std::span<const TradeOff> trade_offs) {
  std::vector<OpenPair> found;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    for (std::size_t j = i + 1; j < parameters.size(); ++j) {
      const CalibratedParameter &first = parameters[i], &second = parameters[j];
      if (!is_open(first) || !is_open(second)) continue;
      const bool is_told =
          std::any_of(trade_offs.begin(), trade_offs.end(), [&](const TradeOff& trade_off) {
            return trade_off.first == first.name && trade_off.second == second.name;
          });
      if (!is_told) found.push_back({&first, &second});
    }
  }
  return found;
}

std::string words_on(const OpenPair& pair) {
  const Interval first = *fitting_values(*pair.first), second = *fitting_values(*pair.second);
  return fmt::format(
      "The data hardly separate {} and {}. Values of the first from {:.2f} to {:.2f} and of the "
      "second from {:.2f} to {:.2f} fit as well as the best. {} would separate them.",
      pair.first->name,
      pair.second->name,
      first.lower,
      first.upper,
      second.lower,
      second.upper,
      sentence_start(separating_test(pair.second->name)));
}

std::string words_on(const TradeOff& trade_off) {
  return fmt::format(
      "{} and {} trade off: along {:.2f}/{:+.2f} the fit is flat over at least +-{:.2f} "
      "(correlation "
      "{:+.2f}); {} would separate them.",
      trade_off.first,
      trade_off.second,
      trade_off.first_share,
      trade_off.second_share,
      trade_off.half_length,
      trade_off.correlation,
      separating_test(trade_off.second));
}

}  // namespace graintruth::calibrate
