// Which parameters the data cannot tell apart, in words.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibrate/knowledge/calibrated_parameter.h"
#include "calibrate/knowledge/posterior.h"
#include "calibrate/parameters.h"

namespace graintruth::calibrate {

// Two parameters of which one can make up for the other: over a long, thin region of their plane
// the fit is as good as the best.
struct TradeOff {
  std::string first, second;
  double first_share = 0.0;   // unit vector along the region, in the parameters' own units;
  double second_share = 0.0;  // the first component is not negative
  double half_length = 0.0;   // of the region along it (95 % of the draws), the same units
  double correlation = 0.0;   // of the two
};

// Pairs whose correlation over the posterior's draws reaches 0.9 in size.
std::vector<TradeOff> find_trade_offs(const ParameterSpace& space, const Posterior& posterior);

// Two parameters of which the data alone leave both wide open.
struct OpenPair {
  const CalibratedParameter* first = nullptr;
  const CalibratedParameter* second = nullptr;
};

// Pairs of parameters whose 95 % intervals of the data alone both reach over a quarter of the range
// of the search or more, but for those that trade off: the data may hold both loosely without a
// direction along which one makes up for the other. A parameter that shows an effect but fits with
// every value once the others follow reaches over all of its range.
std::vector<OpenPair> find_open_pairs(std::span<const CalibratedParameter> parameters,
                                      std::span<const TradeOff> trade_offs);

// One sentence, with the measurement that would separate the two.
std::string words_on(const TradeOff& trade_off);
std::string words_on(const OpenPair& pair);

}  // namespace graintruth::calibrate
