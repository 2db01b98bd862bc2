// How well the free surface of a bed is read from films of a heap and of a drum whose every grain
// is known, as they were filmed and as others would have filmed them. Truth: the outline of the
// true spheres as the film's true camera sees it on the plane of the fiducials, in the tracker's
// own columns. Prints a row a film and change and writes them to OUT.csv; a picture of each last
// frame with its outline goes to the folder PICTURES.
//   bench_tracking_outline [OUT.csv] [part of a film's name] [part of a change's name] [PICTURES]
#include "datasets/store/outline.h"

#include <fmt/format.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "datasets/store/silhouette.h"
#include "datasets/store/table.h"
#include "tracking/film/synthetic_video.h"
#include "tracking/film/video.h"
#include "tracking/registry.h"
#include "tracking/track_film.h"
#include "tracking/view/scale.h"

using namespace graintruth;

namespace {

namespace fs = std::filesystem;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double degree = std::numbers::pi / 180.0;

double number(const toml::table& table, const char* key) {
  return table[key].value<double>().value();
}

struct FilmedBed {
  std::string name;
  datasets::TrackingSpec spec;
  datasets::Film film;
  toml::table truth;
  fs::path spheres;
  double grain = 0.0;        // m
  double turning = unknown;  // rev/min, clockwise
  double lift = unknown;     // m/s
};

std::vector<Eigen::Vector2d> box(double left, double bottom, double right, double top) {
  return {{left, bottom}, {right, bottom}, {right, top}, {left, top}};
}

// The part of a ring between two angles, degrees.
std::vector<Eigen::Vector2d> sector(double inner, double outer, double from, double to) {
  std::vector<Eigen::Vector2d> corners;
  constexpr int steps = 24;
  for (int i = 0; i <= steps; ++i) {
    const double angle = degree * (from + (to - from) * i / steps);
    corners.emplace_back(outer * std::cos(angle), outer * std::sin(angle));
  }
  for (int i = steps; i >= 0; --i) {
    const double angle = degree * (from + (to - from) * i / steps);
    corners.emplace_back(inner * std::cos(angle), inner * std::sin(angle));
  }
  return corners;
}

datasets::SeenOutline rig_of_heap(const toml::table& geometry, double grain) {
  const toml::table& tube = *geometry["tube"].as_table();
  const double inner = 0.5 * number(tube, "inner_diameter_m");
  const double outer = inner + number(tube, "wall_m");
  const double height = number(tube, "height_m");
  datasets::SeenOutline outline{.from_x = -4.0 * inner, .to_x = 4.0 * inner, .floor_z = 0.0};
  outline.grains_after = {box(-0.5 * inner, 0.5 * grain, 0.5 * inner, 2.0 * grain)};
  outline.empty = {box(-4.0 * inner, height, 4.0 * inner, 2.0 * height)};
  outline.mover = datasets::SeenOutline::Mover{
      .name = "tube", .drawing = box(-outer, 0.0, outer, height), .radius = outer};
  return outline;
}

datasets::SeenOutline drum_of(double radius) {
  datasets::SeenOutline outline{.from_x = -radius, .to_x = radius, .floor_z = -radius};
  outline.grains_after = {sector(0.6 * radius, 0.95 * radius, -125.0, -55.0)};
  outline.empty = {sector(0.3 * radius, radius, 50.0, 110.0)};
  outline.drum = datasets::SeenOutline::Drum{.radius = radius};
  return outline;
}

std::vector<FilmedBed> films_in(const fs::path& folder, bool is_heap) {
  std::vector<FilmedBed> films;
  if (!fs::exists(folder)) return films;
  const toml::table geometry = toml::parse_file((folder / "geometry.toml").string());
  const toml::table truth = toml::parse_file((folder / "truth/truth.toml").string());
  const double grain = number(*geometry["particle"].as_table(), "diameter_m");
  const toml::array& files = *geometry["video"]["files"].as_array();
  for (std::size_t i = 0; i < files.size(); ++i) {
    FilmedBed bed;
    const fs::path file = files[i].value<std::string>().value();
    bed.name = file.stem().string();
    bed.film = {bed.name, folder / file, {}, folder / "geometry.toml"};
    bed.spheres = folder / "truth" / (bed.name + "_spheres.csv.gz");
    bed.truth = truth;
    bed.grain = grain;
    bed.spec.body = {.kind = "balls", .balls = {{0.0, 0.5 * grain}}};
    bed.spec.camera.frame_rate = geometry["video"]["fps"].value<double>().value();
    for (const auto& one : *geometry["fiducial"].as_array()) {
      const toml::table& dot = *one.as_table();
      bed.spec.camera.fiducials.push_back(
          {number(dot, "x_m"), number(dot, "z_m"), number(dot, "diameter_m")});
    }
    if (is_heap) {
      bed.spec.rig.outline = rig_of_heap(geometry, grain);
      bed.lift = number(*geometry["tube"].as_table(), "lift_speed_m_s");
    } else {
      bed.spec.rig.outline =
          drum_of(0.5 * number(*geometry["drum"].as_table(), "inner_diameter_m"));
      bed.turning = geometry["video"]["rpm"][i].value<double>().value();
    }
    films.push_back(std::move(bed));
  }
  return films;
}

// The stated camera; which way round its angles count is what the fiducials show.
tracking::Camera true_camera(const FilmedBed& bed) {
  const toml::table& camera = *bed.truth["camera"].as_table();
  const int width = static_cast<int>(number(camera, "width"));
  const int height = static_cast<int>(number(camera, "height"));
  const double distance = number(camera, "distance_m");
  tracking::VideoReader video(bed.film.video, bed.spec.camera.frame_rate);
  cv::Mat frame;
  video.read(frame);
  const tracking::SeenScale seen = tracking::look_for_scale(bed.spec.camera, frame, bed.film);
  tracking::Camera best;
  double least = 1e9;
  const std::array<Eigen::Vector3d, 3> axes = {
      Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      const std::array<double, 3> angles = {
          (signs & 1 ? -1 : 1) * degree * number(camera, "pan_deg"),
          (signs & 2 ? -1 : 1) * degree * number(camera, "tilt_deg"),
          (signs & 4 ? -1 : 1) * degree * number(camera, "roll_deg")};
      Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
      for (const int k : order) {
        const auto i = static_cast<std::size_t>(k);
        rotation = Eigen::AngleAxisd(angles[i], axes[i]).toRotationMatrix() * rotation;
      }
      const Eigen::AngleAxisd turn(rotation);
      tracking::Camera::Parameters parameters;
      parameters << std::log(1e3 * number(camera, "px_per_mm") * distance), 0.0,
          turn.angle() * turn.axis(), number(camera, "aim_x_m"), number(camera, "aim_z_m"),
          std::log(distance), number(camera, "k1"), number(camera, "k2");
      const tracking::Camera tried(width, height, parameters);
      double square = 0.0;
      for (const tracking::CameraReference& dot : seen.references)
        square +=
            (tracking::disc_centroid(tried, dot.x, dot.z, dot.diameter) - dot.pixel).squaredNorm();
      const double rms = std::sqrt(square / (2.0 * static_cast<double>(seen.references.size())));
      if (rms >= least) continue;
      least = rms;
      best = tried;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  fmt::print(
      "{}: the true camera shows the fiducials {:.2f} px rms from where they are seen; it "
      "stands at {:.4f} {:.4f} {:.4f} m\n",
      bed.name,
      least,
      best.position().x(),
      best.position().y(),
      best.position().z());
  return best;
}

// The spheres of the last frame, or of several by their frames.
std::map<int, std::vector<datasets::Ball>> spheres_of(const FilmedBed& bed) {
  std::map<int, std::vector<datasets::Ball>> frames;
  FILE* pipe = ::popen(fmt::format("gzip -dc '{}'", bed.spheres.string()).c_str(), "r");
  std::string text;
  std::array<char, 65536> buffer;
  for (std::size_t got = 0; (got = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    text.append(buffer.data(), got);
  ::pclose(pipe);
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  const bool in_time = line.starts_with("time_s");
  const int last = static_cast<int>(bed.truth["run"][0]["frames"].value<double>().value()) - 1;
  while (std::getline(lines, line)) {
    std::vector<double> cells;
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(std::stod(cell));
    if (in_time) {
      frames[static_cast<int>(cells[1])].push_back({{cells[3], cells[4], cells[5]}, cells[9]});
    } else {
      frames[last].push_back({{cells[1], cells[2], cells[3]}, cells[4]});
    }
  }
  return frames;
}

using Change = std::function<cv::Mat(const cv::Mat&, int number)>;

Change level(double gain, double veil) {
  return [=](const cv::Mat& frame, int) {
    cv::Mat result;
    frame.convertTo(result, CV_8UC3, gain, veil);
    return result;
  };
}

const std::vector<std::pair<std::string, Change>> changes = {
    {"as it is", [](const cv::Mat& frame, int) { return frame; }},
    {"darker", level(0.5, 0.0)},
    {"noisy",
     [](const cv::Mat& frame, int number) {
       cv::Mat noise(frame.size(), CV_32FC3), exact, result;
       cv::RNG generator(static_cast<std::uint64_t>(7919 + number));
       generator.fill(noise, cv::RNG::NORMAL, 0.0, 10.0);
       frame.convertTo(exact, CV_32FC3);
       exact += noise;
       exact.convertTo(result, CV_8UC3);
       return result;
     }},
    {"low contrast", level(0.35, 90.0)},
    {"tilted",
     [](const cv::Mat& frame, int) {
       cv::Mat result;
       const cv::Point2f middle(0.5F * static_cast<float>(frame.cols - 1),
                                0.5F * static_cast<float>(frame.rows - 1));
       cv::warpAffine(frame,
                      result,
                      cv::getRotationMatrix2D(middle, 2.0, 1.0),
                      frame.size(),
                      cv::INTER_CUBIC,
                      cv::BORDER_REPLICATE);
       return result;
     }},
    {"half resolution",
     [](const cv::Mat& frame, int) {
       cv::Mat result;
       cv::resize(frame, result, frame.size() / 2, 0, 0, cv::INTER_AREA);
       return result;
     }},
    {"half rate",
     [](const cv::Mat& frame, int number) { return number % 2 == 0 ? frame : cv::Mat(); }},
    {"time code",
     [](const cv::Mat& frame, int number) {
       cv::Mat result = frame.clone();
       cv::putText(result,
                   fmt::format("00:00:{:02}:{:02}", number / 50, number % 50),
                   {frame.cols / 2 - 90, frame.rows / 12},
                   cv::FONT_HERSHEY_SIMPLEX,
                   0.9,
                   cv::Scalar::all(235),
                   2,
                   cv::LINE_AA);
       return result;
     }},
    {"black bars",
     [](const cv::Mat& frame, int) {
       cv::Mat result;
       cv::copyMakeBorder(frame, result, 60, 60, 40, 40, cv::BORDER_CONSTANT, cv::Scalar::all(0));
       return result;
     }},
    {"reflection",
     [](const cv::Mat& frame, int) {
       cv::Mat light(frame.size(), CV_8UC3, cv::Scalar::all(0)), result;
       cv::ellipse(light,
                   {static_cast<int>(0.58 * frame.cols), static_cast<int>(0.62 * frame.rows)},
                   {frame.cols / 12, frame.rows / 20},
                   20.0,
                   0.0,
                   360.0,
                   cv::Scalar::all(50),
                   cv::FILLED);
       cv::GaussianBlur(light, light, cv::Size(), 4.0);
       cv::add(frame, light, result);
       return result;
     }},
};

struct Line {
  double slope = unknown, offset = unknown;
};

Line fit(const std::vector<double>& x, const std::vector<double>& z) {
  double n = 0.0, sx = 0.0, sz = 0.0, sxx = 0.0, sxz = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(z[i])) continue;
    n += 1.0;
    sx += x[i];
    sz += z[i];
    sxx += x[i] * x[i];
    sxz += x[i] * z[i];
  }
  const double slope = (n * sxz - sx * sz) / (n * sxx - sx * sx);
  return {slope, (sz - slope * sx) / n};
}

// Of a heap: the mean of both flanks, each a line through the columns from the apex outwards
// between 20 and 80 % of the height. Degrees.
double heap_angle(const std::vector<double>& x, const std::vector<double>& z) {
  std::size_t apex = 0;
  for (std::size_t i = 0; i < z.size(); ++i)
    if (std::isfinite(z[i]) && !(z[i] <= z[apex])) apex = i;
  const double top = z[apex];
  double sum = 0.0;
  for (const int way : {-1, 1}) {
    std::vector<double> at, height;
    for (long i = static_cast<long>(apex); i >= 0 && i < static_cast<long>(z.size()); i += way) {
      const double here = z[static_cast<std::size_t>(i)];
      if (!(here >= 0.2 * top)) break;
      if (here > 0.8 * top) continue;
      at.push_back(x[static_cast<std::size_t>(i)]);
      height.push_back(here);
    }
    sum += std::atan(std::abs(fit(at, height).slope)) / degree;
  }
  return 0.5 * sum;
}

// Of a drum: of the line within half its radius.
double drum_angle(const std::vector<double>& x, const std::vector<double>& z, double radius) {
  std::vector<double> at, height;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::abs(x[i]) > 0.5 * radius) continue;
    at.push_back(x[i]);
    height.push_back(z[i]);
  }
  return std::atan(std::abs(fit(at, height).slope)) / degree;
}

struct Errors {
  double n = 0.0, sum = 0.0, square = 0.0, z_n = 0.0, z_sum = 0.0, z_square = 0.0, missed = 0.0;
  double mean() const { return sum / n; }
  double rms() const { return std::sqrt(square / n); }
  double z_sd() const { return std::sqrt(z_square / z_n - std::pow(z_sum / z_n, 2)); }
  Errors& operator+=(const Errors& other) {
    n += other.n;
    sum += other.sum;
    square += other.square;
    z_n += other.z_n;
    z_sum += other.z_sum;
    z_square += other.z_square;
    missed += other.missed;
    return *this;
  }
};

// Two averaged pictures of a real powder in a drum of 84 mm that fills them. Read by hand on an
// enlargement with a grid, before any program had read them: the angle of the line between two
// points of the edge, 80 and 40 pixels apart about the middle.
struct RealDrum {
  std::string file;
  double first_reading, second_reading;  // degrees
};
const std::vector<RealDrum> real_drums = {{"gd_nature_10rpm_averaged.bmp", 38.0, 38.2},
                                          {"gd_nature_30rpm_averaged.bmp", 48.5, 49.0}};

void read_real_drums(const fs::path& folder, const fs::path& pictures) {
  constexpr double radius = 0.042, middle = 202.5;  // m, px
  for (const RealDrum& real : real_drums) {
    datasets::TrackingSpec spec;
    // The powder's own grains are smaller than a pixel: these stand for many of them
    spec.body = {.kind = "balls", .balls = {{0.0, 1e-3}}};
    spec.camera.frame_rate = 1.0;
    for (const auto& [x, z] : {std::pair(-1.0, 0.0), {1.0, 0.0}, {0.0, -1.0}, {0.0, 1.0}})
      spec.camera.points.push_back(
          {middle + middle * x, middle - middle * z, radius * x, radius * z});
    spec.rig.outline = drum_of(radius);
    const datasets::Film film{real.file, folder / real.file, {}, folder / "README.md"};
    const auto tracker = tracking::make_tracker(spec, film);
    tracking::TrackingOptions options;
    if (!pictures.empty()) options.annotated_first = pictures / (real.file + ".png");
    const auto tracked = tracking::track_film(*tracker, spec, film, options);
    const datasets::Outline& outline = tracker->outlines().front();
    fmt::print("{}: slope at the middle {:.2f} degrees; by hand {:.1f} and {:.1f}\n",
               real.file,
               drum_angle(outline.column, outline.height, 0.4 * radius),
               real.first_reading,
               real.second_reading);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path out = argc > 1 ? argv[1] : "tracking_outline.csv";
  const std::string film_part = argc > 2 ? argv[2] : "", part = argc > 3 ? argv[3] : "";
  const fs::path pictures = argc > 4 ? argv[4] : "";
  const fs::path shared = fs::path(GRAINTRUTH_SOURCE_DIR).parent_path() / "shared/lab-videos";
  std::vector<FilmedBed> beds = films_in(shared / "heap", true);
  for (FilmedBed& bed : films_in(shared / "drum", false)) beds.push_back(std::move(bed));
  if (beds.empty()) {
    fmt::print("skipped: {} is not here\n", shared.string());
    return 0;
  }
  datasets::Table table({"film",
                         "change",
                         "rms_d",
                         "bias_d",
                         "z_sd",
                         "missed",
                         "angle_deg",
                         "true_angle_deg",
                         "speed_ratio",
                         "eye_m",
                         "grade",
                         "said"});
  fmt::print("{:12} {:16} {:>6} {:>6} {:>5} {:>6} {:>6} {:>6} {:>7} {:>6}  {}\n",
             "film",
             "change",
             "rms/d",
             "bias/d",
             "z sd",
             "missed",
             "angle",
             "true",
             "speed",
             "eye m",
             "grade");
  std::map<std::string, Errors> pooled;
  const fs::path file =
      fs::temp_directory_path() / fmt::format("graintruth_outline_{}.avi", ::getpid());
  for (const FilmedBed& bed : beds) {
    if (bed.name.find(film_part) == std::string::npos) continue;
    const Eigen::Vector3d position = true_camera(bed).position();
    const datasets::Eye eye{position.x(), position.y(), position.z()};
    const auto spheres = spheres_of(bed);
    for (const auto& [name, change] : changes) {
      if (name.find(part) == std::string::npos) continue;
      datasets::TrackingSpec spec = bed.spec;
      datasets::Film film = bed.film;
      int stride = 1;
      if (name != changes.front().first) {
        std::vector<cv::Mat> frames;
        tracking::VideoReader video(bed.film.video, spec.camera.frame_rate);
        int read = 0;
        for (cv::Mat frame; video.read(frame); ++read) {
          cv::Mat changed = change(frame, read);
          if (!changed.empty()) frames.push_back(changed.clone());
        }
        if (static_cast<int>(frames.size()) < read) {
          stride = 2;
          spec.camera.frame_rate /= 2.0;
        }
        tracking::write_film(file, frames, spec.camera.frame_rate);
        film.video = file;
      }
      std::vector<std::string> row = {bed.name, name};
      try {
        const auto tracker = tracking::make_tracker(spec, film);
        tracking::TrackingOptions options;
        if (!pictures.empty()) {
          fs::create_directories(pictures);
          const std::string stem = fmt::format("{}_{}", bed.name, name);
          options.annotated_first = pictures / (stem + "_first.png");
          options.annotated_middle = pictures / (stem + "_middle.png");
          options.annotated_last = pictures / (stem + "_last.png");
        }
        const tracking::TrackedFilm tracked = tracking::track_film(*tracker, spec, film, options);
        const datasets::Outline& outline = tracker->outlines().front();
        Errors errors;
        std::vector<double> mean(outline.column.size(), 0.0), true_mean = mean;
        for (const auto& [number_of_frame, balls] : spheres) {
          const auto moment = static_cast<std::size_t>(number_of_frame / stride);
          if (moment >= outline.time.size()) continue;
          const std::vector<double> truth = datasets::silhouette(balls, outline.column, eye);
          for (std::size_t k = 0; k < truth.size(); ++k) {
            const double height = outline.height[outline.index(moment, k)];
            mean[k] += height;
            true_mean[k] += truth[k];
            const bool counts = std::isfinite(bed.lift) ? truth[k] > 0.0
                                                        : std::isfinite(truth[k]) &&
                                                              std::abs(outline.column[k]) <= 0.045;
            if (!counts) continue;
            if (!std::isfinite(height)) {
              errors.missed += 1.0;
              continue;
            }
            const double error = height - truth[k];
            errors.n += 1.0;
            errors.sum += error / bed.grain;
            errors.square += std::pow(error / bed.grain, 2);
            if (k % 2 != 0) continue;
            const double z = error / outline.sigma[outline.index(moment, k)];
            errors.z_n += 1.0;
            errors.z_sum += z;
            errors.z_square += z * z;
            if (std::getenv("OUTLINE_ERRORS"))
              fmt::print("  {} x {:.4f} z {:.4f} error/d {:.3f} z {:.2f}\n",
                         number_of_frame,
                         outline.column[k],
                         truth[k],
                         error / bed.grain,
                         z);
          }
        }
        pooled[fmt::format("{} {}", std::isfinite(bed.lift) ? "heaps" : "drums", name)] += errors;
        for (std::size_t k = 0; k < mean.size(); ++k) {
          mean[k] /= static_cast<double>(spheres.size());
          true_mean[k] /= static_cast<double>(spheres.size());
        }
        const bool heap = std::isfinite(bed.lift);
        const double radius = heap ? 0.0 : bed.spec.rig.outline->drum->radius;
        const double angle =
            heap ? heap_angle(outline.column, mean) : drum_angle(outline.column, mean, radius);
        const double true_angle = heap ? heap_angle(outline.column, true_mean)
                                       : drum_angle(outline.column, true_mean, radius);
        nlohmann::ordered_json described;
        tracker->describe(described);
        const auto& figures = described["outline"];
        const double speed = heap ? figures.value("lift_speed_mm_per_s", unknown) / (1e3 * bed.lift)
                                  : figures.value("turning_rpm", unknown) / -bed.turning;
        std::string said;
        for (const std::string& warning : tracked.summary.warnings)
          said += (said.empty() ? "" : " ") + warning;
        fmt::print(
            "{:12} {:16} {:6.3f} {:6.3f} {:5.2f} {:6.0f} {:6.2f} {:6.2f} {:7.4f} {:6.3f}  {} {}\n",
            bed.name,
            name,
            errors.rms(),
            errors.mean(),
            errors.z_sd(),
            errors.missed,
            angle,
            true_angle,
            speed,
            outline.eye.distance,
            tracking::to_string(tracked.summary.grade),
            said);
        for (const double value : {errors.rms(),
                                   errors.mean(),
                                   errors.z_sd(),
                                   errors.missed,
                                   angle,
                                   true_angle,
                                   speed,
                                   outline.eye.distance})
          row.push_back(datasets::number_text(value));
        row.push_back(tracking::to_string(tracked.summary.grade));
        row.push_back(said);
      } catch (const std::exception& error) {
        fmt::print("{:12} {:16} refused: {}\n", bed.name, name, error.what());
        row.insert(row.end(), {"", "", "", "", "", "", "", "", "refused", error.what()});
      }
      std::fflush(stdout);
      table.add(row);
    }
  }
  fs::remove(file);
  for (const auto& [name, errors] : pooled)
    fmt::print("{:24} rms {:.3f} d, bias {:.3f} d, z mean {:.2f}, z sd {:.2f}, missed {}\n",
               name,
               errors.rms(),
               errors.mean(),
               errors.z_sum / errors.z_n,
               errors.z_sd(),
               errors.missed);
  const fs::path real = shared.parent_path() / "real-data/granudrum-mcc";
  if (fs::exists(real) && std::string("granudrum").find(film_part) != std::string::npos)
    read_real_drums(real, pictures);
  datasets::write_csv(out, table);
  fmt::print("written to {}\n", out.string());
  return 0;
}
