// How well a film is tracked as other cameras, lamps and recorders would have filmed it: each of
// some forty changes of one bundled film, and of one of pale balls where the shared data lie beside
// the repository, against the truth. Errors that are larger must be said to be larger: z-scores
// stand beside them. Prints a row a change and writes them to OUT.csv.
//   bench_tracking_changed [OUT.csv] [frames of each film] [part of a change's name]
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "bench/tracking/films.h"
#include "bench/tracking/pair_truth.h"
#include "datasets/store/table.h"
#include "tracking/balls/ball_tracker.h"
#include "tracking/film/synthetic_video.h"
#include "tracking/film/video.h"
#include "tracking/track_film.h"

using namespace graintruth;

namespace {

using Change = std::function<cv::Mat(const cv::Mat&, int number)>;

// Colours one by one, as floating point in 0..1.
Change each(const std::function<void(cv::Mat& exact)>& change) {
  return [change](const cv::Mat& frame, int) {
    cv::Mat exact, result;
    frame.convertTo(exact, CV_32FC3, 1.0 / 255.0);
    change(exact);
    exact.convertTo(result, CV_8UC3, 255.0);
    return result;
  };
}

Change gained(double gain) {
  return each([=](cv::Mat& exact) { exact *= gain; });
}
Change bent(double gamma) {
  return each([=](cv::Mat& exact) { cv::pow(exact, gamma, exact); });
}
Change faded(double contrast, double veil) {
  return each([=](cv::Mat& exact) { exact = exact * contrast + cv::Scalar::all(veil); });
}
Change tinted(double blue, double green, double red) {
  return each([=](cv::Mat& exact) { cv::multiply(exact, cv::Scalar(blue, green, red), exact); });
}
Change lit_from(double degrees, double slope) {
  return each([=](cv::Mat& exact) {
    const double angle = degrees * std::numbers::pi / 180.0;
    for (int row = 0; row < exact.rows; ++row)
      for (int column = 0; column < exact.cols; ++column) {
        const double x = static_cast<double>(column) / exact.cols - 0.5,
                     y = 0.5 - static_cast<double>(row) / exact.rows;
        exact.at<cv::Vec3f>(row, column) *=
            static_cast<float>(1.0 + slope * (x * std::cos(angle) + y * std::sin(angle)));
      }
  });
}
Change hue_turned(double degrees) {
  return [=](const cv::Mat& frame, int) {
    cv::Mat exact, hls, result;
    frame.convertTo(exact, CV_32FC3, 1.0 / 255.0);
    cv::cvtColor(exact, hls, cv::COLOR_BGR2HLS);
    for (int row = 0; row < hls.rows; ++row)
      for (int column = 0; column < hls.cols; ++column) {
        float& hue = hls.at<cv::Vec3f>(row, column)[0];
        hue = std::fmod(hue + static_cast<float>(degrees), 360.0F);
      }
    cv::cvtColor(hls, exact, cv::COLOR_HLS2BGR);
    exact.convertTo(result, CV_8UC3, 255.0);
    return result;
  };
}
Change saturated(double share) {
  return each([=](cv::Mat& exact) {
    cv::Mat grey, three;
    cv::cvtColor(exact, grey, cv::COLOR_BGR2GRAY);
    cv::cvtColor(grey, three, cv::COLOR_GRAY2BGR);
    exact = share * exact + (1.0 - share) * three;
  });
}
Change noisy(double sigma) {
  return [=](const cv::Mat& frame, int number) {
    cv::Mat noise(frame.size(), CV_32FC3), exact, result;
    cv::RNG generator(static_cast<std::uint64_t>(7919 + number));
    generator.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
    frame.convertTo(exact, CV_32FC3);
    exact += noise;
    exact.convertTo(result, CV_8UC3);
    return result;
  };
}
Change blurred(double sigma) {
  return [=](const cv::Mat& frame, int) {
    cv::Mat result;
    cv::GaussianBlur(frame, result, cv::Size(), sigma);
    return result;
  };
}
Change sized(double factor) {
  return [=](const cv::Mat& frame, int) {
    cv::Mat result;
    const cv::Size size(2 * static_cast<int>(std::lround(0.5 * factor * frame.cols)),
                        2 * static_cast<int>(std::lround(0.5 * factor * frame.rows)));
    cv::resize(frame, result, size, 0, 0, factor < 1.0 ? cv::INTER_AREA : cv::INTER_CUBIC);
    return result;
  };
}
Change turned(double degrees) {
  return [=](const cv::Mat& frame, int) {
    cv::Mat result;
    const cv::Point2f middle(0.5F * static_cast<float>(frame.cols),
                             0.5F * static_cast<float>(frame.rows));
    cv::warpAffine(frame,
                   result,
                   cv::getRotationMatrix2D(middle, degrees, 1.0),
                   frame.size(),
                   cv::INTER_CUBIC,
                   cv::BORDER_REPLICATE);
    return result;
  };
}
Change compressed(int quality) {
  return [=](const cv::Mat& frame, int) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", frame, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
    return cv::imdecode(bytes, cv::IMREAD_COLOR);
  };
}
Change flickering(double share) {
  return [=](const cv::Mat& frame, int number) {
    cv::Mat result;
    frame.convertTo(result, CV_8UC3, 1.0 + share * std::sin(1.7 * number));
    return result;
  };
}
Change mixed(std::array<int, 3> channels) {
  return [=](const cv::Mat& frame, int) {
    std::array<cv::Mat, 3> parts;
    cv::split(frame, parts.data());
    cv::Mat result;
    const std::array<cv::Mat, 3> sorted = {parts[static_cast<std::size_t>(channels[0])],
                                           parts[static_cast<std::size_t>(channels[1])],
                                           parts[static_cast<std::size_t>(channels[2])]};
    cv::merge(sorted.data(), 3, result);
    return result;
  };
}
Change negative() {
  return [](const cv::Mat& frame, int) { return cv::Mat(cv::Scalar::all(255) - frame); };
}

const std::vector<std::pair<std::string, Change>> changes = {
    {"as it is", [](const cv::Mat& frame, int) { return frame; }},
    {"gain 0.5", gained(0.5)},
    {"gain 0.7", gained(0.7)},
    {"gain 1.3", gained(1.3)},
    {"gain 1.6", gained(1.6)},
    {"gamma 0.6", bent(0.6)},
    {"gamma 0.8", bent(0.8)},
    {"gamma 1.3", bent(1.3)},
    {"gamma 1.6", bent(1.6)},
    {"haze 0.6", faded(0.6, 0.2)},
    {"haze 0.4", faded(0.4, 0.28)},
    {"warm light", tinted(0.75, 0.95, 1.1)},
    {"cold light", tinted(1.15, 1.0, 0.8)},
    {"light from the left", lit_from(180.0, 0.6)},
    {"light from the right", lit_from(0.0, 0.6)},
    {"light from above", lit_from(90.0, 0.6)},
    {"light from below", lit_from(-90.0, 0.6)},
    {"hue 40", hue_turned(40.0)},
    {"hue 90", hue_turned(90.0)},
    {"hue 140", hue_turned(140.0)},
    {"hue 220", hue_turned(220.0)},
    {"hue 300", hue_turned(300.0)},
    {"half the colour", saturated(0.5)},
    {"half more colour", saturated(1.5)},
    {"grey", saturated(0.0)},
    {"noise 3", noisy(3.0)},
    {"noise 6", noisy(6.0)},
    {"noise 12", noisy(12.0)},
    {"blur 0.7", blurred(0.7)},
    {"blur 1.2", blurred(1.2)},
    {"blur 2", blurred(2.0)},
    {"size 0.6", sized(0.6)},
    {"size 0.8", sized(0.8)},
    {"size 1.5", sized(1.5)},
    {"turned 2", turned(2.0)},
    {"turned -2", turned(-2.0)},
    {"JPEG 60", compressed(60)},
    {"JPEG 30", compressed(30)},
    {"flicker", flickering(0.08)},
    {"red and blue exchanged", mixed({2, 1, 0})},
    {"channels moved on", mixed({1, 2, 0})},
    {"negative", negative()},
};

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path out = argc > 1 ? argv[1] : "tracking_changed.csv";
  const int frames = argc > 2 ? std::stoi(argv[2]) : 120;
  const std::string part = argc > 3 ? argv[3] : "";
  std::vector<bench::Filmed> films = bench::films_of("micro", "", "rep3");
  std::vector<bench::Filmed> pale = bench::pale_films();
  if (!pale.empty()) films.push_back(std::move(pale.front()));
  datasets::Table table({"film",
                         "change",
                         "seen",
                         "strangers",
                         "rmse_px",
                         "worst_body_px",
                         "z_sd",
                         "worst_body_z",
                         "grade",
                         "said"});
  fmt::print("{:10} {:24} {:>6} {:>7} {:>7} {:>7} {:>6} {:>7}  {}\n",
             "film",
             "change",
             "seen %",
             "strange",
             "px",
             "worst",
             "z",
             "worst",
             "grade");
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("graintruth_changed_{}.avi", ::getpid());
  for (const bench::Filmed& filmed : films) {
    for (const auto& [name, change] : changes) {
      if (name.find(part) == std::string::npos) continue;
      std::vector<cv::Mat> pictures;
      {
        tracking::VideoReader video(filmed.film.video, filmed.spec.camera.frame_rate);
        for (cv::Mat frame; video.frames_read() < frames && video.read(frame);)
          pictures.push_back(change(frame, video.frames_read() - 1).clone());
      }
      tracking::write_film(file, pictures, filmed.spec.camera.frame_rate);
      datasets::Film film = filmed.film;
      film.video = file;
      std::vector<std::string> row = {filmed.replicate.name, name};
      try {
        tracking::BallTracker tracker(filmed.spec, film);
        const auto [tracks, summary] = tracking::track_film(tracker, filmed.spec, film);
        const double px = 1.0e3 * summary.scale_px_per_mm;
        bench::PairErrors total;
        double worst = 0.0, worst_z = 0.0;
        for (const bench::PairBody& body :
             bench::compare_pairs(tracks,
                                  filmed.replicate.video.parent_path() / "truth",
                                  filmed.replicate.video.stem().string().substr(0, 4))) {
          total += body.errors;
          worst = std::max({worst,
                            px * body.errors.root(body.errors.x2),
                            px * body.errors.root(body.errors.z2)});
          worst_z = std::max({worst_z,
                              body.errors.root(body.errors.over_x2),
                              body.errors.root(body.errors.over_z2)});
        }
        const double rms = px * total.root(0.5 * (total.x2 + total.z2));
        const double z = total.root(0.5 * (total.over_x2 + total.over_z2));
        std::string said;
        for (const std::string& warning : summary.warnings)
          said += (said.empty() ? "" : " ") + warning;
        fmt::print("{:10} {:24} {:6.1f} {:7} {:7.3f} {:7.3f} {:6.2f} {:7.2f}  {} {}\n",
                   filmed.replicate.name,
                   name,
                   100.0 * total.seen / total.frames,
                   total.strangers,
                   rms,
                   worst,
                   z,
                   worst_z,
                   tracking::to_string(summary.grade),
                   said);
        for (const double value :
             {total.seen / total.frames, total.strangers, rms, worst, z, worst_z})
          row.push_back(datasets::number_text(value));
        row.push_back(tracking::to_string(summary.grade));
        row.push_back(said);
      } catch (const std::exception& error) {
        fmt::print("{:10} {:24} refused: {}\n", filmed.replicate.name, name, error.what());
        row.insert(row.end(), {"0", "0", "", "", "", "", "refused", error.what()});
      }
      std::fflush(stdout);
      table.add(row);
    }
  }
  std::filesystem::remove(file);
  datasets::write_csv(out, table);
  fmt::print("written to {}\n", out.string());
  return 0;
}
