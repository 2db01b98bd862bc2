// How well real recordings of other laboratories are read, against what is known of them: rods
// marked by hand, discs that keep their colour, a published lens, another program's positions, a
// thrown ball. The recordings lie beside the repository and are no part of it. Nothing is tuned to
// a file: what each part is told (sizes in pixels, numbers) is what a laboratory would tell.
//   bench_real_recordings [OUT.csv] [FOLDER]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <map>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "datasets/table.h"
#include "tracking/assignment.h"
#include "tracking/chessboard.h"
#include "tracking/rods.h"
#include "tracking/spots.h"
#include "tracking/video.h"

using namespace graintruth;
using tracking::Spot;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

// Prints a line a figure, and keeps them for the file.
class Figures {
 public:
  void begin(const std::string& recording) {
    recording_ = recording;
    fmt::print("{}\n", recording);
  }
  // One with a target.
  void asked(const std::string& figure,
             const std::string& wanted,
             const std::string& measured,
             bool met) {
    add(figure, wanted, measured, met ? "met" : "NOT MET");
  }
  void told(const std::string& figure, const std::string& measured) {
    add(figure, "", measured, "");
  }
  const datasets::Table& table() const { return table_; }

 private:
  void add(const std::string& figure,
           const std::string& wanted,
           const std::string& measured,
           const std::string& verdict) {
    fmt::print("  {:<40} {:<12} {:<46} {}\n", figure, wanted, measured, verdict);
    table_.add({recording_, figure, wanted, measured, verdict});
  }

  std::string recording_;
  datasets::Table table_{{"recording", "figure", "asked", "measured", "verdict"}};
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// Which of `found` is each of `known`, at most `reach` apart; -1 for none.
std::vector<int> matched(const std::vector<Eigen::Vector2d>& known,
                         const std::vector<Eigen::Vector2d>& found,
                         double reach) {
  constexpr double forbidden = 1e12;
  Eigen::MatrixXd cost(static_cast<Eigen::Index>(known.size()),
                       static_cast<Eigen::Index>(found.size()));
  for (std::size_t i = 0; i < known.size(); ++i) {
    for (std::size_t j = 0; j < found.size(); ++j) {
      const double distance = (known[i] - found[j]).norm();
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          distance > reach ? forbidden : distance * distance;
    }
  }
  return tracking::assign(cost, forbidden);
}

// 200 rods in each of 20 frames, marked by machine and corrected by hand: to 2 to 4 px, as the data
// set's README says.
void rods(const std::filesystem::path& folder, Figures& figures) {
  figures.begin("Magdeburg rods: 20 frames, 200 rods each, marked by hand");
  // The chamber between its side walls, from the front panes' upper to their lower edge
  const tracking::RodOptions options{
      .width_px = 7.0, .longest_px = 115.0, .region = cv::Rect(45, 10, 1180, 850)};
  constexpr double same_rod = 12.0;  // px between centres; a sixth of a usual rod
  const datasets::Table reference = datasets::read_csv(folder / "reference_rods_gp3.csv");
  std::map<int, std::vector<std::array<Eigen::Vector2d, 2>>> known;
  for (std::size_t i = 0; i < reference.rows(); ++i) {
    known[reference.integer(i, "frame")].push_back(
        {Eigen::Vector2d(reference.number(i, "x1_gp3"), reference.number(i, "y1_gp3")),
         Eigen::Vector2d(reference.number(i, "x2_gp3"), reference.number(i, "y2_gp3"))});
  }
  std::vector<double> centres, angles;
  double seconds = 0.0;
  long all = 0, close = 0, detections = 0, hits = 0;
  for (const auto& [frame, ends] : known) {
    const cv::Mat picture = cv::imread((folder / fmt::format("gp3/{:04}.jpg", frame)).string());
    const double started = static_cast<double>(std::clock());
    const std::vector<tracking::Rod> found = tracking::locate_rods(picture, options);
    seconds += (static_cast<double>(std::clock()) - started) / CLOCKS_PER_SEC;
    std::vector<Eigen::Vector2d> known_centres, found_centres;
    for (const auto& one : ends) known_centres.push_back(0.5 * (one[0] + one[1]));
    for (const tracking::Rod& rod : found) found_centres.push_back(rod.centre());
    const std::vector<int> match = matched(known_centres, found_centres, same_rod);
    all += static_cast<long>(ends.size());
    detections += static_cast<long>(found.size());
    for (std::size_t i = 0; i < match.size(); ++i) {
      if (match[i] < 0) continue;
      ++hits;
      const tracking::Rod& rod = found[static_cast<std::size_t>(match[i])];
      const Eigen::Vector2d axis = ends[i][1] - ends[i][0];
      const double turned =
          std::remainder(rod.angle() - std::atan2(-axis.y(), axis.x()), std::numbers::pi);
      centres.push_back((rod.centre() - known_centres[i]).norm());
      angles.push_back(std::abs(turned) / degree);
      close += centres.back() <= 3.0 && angles.back() <= 2.0 ? 1 : 0;
    }
  }
  const double recall = static_cast<double>(hits) / static_cast<double>(all);
  figures.asked(
      "recall (centre within 12 px)", ">= 0.85", fmt::format("{:.3f}", recall), recall >= 0.85);
  figures.told("precision", fmt::format("{:.3f}", static_cast<double>(hits) / detections));
  figures.asked("centre, median of the recalled",
                "<= 3 px",
                fmt::format("{:.2f} px (95 %: {:.1f}, rms {:.2f})",
                            quantile(centres, 0.5),
                            quantile(centres, 0.95),
                            root_mean_square(centres)),
                quantile(centres, 0.5) <= 3.0);
  figures.asked("angle, median of the recalled",
                "<= 2 deg",
                fmt::format("{:.2f} deg (95 %: {:.1f}, rms {:.2f})",
                            quantile(angles, 0.5),
                            quantile(angles, 0.95),
                            root_mean_square(angles)),
                quantile(angles, 0.5) <= 2.0);
  figures.told("time",
               fmt::format("{:.2f} s a frame", seconds / static_cast<double>(known.size())));
  figures.told("within 3 px and 2 deg, of all",
               fmt::format("{:.3f}", static_cast<double>(close) / all));
}

// Discs that never touch, never leave and keep their colour.
void discs(const std::filesystem::path& folder,
           const std::string& name,
           int count,
           Figures& figures) {
  constexpr int diameter = 45;  // px
  figures.begin(fmt::format("Lund magnetic discs, {}: {} discs", name, count));
  // The laboratory's rate; the container's clock is looked at, not believed.
  tracking::VideoReader video(folder / name, 30000.0 / 1001.0);
  std::vector<std::vector<Spot>> frames;
  std::vector<std::vector<bool>> red;
  cv::Mat frame;
  while (video.read(frame)) {
    const cv::Mat contrast = tracking::contrast_to_ground(frame, diameter);
    frames.push_back(tracking::locate_spots(contrast, {.diameter_px = diameter, .noise_px = 2.0}));
    red.emplace_back();
    for (const Spot& spot : frames.back()) {
      // The mean colour of the disc: its magnet is grey
      const cv::Rect box(static_cast<int>(spot.pixel.x()) - diameter / 2,
                         static_cast<int>(spot.pixel.y()) - diameter / 2,
                         diameter,
                         diameter);
      const cv::Scalar mean = cv::mean(frame(box & cv::Rect({}, frame.size())));
      red.back().push_back(mean[2] > mean[1]);
    }
  }
  long right = 0;
  std::map<std::size_t, int> counts;
  for (const auto& spots : frames) {
    right += static_cast<int>(spots.size()) == count ? 1 : 0;
    ++counts[spots.size()];
  }
  const auto tracks = tracking::link_spots(frames, 0.5 * diameter, 10);
  int switches = 0;
  for (const auto& track : tracks) {
    std::optional<bool> last;
    for (std::size_t i = 0; i < track.size(); ++i) {
      if (track[i] < 0) continue;
      const bool now = red[i][static_cast<std::size_t>(track[i])];
      switches += last && *last != now ? 1 : 0;
      last = now;
    }
  }
  const double share = static_cast<double>(right) / static_cast<double>(frames.size());
  std::string seen;
  for (const auto& [number, times] : counts) seen += fmt::format(" {}:{}", number, times);
  figures.asked("frames with the right count",
                ">= 95 %",
                fmt::format("{:.1f} % ({})", 100.0 * share, seen.substr(1)),
                share >= 0.95);
  figures.asked("tracks that change colour",
                "0",
                fmt::format("{} of {} tracks", switches, tracks.size()),
                switches == 0);
  const std::vector<int> uneven = video.uneven_frames();
  figures.asked("jittered clock noticed",
                "yes",
                fmt::format("{} uneven steps", uneven.size()),
                !uneven.empty());
  for (const std::string& sentence : video.warnings()) fmt::print("    {}\n", sentence);
}

double number_after(const std::string& text, const std::string& key, std::size_t which) {
  std::size_t at = text.find(key);
  at = text.find(text.find("data: [", at) == std::string::npos ? key : "data: [", at);
  at = text.find('[', at) + 1;
  for (std::size_t i = 0; i < which; ++i) at = text.find(',', at) + 1;
  return std::stod(text.substr(at));
}

void chessboard(const std::filesystem::path& folder, Figures& figures) {
  figures.begin("Chessboard of OpenCV: 13 views, published lens");
  std::ifstream stream(folder / "left_intrinsics.yml");
  const std::string published((std::istreambuf_iterator<char>(stream)), {});
  std::vector<std::filesystem::path> views;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename().string().starts_with("left") && entry.path().extension() == ".jpg")
      views.push_back(entry.path());
  }
  std::sort(views.begin(), views.end());
  const tracking::Lens lens = tracking::calibrate_lens(views, 9, 6);
  const auto compare = [&](const char* what, double ours, double theirs) {
    const double off = ours / theirs - 1.0;
    figures.asked(what,
                  "within 1 %",
                  fmt::format("{:.2f} px, published {:.2f} ({:+.2f} %)", ours, theirs, 100.0 * off),
                  std::abs(off) <= 0.01);
  };
  compare("focal length", lens.focal_px, number_after(published, "camera_matrix", 0));
  compare("principal point, column",
          lens.principal_point.x(),
          number_after(published, "camera_matrix", 2));
  compare("principal point, row",
          lens.principal_point.y(),
          number_after(published, "camera_matrix", 5));
  figures.told(
      "residual",
      fmt::format("{:.3f} px rms, {} of {} views", lens.rms_px, lens.used.size(), views.size()));
  figures.told("radial distortion k1",
               fmt::format("{:.4f}, published {:.4f}",
                           lens.k1,
                           number_after(published, "distortion_coefficients", 0)));
  figures.told("worst view",
               fmt::format("{}: {:.2f} px, a usual one {:.2f}; {} left out",
                           lens.worst.filename().string(),
                           lens.worst_px,
                           lens.median_px,
                           lens.discarded.size()));
}

void trackpy(const std::filesystem::path& folder, Figures& figures) {
  figures.begin("Spheres in water: positions of trackpy in the first frame");
  const datasets::Table reference = datasets::read_csv(folder / "reference_frame0_located.csv");
  std::vector<Eigen::Vector2d> known;
  for (std::size_t i = 0; i < reference.rows(); ++i)
    known.emplace_back(reference.number(i, "col"), reference.number(i, "row"));
  cv::Mat picture = cv::imread((folder / "frames/T76S3F00001.png").string(), cv::IMREAD_GRAYSCALE);
  picture = 255 - picture;  // dark particles
  // The reference's diameter, and as many as it has: its masses hold a pedestal from rounding the
  // ground down to whole grey levels.
  auto spots = tracking::locate_spots(picture, {.diameter_px = 9, .least_mass = 1.0});
  spots.resize(std::min(spots.size(), known.size()));
  std::vector<Eigen::Vector2d> found;
  for (const Spot& spot : spots) found.push_back(spot.pixel);
  constexpr double same = 2.0;  // px
  std::vector<double> apart;
  const std::vector<int> match = matched(known, found, same);
  for (std::size_t i = 0; i < match.size(); ++i) {
    if (match[i] >= 0)
      apart.push_back((found[static_cast<std::size_t>(match[i])] - known[i]).norm());
  }
  figures.asked(
      "distance, median of the common subset",
      "<= 0.1 px",
      fmt::format("{:.4f} px (95 %: {:.3f})", quantile(apart, 0.5), quantile(apart, 0.95)),
      quantile(apart, 0.5) <= 0.1);
  figures.told("common subset",
               fmt::format("{} of {} (ours {})", apart.size(), known.size(), found.size()));
}

// y = a + b t + c t^2 by least squares.
struct Parabola {
  Eigen::Vector3d coefficients;
  double rms = 0.0;
};
Parabola fit_parabola(const std::vector<double>& times, const std::vector<double>& values) {
  Eigen::MatrixXd design(static_cast<Eigen::Index>(times.size()), 3);
  Eigen::VectorXd target(static_cast<Eigen::Index>(times.size()));
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    design.row(at) << 1.0, times[i], times[i] * times[i];
    target[at] = values[i];
  }
  Parabola fit;
  fit.coefficients = design.colPivHouseholderQr().solve(target);
  fit.rms = std::sqrt((design * fit.coefficients - target).squaredNorm() /
                      static_cast<double>(times.size()));
  return fit;
}

void ball_toss(const std::filesystem::path& folder, Figures& figures) {
  constexpr double pixels_per_metre = 398.7;  // of the tape on the film, README of the data set
  constexpr int diameter = 11;                // px
  constexpr double frame_interval = 0.066;    // s, as header and marks agree
  constexpr double gravity = 9.81;
  figures.begin("Ball toss: one thrown ball, a tape as scale");
  tracking::VideoReader video(folder / "BallToss_new_BallToss.mp4", 1.0 / frame_interval);
  std::vector<cv::Mat> frames;
  for (cv::Mat frame; video.read(frame);) {
    cv::Mat grey;
    cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
    frames.push_back(grey.clone());
  }
  // What stands still is the median of all frames.
  cv::Mat still(frames.front().size(), CV_8U);
  std::vector<std::uint8_t> values(frames.size());
  for (int line = 0; line < still.rows; ++line) {
    for (int column = 0; column < still.cols; ++column) {
      for (std::size_t i = 0; i < frames.size(); ++i)
        values[i] = frames[i].at<std::uint8_t>(line, column);
      std::nth_element(values.begin(),
                       values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                       values.end());
      still.at<std::uint8_t>(line, column) = values[values.size() / 2];
    }
  }
  constexpr std::size_t most_moving = 8;  // the ball, and parts of the thrower
  std::vector<std::vector<Spot>> spots;
  for (const cv::Mat& frame : frames) {
    cv::Mat moving;
    cv::subtract(frame, still, moving);
    spots.push_back(tracking::locate_spots(moving, {.diameter_px = diameter, .least_mass = 1.0}));
    spots.back().resize(std::min(spots.back().size(), most_moving));
  }
  // Of all that moves the ball is what is seen longest on a parabola.
  constexpr double reach = 80.0;         // px; a step of 66 ms at 3 m/s
  constexpr double on_a_parabola = 2.0;  // px rms
  constexpr std::size_t fewest = 6;      // frames; twice what a parabola needs
  const auto tracks = tracking::link_spots(spots, reach, 0);
  double g = std::nan(""), rms = std::nan("");
  std::size_t best = 0;
  std::map<int, Eigen::Vector2d> ball;
  for (const auto& track : tracks) {
    std::vector<double> times, heights;
    std::map<int, Eigen::Vector2d> places;
    for (std::size_t i = 0; i < track.size(); ++i) {
      if (track[i] < 0) continue;
      const Eigen::Vector2d& at = spots[i][static_cast<std::size_t>(track[i])].pixel;
      times.push_back(static_cast<double>(i) * frame_interval);
      heights.push_back(at.y());
      places[static_cast<int>(i)] = at;
    }
    if (times.size() < fewest) continue;
    const Parabola fit = fit_parabola(times, heights);
    if (fit.rms > on_a_parabola || times.size() <= best) continue;
    best = times.size();
    g = 2.0 * fit.coefficients[2] / pixels_per_metre;
    rms = fit.rms;
    ball = places;
  }
  const datasets::Table marks = datasets::read_csv(folder / "reference_points.csv");
  std::vector<double> apart;
  for (std::size_t i = 0; i < marks.rows(); ++i) {
    const auto at = ball.find(marks.integer(i, "frame"));
    if (at != ball.end())
      apart.push_back(
          (at->second - Eigen::Vector2d(marks.number(i, "x_px"), marks.number(i, "y_px"))).norm());
  }
  const double off = g / gravity - 1.0;
  figures.asked("g from the film",
                "stated",
                fmt::format("{:.2f} m/s2 ({:+.1f} %), {} frames", g, 100.0 * off, best),
                best > 0);
  figures.told("parabola's residual", fmt::format("{:.2f} px rms", rms));
  figures.told(
      "distance to the marks, median",
      fmt::format("{:.2f} px ({} of {})", quantile(apart, 0.5), apart.size(), marks.rows()));
  if (std::abs(off) > 0.03)
    fmt::print(
        "    Warning: falling bodies show g = {:.2f} m/s2 instead of {:.2f}: lengths are {:.1f} % "
        "too large, or times {:.1f} % too short.\n",
        g,
        gravity,
        100.0 * off,
        100.0 * (1.0 - 1.0 / std::sqrt(1.0 + off)));
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path folder =
      argc > 2 ? std::filesystem::path(argv[2])
               : std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/real-data";
  Figures figures;
  const auto with = [&](const char* name, const auto& measure) {
    if (std::filesystem::is_directory(folder / name)) {
      measure(folder / name);
    } else {
      figures.begin(fmt::format("{}: skipped, the folder is not here", name));
    }
  };
  with("magdeburg-rods", [&](const auto& at) { rods(at, figures); });
  with("lund-magnetic-discs", [&](const auto& at) {
    discs(at, "N20-light.mp4", 20, figures);
    discs(at, "N40-light.mp4", 40, figures);
  });
  with("opencv-chessboard", [&](const auto& at) { chessboard(at, figures); });
  with("trackpy-bulk-water", [&](const auto& at) { trackpy(at, figures); });
  with("tracker-marked-videos", [&](const auto& at) { ball_toss(at / "balltoss", figures); });
  if (argc > 1) datasets::write_csv(argv[1], figures.table());
  return 0;
}
