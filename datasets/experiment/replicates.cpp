#include "datasets/experiment/replicates.h"

#include <fmt/format.h>

#include <set>
#include <string_view>

#include "datasets/experiment/pictures.h"

namespace graintruth::datasets {

namespace {

std::filesystem::path read_file(TomlSection& section,
                                const char* key,
                                const std::filesystem::path& folder) {
  const auto name = section.optional_text(key);
  if (!name) return {};
  const std::filesystem::path path = folder / *name;
  const bool may_be_pictures = std::string_view(key) == "video";
  if (!(may_be_pictures ? is_film(path) : std::filesystem::is_regular_file(path)))
    section.fail(key, fmt::format("names '{}', but there is no such file", path.string()));
  return path;
}

// The files that a replicate names, and the key of the one that names it.
const char* read_files(TomlSection& section,
                       const std::filesystem::path& folder,
                       Replicate& replicate) {
  replicate.video = read_file(section, "video", folder);
  replicate.tracks = read_file(section, "tracks", folder);
  replicate.outline = read_file(section, "outline", folder);
  replicate.discharge = read_file(section, "discharge", folder);
  replicate.curves = read_file(section, "curves", folder);
  if (!replicate.video.empty() && !replicate.tracks.empty())
    section.fail("tracks",
                 "is given beside 'video': grains are tracked once, in a film or elsewhere");
  if (!replicate.outline.empty() && !(replicate.video.empty() && replicate.tracks.empty()))
    section.fail(
        "outline",
        "is given beside 'video' or 'tracks': an outline stands for a film without tracks");
  if (replicate.file().empty())
    section.fail("video", "is needed, or 'tracks', 'outline', 'discharge' or 'curves'");
  replicate.corrections = read_file(section, "corrections", folder);
  if (!replicate.corrections.empty() && replicate.video.empty())
    section.fail("corrections", "is only known of films; correct the tracks in their own file");
  return !replicate.video.empty()       ? "video"
         : !replicate.tracks.empty()    ? "tracks"
         : !replicate.outline.empty()   ? "outline"
         : !replicate.discharge.empty() ? "discharge"
                                        : "curves";
}

// What only concerns files of others: their clock, their pixels, their axes.
void read_source(TomlSection& section, Replicate& replicate) {
  TrackSource& source = replicate.source;
  const auto only_for = [&](bool fits, std::string_view key, std::string_view files) {
    if (!fits) section.fail(key, fmt::format("is only known of {}", files));
  };
  source.frame_rate = replicate.frame_rate;
  if (const auto event = section.optional_quantity("event", time_units)) {
    only_for(replicate.video.empty(),
             section.has("event_s") ? "event_s" : "event_ms",
             "tracks, outlines and discharge curves; on films the event is found");
    source.event_time = *event;
  }
  source.scale = section.optional_quantity("scale", scale_units, positive);
  if (const auto eye = section.optional_numbers("eye", 3, length_units)) {
    const std::string key = section.key_of("eye", length_units);
    only_for(!replicate.outline.empty(), key, "outlines; of films the camera tells it");
    if (!((*eye)[2] > 0.0))
      section.fail(key, "must be x, z and the distance from the picture plane, which is above 0");
    replicate.eye = {(*eye)[0], (*eye)[1], (*eye)[2]};
  }
  const bool tracks = !replicate.tracks.empty();
  if (source.scale) only_for(tracks, "scale_px_per_mm", "tracks");
  const auto pair = [&](const std::optional<std::vector<double>>& numbers)
      -> std::optional<std::array<double, 2>> {
    if (!numbers) return std::nullopt;
    only_for(tracks, "origin_px", "tracks");
    return std::array{(*numbers)[0], (*numbers)[1]};
  };
  source.origin_px = pair(section.optional_numbers("origin", 2, pixel_units));
  source.origin = pair(section.optional_numbers("origin", 2, length_units));
  if (source.origin_px && source.origin) section.fail("origin_px", "gives 'origin' a second time");
  if (const auto direction = section.optional_text("y_axis")) {
    only_for(tracks, "y_axis", "tracks");
    if (*direction != "down" && *direction != "up")
      section.fail("y_axis", "must be \"down\" (as in pictures) or \"up\"");
    source.y_is_up = *direction == "up";
  }
}

}  // namespace

std::string usual_name(const std::filesystem::path& file) {
  const bool is_pattern = file.filename().string().find_first_of("*%") != std::string::npos &&
                          !std::filesystem::is_regular_file(file);
  const bool is_folder = !file.has_filename();  // its path ends with a slash
  return (is_pattern || is_folder ? file.parent_path().filename() : file.stem()).string();
}

std::vector<Replicate> read_replicates(TomlSection& root,
                                       const std::filesystem::path& folder,
                                       Purpose purpose,
                                       const ReadReplicateRig& read_own_rig) {
  std::vector<Replicate> replicates;
  std::set<std::string> names;
  for (TomlSection& section : root.sections("replicate")) {
    Replicate replicate;
    const char* key = read_files(section, folder, replicate);
    replicate.name = section.optional_text("name").value_or(usual_name(replicate.file()));
    if (replicate.name.empty() || replicate.name.find('/') != std::string::npos) {
      section.fail("name", "must be a plain file name");
    }
    if (!names.insert(replicate.name).second) {
      section.fail(section.has("name") ? "name" : key,
                   fmt::format("makes a second replicate called '{}'", replicate.name));
    }
    replicate.frame_rate = section.optional_quantity("frame_rate", rate_units, positive);
    replicate.noted_event_time = section.optional_quantity("noted_event", time_units, not_negative);
    if (replicate.noted_event_time && replicate.video.empty()) {
      section.fail(section.key_of("noted_event", time_units),
                   "is only known of films; of tracks and curves write event_s");
    }
    read_source(section, replicate);
    replicate.rig = read_own_rig(section);
    if (!replicate.outline.empty() && !replicate.rig.seen_outline)
      section.fail("outline",
                   "is given, but this kind of rig does not tell where the outline of its bed is");
    if (!replicate.discharge.empty() && !replicate.rig.opening && !replicate.rig.scene.exit_height)
      section.fail("discharge",
                   "is given, but no grains leave this rig; a scene needs exit_height");
    replicate.held_out = section.optional_flag("held_out");
    section.finish();
    replicates.push_back(std::move(replicate));
  }
  if (replicates.empty() && purpose == Purpose::tracking)
    root.fail("replicate", "is missing; write [[replicate]] and video = \"...\" for each film");
  if (replicates.size() < 2 && purpose == Purpose::calibration) {
    root.fail(
        "replicate",
        fmt::format("is given {} time(s), but at least 2 replicates are needed: the spread between "
                    "them is the measure of every difference",
                    replicates.size()));
  }
  return replicates;
}

}  // namespace graintruth::datasets
