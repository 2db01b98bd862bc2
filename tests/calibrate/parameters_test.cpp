#include "calibrate/parameters.h"

#include <gtest/gtest.h>

#include "datasets/store/input_error.h"
#include "tests/support/parameters.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

const ParameterSpace space({{"friction_particle_wall", 0.1, 0.5}, {"restitution", 0.3, 0.9}},
                           tests::parameters(0.25, 0.0, 0.0));

TEST(ParameterSpace, GoesToTheUnitCubeAndBack) {
  const ParameterSet parameters = space.from_unit({0.25, 1.0});
  EXPECT_DOUBLE_EQ(parameters.of("friction_particle_particle"), 0.25);  // not tuned: the base value
  EXPECT_DOUBLE_EQ(parameters.of("friction_particle_wall"), 0.2);
  EXPECT_DOUBLE_EQ(parameters.of("restitution"), 0.9);
  EXPECT_NEAR(space.to_unit(parameters)[0], 0.25, 1e-15);
}

TEST(ParameterSpace, CanHoldAParameter) {
  const ParameterSpace held = space.with_fixed("restitution", 0.83);
  EXPECT_EQ(held.dimension(), 1U);
  EXPECT_EQ(held.from_unit({0.0}).of("restitution"), 0.83);
}

TEST(LoadParameters, ReadsAResultAndATable) {
  const TemporaryFolder folder;
  const auto json = folder.write("result.json",
                                 R"({"parameters": {"friction_particle_particle": {"value": 0.1},
                                     "friction_particle_wall": {"value": 0.2}, "restitution": {"value": 0.7}},
                                     "time_step": {"fraction": 0.2}})");
  const ParameterSet from_json = load_parameters(json, {});
  EXPECT_EQ(from_json.of("friction_particle_wall"), 0.2);
  EXPECT_EQ(load_time_step_fraction(json), 0.2);
  const auto toml = folder.write("p.toml", "friction_particle_particle = 0.3\n");
  const ParameterSet from_toml = load_parameters(toml, tests::parameters(0.5, 0.6, 0.7));
  EXPECT_EQ(from_toml.of("friction_particle_particle"), 0.3);
  EXPECT_EQ(from_toml.of("friction_particle_wall"), 0.6);
  EXPECT_FALSE(load_time_step_fraction(toml).has_value());
}

TEST(LoadParameters, RefusesWhatItCannotUse) {
  const TemporaryFolder folder;
  EXPECT_THROW(load_parameters(folder / "absent.json", {}), datasets::InputError);
  EXPECT_THROW(load_parameters(folder.write("a.json", "{"), {}), datasets::InputError);
  EXPECT_THROW(load_parameters(folder.write("b.json", "{\"parameters\": {}}"), {}),
               datasets::InputError);
  EXPECT_THROW(load_parameters(folder.write("c.toml", "friction_particle_particle = -1\n"), {}),
               datasets::InputError);
}

}  // namespace
}  // namespace graintruth::calibrate
