// The bulk density of a bed in a container of constant cross-section: the mass of its grains over
// the cross-section and the height of the bed. A flat bed is twice as high as its grains' centres
// are in the mean.
//   rho_b = N m / (A h),   h = 2 (mean z - z_floor)
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "calibrate/compare/pooled_rule.h"
#include "calibrate/observables/observable.h"
#include "calibrate/observables/track_results.h"
#include "datasets/store/input_error.h"
#include "datasets/store/plausible.h"
#include "datasets/store/toml_section.h"

namespace graintruth::calibrate {

namespace {

struct Container {
  double area = 0.0;   // m2
  double floor = 0.0;  // m
  std::string column;  // of replicates that were weighed and measured by hand
};

class BulkDensity final : public Observable {
 public:
  explicit BulkDensity(Container container) : container_(std::move(container)) {}

  std::string name() const override { return "bulk_density"; }
  ChannelWords words() const override { return {"Bulk density", "kg/m3", "", ""}; }
  bool needs_tracks() const override { return true; }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel*) const override {
    if (const auto curve = recording.curves.find(container_.column);
        curve != recording.curves.end()) {
      Channel channel{.values = {curve->second.value.back()}};
      if (!curve->second.sigma.empty()) channel.errors = {curve->second.sigma.back()};
      return channel;
    }
    const auto& tracks = recording.tracks;
    if (!tracks || tracks->frames() == 0) return {};
    // The bed as it is at last
    double sum = 0.0;
    int grains = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(tracks->particles); ++i) {
      const double z = tracks->poses[tracks->index(tracks->frames() - 1, i)].z;
      if (!(z > container_.floor)) continue;
      sum += z - container_.floor;
      ++grains;
    }
    if (grains == 0) return {};
    const double height = 2.0 * sum / grains;
    return {.values = {grains * situation.particle.mass / (container_.area * height)}};
  }

  // No bed is as dense as its grains, and none far looser than the loosest.
  std::string contradiction(const Channel& channel, const Situation& situation) const override {
    if (!channel.is_known()) return "";
    constexpr double far = 0.1;  // grains that still fall make a bed that looks looser
    const double bed = channel.values.front();
    const auto [lower, upper] = datasets::density_bounds(situation.particle);
    if (bed > far * datasets::loosest_bed * lower && bed < upper) return "";
    const bool is_dense = bed >= upper;
    return fmt::format(
        "the bulk density of {:.4g} kg/m3 is {} a particle, which is {:.4g} kg/m3 or "
        "{} by its mass and shape; look at the units of all three",
        bed,
        is_dense ? "not below that of" : "less than 3 % of that of",
        is_dense ? upper : lower,
        is_dense ? "less" : "more");
  }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    auto of = parts.of(name());
    if (!of) return nullptr;
    return std::make_unique<PooledRule>(
        of->channel,
        ChannelShape{.relative = Relative::to_mean},
        [](const Channel&) { return std::vector<double>{0.0}; },
        *parts.layout,
        std::move(of->replicates));
  }
  std::string lacking_words() const override {
    return fmt::format("tracks, or a column '{}' in the table of curves", container_.column);
  }

 private:
  Container container_;
};

// Width and depth of a box, or the diameter of a cylinder.
double read_area(datasets::TomlSection& settings) {
  if (const auto diameter =
          settings.optional_quantity("diameter", datasets::length_units, datasets::positive))
    return 0.25 * std::numbers::pi * *diameter * *diameter;
  return settings.quantity("width", datasets::length_units, datasets::positive) *
         settings.quantity("depth", datasets::length_units, datasets::positive);
}

std::shared_ptr<const Observable> make(const datasets::Experiment& experiment,
                                       datasets::TomlSection* settings) {
  if (settings == nullptr) {
    throw datasets::InputError(
        fmt::format("{}: 'bulk_density' is compared, but nothing says of which container; write "
                    "[measure.bulk_density] with width_mm and depth_mm, or diameter_mm.",
                    experiment.file.string()));
  }
  Container container;
  container.area = read_area(*settings);
  container.floor = settings->optional_quantity("floor_z", datasets::length_units).value_or(0.0);
  container.column = settings->optional_text("column").value_or("bulk_density_kg_per_m3");
  return std::make_shared<BulkDensity>(std::move(container));
}

}  // namespace

extern constinit const ObservableKind bulk_density_kind{.name = "bulk_density", .make = make};

}  // namespace graintruth::calibrate
