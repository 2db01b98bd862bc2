// Recordings, and how runs ended, in the archives of store/archive.h.
#pragma once

#include "calibrate/engines/engine.h"
#include "datasets/store/archive.h"
#include "datasets/store/trajectory_archive.h"

namespace graintruth::datasets {

template <>
struct EnumWords<calibrate::RunStatus> {
  static constexpr std::array words = {"completed", "unstable", "timed_out"};
};

template <class Archive>
void list_fields(Archive& archive, Eye& eye) {
  auto& [x, z, distance] = eye;
  archive("x_m", x)("z_m", z)("distance_m", distance);
}

template <class Archive>
void list_fields(Archive& archive, Outline& outline) {
  auto& [column, time, height, sigma, eye, surface] = outline;
  archive("column_m", column)("time_s", time)("height_m", height)("sigma_m", sigma)("eye", eye);
  list_if_any(archive, "surface", surface);
}

template <class Archive>
void list_fields(Archive& archive, DischargeCurve& discharge) {
  auto& [time, mass] = discharge;
  archive("time_s", time)("mass_kg", mass);
}

template <class Archive>
void list_fields(Archive& archive, Curve& curve) {
  auto& [time, value, sigma] = curve;
  archive("time_s", time)("value", value)("sigma", sigma);
}

template <class Archive>
void list_fields(Archive& archive, Recording& recording) {
  auto& [tracks, outlines, discharge, curves, notes] = recording;
  archive("tracks", tracks);
  list_surfaces(archive, outlines);
  archive("discharge", discharge)("curves", curves);
  archive("notes", notes);
}

}  // namespace graintruth::datasets

namespace graintruth::calibrate {

template <class Archive>
void list_fields(Archive& archive, EngineRun& run) {
  auto& [status, message, recording, time_step, seconds] = run;
  archive("status", status)("message", message)("time_step_s", time_step)("seconds", seconds);
  archive("recording", recording);
}

}  // namespace graintruth::calibrate
