#include "datasets/experiment/experiment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "datasets/parameters/apply.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

std::string bundled_text() {
  std::ifstream stream(GRAINTRUTH_SOURCE_DIR "/datasets/micro/experiment.toml");
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The bundled experiment with one piece of text replaced, and what the loader says of it.
std::string complaint_about(const std::string& from, const std::string& to) {
  const TemporaryFolder folder;
  for (int i = 1; i <= 5; ++i) folder.write("rep" + std::to_string(i) + ".mp4", "");
  std::string text = bundled_text();
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  try {
    load_experiment(folder.write("experiment.toml", text));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

// A bin of plates with two films, its rig table and its replicates as given.
Experiment load_bin(const std::string& rig, const std::string& replicate) {
  const TemporaryFolder folder;
  for (const char* film : {"a.mp4", "b.mp4"}) folder.write(film, "");
  std::string text = bundled_text();
  const auto cut = [&](const std::string& from, const std::string& to, const std::string& in) {
    const auto start = text.find(from), end = text.find(to, start);
    text.replace(start, end - start, in);
  };
  cut("mass_g = 142", "\n", "mass_g = 0.332");
  cut("spheres = [",
      "# Bench",
      "plate = {semi_major_mm = 6.9, semi_minor_mm = 5.3, thickness_mm = 2.3}\n\n");
  cut("[rig]",
      "# Black",
      "[rig]\nkind = \"flat_bin_orifice\"\nfront_back_gap_mm = 2.6\n" + rig + "\n\n");
  text.resize(text.find("[[replicate]]"));
  text += "[[replicate]]\nvideo = \"a.mp4\"\n" + replicate + "\n[[replicate]]\nvideo = \"b.mp4\"\n";
  return load_experiment(folder.write("bin.toml", text));
}

TEST(LoadExperiment, GivesEveryReplicateOfABinItsOwnOrificeAndFrameRate) {
  const Experiment experiment =
      load_bin("bin_width_mm = 150\nbin_height_mm = 200\norifice_width_mm = 60",
               "orifice_width_mm = 50\nframe_rate_hz = 25");
  ASSERT_TRUE(experiment.particle.body.has_value());
  EXPECT_NEAR(experiment.particle.body->lengths.at("semi_minor"), 0.0053, 1e-15);
  const Experiment first = as_filmed(experiment, experiment.replicates[0]);
  const Experiment second = as_filmed(experiment, experiment.replicates[1]);
  EXPECT_NEAR(first.rig.opening->width(), 0.05, 1e-15);
  EXPECT_EQ(first.camera.frame_rate, 25.0);
  EXPECT_NEAR(second.rig.opening->width(), 0.06, 1e-15);
  EXPECT_EQ(second.camera.frame_rate, 50.0);
  // Side walls and the floor left and right of the orifice
  ASSERT_EQ(first.rig.walls.size(), 4U);
  EXPECT_NEAR(first.rig.walls[2].to_x, -0.025, 1e-15);
}

TEST(LoadExperiment, NeedsAnOrificeThatFitsTheBin) {
  const auto complaint = [](const std::string& rig) -> std::string {
    try {
      load_bin(rig, "orifice_width_mm = 50");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(complaint("bin_width_mm = 150\nbin_height_mm = 200").find("orifice_width_mm"),
            std::string::npos);
  EXPECT_NE(complaint("bin_width_mm = 40\nbin_height_mm = 200").find("wider than the bin"),
            std::string::npos);
}

TEST(LoadExperiment, TheBundledOneIsInSiUnits) {
  const Experiment experiment =
      load_experiment(GRAINTRUTH_SOURCE_DIR "/datasets/micro/experiment.toml");
  EXPECT_EQ(experiment.name, "micro");
  EXPECT_EQ(experiment.particle.count, 10);
  EXPECT_NEAR(experiment.particle.mass, 0.142, 1e-15);
  ASSERT_EQ(experiment.particle.spheres.size(), 2U);
  EXPECT_NEAR(experiment.particle.spheres[1].offset - experiment.particle.spheres[0].offset,
              0.02783,
              1e-12);
  EXPECT_NEAR(experiment.material.elastic_modulus, 6.89e9, 1.0);
  ASSERT_TRUE(experiment.rig.moving_face.has_value());
  EXPECT_NEAR(experiment.rig.moving_face->velocity_z, -0.046, 1e-15);
  // The walls of geometry.toml: a column 135 mm wide under a V of 60 degrees, 300 mm high.
  ASSERT_EQ(experiment.rig.walls.size(), 4U);
  EXPECT_NEAR(experiment.rig.walls[2].to_x, -0.240705081, 1e-9);
  EXPECT_NEAR(experiment.rig.walls[2].to_z, 0.3, 1e-12);
  EXPECT_EQ(experiment.camera.fiducials.size(), 14U);
  EXPECT_EQ(experiment.starts.size(), 10U);
  EXPECT_EQ(experiment.replicates.size(), 5U);
  EXPECT_EQ(experiment.replicates[4].name, "rep5");
}

TEST(LoadExperiment, AnglesMayBeInDegreesOrRadians) {
  EXPECT_EQ(complaint_about("slope_angle_deg = 60 ", "slope_angle_rad = 1.0471975511965976 "), "");
}

TEST(LoadExperiment, AnUnknownKeyIsNamedWithTheNearestThatExists) {
  const std::string sentence = complaint_about("front_back_gap_mm", "front_bck_gap_mm");
  EXPECT_CONTAINS(sentence, "rig.front_bck_gap_mm");
  EXPECT_CONTAINS(sentence, "'front_back_gap_mm'");
  const std::string typo =
      complaint_about("poisson_ratio = 0.35", "poisson_ratio = 0.35\npoison_ratio = 0.3");
  EXPECT_CONTAINS(typo, "material.poison_ratio");
  EXPECT_CONTAINS(typo, "'poisson_ratio'");
  EXPECT_CONTAINS(typo, "experiment.toml:");
}

TEST(LoadExperiment, AKeyLikeNoOtherIsNamedWithAllThatAreKnown) {
  const std::string sentence =
      complaint_about("poisson_ratio = 0.35", "poisson_ratio = 0.35\nshininess = 0.3");
  EXPECT_CONTAINS(sentence, "material.shininess");
  EXPECT_CONTAINS(sentence, "known here are");
  EXPECT_CONTAINS(sentence, "poisson_ratio");
}

TEST(LoadExperiment, AWrongUnitIsNamedWithThoseThatFit) {
  const std::string sentence = complaint_about("mass_g = 142", "mass_mm = 142");
  EXPECT_CONTAINS(sentence, "mass_mm");
  EXPECT_CONTAINS(sentence, "mass_kg");
}

TEST(LoadExperiment, AMissingKeyIsNamed) {
  EXPECT_CONTAINS(complaint_about("frame_rate_hz = 50", ""), "camera.frame_rate_hz");
}

TEST(LoadExperiment, TheSameQuantityInTwoUnitsIsRefused) {
  EXPECT_CONTAINS(complaint_about("mass_g = 142", "mass_g = 142\nmass_kg = 0.142"), "second time");
}

TEST(LoadExperiment, ImpossiblePhysicsIsRefused) {
  EXPECT_CONTAINS(
      complaint_about("friction_particle_particle = 0.36", "friction_particle_particle = -0.1"),
      "friction");
  EXPECT_CONTAINS(complaint_about("restitution = 0.83", "restitution = 1.2"), "restitution");
  for (const char* none : {"0", "-0.1", "nan"}) {
    EXPECT_CONTAINS(
        complaint_about("restitution = 0.83",
                        std::string("restitution = 0.83\nrestitution_uncertainty = ") + none),
        "restitution_uncertainty");
  }
  EXPECT_CONTAINS(complaint_about("poisson_ratio = 0.35", "poisson_ratio = 0.5"), "Poisson");
  EXPECT_CONTAINS(complaint_about("mass_g = 142", "mass_g = 0"), "above 0");
  EXPECT_CONTAINS(complaint_about("mass_g = 142", "mass_g = nan"), "mass_g");
  EXPECT_CONTAINS(complaint_about("{lower = 0.0, upper = 0.6}", "{lower = 0.6, upper = 0.1}"),
                  "above lower");
  EXPECT_CONTAINS(complaint_about("slope_angle_deg = 60", "slope_angle_deg = 95"), "90 degrees");
}

// The line that tunes the friction between particles, with more in it.
std::string complaint_about_prior(const std::string& prior, const std::string& material = "") {
  const std::string bounds = "{lower = 0.0, upper = 0.6";
  if (material.empty()) return complaint_about(bounds, bounds + ", prior = " + prior);
  const TemporaryFolder folder;
  for (int i = 1; i <= 5; ++i) folder.write("rep" + std::to_string(i) + ".mp4", "");
  std::string text = bundled_text();
  text.insert(text.find(bounds) + bounds.size(), ", prior = " + prior);
  text.insert(text.find("[material]\n") + 11, material);
  const Experiment experiment = load_experiment(folder.write("experiment.toml", text));
  const BenchValue& read = *experiment.tuned.front().prior;
  return std::to_string(read.value) + " " + std::to_string(read.standard_uncertainty);
}

TEST(LoadExperiment, ATableOfAnObservableThatIsNotComparedIsRefused) {
  const std::string said =
      complaint_about("frames = 25", "frames = 25\n[measure.lid_force]\nunit = \"N\"");
  for (const char* part :
       {"experiment.toml:", "'measure.lid_force'", "add \"lid_force\" to measure.observables"})
    EXPECT_CONTAINS(said, part);
}

TEST(LoadExperiment, APriorIsTheBenchValueOrStated) {
  EXPECT_EQ(complaint_about_prior("\"bench\"", "friction_particle_particle_uncertainty = 0.03\n"),
            "0.360000 0.030000");
  EXPECT_EQ(complaint_about_prior("{mean = 0.2, uncertainty = 0.05}", "# none\n"),
            "0.200000 0.050000");
}

TEST(LoadExperiment, APriorThatCannotBeIsRefused) {
  EXPECT_CONTAINS(complaint_about_prior("\"bench\""),
                  "'material.friction_particle_particle_uncertainty'");
  EXPECT_CONTAINS(complaint_about_prior("\"tilting\""), "must be \"bench\" or {mean");
  EXPECT_CONTAINS(complaint_about_prior("0.3"), "must be \"bench\" or {mean");
  EXPECT_CONTAINS(complaint_about_prior("{mean = 0.3, uncertainty = 0}"), "above 0");
  EXPECT_CONTAINS(complaint_about_prior("{mean = 0.3, uncertainty = -0.1}"), "above 0");
  EXPECT_CONTAINS(complaint_about_prior("{mean = -0.3, uncertainty = 0.1}"), "friction from 0");
  EXPECT_CONTAINS(complaint_about_prior("{mean = 0.3}"), "prior.uncertainty");
  EXPECT_CONTAINS(complaint_about_prior("{mean = 0.3, uncertainty = 0.1, u = 1}"), "prior.u'");
  const std::string far = complaint_about_prior("{mean = 0.9, uncertainty = 0.1}");
  EXPECT_CONTAINS(far, "experiment.toml:");
  EXPECT_CONTAINS(far, "'tune.friction_particle_particle.prior'");
  EXPECT_CONTAINS(far, "far outside the bounds 0 to 0.6");
  EXPECT_CONTAINS(
      complaint_about("{lower = 0.0, upper = 0.6}", "{prior = {mean = 0.3, uncertainty = 0.1}}"),
      "without bounds");
}

TEST(LoadExperiment, AParticleHasOneShape) {
  EXPECT_CONTAINS(complaint_about("spheres = [", "radius_mm = 5\nspheres = ["),
                  "'particle.spheres' is one of 2 shapes; exactly one of radius_mm");
}

TEST(LoadExperiment, AGrainInOneLayerHasNoBallOutOfIt) {
  const std::string said =
      complaint_about("{offset_mm = 13.915,", "{x_mm = 13.915, y_mm = 4, z_mm = 0,");
  for (const char* part :
       {"experiment.toml:", "'particle.spheres' has a ball 4 mm out of the layer", "y = 0"})
    EXPECT_CONTAINS(said, part);
}

TEST(LoadExperiment, TextWhereANumberBelongsIsRefused) {
  EXPECT_CONTAINS(complaint_about("mass_g = 142", "mass_g = \"142\""), "text");
}

TEST(LoadExperiment, ThreeFiducialsAreTooFew) {
  std::string text = bundled_text();
  const auto from = text.find("fiducials_mm = [");
  const auto to = text.find("]\n\n", from) + 1;
  const std::string sentence =
      complaint_about(text.substr(from, to - from), "fiducials_mm = [[0, 0], [100, 0], [0, 100]]");
  EXPECT_CONTAINS(sentence, "3 fiducials");
  EXPECT_CONTAINS(sentence, "at least 4");
}

TEST(LoadExperiment, OneReplicateIsTooFew) {
  std::string text = bundled_text();
  const auto from = text.find("[[replicate]]\nvideo = \"rep2.mp4\"");
  const auto to = text.find("# Nominal starting places");
  const std::string sentence = complaint_about(text.substr(from, to - from), "");
  EXPECT_CONTAINS(sentence, "at least 2 replicates");
}

TEST(LoadExperiment, AMissingFilmIsNamed) {
  EXPECT_CONTAINS(complaint_about("rep3.mp4", "rep33.mp4"), "rep33.mp4");
}

TEST(LoadExperiment, ADoubledReplicateIsRefused) {
  EXPECT_CONTAINS(complaint_about("rep3.mp4", "rep2.mp4"), "second replicate called 'rep2'");
}

TEST(LoadExperiment, StartingPlacesMustBeAsManyAsParticles) {
  EXPECT_CONTAINS(complaint_about("count = 10", "count = 9"), "10 starting places for 9 particles");
}

TEST(LoadExperiment, BrokenTomlIsNamedWithItsLine) {
  EXPECT_CONTAINS(complaint_about("[particle]", "[particle"), "experiment.toml:");
}

TEST(ReadParameterTable, KnowsItsNamesAndRefusesOthers) {
  const TemporaryFolder folder;
  const auto values =
      read_parameter_table(folder.write("p.toml", "friction_particle_wall = 0.2\n"));
  EXPECT_EQ(values.at("friction_particle_wall"), 0.2);
  EXPECT_EQ(values.size(), 1U);
  EXPECT_THROW(read_parameter_table(folder.write("q.toml", "friction = 0.2\n")), InputError);
  EXPECT_THROW(read_parameter_table(folder.write("r.toml", "restitution = 0\n")), InputError);
}

// A setting that every replicate states need not stand in [rig]; one that nobody states is missing.
TEST(LoadExperiment, APistonsSpeedMayBeThatOfEachReplicate) {
  const std::string speed = "piston_speed_mm_per_s = 46";
  EXPECT_CONTAINS(complaint_about(speed, ""), "'replicate.piston_speed");
  const TemporaryFolder folder;
  std::string text = bundled_text();
  text.erase(text.find(speed), speed.size());
  for (int i = 1; i <= 5; ++i) {
    const std::string film = "video = \"rep" + std::to_string(i) + ".mp4\"\n";
    folder.write("rep" + std::to_string(i) + ".mp4", "");
    text.insert(text.find(film) + film.size(), speed + "\n");
  }
  const Experiment experiment = load_experiment(folder.write("experiment.toml", text));
  for (const Replicate& replicate : experiment.replicates)
    EXPECT_DOUBLE_EQ(replicate.rig.moving_face->velocity_z, -0.046);
}

TEST(LoadExperiment, ABenchValueOfAWallThatIsNotThereIsRefused) {
  EXPECT_CONTAINS(
      complaint_about("restitution = 0.83", "restitution = 0.83\nfriction_particle_lid = 0.2"),
      "'material.friction_particle_lid' is of a wall 'lid', but the walls of the rig are "
      "column_left");
}

// A gate of a material of its own keeps its friction, even none, and the friction with walls moves
// all other walls.
TEST(LoadExperiment, AWallOfAnotherMaterialIsTheOnlyOneThatDoesNotFollow) {
  for (const double own : {0.0, 0.1}) {
    const TemporaryFolder folder;
    std::ifstream stream(GRAINTRUTH_SOURCE_DIR "/app/new/scene/box.toml");
    std::string text(std::istreambuf_iterator<char>(stream), {});
    const auto gate = text.find("name = \"gate\"");
    const std::string wall = "material = \"wall\"";
    text.replace(text.find(wall, gate), wall.size(), "material = \"felt\"");
    text +=
        "\n[[material]]\nname = \"felt\"\nrigid = true\n[[surfaces]]\nfirst = \"ball\"\n"
        "second = \"felt\"\nfriction = " +
        std::to_string(own) + "\nrestitution = 0.7\n";
    folder.write("box.toml", text);
    folder.write("cell.csv", "");
    const Experiment experiment =
        load_experiment(folder.write("experiment.toml", R"(title = "A gate"
[rig]
kind = "scene"
scene = "box.toml"
[tune]
friction_particle_wall = {}
[[replicate]]
name = "a"
discharge = "cell.csv"
[[replicate]]
name = "b"
discharge = "cell.csv"
)"));
    EXPECT_EQ(bench_value(experiment, "friction_particle_wall").value, 0.3);
    ParameterSet parameters = bench_parameters(experiment);
    ASSERT_TRUE(parameters.has("friction_particle_gate"));
    EXPECT_EQ(parameters.of("friction_particle_gate"), own);
    EXPECT_FALSE(parameters.has("friction_particle_floor_left"));
    SceneData scene = experiment.rig.scene;
    parameters.set("friction_particle_wall", 0.55);
    apply_parameters(parameters, scene);
    EXPECT_EQ(on_wall("floor_left", scene, &SceneSurfaces::friction), 0.55);
    EXPECT_EQ(on_wall("gate", scene, &SceneSurfaces::friction), own);
  }
}

}  // namespace
}  // namespace graintruth::datasets
