#include "tracking/film/recording.h"

#include <fmt/format.h>

#include "datasets/store/input_error.h"
#include "tracking/film/fields.h"
#include "tracking/film/film_file.h"

namespace graintruth::tracking {

datasets::TrackingSpec as_recorded(datasets::TrackingSpec spec,
                                   const std::filesystem::path& video) {
  if (detect_scan(video) == Scan::progressive) return spec;
  const double declared = FilmFile(video).container().frame_rate;
  // A laboratory that states the field rate has said it already.
  constexpr double nearer_to_fields = 1.5;
  if (!(declared > 0.0) || spec.camera.frame_rate < nearer_to_fields * declared)
    spec.camera.frame_rate *= 2.0;
  return spec;
}

void require_motion(const datasets::TrackingSpec& spec, const datasets::Film& film, int pictures) {
  // A bed at rest needs no more than one picture
  if (spec.rig.outline) return;
  const bool is_moved = !spec.rig.walls.empty() || spec.rig.face || spec.rig.box;
  if (pictures != 1 || !is_moved) return;
  throw datasets::InputError(
      fmt::format("{}: is a single picture, but what moves in the rig is seen on several; give a "
                  "film, or the folder of its pictures",
                  film.video.string()));
}

}  // namespace graintruth::tracking
