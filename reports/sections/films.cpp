// The films, and how well they were tracked.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "reports/page/words.h"
#include "reports/sections/pictures.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

// "tracks/rep1.first.jpg" -> "first"
std::string moment_of(const std::filesystem::path& name) {
  const std::string extension = name.stem().extension().string();
  return extension.empty() ? name.stem().string() : extension.substr(1);
}

// "14 fiducials"; older runs only count them.
std::string scale_of(const Json& replicate) {
  const std::string scale = text(replicate, {"scale_from"});
  return scale.empty() ? count(number(replicate, {"fiducials_found"})) : scale;
}

TableView film_table(const Json& replicates) {
  TableView table("How well each film could be read",
                  {{"Replicate", Align::left},
                   {"Film", Align::left},
                   {"Grade", Align::left},
                   {"Frames"},
                   {"Frames tracked per second"},
                   {"Completeness"},
                   {"Gaps"},
                   {"Suspected swaps"},
                   {"Scale (px/mm)"},
                   {"Scale from", Align::left},
                   {"Calibration residual, RMS (mm)"},
                   {"largest (mm)"},
                   {"left out (mm)"},
                   {"Position error (px)"},
                   {"Start event (s)"}});
  for (const Json& replicate : replicates) {
    const double completeness = number(replicate, {"completeness"});
    const double event = number(replicate, {"event_time_s"});
    const double event_sigma = number(replicate, {"event_time_sigma_s"});
    const auto cell = [](const std::string& words) {
      return words.empty() ? std::string(nothing) : words;
    };
    table.add_row({text(replicate, {"name"}),
                   cell(text(replicate, {"film"})),
                   cell(text(replicate, {"grade"})),
                   count(number(replicate, {"frames"})),
                   significant(number(replicate, {"frames_per_second"})),
                   percent(completeness <= 1.0 ? 100.0 * completeness : completeness),
                   count(number(replicate, {"gaps"})),
                   count(number(replicate, {"suspected_swaps"})),
                   decimal(number(replicate, {"scale_px_per_mm"}), 3),
                   cell(scale_of(replicate)),
                   decimal(number(replicate, {"calibration_rms_mm"}), 2),
                   decimal(number(replicate, {"calibration_max_mm"}), 2),
                   decimal(number(replicate, {"calibration_leave_one_out_mm"}), 2),
                   decimal(number(replicate, {"pixel_error_px"}), 2),
                   std::isfinite(event_sigma)
                       ? fmt::format("{} ± {}", decimal(event, 3), decimal(event_sigma, 3))
                       : decimal(event, 3)});
  }
  return table;
}

}  // namespace

Section films_section(const RunData& data, Section section) {
  const Json& replicates = list(data.tracking, {"replicates"});
  if (replicates.empty()) {
    section.add_absence(
        "The quality of films cannot be shown: tracking.json is absent, empty or cannot be read. "
        "This is no error where no film was tracked, because tracks or discharge curves were "
        "imported.");
    return section;
  }
  constexpr std::size_t few = 8;  // films of which every picture has its place on the page
  std::vector<std::string> warnings;
  std::vector<Picture> pictures;
  std::vector<std::string> missing;
  std::vector<std::string> damaged;
  for (const Json& replicate : replicates) {
    const std::string name = text(replicate, {"name"});
    for (const Json& warning : list(replicate, {"warnings"}))
      if (warning.is_string())
        warnings.push_back(fmt::format("{}: {}", name, warning.get<std::string>()));
    for (const Json& listed : list(replicate, {"annotated_frames"})) {
      if (!listed.is_string()) continue;
      const std::filesystem::path picture = listed.get<std::string>();
      if (replicates.size() > few && moment_of(picture) != "middle") continue;
      const EmbeddedPicture embedded = embed_picture(data.folder, picture);
      if (embedded.state == PictureState::missing) missing.push_back(listed.get<std::string>());
      if (embedded.state == PictureState::cut_off) damaged.push_back(listed.get<std::string>());
      if (embedded.state != PictureState::whole) continue;
      pictures.push_back({fmt::format("{}: {} frame", name, moment_of(picture)), embedded.source});
    }
  }
  section.add_warnings(warnings);
  if (!pictures.empty()) {
    section.add_paragraph(
        "What was found, drawn on the film. Look whether every outline lies on its particle: no "
        "statistic on this page shows such an error.");
    if (replicates.size() > few) {
      section.add_paragraph(
          "There are many films, so only the middle frame of each is shown. The folder's tracks/ "
          "has the first and last ones as pictures, and films of all frames.");
    }
    section.add_gallery(pictures);
  }
  if (!missing.empty()) {
    section.add_absence(
        fmt::format("Annotated frames that the run lists but does not hold: {}.", joined(missing)));
  }
  if (!damaged.empty())
    section.add_absence(fmt::format("Annotated frames that were cut off: {}.", joined(damaged)));
  if (pictures.empty() && missing.empty() && damaged.empty()) {
    section.add_absence("This run left no annotated frames behind.");
  }
  section.begin_fold("How well each film could be read");
  section.add_paragraph(
      "Completeness: of all particles in all frames, the share that was found. Calibration "
      "residual: the distance of fiducials, clicked points or corners of a chessboard from where "
      "the "
      "fitted camera puts them. Left out: the same for one that is predicted from the others. "
      "Start event: its time on the "
      "film. All other times on this page count from it.");
  section.add_table(film_table(replicates));
  return section;
}

}  // namespace graintruth::reports
