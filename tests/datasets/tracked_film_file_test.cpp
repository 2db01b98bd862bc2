// Files of films that are only tracked: what they may leave out, what gives scale, and what is said
// of every key that is wrong.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "datasets/experiment/experiment.h"
#include "datasets/experiment/pictures.h"
#include "datasets/experiment/tracking_spec.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

constexpr const char* rod = "body = \"rod\"\nlength_mm = 11\ndiameter_mm = 0.8\n";
constexpr const char* stick =
    "[camera.stick]\nfrom_px = [10, 20]\nto_px = [310, 420]\nlength_mm = 100\n";
constexpr const char* points =
    "[[camera.point]]\npx = [10, 20]\nmm = [0, 100]\n[[camera.point]]\npx = [500, 20]\nmm = [100, "
    "100]\n"
    "[[camera.point]]\npx = [10, 510]\nmm = [0, 0]\n[[camera.point]]\npx = [500, 510]\ncm = [10, "
    "0]\n";
constexpr const char* board = "[camera.chessboard]\ncolumns = 9\nrows = 6\nsquare_mm = 25\n";
constexpr const char* dots =
    "fiducial_diameter_mm = 5\nfiducials_mm = [[0, 0], [0, 9], [9, 0], [9, 9]]\n";

// A file of one film: [particle], [camera] behind its frame rate, and the film.
class TrackedFilmFile : public testing::Test {
 protected:
  TrackedFilmFile() {
    folder_.write("film.mp4", "a film");
    for (const char* picture : {"board1.png", "board2.png", "board10.png", "board.txt"})
      folder_.write(picture, picture);
  }

  std::string file_of(const std::string& particle,
                      const std::string& camera,
                      const std::string& replicate = "video = \"film.mp4\"\n") {
    return folder_.write("film.toml",
                         "[particle]\n" + particle + "[camera]\nframe_rate_hz = 50\n" + camera +
                             "[[replicate]]\n" + replicate);
  }

  Experiment load(const std::string& particle, const std::string& camera) {
    return load_experiment(file_of(particle, camera), Purpose::tracking);
  }

  // One sentence with file and line; without the folder's name.
  std::string complaint(const std::string& particle,
                        const std::string& camera,
                        const std::string& replicate = "video = \"film.mp4\"\n") {
    const std::string file = file_of(particle, camera, replicate);
    try {
      load_experiment(file, Purpose::tracking);
    } catch (const InputError& error) {
      const std::string text = error.what();
      EXPECT_TRUE(text.starts_with(file + ":")) << text;
      EXPECT_TRUE(text.ends_with(".") || text.ends_with("?")) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      return text.substr(file.size() + 1);
    }
    return "";
  }

  tests::TemporaryFolder folder_;
};

#define EXPECT_CONTAINS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST_F(TrackedFilmFile, NeedsNoRigNorTitleNorASecondFilm) {
  const Experiment experiment = load(rod, stick);
  EXPECT_EQ(experiment.title, "film");
  EXPECT_EQ(experiment.replicates.size(), 1U);
  EXPECT_EQ(experiment.particle.count, 0);
  const TrackingSpec spec = make_tracking_spec(experiment, experiment.replicates[0]);
  EXPECT_EQ(spec.body.kind, "rod");
  EXPECT_NEAR(spec.body.lengths.at("length"), 0.011, 1e-15);
  EXPECT_NEAR(spec.body.lengths.at("diameter"), 0.0008, 1e-15);
  EXPECT_FALSE(spec.body.count);
  EXPECT_TRUE(spec.rig.walls.empty());
}

TEST_F(TrackedFilmFile, TakesBallsAndPlatesWithACount) {
  const std::string ball = "spheres = [{offset_mm = 0, radius_mm = 5}]\n";
  EXPECT_EQ(load("count = 3\n" + ball, stick).particle.spheres.size(), 1U);
  EXPECT_CONTAINS(complaint(ball, stick), "key 'particle.count' is missing");
  const std::string plate = "plate = {semi_major_mm = 7, semi_minor_mm = 5, thickness_mm = 2}\n";
  EXPECT_EQ(load("count = 3\n" + plate, stick).particle.body->kind, "plate");
  EXPECT_CONTAINS(complaint("count = 3\n" + plate + rod, stick), "is given beside 'plate'");
}

TEST_F(TrackedFilmFile, CannotBeCalibratedOn) {
  const std::string file = file_of(rod, stick);
  try {
    load_experiment(file);
    FAIL() << "was read";
  } catch (const InputError& error) {
    EXPECT_CONTAINS(std::string(error.what()), "film.toml:1: key 'title' is missing");
  }
}

TEST_F(TrackedFilmFile, TellsWhichBodiesThereAre) {
  EXPECT_CONTAINS(complaint("body = \"cube\"\n", stick), "must be \"disc\" or \"rod\"");
  EXPECT_CONTAINS(complaint("body = \"rod\"\ndiameter_mm = 1\n", stick),
                  "'particle.length_m' is missing");
  EXPECT_CONTAINS(complaint("body = \"rod\"\nlength_mm = 1\ndiameter_mm = 2\n", stick),
                  "4: key 'particle.diameter_mm' must not exceed 'length'");
  EXPECT_CONTAINS(complaint("body = \"disc\"\ndiameter_mm = 0\n", stick), "a number above 0");
  EXPECT_CONTAINS(complaint("body = \"disc\"\ndiameter_mm = 1\nlength_mm = 2\n", stick),
                  "key 'particle.length_mm' is unknown");
}

TEST_F(TrackedFilmFile, ReadsEveryScale) {
  const Camera with_stick = load(rod, stick).camera;
  ASSERT_TRUE(with_stick.stick);
  EXPECT_EQ(with_stick.stick->to, (std::array{310.0, 420.0}));
  EXPECT_EQ(with_stick.stick->origin, with_stick.stick->from);
  EXPECT_NEAR(with_stick.stick->length, 0.1, 1e-15);
  const Camera with_points = load(rod, "click_error_px = 0.8\n" + std::string(points)).camera;
  ASSERT_EQ(with_points.points.size(), 4U);
  EXPECT_NEAR(with_points.points[3].x, 0.1, 1e-15);
  EXPECT_NEAR(with_points.points[1].z, 0.1, 1e-15);
  EXPECT_EQ(with_points.click_error, 0.8);
  const Camera with_board =
      load(rod, std::string(board) + "picture = \"board1.png\"\nx_mm = 5\n").camera;
  ASSERT_TRUE(with_board.chessboard && with_board.chessboard->picture);
  EXPECT_NEAR(with_board.chessboard->x, 0.005, 1e-15);
  EXPECT_EQ(load(rod, dots).camera.fiducials.size(), 4U);
}

TEST_F(TrackedFilmFile, NeedsOneScaleAndNoSecond) {
  EXPECT_CONTAINS(complaint(rod, ""), "key 'camera.fiducials_mm' is missing; films need a scale");
  EXPECT_CONTAINS(complaint(rod, std::string(dots) + stick),
                  "key 'camera.stick' gives the scale a second time, after 'fiducials_mm'");
  EXPECT_CONTAINS(complaint(rod, std::string(board) + points),
                  "key 'camera.chessboard' gives the scale a second time, after 'point'");
}

TEST_F(TrackedFilmFile, TellsWhatIsWrongWithPoints) {
  const std::string one = "[[camera.point]]\npx = [1, 2]\nmm = [3, 4]\n";
  EXPECT_CONTAINS(complaint(rod, one),
                  "key 'camera.point' is given 1 time(s), but at least 4 points");
  EXPECT_CONTAINS(complaint(rod, "[[camera.point]]\npx = [1, 2]\n"),
                  "key 'camera.point.mm' is missing");
  EXPECT_CONTAINS(complaint(rod, "[[camera.point]]\nmm = [1, 2]\n"),
                  "key 'camera.point.px' is missing");
  EXPECT_CONTAINS(complaint(rod, "[[camera.point]]\npx = [1, 2, 3]\nmm = [1, 2]\n"),
                  "must be a list of 2 numbers");
  EXPECT_CONTAINS(complaint(rod, "[[camera.point]]\npx = [1, 2]\nmm = [1, 2]\ncm = [1, 2]\n"),
                  "gives the place a second time");
  std::string line;
  for (const int k : {0, 1, 2, 3, 4})
    line += fmt::format("[[camera.point]]\npx = [{0}, {0}]\nmm = [{0}, {0}]\n", 10 * k);
  EXPECT_CONTAINS(complaint(rod, line), "lie on one line");
  EXPECT_CONTAINS(complaint(rod, "click_error_px = 0\n" + std::string(points)), "a number above 0");
  EXPECT_CONTAINS(complaint(rod, "click_error_px = 1\n" + std::string(dots)),
                  "key 'camera.click_error_px' is unknown");
}

TEST_F(TrackedFilmFile, TellsWhatIsWrongWithAStick) {
  EXPECT_CONTAINS(
      complaint(rod, "[camera.stick]\nfrom_px = [1, 2]\nto_px = [1, 2]\nlength_mm = 3\n"),
      "key 'camera.stick.to_px' is the same point as from_px");
  EXPECT_CONTAINS(complaint(rod, "[camera.stick]\nfrom_px = [1, 2]\nto_px = [5, 2]\n"),
                  "key 'camera.stick.length_m' is missing");
  EXPECT_CONTAINS(complaint(rod, "[camera.stick]\nto_px = [5, 2]\nlength_mm = 3\n"),
                  "key 'camera.stick.from_px' is missing");
  EXPECT_CONTAINS(complaint(rod, std::string(stick) + "lenght_uncertainty_mm = 1\n"),
                  "did you mean 'length_uncertainty_mm'?");
  EXPECT_CONTAINS(complaint(rod, std::string(stick) + "length_uncertainty_mm = -1\n"),
                  "a number above 0");
}

TEST_F(TrackedFilmFile, TellsWhatIsWrongWithAChessboard) {
  EXPECT_CONTAINS(complaint(rod, "[camera.chessboard]\ncolumns = 2\nrows = 6\nsquare_mm = 25\n"),
                  "must be a whole number from 3 to 100");
  EXPECT_CONTAINS(complaint(rod, "[camera.chessboard]\ncolumns = 9\nrows = 6\n"),
                  "key 'camera.chessboard.square_m' is missing");
  EXPECT_CONTAINS(complaint(rod, std::string(board) + "picture = \"none.png\"\n"),
                  "but there is no such file");
}

TEST_F(TrackedFilmFile, ReadsTheLensFromPicturesOfABoard) {
  const std::string lens = "[camera.lens]\ncolumns = 9\nrows = 6\n";
  const Camera camera = load(rod, std::string(stick) + lens + "pictures = \"board*.png\"\n").camera;
  ASSERT_TRUE(camera.lens);
  ASSERT_EQ(camera.lens->pictures.size(), 3U);
  EXPECT_EQ(camera.lens->pictures[1].file.filename(), "board2.png");  // 2 before 10
  EXPECT_CONTAINS(
      complaint(rod, std::string(stick) + lens + "pictures = [\"board1.png\", \"board2.png\"]\n"),
      "names 2 picture(s), but at least 3");
  EXPECT_CONTAINS(complaint(rod, std::string(stick) + lens + "pictures = [1]\n"),
                  "must be text in quotes, or a list of such texts");
  EXPECT_CONTAINS(complaint(rod, std::string(stick) + lens),
                  "key 'camera.lens.pictures' is missing");
}

TEST_F(TrackedFilmFile, TellsWhatIsWrongWithARegion) {
  EXPECT_EQ(load(rod, "region_px = [1, 2, 30, 40]\n" + std::string(stick)).camera.region,
            (std::array{1, 2, 30, 40}));
  EXPECT_CONTAINS(complaint(rod, "region_px = [30, 2, 1, 40]\n" + std::string(stick)),
                  "with left < right and top < bottom");
  EXPECT_CONTAINS(complaint(rod, "region_px = [0.5, 2, 1, 40]\n" + std::string(stick)),
                  "must hold whole numbers of pixels");
}

TEST_F(TrackedFilmFile, TakesPicturesForAFilm) {
  const auto load_film = [&](const std::string& video) {
    return load_experiment(file_of(rod, stick, "video = \"" + video + "\"\n"), Purpose::tracking)
        .replicates[0];
  };
  EXPECT_EQ(load_film("board*.png").name, folder_.path().filename());
  const auto pictures = pictures_of(folder_.path());
  ASSERT_EQ(pictures.size(), 3U);  // no text among them
  EXPECT_EQ(pictures[2].filename(), "board10.png");
  EXPECT_EQ(pictures_of(folder_ / "board1*.png").size(), 2U);
  EXPECT_EQ(load_film("board%d.png").name, folder_.path().filename());
  EXPECT_EQ(pictures_of(folder_ / "board%d.png"), pictures);
  EXPECT_EQ(pictures_of(folder_ / "board%02d.png").size(), 1U);  // 10 alone has two digits
  EXPECT_EQ(numbers_of(pictures), std::vector<long>({1, 2, 10}));
  const std::string before = film_hash(folder_ / "board*.png");
  folder_.write("board2.png", "another");
  EXPECT_NE(film_hash(folder_ / "board*.png"), before);
  EXPECT_CONTAINS(complaint(rod, stick, "video = \"none*.png\"\n"), "but there is no such file");
  EXPECT_CONTAINS(complaint(rod, std::string(stick).substr(0), "name = \"film\"\n"),
                  "'replicate.video' is needed");
}

// Where a picture lies decides nothing; what it shows does.
TEST_F(TrackedFilmFile, FingerprintsPicturesByWhatTheyShow) {
  const auto print = [&](const std::string& picture) {
    const Experiment experiment = load(rod, std::string(board) + "picture = \"" + picture + "\"\n");
    return fingerprint(make_tracking_spec(experiment, experiment.replicates[0]));
  };
  const std::string before = print("board1.png");
  folder_.write("copy.png", "board1.png");
  EXPECT_EQ(print("copy.png"), before);
  EXPECT_NE(print("board2.png"), before);
}

}  // namespace
}  // namespace graintruth::datasets
