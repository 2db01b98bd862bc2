#include "app/annotate/film_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "datasets/store/input_error.h"
#include "datasets/store/trajectories.h"
#include "reports/sections/pictures.h"
#include "tracking/event/first_change.h"
#include "tracking/film/recording.h"
#include "tracking/film/video.h"
#include "tracking/view/mask.h"
#include "tracking/view/scale.h"

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;

constexpr double usual_rate = 25.0;  // Hz, of pictures that tell none
constexpr std::size_t most_pictures = 24;

struct WholeFilm {
  cv::Mat first;
  int pictures = 0;
  double rate = 0.0;                           // Hz, of pictures
  std::vector<double> moments;                 // in intervals of that rate
  std::optional<tracking::FirstChange> start;  // counted in pictures
};

// The rate at which the film holds pictures: as stated, else as the container says.
double rate_of(const LookedAtFilm& film) {
  tracking::VideoReader reader(film.video, usual_rate);
  cv::Mat frame;
  reader.read(frame);
  const double declared = reader.declared_frame_rate();
  datasets::TrackingSpec spec;
  spec.camera.frame_rate = film.frame_rate.value_or(declared > 0.0 ? declared : usual_rate);
  return tracking::as_recorded(spec, film.video).camera.frame_rate;
}

// How far pictures are from the first one where they differ most: what moves changes a small part
// of a film, and codecs repeat pictures that hardly change.
class Difference {
 public:
  double from_first(const cv::Mat& frame) {
    constexpr double block = 1.0 / 8.0;  // blocks of 8 x 8 pixels, whose noise averages out
    cv::Mat grey, blocks;
    cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
    grey.convertTo(grey, CV_32F);
    cv::resize(grey, blocks, {}, block, block, cv::INTER_AREA);
    if (first_.empty()) first_ = blocks;
    const cv::Mat1f off = cv::abs(blocks - first_);
    std::vector<float> values(off.begin(), off.end());
    const std::size_t most = std::max<std::size_t>(1, values.size() / 200);  // half a per cent
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(most) - 1,
                     values.end(),
                     std::greater<>());
    return std::accumulate(
               values.begin(), values.begin() + static_cast<std::ptrdiff_t>(most), 0.0) /
           static_cast<double>(most);
  }

 private:
  cv::Mat first_;
};

WholeFilm read_film(const LookedAtFilm& film) {
  WholeFilm whole{.rate = rate_of(film)};
  tracking::VideoReader reader(film.video, whole.rate);
  cv::Mat frame;
  Difference difference;
  std::vector<double> changes;
  while (reader.read(frame)) {
    const double change = difference.from_first(frame);
    if (whole.first.empty())
      whole.first = frame.clone();
    else
      changes.push_back(change);
    whole.moments.push_back(reader.moment());
  }
  whole.pictures = reader.frames_read();
  whole.start = tracking::find_first_change(changes);
  return whole;
}

// Which pictures are worth most: the first, those about the start, the last, and ever more between.
std::vector<int> in_order_of_worth(const WholeFilm& film) {
  std::vector<int> order;
  std::set<int> taken;
  const auto take = [&](int picture) {
    if (picture >= 0 && picture < film.pictures && taken.insert(picture).second)
      order.push_back(picture);
  };
  take(0);
  if (film.start) {
    for (const int step : {0, -1, 1, -2, 2, 3, 4}) take(film.start->picture + step);
  }
  take(film.pictures - 1);
  for (int parts = 2; order.size() < most_pictures && parts <= 64; parts *= 2) {
    for (int k = 1; k < parts && order.size() < most_pictures; k += 2)
      take((film.pictures - 1) * k / parts);
  }
  return order;
}

std::string jpeg(const cv::Mat& picture, int quality) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return {bytes.begin(), bytes.end()};
}

// As good as fits; the size of the picture stays, because places are clicked in it.
std::string jpeg_within(const cv::Mat& picture, std::size_t budget) {
  std::string content;
  for (const int quality : {92, 80, 65, 50, 35}) {
    content = jpeg(picture, quality);
    if (content.size() <= budget) break;
  }
  return content;
}

Json pictures_of(const LookedAtFilm& film, const WholeFilm& whole, std::size_t budget) {
  // 1. All that are worth showing, compressed; points are clicked in the first one
  constexpr int quality = 80;
  const std::vector<int> order = in_order_of_worth(whole);
  std::map<int, std::string> compressed;
  tracking::VideoReader reader(film.video, whole.rate);
  cv::Mat frame;
  while (reader.read(frame)) {
    const int number = reader.frames_read() - 1;
    if (std::find(order.begin(), order.end(), number) != order.end())
      compressed[number] = number == 0 ? jpeg_within(frame, budget) : jpeg(frame, quality);
  }
  // 2. As many as fit
  std::map<int, const std::string*> shown;
  std::size_t size = 0;
  for (const int number : order) {
    const std::string& content = compressed.at(number);
    if (!shown.empty() && size + content.size() > budget) continue;
    size += content.size();
    shown[number] = &content;
  }
  Json pictures = Json::array();
  for (const auto& [number, content] : shown) {
    pictures.push_back({{"frame", number},
                        {"time", whole.moments[static_cast<std::size_t>(number)] / whole.rate},
                        {"source", reports::address_of_jpeg(*content)}});
  }
  return pictures;
}

Json suggestion_of(const WholeFilm& film) {
  if (!film.start) return nullptr;
  const auto at = [&](int picture) {
    return film.moments[static_cast<std::size_t>(std::clamp(picture, 0, film.pictures - 1))] /
           film.rate;
  };
  const double before = at(film.start->picture - 1);
  const double after = at(film.start->picture);
  return {{"frame", film.start->picture},
          {"time", 0.5 * (before + after)},
          {"uncertainty", after - before},
          {"words",
           fmt::format("pictures change {:.0f} times as much as rest scatters",
                       film.start->certainty)}};
}

// Every dark disc on light ground, whatever its size up to a tenth of the picture.
Json discs_in(const cv::Mat& grey) {
  constexpr double share = 0.05;  // find_dark_dots doubles it
  std::vector<tracking::DarkDot> dots =
      tracking::find_dark_dots(grey, {{0.0, 0.0, share}, {1.0, 0.0, share}});
  Json discs = Json::array();
  constexpr std::size_t most = 200;
  for (const tracking::DarkDot& dot : dots) {
    tracking::FiducialSighting sighting{0, dot.centre, dot.diameter};
    if (discs.size() == most || !tracking::refine_fiducial(grey, sighting)) continue;
    discs.push_back(
        {{"pixel", {sighting.pixel.x(), sighting.pixel.y()}}, {"diameter", sighting.diameter_px}});
  }
  return discs;
}

// What gives the scale and is found on the film itself: discs and corners of known places.
Json references_in(const cv::Mat& first, const LookedAtFilm& film) {
  Json found = Json::array();
  if (!film.spec) return found;
  const datasets::Camera& camera = film.spec->camera;
  if (camera.stick || !camera.points.empty() || (camera.fiducials.empty() && !camera.chessboard))
    return found;
  try {
    for (const tracking::CameraReference& one :
         tracking::look_for_scale(camera, first, {.name = film.name, .video = film.video})
             .references) {
      found.push_back({{"x", one.x},
                       {"z", one.z},
                       {"diameter", one.diameter},
                       {"pixel", {one.pixel.x(), one.pixel.y()}}});
    }
  } catch (const datasets::InputError&) {
    // A picture that cannot be read is told when the experiment is read
  }
  return found;
}

// Where the tracks of an earlier run begin.
Json grains_in(const std::filesystem::path& file) {
  Json grains = Json::array();
  if (!std::filesystem::is_regular_file(file)) return grains;
  const datasets::Trajectories tracks = datasets::read_tracks(file);
  for (int particle = 0; particle < tracks.particles && tracks.frames() > 0; ++particle) {
    const datasets::Pose& pose = tracks.poses[tracks.index(0, static_cast<std::size_t>(particle))];
    if (!std::isfinite(pose.x) || !std::isfinite(pose.z)) continue;
    grains.push_back({{"x", pose.x}, {"z", pose.z}, {"angle", nullptr}});
    if (std::isfinite(pose.angle)) grains.back()["angle"] = pose.angle;
  }
  return grains;
}

}  // namespace

Json look_at_film(const LookedAtFilm& film, std::size_t budget) {
  const WholeFilm whole = read_film(film);
  cv::Mat seen = whole.first;
  if (film.spec) tracking::Mask(film.spec->camera).cover(seen);
  cv::Mat grey;
  cv::cvtColor(seen, grey, cv::COLOR_BGR2GRAY);
  return {{"name", film.name},
          {"width", whole.first.cols},
          {"height", whole.first.rows},
          {"frames", whole.pictures},
          {"suggestion", suggestion_of(whole)},
          {"discs", discs_in(grey)},
          {"references", references_in(seen, film)},
          {"grains", grains_in(film.tracks)},
          {"pictures", pictures_of(film, whole, budget)}};
}

}  // namespace graintruth::app
