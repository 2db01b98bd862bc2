// Every parameter of the registry: what it sets is what it is read back as, and nothing else moves.
#include <gtest/gtest.h>

#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"
#include "datasets/scene/scene_archive.h"
#include "datasets/scene/scene_file.h"

namespace graintruth::datasets {
namespace {

// A scene with walls of several names that share a material.
SceneData scene() { return load_scene(GRAINTRUTH_SOURCE_DIR "/datasets/scenes/micro_thesis.toml"); }

// In the middle of the values that a search may take.
double usual_value(const ParameterKind& kind) {
  return 0.4 * kind.usual_lower + 0.6 * kind.usual_upper;
}

std::string name_of(const ParameterKind& kind, const SceneData& scene) {
  return std::string(kind.name) + (kind.is_of_a_wall ? scene.walls.front().name : "");
}

TEST(Parameters, AreReadBackAsTheyWereSet) {
  for (const ParameterKind* kind : parameter_kinds()) {
    SceneData with = scene();
    const Parameter parameter = parameter_named(name_of(*kind, with));
    const double value = usual_value(*kind);
    kind->apply(value, parameter.wall, with);
    EXPECT_EQ(kind->value_in(parameter.wall, with), value) << parameter.name;
    EXPECT_NE(to_json(with), to_json(scene())) << parameter.name << " sets nothing";
    // Set twice is set once
    SceneData again = with;
    kind->apply(value, parameter.wall, again);
    EXPECT_EQ(to_json(again), to_json(with)) << parameter.name;
  }
}

TEST(Parameters, DoNotMoveEachOther) {
  for (const ParameterKind* first : parameter_kinds()) {
    for (const ParameterKind* second : parameter_kinds()) {
      // One of a special kind moves part of what the general one sets
      if (first == second || !first->same_as.empty() || !second->same_as.empty()) continue;
      SceneData with = scene();
      first->apply(usual_value(*first), "", with);
      second->apply(usual_value(*second), "", with);
      EXPECT_EQ(first->value_in("", with), usual_value(*first))
          << second->name << " moved " << first->name;
    }
  }
}

// What is general is applied first, so that it does not undo what is special.
TEST(Parameters, ThatAreSpecialComeAfterTheGeneralOne) {
  for (const ParameterKind* kind : parameter_kinds()) {
    if (kind->same_as.empty()) continue;
    EXPECT_TRUE(comes_before(kind->same_as, name_of(*kind, scene()))) << kind->name;
    SceneData with = scene();
    const Parameter special = parameter_named(name_of(*kind, with));
    apply_parameters({{special.name, usual_value(*kind)},
                      {std::string(kind->same_as), 0.5 * usual_value(*kind)}},
                     with);
    EXPECT_EQ(kind->value_in(special.wall, with), usual_value(*kind)) << kind->name;
  }
}

TEST(Parameters, SlidingFrictionIsNeverAboveStaticFriction) {
  SceneData with = scene();
  for (SceneSurfaces& surfaces : with.surfaces) surfaces.static_friction = 0.3;
  for (const ParameterKind* kind : parameter_kinds()) {
    SceneData moved = with;
    for (const double value : {kind->usual_lower, kind->usual_upper, kind->usual_lower}) {
      kind->apply(value, parameter_named(name_of(*kind, with)).wall, moved);
      for (const SceneSurfaces& surfaces : moved.surfaces)
        EXPECT_GE(surfaces.static_friction, surfaces.friction) << kind->name;
    }
  }
}

TEST(Parameters, TellWhatAReaderNeeds) {
  for (const ParameterKind* kind : parameter_kinds()) {
    EXPECT_FALSE(kind->title.empty()) << kind->name;
    EXPECT_FALSE(kind->phrase.empty()) << kind->name;
    EXPECT_FALSE(kind->bench_test.empty()) << kind->name;
    EXPECT_LT(kind->usual_lower, kind->usual_upper) << kind->name;
    EXPECT_GE(kind->usual_lower, kind->range.lower) << kind->name;
    EXPECT_LE(kind->usual_upper, kind->range.upper) << kind->name;
    EXPECT_TRUE(kind->same_as.empty() || find_parameter(kind->same_as)) << kind->name;
  }
}

}  // namespace
}  // namespace graintruth::datasets
