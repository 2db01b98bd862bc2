// Which beds and heaps of chapter 5 there are, and how each is found again.
#include "app/thesis/shape_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>

#include "calibrate/ensemble.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

const std::string parameters = "table_5_1_parameters";
const std::string scalars = "ch5_scalars";

// One run of many: a bed or a heap.
struct ShapeRun {
  int aspect_ratio = 1;
  std::uint64_t seed = 0;
  std::string name;
};

// How far all runs of a kind are. A run costs as its spheres do; its filling, or consolidation, is
// a half of it.
class ShapeProgress {
 public:
  ShapeProgress(std::string job, const std::vector<ShapeRun>& runs, ProgressLine& line)
      : job_(std::move(job)), runs_(runs), shares_(runs.size()), line_(line) {}

  // For one run, on any thread.
  PhaseProgress of(std::size_t run) {
    return [this, run, first = std::string()](
               const std::string& phase, double share, const std::string& detail) mutable {
      if (first.empty()) first = phase;
      shares_[run] = (phase == first ? 0.0 : 0.5) + 0.5 * share;
      show(runs_[run].name + " " + phase + " " + detail);
    };
  }
  void finish(std::size_t run) { shares_[run] = 1.0; }

 private:
  void show(const std::string& detail) {
    double done = 0.0, all = 0.0;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      done += runs_[i].aspect_ratio * shares_[i];
      all += runs_[i].aspect_ratio;
    }
    line_.show(job_, done / all, detail);
  }

  std::string job_;
  const std::vector<ShapeRun>& runs_;
  std::vector<std::atomic<double>> shares_;
  ProgressLine& line_;
};

// All aspect ratios and seeds of one kind: seed by seed, so that a study that was interrupted has
// whole sets, and the longest first, so that none is left to run alone at the end of a set.
std::vector<ShapeRun> runs_of(const ShapeKind& kind,
                              const ThesisData& thesis,
                              const Studies& studies) {
  const auto seeds =
      calibrate::make_seeds(studies.seed(), kind.settings, thesis.count(kind.settings, "seeds"));
  std::vector<double> ratios = thesis.settings(kind.settings, "aspect_ratios");
  std::sort(ratios.rbegin(), ratios.rend());
  std::vector<ShapeRun> runs;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    for (const double ratio : ratios) {
      const int aspect_ratio = static_cast<int>(std::lround(ratio));
      runs.push_back(
          {aspect_ratio,
           seeds[i],
           fmt::format("study-shape-aspect-ratio-{}-{}-{}", aspect_ratio, kind.name, i + 1)});
    }
  }
  return runs;
}

// What one run depends on besides its aspect ratio and seed.
std::string inputs_of(const ShapeKind& kind, const ThesisData& thesis) {
  std::string inputs = fmt::format("{} {} {} particles of {} m in {} m, orifice {}",
                                   thesis.settings_text_of_a_run(kind.settings),
                                   datasets::file_hash(scene_of_hopper()),
                                   thesis.number(parameters, "particles"),
                                   thesis.si(parameters, "radius_equivalent_sphere"),
                                   thesis.si(parameters, "hopper_width"),
                                   thesis.si(parameters, "orifice_over_hopper_width"));
  for (const char* quantity : kind.printed)
    inputs += fmt::format("; {}={}", quantity, thesis.printed(scalars, quantity).text);
  return inputs;
}

// From spheres to the longest.
std::vector<ShapeRuns> by_aspect_ratio(const std::vector<ShapeRun>& runs, std::vector<Json> found) {
  std::map<int, ShapeRuns> of_ratio;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    ShapeRuns& all = of_ratio[runs[i].aspect_ratio];
    all.label = std::to_string(runs[i].aspect_ratio);
    if (found[i].is_null()) continue;
    if (found[i].contains("failed")) {
      all.failure = found[i].at("failed").get<std::string>();
    } else {
      all.runs.push_back(std::move(found[i]));
    }
  }
  std::vector<ShapeRuns> sorted;
  for (auto& [ratio, all] : of_ratio) sorted.push_back(std::move(all));
  return sorted;
}

}  // namespace

const ShapeKind bed_kind{
    "bed", "shape", run_bed, {"solid_fraction_mesh", "velocity_class_slow", "velocity_class_fast"}};
const ShapeKind heap_kind{
    "heap",
    "heap",
    run_heap,
    {"impact_velocity_AR1", "impact_velocity_AR2", "impact_velocity_AR4", "heap_friction"}};

Simulated ShapeRuns::of(const char* key) const {
  std::vector<double> found;
  for (const Json& run : runs)
    if (run.at(key).is_number()) found.push_back(run.at(key).get<double>());
  return found.empty() ? Simulated{.seeds = 0} : over_seeds(found);
}

std::vector<ShapeRuns> run_all(const ShapeKind& kind, const ThesisData& thesis, Studies& studies) {
  const std::vector<ShapeRun> runs = runs_of(kind, thesis, studies);
  const std::string inputs = inputs_of(kind, thesis);
  std::vector<Json> found(runs.size());
  ShapeProgress progress(fmt::format("study-shape, {}s", kind.name), runs, studies.progress());
  studies.in_parallel(static_cast<int>(runs.size()), [&](int turn) {
    const auto i = static_cast<std::size_t>(turn);
    found[i] = studies.result(runs[i].name, inputs, [&] {
      return kind.run(thesis, runs[i].aspect_ratio, runs[i].seed, progress.of(i));
    });
    progress.finish(i);
  });
  return by_aspect_ratio(runs, std::move(found));
}

std::vector<ShapeRuns> stored_of(const ShapeKind& kind,
                                 const ThesisData& thesis,
                                 const Studies& studies) {
  const std::vector<ShapeRun> runs = runs_of(kind, thesis, studies);
  const std::string inputs = inputs_of(kind, thesis);
  std::vector<Json> found;
  for (const ShapeRun& run : runs) found.push_back(studies.stored(run.name, inputs));
  return by_aspect_ratio(runs, std::move(found));
}

}  // namespace graintruth::app
