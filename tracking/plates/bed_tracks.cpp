#include "tracking/plates/bed_tracks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "tracking/bodies/assignment.h"
#include "tracking/bodies/link.h"
#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr double lost_score = 0.8;           // plates score 0.98 and more where they are
constexpr double good_score = 0.9;           // less is doubted where plates move far
constexpr double largest_gain_change = 1.6;  // factor; light changes slowly, blur a little
constexpr double deepest_overlap = 0.85;     // touching scale
constexpr double least_visible = 0.35;       // of its area; less is too little to fit
constexpr double settled_px = 0.01;          // a plate that moves less is not fitted again
constexpr double longest_step_px = 2.5;
constexpr int most_sweeps = 9;
constexpr std::size_t memory_frames = 12;  // for gaps that are filled afterwards
constexpr int inflation_interval = 4;      // frames
constexpr double rest_px = 0.1;            // a frame; jitter is less
constexpr double fast_share = 0.25;        // of the semi-minor axis, a frame
// A share of a plate's contrast that stays unexplained, over what is usual in the frame, that calls
// for a second look; and a share that never does.
constexpr double doubtful_ratio = 2.5, doubtless_share = 0.04;
// Of the semi-minor axis, that gravity moves a plate beyond its prediction in a frame: below it
// predictions are near enough to fit from.
constexpr double coarse_share = 0.3;

}  // namespace

BedTracks::BedTracks(const BedScene& scene, const FirstBed& bed, const cv::Mat& frame)
    : scene_(scene),
      bed_(bed),
      orifice_(scene, frame),
      closed_view_(scene.view(false)),
      open_view_(scene.view(true)),
      pixel_(scene.pixel()),
      fall_(scene.spec.rig.gravity / std::pow(scene.spec.camera.frame_rate, 2)) {
  for (const PlateFit& plate : bed.plates) {
    PlateTrack& track = tracks_.emplace_back();
    track.gain = plate.gain;
    accept(track, plate, frame, 0);
    track.velocity = {0.0, 0.0, 0.0};
  }
}

// Position errors show in blocks. Codecs shift blocks of pixels but cannot turn them, so that parts
// of a turning plate lag behind each other, each as a whole: an error between parts, which does not
// shrink as that of single pixels does (random effects, DerSimonian and Laird 1986). With B what
// blocks tell, H the parts' squared difference over what white residuals make of it, and L the
// leverage:
//   inflation of the angle = B + L (H - B).
Eigen::Vector3d BedTracks::variance_inflation(Pace pace) const {
  const Inflation& inflation = inflation_[static_cast<std::size_t>(pace)];
  if (inflation.count == 0.0) return Eigen::Vector3d::Ones();
  Eigen::Vector3d result = (inflation.blocks / inflation.count).cwiseMax(1.0);
  const double halves = inflation.halves[2] / inflation.count;
  const double leverage = inflation.leverage[2] / inflation.count;
  result[2] += leverage * std::max(0.0, halves - result[2]);
  return result;
}

Eigen::Vector3f BedTracks::colour_of(const cv::Mat& frame, const datasets::Pose& pose) const {
  constexpr int samples = 16;
  constexpr double ring = 0.7;  // of the half axes: inside the rim, outside most holes
  const double c = std::cos(pose.angle), s = std::sin(pose.angle);
  const Eigen::Vector2d centre = scene_.film.calibration.camera.project(pose.x, pose.z);
  const Eigen::Matrix2d jacobian = scene_.film.calibration.camera.jacobian(pose.x, pose.z);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int used = 0;
  for (int k = 0; k < samples; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / samples;
    const double u = ring * scene_.shape.semi_major * std::cos(angle);
    const double v = ring * scene_.shape.semi_minor * std::sin(angle);
    const Eigen::Vector2d at = centre + jacobian * Eigen::Vector2d(c * u - s * v, s * u + c * v);
    const cv::Point point(static_cast<int>(std::lround(at.x())),
                          static_cast<int>(std::lround(at.y())));
    if (!cv::Rect(0, 0, frame.cols, frame.rows).contains(point)) continue;
    const cv::Vec3b& pixel = frame.at<cv::Vec3b>(point);
    sum += Eigen::Vector3f(pixel[0], pixel[1], pixel[2]) - scene_.contrast.ground;
    ++used;
  }
  return sum / static_cast<float>(std::max(1, used)) / static_cast<float>(bed_.usual_gain);
}

// As fast as in the last frame, and free fall below the orifice. Where gravity carries plates far
// between frames they fall freely from the arch over the orifice on, which is about as high as the
// orifice's half width (free-fall arch, Hilton and Cleary 2011); elsewhere each gains as much speed
// as those about it just did.
datasets::Pose BedTracks::predict(const PlateTrack& track) const {
  datasets::Pose pose = track.expected;
  pose.x += track.velocity.x;
  pose.z += track.velocity.z;
  pose.angle += track.velocity.angle;
  // No plate gets into a wall
  const double side = 0.5 * scene_.box().width - deepest_overlap * scene_.shape.semi_minor;
  if (is_coarse()) pose.x = std::clamp(pose.x, -side, side);
  if (opened_at_ < 0 || track.unseen > 0) return pose;
  const double half_orifice = 0.5 * scene_.box().opening;
  const bool in_arch = is_coarse() && std::abs(pose.x) < half_orifice && pose.z < half_orifice;
  if (pose.z < 0.0 || in_arch) {
    pose.z -= fall_;
  } else if (is_coarse()) {
    const Eigen::Vector2d gained = gained_about(track.expected);
    pose.x += gained.x();
    pose.z += gained.y();
  }
  return pose;
}

// Median change of velocity, m a frame, of the plates within two and a half lengths.
Eigen::Vector2d BedTracks::gained_about(const datasets::Pose& place) const {
  std::vector<double> x, z;
  for (const PlateTrack& track : tracks_) {
    const std::size_t n = track.sightings.size();
    if (track.left_at >= 0 || n < 3) continue;
    const auto &a = track.sightings[n - 3], &b = track.sightings[n - 2],
               &c = track.sightings[n - 1];
    if (!a || !b || !c) continue;
    if (std::hypot(c->pose.x - place.x, c->pose.z - place.z) > 5.0 * scene_.shape.semi_major)
      continue;
    x.push_back(c->pose.x - 2.0 * b->pose.x + a->pose.x);
    z.push_back(c->pose.z - 2.0 * b->pose.z + a->pose.z);
  }
  constexpr std::size_t enough = 3;
  if (x.size() < enough) return {0.0, 0.0};
  return {median(x), median(z)};
}

bool BedTracks::is_coarse() const { return fall_ > coarse_share * scene_.shape.semi_minor; }

// By how far the rim moves in a frame.
Pace BedTracks::pace_of(const PlateTrack& track) const {
  const double travel = std::hypot(track.velocity.x, track.velocity.z) +
                        scene_.shape.semi_major * std::abs(track.velocity.angle);
  if (travel < rest_px * pixel_) return Pace::rest;
  return travel < fast_share * scene_.shape.semi_minor ? Pace::slow : Pace::fast;
}

bool BedTracks::has_left(const PlateFit& plate, const datasets::Pose& expected) const {
  return opened_at_ >= 0 && expected.z < -scene_.shape.semi_minor && plate.visible < least_visible;
}

bool BedTracks::is_lost(const PlateFit& plate, const PlateTrack& track) const {
  const double change = plate.gain / track.gain;
  return plate.score < lost_score || change > largest_gain_change ||
         change < 1.0 / largest_gain_change || plate.visible < least_visible ||
         is_in_wall(plate.pose);
}

// Nearer to a side wall of the bin than a plate can be.
bool BedTracks::is_in_wall(const datasets::Pose& pose) const {
  const double room = 0.5 * scene_.box().width - std::abs(pose.x);
  return pose.z > 0.0 && room < deepest_overlap * scene_.shape.semi_minor;
}

void BedTracks::fit_all(BedFit& fit, const std::vector<int>& index_of) {
  std::vector<double> step(fit.size(), std::numeric_limits<double>::infinity());
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    bool moved = false;
    for (const int index : index_of) {
      if (index < 0) continue;
      const auto k = static_cast<std::size_t>(index);
      if (sweep > 1 && step[k] < settled_px * pixel_) continue;
      step[k] = fit.improve(k, longest_step_px * pixel_);
      moved = moved || step[k] >= settled_px * pixel_;
    }
    if (sweep > 0 && !moved) break;
  }
}

// Plates that the model explains worse than usual may sit in a false minimum: turned by a collision
// or pushed aside. Each is fitted again from other angles, where it stands and where it was
// predicted, and stays at the best. Returns whether any moved.
bool BedTracks::retry_doubtful(BedFit& fit, const std::vector<int>& index_of) {
  std::vector<double> unexplained(tracks_.size(), 0.0), sorted;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    if (index_of[k] < 0) continue;
    unexplained[k] = 1.0 - fit.measure(static_cast<std::size_t>(index_of[k])).score;
    sorted.push_back(unexplained[k]);
  }
  if (sorted.empty()) return false;
  const double limit = std::max(doubtless_share, doubtful_ratio * median(sorted));
  bool moved = false;
  constexpr int turns = 6;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    if (index_of[k] < 0 || unexplained[k] < limit) continue;
    const auto index = static_cast<std::size_t>(index_of[k]);
    const PlateFit start = fit.measure(index);
    PlateFit best = start;
    for (const datasets::Pose& from : {start.pose, tracks_[k].expected}) {
      for (int turn = 0; turn < turns; ++turn) {
        fit.move(
            index,
            {from.x, from.z, from.angle + axis_difference(std::numbers::pi * turn / turns, 0.0)});
        for (int step = 0; step < 10; ++step)
          if (fit.improve(index, longest_step_px * pixel_) < 5.0 * settled_px * pixel_) break;
        const PlateFit tried = fit.measure(index);
        const double change = tried.gain / tracks_[k].gain;
        if (change > largest_gain_change || change < 1.0 / largest_gain_change) continue;
        if (tried.score > best.score) best = tried;
      }
    }
    best.pose.angle =
        tracks_[k].expected.angle + axis_difference(best.pose.angle, tracks_[k].expected.angle);
    fit.restore(index, best);
    moved = moved || best.score > start.score;
  }
  return moved;
}

// Where gravity can carry plates far in a frame, each is first looked for as it looked in the last
// frame, with its surroundings, at half the resolution.
void BedTracks::match_coarsely(const cv::Mat1f& coarse) {
  const double reach = 0.5 * 1.3 * fall_ / pixel_;                     // coarse pixels
  const double window = 0.5 * 1.5 * scene_.shape.semi_major / pixel_;  // half of the pattern's side
  const auto coarse_at = [&](const datasets::Pose& pose) {
    const Eigen::Vector2d pixel = scene_.film.calibration.camera.project(pose.x, pose.z);
    return Eigen::Vector2d(0.5 * (pixel.x() - scene_.region.x + 0.5) - 0.5,
                           0.5 * (pixel.y() - scene_.region.y + 0.5) - 0.5);
  };
  const cv::Rect whole(0, 0, coarse.cols, coarse.rows);
  for (PlateTrack& track : tracks_) {
    if (track.left_at >= 0 || track.unseen > 0) continue;
    const datasets::Pose& last = track.sightings.back()->pose;
    const Eigen::Vector2d before = coarse_at(last), now = coarse_at(track.expected);
    const int half = static_cast<int>(std::ceil(window)), far = static_cast<int>(std::ceil(reach));
    const cv::Point from(static_cast<int>(std::lround(before.x())),
                         static_cast<int>(std::lround(before.y())));
    const cv::Point to(static_cast<int>(std::lround(now.x())),
                       static_cast<int>(std::lround(now.y())));
    const cv::Rect pattern(from.x - half, from.y - half, 2 * half + 1, 2 * half + 1);
    const cv::Rect field(
        to.x - half - far, to.y - half - far, 2 * (half + far) + 1, 2 * (half + far) + 1);
    if ((pattern & whole) != pattern || (field & whole) != field) continue;
    cv::Mat1f response;
    cv::matchTemplate(coarse(field), coarse_(pattern), response, cv::TM_CCOEFF_NORMED);
    cv::Point best;
    cv::minMaxLoc(response, nullptr, nullptr, nullptr, &best);
    // From the rounded places to the true ones
    const Eigen::Vector2d shift(best.x - far + to.x - from.x + before.x() - now.x(),
                                best.y - far + to.y - from.y + before.y() - now.y());
    const Eigen::Vector2d plane =
        scene_.film.calibration.camera.jacobian(track.expected.x, track.expected.z).inverse() *
        (2.0 * shift);
    track.expected.x += plane.x();
    track.expected.z += plane.y();
  }
}

// Plates that are not explained where they were fitted, and of two in one place the worse.
std::vector<std::size_t> BedTracks::find_lost(const std::vector<int>& index_of,
                                              const std::vector<PlateFit>& measured) const {
  std::vector<char> lost(tracks_.size(), 0);
  for (std::size_t k = 0; k < tracks_.size(); ++k)
    lost[k] = index_of[k] >= 0 && is_lost(measured[k], tracks_[k]);
  const double reach = 2.0 * scene_.shape.semi_minor * deepest_overlap;
  const double far = 2.0 * scene_.shape.semi_major;
  for (std::size_t a = 0; a < tracks_.size(); ++a) {
    if (index_of[a] < 0) continue;
    for (std::size_t b = 0; b < a; ++b) {
      if (index_of[b] < 0) continue;
      const datasets::Pose &one = measured[a].pose, &other = measured[b].pose;
      const double distance = std::hypot(one.x - other.x, one.z - other.z);
      if (distance > far) continue;
      if (distance > reach && touching_scale(one, other, scene_.shape) > deepest_overlap) continue;
      if (lost[a] || lost[b]) continue;
      lost[measured[a].score < measured[b].score ? a : b] = 1;
    }
  }
  std::vector<std::size_t> list;
  for (std::size_t k = 0; k < tracks_.size(); ++k)
    if (lost[k]) list.push_back(k);
  return list;
}

void BedTracks::accept(PlateTrack& track, const PlateFit& plate, const cv::Mat& frame, int number) {
  const bool seen_before = !track.sightings.empty() && track.unseen == 0;
  if (seen_before && track.sightings.back()) {
    const datasets::Pose& before = track.sightings.back()->pose;
    track.velocity = {
        plate.pose.x - before.x, plate.pose.z - before.z, plate.pose.angle - before.angle};
  }
  track.sightings.resize(static_cast<std::size_t>(number));
  track.sightings.push_back(PlateSighting{plate.pose,
                                          plate.covariance,
                                          static_cast<float>(plate.score),
                                          static_cast<float>(plate.gain),
                                          pace_of(track),
                                          false});
  track.expected = plate.pose;
  track.unseen = 0;
  const Eigen::Vector3f colour = colour_of(frame, plate.pose);
  // Light changes along the way: remembered for about fifty frames
  const bool first = number == 0;
  track.colour = first ? colour : Eigen::Vector3f(0.98F * track.colour + 0.02F * colour);
  track.gain = first ? plate.gain : 0.9 * track.gain + 0.1 * plate.gain;
}

void BedTracks::follow(const cv::Mat& frame, int number, int parity) {
  if (opened_at_ < 0 && orifice_.is_open(frame)) opened_at_ = number;
  const bool open = opened_at_ >= 0;
  const int row_step = parity < 0 ? 1 : 2;
  const int first_row = parity < 0 ? 0 : (parity + scene_.region.y) % 2;
  const cv::Mat1f contrast = contrast_of(frame, scene_.region, scene_.contrast);
  memory_.push_back({number, contrast, first_row, row_step, open});
  if (memory_.size() > memory_frames) memory_.pop_front();
  BedFit fit(open ? open_view_ : closed_view_, bed_.look, contrast.clone(), first_row, row_step);

  // 1. Prediction
  cv::Mat1f coarse;
  cv::resize(contrast, coarse, cv::Size(), 0.5, 0.5, cv::INTER_AREA);
  std::vector<int> index_of(tracks_.size(), -1);
  std::vector<std::size_t> waiting;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    PlateTrack& track = tracks_[k];
    if (track.left_at >= 0) continue;
    track.expected = predict(track);
  }
  std::vector<datasets::Pose> predicted;
  for (const PlateTrack& track : tracks_) predicted.push_back(track.expected);
  if (open && is_coarse()) match_coarsely(coarse);
  coarse_ = coarse;

  // 2. All plates that were seen in the last frame fitted together
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    const PlateTrack& track = tracks_[k];
    if (track.left_at >= 0) continue;
    if (track.unseen == 0)
      index_of[k] = static_cast<int>(fit.add(track.expected, track.gain));
    else
      waiting.push_back(k);
  }
  fit_all(fit, index_of);
  if (retry_doubtful(fit, index_of)) fit_all(fit, index_of);

  // 3. Who has left, who is lost
  std::vector<PlateFit> measured(tracks_.size());
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    if (index_of[k] < 0) continue;
    const auto index = static_cast<std::size_t>(index_of[k]);
    measured[k] = fit.measure(index);
    if (has_left(measured[k], tracks_[k].expected)) {
      tracks_[k].left_at = number;
      fit.remove(index);
      index_of[k] = -1;
    }
  }
  std::vector<std::size_t> lost = find_lost(index_of, measured);
  losses_ += static_cast<int>(lost.size());
  for (const std::size_t k : lost) {
    fit.remove(static_cast<std::size_t>(index_of[k]));
    index_of[k] = -1;
  }
  // Neighbours of a plate that had been fitted in a wrong place are seen better once it has left it
  constexpr int most_rounds = 3;
  for (int round = 0; open && is_coarse() && round < most_rounds; ++round) {
    // One that is half explained may lie between two plates and hide both
    for (std::size_t k = 0; k < tracks_.size(); ++k) {
      if (index_of[k] < 0 || measured[k].score > good_score) continue;
      fit.remove(static_cast<std::size_t>(index_of[k]));
      index_of[k] = -1;
      (tracks_[k].unseen > 0 ? waiting : lost).push_back(k);
    }
    if (!tell_apart(fit, frame, predicted, lost, waiting, index_of, measured)) break;
    fit_all(fit, index_of);
    if (retry_doubtful(fit, index_of)) fit_all(fit, index_of);
    for (std::size_t k = 0; k < tracks_.size(); ++k)
      if (index_of[k] >= 0) measured[k] = fit.measure(static_cast<std::size_t>(index_of[k]));
    for (const std::size_t k : find_lost(index_of, measured)) {
      fit.remove(static_cast<std::size_t>(index_of[k]));
      index_of[k] = -1;
      (tracks_[k].unseen > 0 ? waiting : lost).push_back(k);
    }
  }
  lost.insert(lost.end(), waiting.begin(), waiting.end());

  // 4. The lost ones looked for in what the others leave unexplained
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    if (index_of[k] < 0) continue;
    const int gap = tracks_[k].unseen;
    accept(tracks_[k], measured[k], frame, number);
    if (gap > 0) fill_gap(k, number - gap, number);
  }
  if (!lost.empty()) recover(fit, frame, number, lost);

  // 5. How far the residuals are from white
  if (number % inflation_interval == 0) {
    for (std::size_t k = 0; k < tracks_.size(); ++k) {
      if (index_of[k] < 0) continue;
      const BedFit::Variances variances = fit.variances(static_cast<std::size_t>(index_of[k]));
      Inflation& inflation = inflation_[static_cast<std::size_t>(pace_of(tracks_[k]))];
      inflation.blocks += variances.blocks;
      inflation.halves += variances.halves;
      inflation.leverage += variances.leverage;
      inflation.count += 1.0;
    }
  }
}

// Plates that no track was fitted to: wherever as much as a plate stays unexplained.
std::vector<BedTracks::Found> BedTracks::find_strangers(BedFit& fit, const cv::Mat& frame) const {
  const BedView& view = fit.view();
  const int side = std::max(3, static_cast<int>(1.4 * scene_.shape.semi_minor / pixel_)) | 1;
  constexpr double least_share = 0.35;  // of the usual brightness, as in the first frame
  constexpr int most = 12;              // a frame; more is a frame that nobody understands
  cv::Mat1b taken(view.usable.size(), std::uint8_t{0});
  std::vector<Found> found;
  for (int tries = 0; tries < 2 * most && static_cast<int>(found.size()) < most; ++tries) {
    cv::Mat1f mean;
    fit.residual().copyTo(mean);
    mean.setTo(0.0F, view.usable == 0);
    cv::boxFilter(mean, mean, CV_32F, {side, side});
    mean.setTo(0.0F, taken);
    double highest = 0.0;
    cv::Point at;
    cv::minMaxLoc(mean, nullptr, &highest, nullptr, &at);
    if (highest < least_share * bed_.usual_gain) break;
    cv::circle(taken, at, side / 2, cv::Scalar(255), cv::FILLED);
    const Eigen::Vector2d plane = view.camera->unproject(
        {static_cast<double>(view.region.x + at.x), static_cast<double>(view.region.y + at.y)});
    PlateTrack nobody;
    nobody.expected = {plane.x(), plane.y(), 0.0};
    nobody.gain = highest;
    const std::optional<Found> one = seek(fit, frame, nobody);
    if (!one || overlaps_any(fit, one->plate.pose)) continue;
    Found kept = *one;
    kept.index = fit.add(one->plate.pose, one->plate.gain);
    found.push_back(kept);
  }
  return found;
}

// Hard plates do not overlap.
bool BedTracks::overlaps_any(const BedFit& fit, const datasets::Pose& pose) const {
  for (std::size_t other = 0; other < fit.size(); ++other) {
    if (!fit.is_present(other)) continue;
    const datasets::Pose& a = fit.pose(other);
    if (std::hypot(a.x - pose.x, a.z - pose.z) < 2.0 * scene_.shape.semi_major &&
        touching_scale(a, pose, scene_.shape) < deepest_overlap)
      return true;
  }
  return false;
}

// Where plates move by about their own length in a frame, one may have been fitted where its
// neighbour is now. All places, and those that nobody was fitted to, are given to the tracks anew:
// by how far each lies from the prediction, and by colour. Returns whether any changed its place.
bool BedTracks::tell_apart(BedFit& fit,
                           const cv::Mat& frame,
                           const std::vector<datasets::Pose>& predicted,
                           std::vector<std::size_t>& lost,
                           std::vector<std::size_t>& waiting,
                           std::vector<int>& index_of,
                           std::vector<PlateFit>& measured) const {
  // 1. Places
  std::vector<Found> places = find_strangers(fit, frame);
  for (const std::vector<std::size_t>* missing : {&lost, &waiting}) {
    for (const std::size_t k : *missing) {
      const std::optional<Found> one = seek(fit, frame, tracks_[k]);
      if (!one || overlaps_any(fit, one->plate.pose)) continue;
      places.push_back(*one);
      places.back().index = fit.add(one->plate.pose, one->plate.gain);
    }
  }
  const std::size_t strangers = places.size();
  std::vector<std::size_t> tracks;  // all that may own one
  std::vector<double> differences;
  for (std::size_t k = 0; k < tracks_.size(); ++k) {
    if (index_of[k] < 0) continue;
    places.push_back(
        {static_cast<std::size_t>(index_of[k]), measured[k], colour_of(frame, measured[k].pose)});
    tracks.push_back(k);
    differences.push_back((places.back().colour - tracks_[k].colour).norm());
  }
  tracks.insert(tracks.end(), lost.begin(), lost.end());
  tracks.insert(tracks.end(), waiting.begin(), waiting.end());
  if (places.empty()) return false;
  // 2. Costs. Collisions change speeds by about as much as gravity does, and may stop a plate at
  // any part of its way. Colours err by what those of this frame do: video shares them among rows,
  // which blends the fields of an interlaced frame.
  const double colour_sigma = std::max(0.06, median(differences));
  const double step_sigma = 0.6 * fall_;
  constexpr double forbidden = 1.0e6, gate = 6.0;
  Eigen::MatrixXd cost(static_cast<Eigen::Index>(tracks.size()),
                       static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const PlateTrack& track = tracks_[tracks[i]];
    const datasets::Pose& expected = predicted[tracks[i]];
    const double sigma = step_sigma * (1.0 + track.unseen);
    const datasets::Pose& last = track.sightings.back()->pose;
    const Eigen::Vector2d way(expected.x - last.x, expected.z - last.z);
    const double length = track.unseen > 0 ? 0.0 : way.norm();
    for (std::size_t j = 0; j < places.size(); ++j) {
      const datasets::Pose& pose = places[j].plate.pose;
      const Eigen::Vector2d off(pose.x - expected.x, pose.z - expected.z);
      const double short_of = length > 0.0 ? -off.dot(way) / length : 0.0;
      const bool is_slowed = short_of > 0.0 && short_of < length + sigma;
      const double across = std::sqrt(std::max(0.0, off.squaredNorm() - short_of * short_of));
      const double distance =
          is_slowed ? std::hypot(across / sigma, short_of / std::max(sigma, 0.5 * length))
                    : off.norm() / sigma;
      const double colour = (places[j].colour - track.colour).norm() / colour_sigma;
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          distance > gate ? forbidden : distance * distance + std::min(16.0, colour * colour);
    }
  }
  std::vector<int> place_of = assign(cost, forbidden);
  // 3. Hard plates between two panes cannot pass through each other: of two whose ways would, each
  // goes where the other was to
  std::vector<datasets::Pose> goals;
  for (const Found& place : places) goals.push_back(place.plate.pose);
  undo_crossings(tracks, goals, place_of);
  // 4. Everybody moves to the place given
  std::vector<char> used(places.size(), 0);
  lost.clear();
  waiting.clear();
  bool changed = false;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const std::size_t k = tracks[i];
    const int before = index_of[k];
    if (place_of[i] < 0) {
      index_of[k] = -1;
      (tracks_[k].unseen > 0 ? waiting : lost).push_back(k);
      continue;
    }
    const auto j = static_cast<std::size_t>(place_of[i]);
    used[j] = 1;
    index_of[k] = static_cast<int>(places[j].index);
    measured[k] = places[j].plate;
    measured[k].pose.angle =
        predicted[k].angle + axis_difference(measured[k].pose.angle, predicted[k].angle);
    changed = changed || index_of[k] != before;
  }
  for (std::size_t j = 0; j < strangers; ++j)
    if (!used[j]) fit.remove(places[j].index);
  return changed;
}

void BedTracks::undo_crossings(const std::vector<std::size_t>& tracks,
                               const std::vector<datasets::Pose>& places,
                               std::vector<int>& place_of) const {
  struct Way {
    Eigen::Vector2d from, step;
  };
  const auto way_of = [&](std::size_t i, int place) {
    const datasets::Pose& from = tracks_[tracks[i]].sightings.back()->pose;
    const datasets::Pose& to = places[static_cast<std::size_t>(place)];
    return Way{{from.x, from.z}, {to.x - from.x, to.z - from.z}};
  };
  // Straight ways at even speed, m: nearer than two plates side by side is impossible
  const double least_distance = deepest_overlap * 2.0 * scene_.shape.semi_minor;
  const auto cross = [&](const Way& a, const Way& b) {
    const Eigen::Vector2d apart = b.from - a.from, change = b.step - a.step;
    const double square = change.squaredNorm();
    const double share = square > 0.0 ? std::clamp(-apart.dot(change) / square, 0.0, 1.0) : 0.0;
    return (apart + share * change).norm() < least_distance;
  };
  std::vector<std::size_t> moving;  // those whose ways are known
  for (std::size_t i = 0; i < tracks.size(); ++i)
    if (place_of[i] >= 0 && tracks_[tracks[i]].unseen == 0) moving.push_back(i);
  // How many others a track would cross on its way to a place, `but` for one
  const auto crossed_by = [&](std::size_t i, int place, std::size_t but) {
    const Way own = way_of(i, place);
    int count = 0;
    for (const std::size_t other : moving)
      if (other != i && other != but) count += cross(own, way_of(other, place_of[other]));
    return count;
  };
  constexpr int most_passes = 4;
  for (int pass = 0; pass < most_passes; ++pass) {
    bool changed = false;
    for (const std::size_t i : moving) {
      for (const std::size_t j : moving) {
        if (j <= i || !cross(way_of(i, place_of[i]), way_of(j, place_of[j]))) continue;
        if (cross(way_of(i, place_of[j]), way_of(j, place_of[i]))) continue;
        const int now = crossed_by(i, place_of[i], j) + crossed_by(j, place_of[j], i);
        const int then = crossed_by(i, place_of[j], j) + crossed_by(j, place_of[i], i);
        if (then > now) continue;
        std::swap(place_of[i], place_of[j]);
        changed = true;
      }
    }
    if (!changed) break;
  }
}

// The best place about the expected one, by a coarse search over places and angles in the residual
// and then a fit of the best few.
std::optional<BedTracks::Found> BedTracks::seek(BedFit& fit,
                                                const cv::Mat& frame,
                                                const PlateTrack& track) const {
  const double stride = 0.3 * scene_.shape.semi_minor;
  const double speed = std::hypot(track.velocity.x, track.velocity.z);
  const double reach =
      std::min(4.0 * scene_.shape.semi_major,
               (1.0 + 0.5 * track.unseen) * (scene_.shape.semi_minor + 0.5 * speed + 2.0 * fall_));
  const int steps = static_cast<int>(std::ceil(reach / stride));
  struct Start {
    datasets::Pose pose;
    double gain, value;
  };
  std::vector<Start> starts;
  constexpr int angles = 6;
  for (int i = -steps; i <= steps; ++i) {
    for (int j = -steps; j <= steps; ++j) {
      if (i * i + j * j > steps * steps) continue;
      for (int k = 0; k < angles; ++k) {
        const datasets::Pose pose{track.expected.x + i * stride,
                                  track.expected.z + j * stride,
                                  track.expected.angle + std::numbers::pi * k / angles};
        double score = 0.0;
        const double gain = fit.gain_at(pose, &score);
        if (gain < 0.4 * track.gain) continue;
        starts.push_back({pose, gain, score * std::min(1.0, gain / track.gain)});
      }
    }
  }
  constexpr std::size_t tried = 4;
  std::sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) {
    return a.value > b.value;
  });
  std::optional<Found> best;
  std::vector<datasets::Pose> done;
  for (const Start& start : starts) {
    if (done.size() == tried) break;
    const bool near = std::any_of(done.begin(), done.end(), [&](const datasets::Pose& pose) {
      return std::hypot(pose.x - start.pose.x, pose.z - start.pose.z) < 1.5 * stride;
    });
    if (near) continue;
    done.push_back(start.pose);
    const std::size_t index = fit.add(start.pose, start.gain);
    for (int step = 0; step < 10; ++step)
      if (fit.improve(index, longest_step_px * pixel_) < settled_px * pixel_) break;
    Found found{index, fit.measure(index), {}};
    fit.remove(index);
    if (is_lost(found.plate, track)) continue;
    if (best && best->plate.score > found.plate.score) continue;
    if (!frame.empty()) found.colour = colour_of(frame, found.plate.pose);
    best = found;
  }
  return best;
}

void BedTracks::recover(BedFit& fit,
                        const cv::Mat& frame,
                        int number,
                        const std::vector<std::size_t>& lost) {
  // 1. Detections: each is put into the model, so that none is found twice
  std::vector<Found> found;
  std::vector<std::size_t> order = lost;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return tracks_[a].unseen < tracks_[b].unseen;
  });
  for (const std::size_t k : order) {
    const std::optional<Found> one = seek(fit, frame, tracks_[k]);
    if (!one) continue;
    if (overlaps_any(fit, one->plate.pose)) continue;
    Found kept = *one;
    kept.index = fit.add(one->plate.pose, one->plate.gain);
    found.push_back(kept);
  }
  // 2. To whom each belongs: place and colour
  constexpr double colour_sigma = 0.06;  // of the usual brightness
  constexpr double forbidden = 1.0e6;
  Eigen::MatrixXd cost(static_cast<Eigen::Index>(lost.size()),
                       static_cast<Eigen::Index>(found.size()));
  for (std::size_t i = 0; i < lost.size(); ++i) {
    const PlateTrack& track = tracks_[lost[i]];
    const double sigma = (1.0 + track.unseen) * 0.4 * scene_.shape.semi_minor + fall_;
    for (std::size_t j = 0; j < found.size(); ++j) {
      const datasets::Pose& pose = found[j].plate.pose;
      const double distance =
          std::hypot(pose.x - track.expected.x, pose.z - track.expected.z) / sigma;
      const double colour = (found[j].colour - track.colour).norm() / colour_sigma;
      constexpr double gate = 6.0;
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          distance > gate ? forbidden : distance * distance + std::min(50.0, colour * colour);
    }
  }
  const std::vector<int> detection_of = assign(cost, forbidden);
  bool doubtful = false;
  for (std::size_t i = 0; i < lost.size(); ++i) {
    PlateTrack& track = tracks_[lost[i]];
    if (detection_of[i] >= 0) {
      PlateFit plate = found[static_cast<std::size_t>(detection_of[i])].plate;
      plate.pose.angle =
          track.expected.angle + axis_difference(plate.pose.angle, track.expected.angle);
      const int gap = track.unseen;
      accept(track, plate, frame, number);
      if (gap == 0)
        ++recoveries_;
      else
        fill_gap(lost[i], number - gap, number);
      continue;
    }
    doubtful = true;
    ++track.unseen;
    const bool below = opened_at_ >= 0 && track.expected.z < -scene_.shape.semi_minor;
    const Eigen::Vector2d at =
        scene_.film.calibration.camera.project(track.expected.x, track.expected.z);
    if (below && at.y() > frame.rows - 1.0) track.left_at = number;
    if (below) {
      track.velocity.z -= fall_;
    } else {
      // Nobody knows; it slows down
      for (double* component : {&track.velocity.x, &track.velocity.z, &track.velocity.angle})
        *component *= 0.8;
    }
  }
  if (doubtful) doubtful_frames_.push_back(number);
}

// Backwards through the frames in which a plate was not seen, each fitted among the neighbours that
// were.
void BedTracks::fill_gap(std::size_t k, int from, int to) {
  PlateTrack& track = tracks_[k];
  if (from < 1 || !track.sightings[static_cast<std::size_t>(from - 1)]) return;
  const datasets::Pose before = track.sightings[static_cast<std::size_t>(from - 1)]->pose;
  const datasets::Pose after = track.sightings[static_cast<std::size_t>(to)]->pose;
  const double frames = to - from + 1;
  track.velocity = {(after.x - before.x) / frames,
                    (after.z - before.z) / frames,
                    (after.angle - before.angle) / frames};
  for (const Memory& memory : memory_) {
    if (memory.number < from || memory.number >= to) continue;
    const double share = (memory.number - from + 1) / frames;
    const datasets::Pose guess{before.x + share * (after.x - before.x),
                               before.z + share * (after.z - before.z),
                               before.angle + share * (after.angle - before.angle)};
    BedFit fit(memory.open ? open_view_ : closed_view_,
               bed_.look,
               memory.contrast.clone(),
               memory.first_row,
               memory.row_step);
    const auto frame = static_cast<std::size_t>(memory.number);
    for (const PlateTrack& other : tracks_) {
      if (other.sightings.size() <= frame || !other.sightings[frame]) continue;
      const PlateSighting& seen = *other.sightings[frame];
      if (std::hypot(seen.pose.x - guess.x, seen.pose.z - guess.z) < 6.0 * scene_.shape.semi_major)
        fit.add(seen.pose, seen.gain);
    }
    PlateTrack about = track;
    about.expected = guess;
    const std::optional<Found> found = seek(fit, cv::Mat(), about);
    if (!found) continue;
    PlateFit plate = found->plate;
    plate.pose.angle = guess.angle + axis_difference(plate.pose.angle, guess.angle);
    track.sightings[frame] = PlateSighting{plate.pose,
                                           plate.covariance,
                                           static_cast<float>(plate.score),
                                           static_cast<float>(plate.gain),
                                           pace_of(track),
                                           true};
  }
}

}  // namespace graintruth::tracking
