// The camera of an experiment as its file states it: the clock, the pixels, and what gives scale.
#pragma once

#include <optional>
#include <vector>

namespace graintruth::datasets {

class TomlSection;

// A dark disc on a light ground, in the plane of the particle centres.
struct Fiducial {
  double x = 0.0, z = 0.0;  // m, centre
  double diameter = 0.0;    // m
};

struct Camera {
  double frame_rate = 0.0;    // Hz, true rate of the recording
  double pixel_aspect = 1.0;  // width of a pixel over its height
  std::vector<Fiducial> fiducials;
  // When the event should be seen, in seconds of film, if the laboratory noted it. Only checks what
  // is found.
  std::optional<double> noted_event_time;
};

// Reads and checks [camera]. Films need a scale, `films` says whether there are any.
Camera read_camera(TomlSection section, bool films);

}  // namespace graintruth::datasets
