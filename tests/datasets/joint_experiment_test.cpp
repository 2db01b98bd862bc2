// Experiments that share grains and walls, but not every wall.
#include "datasets/experiment/joint_experiment.h"

#include <gtest/gtest.h>

#include "datasets/parameters/apply.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

// Balls above one wall of this name.
std::string experiment_with(const std::string& wall, const std::string& material = "") {
  return R"(title = "Balls on a wall"
[particle]
count = 2
mass_g = 10
radius_mm = 5
[material]
elastic_modulus_mpa = 20
poisson_ratio = 0.3
friction_particle_particle = 0.4
friction_particle_wall = 0.3
restitution = 0.7
)" + material +
         R"(
[rig]
kind = "walls"
front_back_gap_mm = 12
[[rig.wall]]
name = ")" +
         wall + R"("
from_x_mm = 0
from_z_mm = 0
to_x_mm = 100
to_z_mm = 0
[[replicate]]
tracks = "a.csv"
[[replicate]]
tracks = "b.csv"
)";
}

struct Joint {
  Joint(const std::string& first, const std::string& second) {
    for (const char* tracks : {"a.csv", "b.csv"}) folder.write(tracks, "");
    folder.write("first.toml", first);
    folder.write("second.toml", second);
  }
  JointExperiment load(const std::string& tune) const {
    return load_joint_experiment(folder.write("joint.toml",
                                              "title = \"Two\"\n[[experiment]]\nfile = "
                                              "\"first.toml\"\n[[experiment]]\nfile = "
                                              "\"second.toml\"\n[tune]\n" +
                                                  tune + "\n"));
  }
  std::string complaint(const std::string& tune) const {
    try {
      load(tune);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  tests::TemporaryFolder folder;
};

TEST(JointExperiment, TunesAWallOfAnyOfThem) {
  const Joint files(experiment_with("floor"),
                    experiment_with("lid", "friction_particle_lid = 0.2"));
  const JointExperiment joint = files.load("friction_particle_lid = {}\nrestitution = {}");
  ASSERT_EQ(joint.common.tuned.size(), 2U);
  EXPECT_EQ(bench_value(joint.common, "friction_particle_lid").value, 0.2);
  for (const JointPart& part : joint.parts) EXPECT_EQ(part.experiment.tuned.size(), 2U);
  // Where there is no such wall, nothing is set
  const SceneData scene = joint.parts[0].experiment.rig.scene;
  SceneData changed = scene;
  apply_parameters({{"friction_particle_lid", 0.1}}, changed);
  EXPECT_EQ(changed.surfaces.size(), scene.surfaces.size());
  EXPECT_EQ(changed.materials.size(), scene.materials.size());
}

TEST(JointExperiment, NamesTheWallsOfAllWhereNoneIsMeant) {
  const Joint files(experiment_with("floor"), experiment_with("lid"));
  const std::string said = files.complaint("friction_particle_side = {}");
  for (const char* part :
       {"joint.toml:", "tune.friction_particle_side", "no rig has a wall 'side'", "floor, lid"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

TEST(JointExperiment, TheSameWallHasTheSameFriction) {
  const Joint files(experiment_with("lid"), experiment_with("lid", "friction_particle_lid = 0.2"));
  const std::string said = files.complaint("restitution = {}");
  for (const char* part : {"joint.toml:", "material.friction_particle_lid of 0.2", "0.3"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

}  // namespace
}  // namespace graintruth::datasets
