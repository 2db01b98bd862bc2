// Films drawn by a test, tracked as if they had come from a camera.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/input_error.h"
#include "tracking/synthetic_video.h"
#include "tracking/track_video.h"

namespace graintruth::tracking {

constexpr double frame_rate = 50.0;  // Hz, of all of them

// A file of the running test.
inline std::filesystem::path temporary(const std::string& name) {
  const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  return std::filesystem::temp_directory_path() / ("graintruth_" + test + "_" + name);
}

inline TrackedFilm track(const datasets::Experiment& experiment,
                         const std::vector<cv::Mat>& pictures) {
  datasets::Replicate replicate;
  replicate.name = "drawn";
  replicate.video = temporary("film.avi");
  write_film(replicate.video, pictures, frame_rate);
  struct Remove {
    std::filesystem::path file;
    ~Remove() { std::filesystem::remove(file); }
  } remove{replicate.video};
  return track_video(experiment, replicate);
}

inline bool tells(const TrackingSummary& summary, const std::string& words) {
  for (const std::string& sentence : summary.warnings)
    if (sentence.find(words) != std::string::npos) return true;
  return false;
}

// What the tracker says of a film that it does not take; empty where it takes it.
inline std::string refusal(const datasets::Experiment& experiment,
                           const std::vector<cv::Mat>& pictures) {
  try {
    track(experiment, pictures);
  } catch (const datasets::InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace graintruth::tracking
