#include "app/thesis/macro_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/run/data_folder.h"
#include "app/run/interrupt.h"
#include "app/scenes/scene_files.h"
#include "app/thesis/button.h"
#include "calibrate/engines/scene_run.h"
#include "calibrate/ensemble.h"
#include "calibrate/flow/bulk_measure.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

const std::string properties = "table_4_3_macro_properties";
const std::string experiment = "table_4_4_beverloo_experiment";

std::filesystem::path scene_of_bin() { return data_folder() / "scenes" / "macro_bin.toml"; }

// The bundled bin with another orifice, and without friction while it fills where so asked.
datasets::SceneFile bin_with(double orifice, bool frictionless, double duration) {
  datasets::SceneFile file = datasets::load_scene(scene_of_bin());
  for (datasets::SceneWall& wall : file.walls) {
    if (wall.name == "floor_left") wall.points[1].x() = -0.5 * orifice;
    if (wall.name == "floor_right") wall.points[0].x() = 0.5 * orifice;
    if (wall.name != "orifice_panel") continue;
    wall.points[0].x() = -0.5 * orifice;
    wall.points[1].x() = 0.5 * orifice;
  }
  if (frictionless) {
    file.phases.front().friction_between_particles = 0.0;
    file.phases.front().friction_with_walls = 0.0;
  }
  file.phases.back().duration = duration;
  return file;
}

calibrate::BulkRig rig_of(const ThesisData& thesis, double orifice) {
  const Ellipse ellipse = button_ellipse(thesis);
  return {.width = thesis.si(properties, "hopper_width"),
          .orifice = orifice,
          .particle_area = std::numbers::pi * ellipse.along * ellipse.across,
          .particle_diameter = button_diameter(thesis),
          .particle_mass = thesis.si(properties, "mass")};
}

// What is seen of a run moment by moment: figures 4.12a and 4.13.
void add_course(const datasets::Trajectories& tracks,
                const calibrate::BulkMeasurement& bin,
                const calibrate::BulkRig& rig,
                const ThesisData& thesis,
                Json& result) {
  const double interval = thesis.setting("macro", "sampling");
  const double emptied = thesis.setting("macro", "emptied") * tracks.particles;
  double next = 0.0;
  for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
    const double time = tracks.time[frame];
    if (time < next - 1e-9) continue;
    next += interval;
    const int left = calibrate::discharged_by(bin.discharge, time);
    result["time"].push_back(time);
    result["discharged"].push_back(left * rig.particle_mass);
    result["solid_fraction"].push_back(
        left < emptied ? calibrate::measure_bed(tracks, frame, rig).solid_fraction : no_number);
  }
}

// Once the bed is almost empty single grains that roll off the floor leave pauses too: those are no
// arches.
void add_arches(const calibrate::Discharge& discharge,
                const calibrate::BulkRig& rig,
                const ThesisData& thesis,
                Json& result) {
  const calibrate::Arching arching = calibrate::find_arching(discharge, rig);
  const double emptied = thesis.setting("macro", "emptied") * discharge.particles;
  const auto arches =
      std::count_if(arching.pauses.begin(), arching.pauses.end(), [&](const auto& pause) {
        return calibrate::discharged_by(discharge, pause.from) < emptied;
      });
  result["pauses"] = arching.pauses.size();
  result["arches"] = arches + (arching.jammed ? 1 : 0);
}

// The velocity profile of figure 4.18 and B of it: by the thesis's form with the velocity of the
// middle, and by an orifice of its width with a free one.
void add_profile(const calibrate::VelocityProfile& profile,
                 const calibrate::BulkRig& rig,
                 Json& result) {
  const auto bins = calibrate::profile_bins(rig);
  const double bin_width = rig.width / static_cast<double>(bins);
  result["velocity"] = std::vector<double>(bins, no_number);
  for (std::size_t bin = 0; bin < bins; ++bin)
    result["x"].push_back((static_cast<double>(bin) + 0.5) * bin_width - 0.5 * rig.width);
  const calibrate::VelocitySample* middle = nullptr;
  for (const calibrate::VelocitySample& sample : profile.samples) {
    const double bin = std::floor((sample.x + 0.5 * rig.width) / bin_width);
    const auto last = static_cast<double>(bins - 1);
    result["velocity"][static_cast<std::size_t>(std::clamp(bin, 0.0, last))] = sample.velocity;
    if (middle == nullptr || std::abs(sample.x) < std::abs(middle->x)) middle = &sample;
  }
  constexpr std::size_t fewest = 4;
  if (profile.samples.size() < fewest || !(middle->velocity > 0.0)) return;
  std::vector<calibrate::VelocitySample> samples = profile.samples;
  for (calibrate::VelocitySample& sample : samples) sample.standard_uncertainty = 0.0;
  result["B"] = calibrate::fit_kinematic(
                    samples, {.height = profile.height, .pinned_velocity = middle->velocity})
                    .B;
  result["B_finite"] =
      calibrate::fit_kinematic(samples, {.height = profile.height, .orifice = rig.orifice}).B;
}

Json empty_bin(const datasets::SceneFile& file,
               const calibrate::BulkRig& rig,
               const ThesisData& thesis,
               std::uint64_t seed) {
  const calibrate::SceneRun run =
      calibrate::run_scene(file, {.seed = seed, .stop = is_interrupted});
  Json result = {{"completed", run.status == sim::RunStatus::completed && run.reached_event}};
  for (const char* list : {"time", "discharged", "solid_fraction", "x", "velocity"})
    result[list] = Json::array();
  if (!result["completed"].get<bool>()) return result;
  const datasets::Trajectories tracks = planar_tracks(run);
  const calibrate::BulkMeasurement bin =
      calibrate::measure_bulk(tracks, rig, thesis.si("packing_and_flow", "profile_band_height"));
  result["fraction"] = bin.at_rest.solid_fraction;
  add_arches(bin.discharge, rig, thesis, result);
  add_course(tracks, bin, rig, thesis, result);
  const auto steady = calibrate::steady_rate(bin.discharge, rig);
  if (!steady) return result;
  result["rate"] = steady->rate;
  result["density"] = bin.flowing_density;
  result["flowing_fraction"] = bin.flowing_density * rig.particle_area / rig.particle_mass;
  add_profile(bin.profile, rig, result);
  return result;
}

Json run_bin(const ThesisData& thesis, Studies& studies, double orifice, bool frictionless) {
  const calibrate::BulkRig rig = rig_of(thesis, orifice);
  const datasets::SceneFile file =
      bin_with(orifice, frictionless, thesis.setting("macro", "duration"));
  const int seeds = thesis.count("macro", "seeds");
  const auto drawn = calibrate::make_seeds(studies.seed(), "macro", seeds);
  std::vector<Json> found(drawn.size());
  studies.in_parallel(seeds, [&](int i) {
    const auto which = static_cast<std::size_t>(i);
    found[which] = empty_bin(file, rig, thesis, drawn[which]);
  });
  return found;
}

}  // namespace

std::vector<double> OrificeRuns::values(const char* key) const {
  std::vector<double> found;
  for (const Json& run : runs) {
    if (run.contains(key) && run.at(key).is_number()) found.push_back(run.at(key).get<double>());
  }
  return found;
}

OrificeRuns::Band OrificeRuns::band(const char* key) const {
  std::vector<const Json*> lists;
  std::size_t places = 0;
  for (const Json& run : runs) {
    if (run.at(key).empty()) continue;
    lists.push_back(&run.at(key));
    places = std::max(places, run.at(key).size());
  }
  Band band{std::vector<double>(places, no_number), std::vector<double>(places, no_number)};
  for (std::size_t place = 0; place < places; ++place) {
    std::vector<double> found;
    for (const Json* list : lists) {
      if (place < list->size() && (*list)[place].is_number())
        found.push_back((*list)[place].get<double>());
    }
    if (found.size() < lists.size()) continue;
    const Simulated here = over_seeds(found);
    band.mean[place] = here.mean;
    band.spread[place] = here.spread;
  }
  return band;
}

std::vector<OrificeRuns> run_bins(const ThesisData& thesis, Studies& studies, bool frictionless) {
  const datasets::Table& table = thesis.table(experiment);
  const std::string inputs =
      thesis.settings_text("macro") + " " + datasets::file_hash(scene_of_bin());
  std::vector<OrificeRuns> all;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    OrificeRuns of{.label = table.text(row, "orifice_D_cm"),
                   .orifice = table.number(row, "orifice_D_cm") * unit_in_si("cm")};
    const std::string name =
        fmt::format("study-macro-{}-{}cm", frictionless ? "frictionless" : "friction", of.label);
    of.runs = studies.result(
        name, inputs, [&] { return run_bin(thesis, studies, of.orifice, frictionless); });
    all.push_back(std::move(of));
  }
  return all;
}

}  // namespace graintruth::app
