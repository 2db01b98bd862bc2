// One kind of body on film: found in the first picture, followed into the next ones, drawn over
// them. A kind is one file with one implementation, and one line in tracking/trackers.def.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "datasets/store/outline.h"
#include "datasets/store/table.h"
#include "datasets/store/trajectories.h"
#include "tracking/tracking_summary.h"
#include "tracking/view/film_camera.h"

namespace graintruth::tracking {

struct Picture {
  cv::Mat frame;        // 8-bit BGR
  int number = 0;       // from 0
  int parity = -1;      // which rows it really holds, see VideoReader
  double moment = 0.0;  // when it was taken, see VideoReader
};

// A particle at a place.
struct DrawnBody {
  std::size_t particle = 0;  // from 0
  datasets::Pose pose;       // the angle may be NaN
  cv::Scalar colour;         // blue, green, red
  bool filled = false;       // a thing of its own, as in a simulation; else lines over a film
};

// Of one film, whose files and spec it knows from its making. Calls come in the order of this list.
// Sentences go to the summary; InputError says that the film cannot be tracked.
class ParticleTracker {
 public:
  virtual ~ParticleTracker() = default;

  // Called with every picture before anybody looks at it: takes out noise, say.
  virtual void prepare(cv::Mat& /*frame*/, int /*number*/) {}
  // Whether the film must be seen from end to end before the first particle is looked for.
  virtual bool looks_ahead() const { return false; }
  virtual void look_ahead(const Picture& /*picture*/, const FilmCamera& /*camera*/) {}

  // Who is where in the first picture.
  virtual void find_first(const Picture& picture,
                          const FilmCamera& camera,
                          TrackingSummary& summary) = 0;
  virtual void follow(const Picture& picture) = 0;
  // Who was where when, with uncertainty and time zero. The summary knows the film's own figures by
  // now, and gets those of particles and event.
  virtual datasets::Trajectories finish(TrackingSummary& summary) = 0;

  // The free surfaces of the bed after `finish`, where these are what is looked for; else none.
  virtual std::span<const datasets::Outline> outlines() const { return {}; }

  // As it looks in this film; as the experiment states it before `finish`.
  virtual void draw(cv::Mat& picture, const Camera& camera, const DrawnBody& body) const = 0;
  // What else was found in a frame of the film.
  virtual void draw_frame(cv::Mat& /*picture*/,
                          const Camera& /*camera*/,
                          std::size_t /*frame*/) const {}
  // Many and small: numbers and long trails would hide them.
  virtual bool is_crowd() const { return false; }

  // Figures that no other kind of body has, for tracking.json.
  virtual void describe(nlohmann::ordered_json& /*film*/) const {}
  // What else such a film tells; tables by the names of their files, tracks/<film>.<name>.csv.
  virtual std::map<std::string, datasets::Table> tables() const { return {}; }
};

}  // namespace graintruth::tracking
