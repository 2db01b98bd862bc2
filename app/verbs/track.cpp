// graintruth track: films to tracks, quality figures and overlays.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/run/session.h"

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
    fmt::print("{}: {}, {} frames, {:.2f} % of all poses found, ",
               film["name"].get<std::string>(),
               film["grade"].get<std::string>(),
               film["frames"].get<int>(),
               100.0 * film["completeness"].get<double>());
    if (const auto& rms = film["calibration_rms_mm"]; rms.is_number())
      fmt::print("calibration {:.3f} mm rms, ", rms.get<double>());
    fmt::print("event at {:.4f} s of film\n", film["event_time_s"].get<double>());
    for (const auto& found : film["findings"]) fmt::print("  {}\n", found.get<std::string>());
    for (const auto& warning : film["warnings"])
      fmt::print("  warning: {}\n", warning.get<std::string>());
  }
  for (const auto& note : tracking["notes"]) fmt::print("Note: {}\n", note.get<std::string>());
  for (const std::string& line : measured) fmt::print("{}\n", line);
  fmt::print("Tracks and overlays: {}\n", (session.folder().root / "tracks").string());
  return 0;
}

}  // namespace graintruth::app
