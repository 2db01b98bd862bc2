// The films and how well they were read: without this the intervals above mean nothing.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "reports/sections.h"
#include "reports/words.h"

namespace graintruth::reports {

namespace {

// RFC 4648, with padding.
std::string base64(std::string_view bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t taken = std::min<std::size_t>(3, bytes.size() - i);
    std::array<unsigned, 3> triple = {};
    for (std::size_t k = 0; k < taken; ++k) triple[k] = static_cast<unsigned char>(bytes[i + k]);
    const unsigned bits = triple[0] << 16 | triple[1] << 8 | triple[2];
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= taken ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// Pictures lie in the run folder; a name that leads out of it is not followed.
bool stays_inside(const std::filesystem::path& name) {
  if (name.empty() || name.is_absolute()) return false;
  for (const auto& part : name.lexically_normal())
    if (part == "..") return false;
  return true;
}

// A JPEG file begins and ends with these marks (ITU T.81, table B.1).
bool is_whole_picture(std::string_view content) {
  return content.starts_with("\xFF\xD8") && content.ends_with("\xFF\xD9");
}

// "tracks/rep1.first.jpg" -> "first"
std::string moment_of(const std::filesystem::path& name) {
  const std::string extension = name.stem().extension().string();
  return extension.empty() ? name.stem().string() : extension.substr(1);
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
                   {"Fiducials"},
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
                   count(number(replicate, {"fiducials_found"})),
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
        "That is as it should be where no film was tracked, because tracks or discharge curves "
        "came ready-made.");
    return section;
  }
  section.add_paragraph(
      "Completeness is the share of particles and frames in which a particle was found. The "
      "calibration residual is how "
      "far the fiducials lie from where the fitted camera puts them; left out, when each is "
      "predicted from the others. "
      "The start event is its time on the film; all times elsewhere count from it.");
  section.add_table(film_table(replicates));

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
      const std::filesystem::path file = data.folder.root / picture;
      if (!stays_inside(picture) || !std::filesystem::is_regular_file(file)) {
        missing.push_back(listed.get<std::string>());
        continue;
      }
      const std::string content = datasets::read_whole(file);
      if (!is_whole_picture(content)) {
        damaged.push_back(listed.get<std::string>());
        continue;
      }
      pictures.push_back({fmt::format("{}: {} frame", name, moment_of(picture)),
                          "data:image/jpeg;base64," + base64(content)});
    }
  }
  section.add_warnings(warnings);
  section.add_heading("Annotated frames");
  if (!pictures.empty()) {
    section.add_paragraph(
        "What was found, drawn on the film. An outline that is not on its particle is an error "
        "that no statistic on "
        "this page would show.");
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
  return section;
}

}  // namespace graintruth::reports
