#include "bench/tracking/films.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "tracking/film/recording.h"

namespace graintruth::bench {

namespace fs = std::filesystem;

std::vector<Filmed> films_of(const std::string& data_set,
                             const std::string& file,
                             const std::string& part) {
  const fs::path folder = fs::path(GRAINTRUTH_SOURCE_DIR) / "datasets" / data_set;
  std::vector<fs::path> files = {folder / "experiment.toml", folder / "other_cameras.toml"};
  if (!file.empty()) files = {file};
  std::vector<Filmed> films;
  for (const fs::path& each : files) {
    try {
      const datasets::Experiment experiment = datasets::load_experiment(each);
      for (const datasets::Replicate& replicate : experiment.replicates) {
        const bool is_new = std::none_of(films.begin(), films.end(), [&](const Filmed& film) {
          return film.replicate.name == replicate.name;
        });
        if (!is_new || replicate.name.find(part) == std::string::npos) continue;
        films.push_back({experiment,
                         replicate,
                         datasets::film_of(experiment, replicate),
                         tracking::as_recorded(datasets::make_tracking_spec(experiment, replicate),
                                               replicate.video)});
      }
    } catch (const std::exception& error) {
      fmt::print("skipped: {}\n", error.what());
    }
  }
  return films;
}

std::vector<Filmed> pale_films() {
  const fs::path source = GRAINTRUTH_SOURCE_DIR;
  const fs::path folder = source.parent_path() / "shared" / "lab-videos" / "micro-pale";
  std::vector<Filmed> films;
  if (!fs::exists(folder)) {
    fmt::print("skipped: {} is not there\n", folder.string());
    return films;
  }
  datasets::Experiment experiment =
      datasets::load_experiment(source / "datasets" / "micro" / "experiment.toml");
  experiment.replicates.resize(2);
  for (datasets::Replicate& replicate : experiment.replicates) {
    replicate.video = folder / replicate.video.filename();
    replicate.name = "pale " + replicate.name;
  }
  for (const datasets::Replicate& replicate : experiment.replicates)
    films.push_back({experiment,
                     replicate,
                     datasets::film_of(experiment, replicate),
                     tracking::as_recorded(datasets::make_tracking_spec(experiment, replicate),
                                           replicate.video)});
  return films;
}

}  // namespace graintruth::bench
