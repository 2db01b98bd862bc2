// graintruth track: films to tracks, quality figures and overlays.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/session.h"

namespace graintruth::app {

int run_track(const TrackCommand& command) {
  Session session("track", command.common, command.experiment);
  session.track();
  const std::string text = datasets::read_whole(session.folder().tracking());
  const auto tracking = nlohmann::json::parse(text);
  const std::vector<std::string> measured = session.write_measured();
  write_run_record(session.folder(), command.common, session.experiment(), session.record());
  if (command.common.json) {
    fmt::print("{}", text);
    return 0;
  }
  for (const auto& film : tracking["replicates"]) {
    fmt::print(
        "{}: {}, {} frames, {:.2f} % of all poses found, calibration {:.3f} mm rms, event at "
        "{:.4f} s of film\n",
        film["name"].get<std::string>(),
        film["grade"].get<std::string>(),
        film["frames"].get<int>(),
        100.0 * film["completeness"].get<double>(),
        film["calibration_rms_mm"].get<double>(),
        film["event_time_s"].get<double>());
    if (film.contains("bed")) {
      const auto& bed = film["bed"];
      fmt::print("  {} particles in the first frame", bed["particles_in_first_frame"].get<int>());
      const int ran_out = bed["discharged"].get<int>(), remain = bed["remaining"].get<int>();
      // Of a smeared film nobody knows
      if (ran_out + remain > 0) fmt::print(", {} ran out, {} remain", ran_out, remain);
      fmt::print("\n");
    }
    for (const auto& warning : film["warnings"])
      fmt::print("  warning: {}\n", warning.get<std::string>());
  }
  for (const std::string& line : measured) fmt::print("{}\n", line);
  fmt::print("Tracks and overlays: {}\n", (session.folder().root / "tracks").string());
  return 0;
}

}  // namespace graintruth::app
