// Trajectories in the archives of store/archive.h.
#pragma once

#include "datasets/store/archive.h"
#include "datasets/store/trajectories.h"

namespace graintruth::datasets {

namespace archive_detail {

// Three numbers a pose: there are thousands of them.
template <>
struct Converter<Pose> {
  static Json write(Pose& pose) {
    auto& [x, z, angle] = pose;
    return {number_json(x), number_json(z), number_json(angle)};
  }
  static void read(const Json& json, Pose& pose, bool) {
    if (!json.is_array() || json.size() != 3)
      throw std::invalid_argument("must be a list of x, z and angle");
    auto& [x, z, angle] = pose;
    x = number_of(json[0]);
    z = number_of(json[1]);
    angle = number_of(json[2]);
  }
};

}  // namespace archive_detail

template <class Archive>
void list_fields(Archive& archive, Trajectories& tracks) {
  auto& [time, particles, poses, sigmas, scores] = tracks;
  archive("time_s", time)("particles", particles)("poses", poses)("sigmas", sigmas);
  archive("scores", scores);
}

}  // namespace graintruth::datasets
