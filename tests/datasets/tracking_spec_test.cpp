// What decides the tracks of a film, and nothing else, changes its fingerprint.
#include "datasets/experiment/tracking_spec.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "datasets/store/run_folder.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using Json = nlohmann::ordered_json;

// With something in every field.
TrackingSpec full_spec() {
  TrackingSpec spec;
  spec.film_hash = "0123";
  spec.corrections_hash = "4567";
  spec.body = {"balls", {{-0.01, 0.02}}, {{"length", 0.03}}, 4};
  spec.camera = {.frame_rate = 50.0,
                 .pixel_aspect = 1.1,
                 .fiducials = {{0.1, 0.2, 0.01}},
                 .points = {{10.0, 20.0, 0.1, 0.2}},
                 .chessboard = Chessboard{9, 6, 0.025, 0.1, 0.2, StatedPicture{"", "89ab"}},
                 .stick = Stick{{1.0, 2.0}, {3.0, 4.0}, 0.5, 0.001, {5.0, 6.0}},
                 .lens = LensBoard{8, 5, {{"", "cdef"}, {"", "fedc"}}},
                 .region = std::array{1, 2, 300, 400},
                 .noted_event_time = 0.3,
                 .checks = {{{{1.0, 2.0}, {3.0, 4.0}, 0.5, 0.001}}},
                 .masks = {{{{{1.0, 2.0}, {3.0, 4.0}, {5.0, 6.0}}}}}};
  spec.starts = {{0.1, 0.2, 0.3}};
  spec.rig = {.walls = {{"wall", 0.1, 0.2, 0.3, 0.4}},
              .face = MovingFace{0.1, 0.2, 0.3, -0.4},
              .box = OpenBox{0.1, 0.2, 0.05},
              .pane_gap = 0.01,
              .outline = SeenOutline{
                  .from_x = -0.1,
                  .to_x = 0.1,
                  .floor_z = 0.01,
                  .grains_before = {{{0.1, 0.2}}},
                  .grains_after = {{{0.3, 0.4}}},
                  .empty = {{{0.5, 0.6}}},
                  .mover = SeenOutline::Mover{"tube", {{0.1, 0.2}}, {0.0, 0.3}, true, 0.02},
                  .drum = SeenOutline::Drum{{0.1, 0.2}, 0.05, 0.3},
                  .surfaces = {{"upper", -0.1, 0.1, 0.05, 0.2}}}};
  return spec;
}

// Every number, text and flag of the JSON in turn, changed alone.
std::vector<Json> changed_alone(const Json& json) {
  std::vector<Json> changed;
  const Json flat = json.flatten();
  for (const auto& [place, value] : flat.items()) {
    Json other = flat;
    if (value.is_string()) {
      other[place] = value.get<std::string>() + "x";
    } else if (value.is_boolean()) {
      other[place] = !value.get<bool>();
    } else if (value.is_number_integer()) {
      other[place] = value.get<long>() + 1;
    } else {
      other[place] = std::nextafter(value.get<double>(), 1e9);
    }
    changed.push_back(other.unflatten());
  }
  return changed;
}

TEST(TrackingSpec, ReadsBackWhatItWrote) {
  const std::string text = json_text(full_spec());
  EXPECT_EQ(json_text(read_tracking_spec(text)), text);
}

TEST(TrackingSpec, AnyFieldChangedAloneChangesTheFingerprint) {
  std::set<std::string> prints = {fingerprint(full_spec())};
  const std::vector<Json> changed = changed_alone(Json::parse(json_text(full_spec())));
  EXPECT_GT(changed.size(), 50U);
  for (const Json& json : changed) {
    const TrackingSpec spec = read_tracking_spec(json.dump());
    EXPECT_EQ(json_text(spec), json.dump());  // it reached the spec
    EXPECT_TRUE(prints.insert(fingerprint(spec)).second) << json.dump();
  }
}

TEST(TrackingSpec, WhatIsNotThereChangesTheFingerprint) {
  std::set<std::string> prints = {fingerprint(full_spec())};
  TrackingSpec spec = full_spec();
  spec.body.count.reset();
  EXPECT_TRUE(prints.insert(fingerprint(spec)).second);
  spec.rig.face.reset();
  EXPECT_TRUE(prints.insert(fingerprint(spec)).second);
  spec.camera.noted_event_time.reset();
  EXPECT_TRUE(prints.insert(fingerprint(spec)).second);
  spec.starts.clear();
  EXPECT_TRUE(prints.insert(fingerprint(spec)).second);
}

class SpecOfAnExperiment : public testing::Test {
 protected:
  SpecOfAnExperiment() {
    experiment_.file = "experiment.toml";
    experiment_.particle =
        particle_of({.spheres = {{Eigen::Vector3d::Zero(), 0.005}}, .mass = 0.004}, 3);
    replicate_.rig.walls = {{"left", 0.0, 0.0, 0.0, 1.0}};
    replicate_.rig.front_back_gap = 0.011;
    experiment_.camera = {.frame_rate = 50.0, .fiducials = {{0.0, 0.0, 0.01}}};
    replicate_.name = "film";
    replicate_.video = folder_.write("film.mp4", "a film");
  }
  std::string print() const { return fingerprint(make_tracking_spec(experiment_, replicate_)); }

  tests::TemporaryFolder folder_;
  Experiment experiment_;
  Replicate replicate_;
};

TEST_F(SpecOfAnExperiment, FollowsWhatDecidesTracks) {
  std::set<std::string> prints = {print()};
  const auto expect_another = [&](const char* what) {
    EXPECT_TRUE(prints.insert(print()).second) << what;
  };
  // Decides where the front edges of walls are looked for
  replicate_.rig.front_back_gap = 0.012;
  expect_another("front_back_gap");
  replicate_.frame_rate = 100.0;
  expect_another("frame rate of the film");
  experiment_.particle.spheres[0].radius = 0.0051;
  expect_another("radius");
  replicate_.rig.moving_face = MovingFace{0.0, -1.0, 1.0, -0.04};
  expect_another("piston");
  folder_.write("film.mp4", "another film");
  expect_another("film");
  replicate_.corrections = folder_.write("repairs.csv", "frame,action,particle\n");
  expect_another("corrections");
  folder_.write("repairs.csv", "frame,action,particle\n3,delete,1\n");
  expect_another("content of the corrections");
}

TEST_F(SpecOfAnExperiment, IgnoresWhatOnlySimulationsAndPagesNeed) {
  const std::string before = print();
  experiment_.title = "another title";
  experiment_.particle.mass = 1.0;
  experiment_.material.bench = {{"friction_particle_wall", {0.9, 0.0}}};
  experiment_.tuned.push_back({"restitution", 0.1, 0.9});
  experiment_.measurement.frames = 3;
  replicate_.rig.walls[0].name = "right";
  replicate_.name = "renamed";
  EXPECT_EQ(print(), before);
}

TEST_F(SpecOfAnExperiment, HasTheOpeningOfItsFilm) {
  experiment_.particle.body = NamedBody{"plate", {{"semi_minor", 0.006}}};
  replicate_.rig.bed = BedBox{-0.1, 0.1, 0.3};
  replicate_.rig.opening = Opening{-0.025, 0.025, 0.0};
  const TrackingSpec spec = make_tracking_spec(experiment_, replicate_);
  EXPECT_EQ(spec.body.kind, "plate");
  EXPECT_EQ(spec.body.lengths.at("semi_minor"), 0.006);
  ASSERT_TRUE(spec.rig.box);
  EXPECT_EQ(spec.rig.box->opening, 0.05);
}

}  // namespace
}  // namespace graintruth::datasets
