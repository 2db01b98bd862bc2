// A film and a simulation of it, at the same times.
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "datasets/store/input_error.h"
#include "reports/page/words.h"
#include "reports/sections/pictures.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

// The list of the pictures; null where there is none.
Json read_list(const datasets::RunFolder& folder) {
  const std::filesystem::path file = folder.side_by_side_list();
  if (!std::filesystem::is_regular_file(file)) return nullptr;
  Json list = Json::parse(datasets::read_whole(file), nullptr, false);
  if (list.is_discarded()) {
    throw datasets::InputError(fmt::format("{} is not valid JSON.", file.filename().string()));
  }
  return list;
}

std::string words_on_start(const RunData& data) {
  if (!list(data.result, {"comparison"}).empty()) {
    return " The simulation starts from the bed on this film, with a draw of the error of its "
           "tracks. Particles that have fallen through are taken out.";
  }
  if (!at(data.result, {"agreement"}).is_object()) return "";
  return " The simulation starts from the mean of all films' starting places, with a draw of their "
         "spread. So it is no copy of this film, but one more of its kind.";
}

}  // namespace

Section side_by_side_section(const RunData& data, Section section) {
  const Json pictures = read_list(data.folder);
  if (pictures.is_null()) {
    section.add_absence(
        "No film was shown beside a simulation in this run (side_by_side.json is absent). This is "
        "no error where no film was tracked.");
    return section;
  }
  // 1. What is there of the stills
  Json stills = Json::array();
  std::vector<std::string> lost;
  for (const Json& still : list(pictures, {"stills"})) {
    const std::string file = text(still, {"file"});
    const EmbeddedPicture picture = embed_picture(data.folder, file);
    if (picture.state != PictureState::whole) {
      lost.push_back(file);
      continue;
    }
    const double hundredths = std::round(100.0 * number(still, {"time_s"})) + 0.0;  // no -0
    stills.push_back(
        {{"picture", picture.source}, {"moment", decimal(0.01 * hundredths, 2) + "\u00a0s"}});
  }
  // 2. On paper, and without scripts: the first, the middle and the last
  for (std::size_t i = 0; i < stills.size(); ++i)
    stills[i]["key"] = i == 0 || i == stills.size() / 2 || i + 1 == stills.size();
  const std::string replicate = text(pictures, {"replicate"});
  const bool shows_outline = text(pictures, {"shows"}) == "outline";
  section.add_paragraph(fmt::format(
      "Left: the film {}, with what was found drawn on it. Right: one simulation at the parameters "
      "of this page, as the same camera would see it. {}{}",
      replicate,
      shows_outline ? "The line over it is the outline of the film."
                    : "A particle has the same colour in both.",
      words_on_start(data)));
  if (!stills.empty()) {
    section.add_template(
        "side_by_side",
        {{"stills", stills}, {"replicate", replicate}, {"film", text(pictures, {"film"})}});
  }
  if (!lost.empty())
    section.add_absence(fmt::format("Pictures that are missing or cut off: {}.", joined(lost)));
  return section;
}

}  // namespace graintruth::reports
