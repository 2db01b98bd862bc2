// An annotation beside an experiment: its keys count as if they stood in the experiment file, and
// what is wrong with them is said with the annotation's own lines.
#include "datasets/experiment/annotation.h"

#include <gtest/gtest.h>

#include "datasets/experiment/experiment.h"
#include "datasets/experiment/tracking_spec.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

constexpr const char* stick =
    "[camera.stick]\nfrom_px = [10, 20]\nto_px = [310, 420]\nlength_mm = 100\n";

class Annotation : public testing::Test {
 protected:
  Annotation() {
    folder_.write("one.mp4", "a film");
    folder_.write("two.mp4", "another film");
    folder_.write("experiment.toml",
                  "[particle]\nbody = \"disc\"\ndiameter_mm = 5\n"
                  "[camera]\nframe_rate_hz = 50\nannotation = \"annotation.toml\"\n"
                  "[[replicate]]\nvideo = \"one.mp4\"\n"
                  "[[replicate]]\nname = \"b\"\nvideo = \"two.mp4\"\n");
  }

  Experiment load(const std::string& annotation) {
    folder_.write("annotation.toml", annotation);
    return load_experiment(folder_ / "experiment.toml", Purpose::tracking);
  }
  // What is said, without the folder's name.
  std::string complaint(const std::string& annotation) {
    try {
      load(annotation);
    } catch (const InputError& error) {
      std::string text = error.what();
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      const std::string folder = folder_.path().string() + "/";
      for (auto at = text.find(folder); at != std::string::npos; at = text.find(folder))
        text.erase(at, folder.size());
      return text;
    }
    return "";
  }

  tests::TemporaryFolder folder_;
};

TEST_F(Annotation, CountsAsIfItStoodInTheExperimentFile) {
  const Experiment experiment =
      load(std::string(stick) +
           "[[camera.mask]]\ncorners_px = [[1, 2], [30, 2], [30, 40]]\n"
           "[[camera.check]]\nfrom_px = [1, 2]\nto_px = [4, 6]\nlength_cm = 1\n"
           "[[replicate]]\nname = \"one\"\nnoted_event_s = 0.4\n"
           "[[replicate]]\nvideo = \"two.mp4\"\nname = \"b\"\nheld_out = true\n");
  ASSERT_TRUE(experiment.camera.stick);
  EXPECT_EQ(experiment.camera.stick->length, 0.1);
  ASSERT_TRUE(experiment.camera.masks);
  EXPECT_EQ(experiment.camera.masks->at(0).corners[2][1], 40.0);
  ASSERT_TRUE(experiment.camera.checks);
  EXPECT_EQ(experiment.camera.checks->at(0).length, 0.01);
  EXPECT_EQ(experiment.annotation, folder_ / "annotation.toml");
  ASSERT_EQ(experiment.replicates.size(), 2U);
  EXPECT_EQ(as_filmed(experiment, experiment.replicates[0]).camera.noted_event_time, 0.4);
  EXPECT_FALSE(as_filmed(experiment, experiment.replicates[1]).camera.noted_event_time);
  EXPECT_EQ(experiment.replicates[1].held_out, true);
}

TEST_F(Annotation, DecidesTheFingerprintOfFilms) {
  const auto print = [&](const std::string& more) {
    const Experiment experiment = load(stick + more);
    return fingerprint(make_tracking_spec(experiment, experiment.replicates[0]));
  };
  const std::string plain = print("");
  EXPECT_EQ(print("# a remark\n"), plain);
  EXPECT_NE(print("[camera]\nclick_error_px = 0.7\n"), plain);
  EXPECT_NE(print("[[camera.mask]]\ncorners_px = [[1, 2], [30, 2], [30, 40]]\n"), plain);
  EXPECT_NE(print("[[replicate]]\nname = \"one\"\nnoted_event_s = 0.4\n"), plain);
}

TEST_F(Annotation, MayRepeatWhatTheExperimentStates) {
  EXPECT_EQ(load(std::string("camera.frame_rate_hz = 50.0\n") + stick).camera.frame_rate, 50.0);
}

TEST_F(Annotation, SaysWhatIsWrongWithItsOwnLines) {
  const std::string frame_rate = std::string("camera.frame_rate_hz = 25\n") + stick;
  EXPECT_EQ(complaint(frame_rate),
            "annotation.toml:1: key 'camera.frame_rate_hz' is stated otherwise in "
            "experiment.toml:5; keep one of them.");
  EXPECT_EQ(complaint("[camera]\nfiducials_mm = [[0, 0]]\nfiducial_diameter_mm = 5\n"),
            "annotation.toml:2: key 'camera.fiducials_mm' gives 1 fiducials, but at least 4 are "
            "needed to find scale and tilt.");
  EXPECT_EQ(complaint(std::string(stick) + "lenght_mm = 3\n"),
            "annotation.toml:5: key 'camera.stick.lenght_mm' is unknown; did you mean "
            "'length_mm'?");
  EXPECT_EQ(complaint(std::string(stick) + "[[replicate]]\nname = \"three\"\n"),
            "annotation.toml:5: key 'replicate' says something of 'three', which is not in "
            "experiment.toml.");
  EXPECT_EQ(complaint(std::string(stick) + "[[camera.mask]]\ncorners_px = [[1, 2]]\n"),
            "annotation.toml:6: key 'camera.mask.corners_px' must be a list of at least 3 corners "
            "[column, row].");
  EXPECT_EQ(complaint("[camera.stick\n").substr(0, 18), "annotation.toml:1:");
}

TEST_F(Annotation, MustBeThere) {
  std::filesystem::remove(folder_ / "annotation.toml");
  try {
    load_experiment(folder_ / "experiment.toml", Purpose::tracking);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("experiment.toml:6: key 'camera.annotation' names"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace graintruth::datasets
