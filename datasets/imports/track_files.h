// Tracks from files: ours, and those of other programs, whose columns, clocks and pixels are turned
// into times from the start event and metres.
#pragma once

#include <array>
#include <filesystem>
#include <optional>

#include "datasets/store/trajectories.h"

namespace graintruth::datasets {

// What a laboratory says of a file of tracks that the file itself does not.
struct TrackSource {
  std::optional<double> scale;                     // px/m; needed for positions in pixels
  std::optional<std::array<double, 2>> origin_px;  // where the rig's origin lies in the picture
  std::optional<std::array<double, 2>> origin;     // the same in m, from the file's own origin
  std::optional<bool> y_is_up;                     // which way y grows; down unless said
  std::optional<double> frame_rate;                // Hz; counts for more than the file's times
  // Hz, the camera's; tells the time where nothing else does, and must not contradict the file
  double usual_frame_rate = 0.0;
  double event_time = 0.0;  // s, of the start event on the file's clock
};

struct ReadTracks {
  Trajectories tracks;
  // Particles bear the numbers of their starting places, as in our own files. Other programs number
  // particles as they find them; then they come here in the order of those numbers.
  bool numbered_by_place = true;
  std::vector<std::string> notes;  // sentences on what of the file was not taken as it stands
};

// Reads what write_tracks wrote; any table with columns of column_names.h, parted by commas, tabs
// or semicolons; TrackMate's table of spots with its three further header rows; and TrackMate's
// "Export tracks to XML file". A column y grows downwards unless the source says otherwise, as in
// every picture; a column z grows upwards. Angles may be missing (NaN) and are unwrapped. Throws
// InputError with file, line and column for what cannot be used, and where the times of the file
// contradict the frame rate that is stated.
ReadTracks read_track_file(const std::filesystem::path& file, const TrackSource& source = {});

// As above, of a file of ours.
Trajectories read_tracks(const std::filesystem::path& file);

}  // namespace graintruth::datasets
