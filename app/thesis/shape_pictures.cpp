// Squares, tenths, classes and marked grains of a bed, as the figures of chapter 5 show them.
#include "app/thesis/shape_pictures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/thesis/thesis_data.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

// A tenth of a millimetre is enough for a picture.
double drawn(double metres) { return 1e-4 * std::round(1e4 * metres); }

}  // namespace

double top_of(const std::vector<sim::Vec3>& centres) {
  double top = 0.0;
  for (const sim::Vec3& centre : centres) top = std::max(top, centre.z());
  return top;
}

Json solid_fraction_of_squares(const std::vector<sim::Vec3>& centres,
                               const Squares& squares,
                               double area) {
  const double side = squares.side, left = -0.5 * squares.width;
  std::map<std::pair<int, int>, int> counts;
  for (const sim::Vec3& centre : centres) {
    ++counts[{static_cast<int>(std::floor((centre.x() - left) / side)),
              static_cast<int>(std::floor(centre.z() / side))}];
  }
  std::vector<double> x, z, fraction;
  for (const auto& [square, count] : counts) {
    x.push_back(drawn(left + (square.first + 0.5) * side));
    z.push_back(drawn((square.second + 0.5) * side));
    fraction.push_back(count * area / (side * side));
  }
  return {{"x", x}, {"z", z}, {"fraction", fraction}};
}

std::vector<double> force_by_tenths(const datasets::SceneFile& file,
                                    const calibrate::SceneRun& run,
                                    std::size_t rest) {
  const auto first =
      std::find_if(run.frames.begin() + static_cast<std::ptrdiff_t>(rest),
                   run.frames.end(),
                   [](const calibrate::SceneFrame& frame) { return !frame.strip_force.empty(); });
  if (first == run.frames.end()) return {};
  std::vector<double> force(static_cast<std::size_t>(run.strips.count), 0.0);
  for (std::size_t w = 0; w < file.walls.size(); ++w) {
    if (file.walls[w].name != "left" && file.walls[w].name != "right") continue;
    for (std::size_t strip = 0; strip < force.size(); ++strip)
      force[strip] += 0.5 * first->strip_force[w][strip];
  }
  return force;
}

Json wall_history(const datasets::SceneFile& file,
                  const calibrate::SceneRun& run,
                  std::size_t rest,
                  double until) {
  const auto left =
      std::find_if(file.walls.begin(), file.walls.end(), [](const datasets::SceneWall& wall) {
        return wall.name == "left";
      });
  const auto wall = static_cast<std::size_t>(left - file.walls.begin());
  std::vector<double> time;
  std::vector<std::vector<double>> tenths(static_cast<std::size_t>(run.strips.count));
  for (std::size_t f = rest; f < run.frames.size(); ++f) {
    const calibrate::SceneFrame& frame = run.frames[f];
    const double since = frame.state.time - run.event_time;
    if (frame.strip_force.empty()) continue;
    if (since > until) break;
    time.push_back(since);
    for (std::size_t strip = 0; strip < tenths.size(); ++strip)
      tenths[strip].push_back(frame.strip_force[wall][strip]);
  }
  return {{"time", time}, {"tenths", tenths}};
}

Json speed_classes(const sim::State& state, double height, double slow, double fast) {
  const auto is_drawn = [&](const sim::Vec3& place) {
    return place.z() >= 0.0 && place.z() < height;
  };
  double largest = 0.0;
  for (std::size_t i = 0; i < state.position.size(); ++i)
    if (is_drawn(state.position[i])) largest = std::max(largest, state.velocity[i].norm());
  std::vector<double> x, z;
  std::vector<int> classes;
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    if (!is_drawn(state.position[i])) continue;
    const double share = state.velocity[i].norm() / largest;
    x.push_back(drawn(state.position[i].x()));
    z.push_back(drawn(state.position[i].z()));
    classes.push_back(share < slow ? 0 : share > fast ? 2 : 1);
  }
  return {{"x", x}, {"z", z}, {"class", classes}};
}

Json paths_of_marked(const calibrate::SceneRun& run, std::size_t rest, double width, int in_a_row) {
  const sim::State& start = run.frames[rest].state;
  const std::vector<sim::Vec3>& centres = start.position;
  const double height = top_of(centres);
  Json paths = Json::array();
  for (int field = 0; field < in_a_row * in_a_row; ++field) {
    const int column = field % in_a_row, row = field / in_a_row;
    const sim::Vec3 middle(
        ((column + 0.5) / in_a_row - 0.5) * width, 0.0, (row + 0.5) / in_a_row * height);
    const auto nearest =
        std::min_element(centres.begin(), centres.end(), [&](const auto& a, const auto& b) {
          return (a - middle).squaredNorm() < (b - middle).squaredNorm();
        });
    const auto marked = static_cast<std::size_t>(nearest - centres.begin());
    std::vector<double> time, x, z, turned, sideways;
    for (std::size_t f = rest; f < run.frames.size(); ++f) {
      const sim::State& state = run.frames[f].state;
      const sim::Vec3& place = state.position[marked];
      if (place.z() < 0.0) break;
      time.push_back(state.time - run.event_time);
      x.push_back(drawn(place.x()));
      z.push_back(drawn(place.z()));
      turned.push_back((state.picture_angle[marked] - start.picture_angle[marked]) /
                       unit_in_si("deg"));
      sideways.push_back(state.velocity[marked].x());
    }
    paths.push_back(
        {{"time", time}, {"x", x}, {"z", z}, {"turned", turned}, {"sideways", sideways}});
  }
  return paths;
}

}  // namespace graintruth::app
