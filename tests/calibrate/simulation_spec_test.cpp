// What decides a simulation, and nothing else, is in its fingerprint.
#include "calibrate/engines/simulation_spec.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "datasets/scene/scene_file.h"

namespace graintruth::calibrate {
namespace {

using Json = nlohmann::ordered_json;

// With something in every list.
SimulationSpec full_spec() {
  SimulationSpec spec;
  spec.engine_version = "1";
  spec.parameters = {{"friction_particle_wall", 0.3}};
  spec.time_step_fraction = 0.1;
  spec.seed = 7;
  spec.scene = datasets::load_scene(GRAINTRUTH_SOURCE_DIR "/datasets/scenes/box_3d.toml");
  spec.start = {{{0.1, 0.2, 0.3}}, {0.01, 0.02, 0.03}};
  spec.scene.fill.jitter = 0.001;
  spec.scene.fill.body_centred = false;
  spec.scene.fill.within = datasets::SceneRoom{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 0.5};
  spec.record = {true,
                 {"wall_force_floor_z_n"},
                 {OutlinePlan{{0.1, 0.2}, {0.1, 0.2, 0.3}},
                  OutlinePlan{{0.3, 0.4}, {0.1, 0.2, 0.3}, "upper", 0.1, 0.2}}};
  return spec;
}

TEST(SimulationSpec, AnyFieldChangedAloneChangesTheFingerprint) {
  const std::string text = to_text(full_spec());
  EXPECT_EQ(to_text(spec_from_text(text)), text);
  std::set<std::string> prints = {fingerprint_of(full_spec())};
  const Json whole = Json::parse(text), flat = whole.flatten();
  int changed = 0;
  for (const auto& [place, value] : flat.items()) {
    Json other = whole;
    Json& leaf = other[Json::json_pointer(place)];
    if (value.is_boolean()) {
      leaf = !value.get<bool>();
    } else if (value.is_number_integer()) {
      leaf = value.get<long>() + 1;
    } else if (value.is_number()) {
      leaf = std::nextafter(value.get<double>(), 1e9);
    } else {
      continue;  // words of lists, and what is not there
    }
    const SimulationSpec spec = spec_from_text(other.dump());
    EXPECT_TRUE(prints.insert(fingerprint_of(spec)).second) << place;
    ++changed;
  }
  EXPECT_GT(changed, 80);
}

// What came later and is not asked for stands in no text, so that older fingerprints stay.
TEST(SimulationSpec, WhatIsNotAskedForIsNotWritten) {
  SimulationSpec spec = full_spec();
  const std::string whole = to_text(spec);
  spec.record.outlines.clear();
  spec.scene.fill.jitter.reset();
  spec.scene.fill.body_centred.reset();
  spec.scene.fill.within.reset();
  const std::string text = to_text(spec);
  for (const char* key :
       {"\"outline\"", "\"upper\"", "\"jitter_m\"", "\"body_centred\"", "\"within\""}) {
    EXPECT_NE(whole.find(key), std::string::npos) << key;
    EXPECT_EQ(text.find(key), std::string::npos) << key;
  }
}

// A plate's thickness is in its moments of inertia, and these are in the fingerprint.
TEST(SimulationSpec, PartsSayWhatChanged) {
  const auto differing = [](const SimulationSpec& one, const SimulationSpec& other) {
    const SpecParts a = parts_of(one), b = parts_of(other);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].first, b[i].first);
      if (a[i].second != b[i].second) names.push_back(a[i].first);
    }
    return names;
  };
  using Names = std::vector<std::string>;
  SimulationSpec spec = full_spec();
  spec.scene.particles.front().inertia = Eigen::Vector3d(1.0, 2.0, 3.0);
  EXPECT_EQ(differing(full_spec(), spec), Names{"particle"});
  spec = full_spec();
  spec.scene.surfaces.front().rolling_friction = 0.1;
  EXPECT_EQ(differing(full_spec(), spec), Names{"material"});
  spec = full_spec();
  spec.scene.walls.front().motion.velocity.z() += 1.0;
  EXPECT_EQ(differing(full_spec(), spec), Names{"rig"});
  spec = full_spec();
  spec.engine_version = "2";
  EXPECT_EQ(differing(full_spec(), spec), Names{"the program's numbers"});
  // Those of one run of the same problem
  spec = full_spec();
  spec.seed = 8;
  spec.time_step_fraction = 0.05;
  EXPECT_EQ(differing(full_spec(), spec), Names{});
}

}  // namespace
}  // namespace graintruth::calibrate
