// Films drawn by a test, tracked as if they had come from a camera.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/store/input_error.h"
#include "tracking/film/recording.h"
#include "tracking/film/synthetic_video.h"
#include "tracking/registry.h"
#include "tracking/track_film.h"

namespace graintruth::tracking {

constexpr double frame_rate = 50.0;  // Hz, of all of them

// A file of the running test.
inline std::filesystem::path temporary(const std::string& name) {
  const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  return std::filesystem::temp_directory_path() / ("graintruth_" + test + "_" + name);
}

// The pictures as a film; the file is gone with it.
class DrawnFilm {
 public:
  explicit DrawnFilm(const std::vector<cv::Mat>& pictures, double rate = frame_rate)
      : film_{.name = "drawn", .video = temporary("film.avi"), .experiment = "drawn.toml"} {
    write_film(film_.video, pictures, rate);
  }
  ~DrawnFilm() { std::filesystem::remove(film_.video); }
  DrawnFilm(const DrawnFilm&) = delete;
  DrawnFilm& operator=(const DrawnFilm&) = delete;

  const datasets::Film& film() const { return film_; }

 private:
  datasets::Film film_;
};

// By the tracker that the registry finds for it.
inline TrackedFilm track(const datasets::TrackingSpec& spec,
                         const datasets::Film& film,
                         const TrackingOptions& options = {}) {
  const datasets::TrackingSpec recorded = as_recorded(spec, film.video);
  return track_film(*make_tracker(recorded, film), recorded, film, options);
}

inline TrackedFilm track(const datasets::TrackingSpec& spec, const std::vector<cv::Mat>& pictures) {
  const DrawnFilm drawn(pictures);
  return track(spec, drawn.film());
}

inline bool tells(const TrackingSummary& summary, const std::string& words) {
  for (const std::string& sentence : summary.warnings)
    if (sentence.find(words) != std::string::npos) return true;
  return false;
}

// What the tracker says of a film that it does not take; empty where it takes it.
inline std::string refusal(const datasets::TrackingSpec& spec,
                           const std::vector<cv::Mat>& pictures) {
  try {
    track(spec, pictures);
  } catch (const datasets::InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace graintruth::tracking
