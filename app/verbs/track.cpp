// graintruth track: films to tracks, quality figures and overlays.
#include <fmt/format.h>

#include <cmath>

#include "app/run/session.h"
#include "reports/page/run_data.h"

namespace graintruth::app {

int run_track(const TrackCommand& command) {
  Session session("track", command.common, command.experiment);
  session.track();
  const std::string text = datasets::read_whole(session.folder().tracking());
  const auto tracking = reports::Json::parse(text);
  const std::vector<std::string> measured = session.write_measured();
  write_run_record(session.folder(), command.common, session.experiment(), session.record());
  if (command.common.json) {
    fmt::print("{}", text);
    return 0;
  }
  for (const datasets::Warning& doubt : session.films().doubts)
    fmt::print("Warning: {}\n", doubt.text);
  for (const auto& film : reports::list(tracking, {"replicates"})) {
    fmt::print("{}: {}, {} frames, ",
               reports::text(film, {"name"}),
               reports::text(film, {"grade"}),
               reports::number(film, {"frames"}));
    if (film.contains("outline")) {
      fmt::print("outline to {:.3f} mm in {:.1f} % of its columns, ",
                 reports::number(film, {"outline", "sigma_mm"}),
                 100.0 * reports::number(film, {"outline", "share_of_columns_seen"}));
    } else {
      fmt::print("{:.2f} % of all poses found, ", 100.0 * reports::number(film, {"completeness"}));
    }
    if (const double rms = reports::number(film, {"calibration_rms_mm"}); std::isfinite(rms))
      fmt::print("calibration {:.3f} mm rms, ", rms);
    fmt::print("event at {:.4f} s of film\n", reports::number(film, {"event_time_s"}));
    for (const auto& found : reports::list(film, {"findings"}))
      fmt::print("  {}\n", reports::text(found, {}));
    for (const auto& warning : reports::list(film, {"warnings"}))
      fmt::print("  warning: {}\n", reports::text(warning, {}));
  }
  for (const auto& note : reports::list(tracking, {"notes"}))
    fmt::print("Note: {}\n", reports::text(note, {}));
  for (const std::string& line : measured) fmt::print("{}\n", line);
  fmt::print("Tracks and overlays: {}\n", (session.folder().root / "tracks").string());
  return 0;
}

}  // namespace graintruth::app
