// The free surface of a bed: what grains and what is behind them look like is learned from where
// the drawing of the rig says that they surely are, or surely are not; every picture is then cut
// along its columns.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>

#include "datasets/store/input_error.h"
#include "datasets/store/outline.h"
#include "datasets/store/silhouette.h"
#include "tracking/drawing/drawing.h"
#include "tracking/event/start_of_motion.h"
#include "tracking/median.h"
#include "tracking/outline/colour_model.h"
#include "tracking/outline/lift.h"
#include "tracking/outline/plane_picture.h"
#include "tracking/outline/turning.h"
#include "tracking/outline/upper_edge.h"
#include "tracking/particle_tracker.h"
#include "tracking/view/mask.h"

namespace graintruth::tracking {

namespace {

using datasets::SeenOutline;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Gaussians of each model. Balls are lit, shaded and shiny; behind them are a wall, a floor, marks.
constexpr int grain_colours = 4;
constexpr int ground_colours = 6;
// Pixels of each model that one picture gives at most
constexpr std::size_t most_pixels = 4000;
// No cell is believed more than this: odds of twenty to one
const float most_evidence = std::log(20.0F);
// Pictures that are kept of a film to learn from
constexpr std::size_t most_samples = 24;

// Grey levels, of single pixels: what is left of the picture after its neighbours are taken off
// (Immerkaer 1996), where not more than half of it is edges.
double pixel_noise(const cv::Mat& picture, const cv::Mat1b& mask) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  const cv::Mat1f kernel = (cv::Mat1f(3, 3) << 1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat1f left;
  cv::filter2D(grey, left, CV_32F, kernel);
  std::vector<float> sizes;
  for (int row = 1; row + 1 < left.rows; ++row)
    for (int column = 1; column + 1 < left.cols; ++column)
      if (mask(row, column) != 0) sizes.push_back(std::abs(left(row, column)));
  // Rounding to whole levels is noise as well
  constexpr double rounding = 0.2887;
  return std::hypot(median(sizes) / 0.6745 / 6.0, rounding);
}

ColourModel::Colour mean_of(const std::vector<ColourModel::Colour>& colours) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ColourModel::Colour& colour : colours) sum += colour.cast<double>();
  return (sum / static_cast<double>(colours.size())).cast<float>();
}

class OutlineTracker : public ParticleTracker {
 public:
  OutlineTracker(const datasets::TrackingSpec& spec, const datasets::Film& film)
      : spec_(spec), film_(film), rig_(*spec.rig.outline) {
    for (const datasets::AxialSphere& ball : spec.body.balls)
      grain_ = std::max(grain_, 2.0 * ball.radius);
    for (const auto& [name, length] : spec.body.lengths) grain_ = std::max(grain_, length);
  }

  bool looks_ahead() const override { return true; }

  void look_ahead(const Picture& picture, const FilmCamera& camera) override {
    if (times_.empty()) set_up(camera);
    times_.push_back(picture.moment / spec_.camera.frame_rate);
    const cv::Mat plane = plane_.of(picture.frame);
    if (lift_watcher_ || turning_watcher_) {
      cv::Mat grey;
      cv::cvtColor(lift_watcher_ ? plane : picture.frame, grey, cv::COLOR_BGR2GRAY);
      if (lift_watcher_) lift_watcher_->look(grey, plane_.seen(), times_.back());
      if (turning_watcher_) turning_watcher_->look(grey, times_.back());
    }
    keep(plane, picture.number);
    last_ = {picture.number, plane};
  }

  void find_first(const Picture& picture,
                  const FilmCamera& camera,
                  TrackingSummary& summary) override {
    learn(summary);
    summary.scale_px_per_mm = 1e-3 * lens_.scale(0.5 * (rig_.from_x + rig_.to_x), middle_z());
    calibration_ = camera.calibration;
    find_place_errors();
    follow(picture);
  }

  void follow(const Picture& picture) override {
    const double time = picture.moment / spec_.camera.frame_rate;
    const cv::Mat plane = plane_.of(picture.frame);
    const GrainEvidence evidence = evidence_in(plane, time);
    for (Surface& surface : surfaces_) {
      surface.edges.push_back(edge_of(surface, plane, evidence));
      average(surface.edges.back(), surface);
    }
    seen_times_.push_back(time);
  }

  datasets::Trajectories finish(TrackingSummary& summary) override {
    tell_event(summary);
    const std::size_t frames = seen_times_.size();
    const Eigen::Vector3d& eye = lens_.position();
    for (Surface& surface : surfaces_) {
      for (const double time : seen_times_)
        surface.outline.time.push_back(time - summary.event_time_s);
      surface.outline.eye = {eye.x(), eye.y(), eye.z()};
      outlines_.push_back(std::move(surface.outline));
    }
    tell_quality(summary);
    datasets::Trajectories nobody = datasets::make_trajectories(frames, 0, true);
    nobody.time = outlines_.front().time;
    return nobody;
  }

  std::span<const datasets::Outline> outlines() const override { return outlines_; }

  void draw(cv::Mat&, const Camera&, const DrawnBody&) const override {}

  void draw_frame(cv::Mat& picture, const Camera& camera, std::size_t frame) const override {
    if (frame >= seen_times_.size()) return;
    const PlaneGrid& grid = plane_.grid();
    if (lift_watcher_) {
      const std::vector<Eigen::Vector2d> shadow =
          lift_watcher_->shadow(rise_at(seen_times_[frame]));
      for (std::size_t k = 0; k < shadow.size(); ++k) {
        const Eigen::Vector2d& from = shadow[k];
        const Eigen::Vector2d& to = shadow[(k + 1) % shadow.size()];
        draw_line(picture,
                  camera.project(from.x(), from.y()),
                  camera.project(to.x(), to.y()),
                  cv::Scalar(200, 120, 0));
      }
    }
    for (const Surface& surface : surfaces_) {
      const UpperEdge& edge = surface.edges[frame];
      for (std::size_t k = 1; k < edge.row.size(); ++k) {
        if (!std::isfinite(edge.row[k]) || !std::isfinite(edge.row[k - 1])) continue;
        const bool hidden = edge.hidden[k] != 0;
        const auto c = static_cast<double>(k) + surface.part.x;
        draw_line(picture,
                  camera.project(grid.x(c - 1.0), grid.z(edge.row[k - 1])),
                  camera.project(grid.x(c), grid.z(edge.row[k])),
                  hidden ? cv::Scalar(160, 160, 160) : cv::Scalar(0, 255, 255));
      }
    }
    for (const datasets::Outline& outline : outlines_) {
      for (std::size_t k = 0; k < outline.column.size(); ++k) {
        const double z = outline.height[outline.index(frame, k)];
        if (!std::isfinite(z)) continue;
        const double half = 0.5 * width_;
        draw_line(picture,
                  camera.project(outline.column[k] - half, z),
                  camera.project(outline.column[k] + half, z),
                  cv::Scalar(0, 255, 0));
      }
    }
  }

  void describe(nlohmann::ordered_json& film) const override {
    nlohmann::ordered_json& json = film["outline"];
    std::size_t columns = 0;
    for (const datasets::Outline& outline : outlines_) columns += outline.column.size();
    json["columns"] = columns;
    json["column_width_mm"] = 1e3 * width_;
    json["share_of_columns_seen"] = seen_share_;
    json["sigma_mm"] = sigma_mm_;
    json["colours_confused"] = confusion_;
    json["pixel_noise_grey"] = noise_;
    json["eye_m"] = {{"x", lens_.position().x()},
                     {"z", lens_.position().y()},
                     {"distance", lens_.position().z()}};
    const Eigen::Vector3d sigma = eye_sigma();
    json["eye_sigma_m"] = {{"x", sigma.x()}, {"z", sigma.y()}, {"distance", sigma.z()}};
    if (lift_) {
      json["lift_speed_mm_per_s"] = 1e3 * lift_->speed;
      json["lift_speed_sigma_mm_per_s"] = 1e3 * lift_->speed_sigma;
    }
    if (turning_) {
      constexpr double rpm = 60.0 / (2.0 * std::numbers::pi);
      json["turning_rpm"] = rpm * turning_->rate;
      json["turning_sigma_rpm"] = rpm * turning_->sigma;
    }
  }

 private:
  struct Sample {
    int number = 0;
    cv::Mat plane;
  };
  // What is looked for in one part of the plane.
  struct Surface {
    datasets::SeenOutline::Surface seen;
    cv::Rect part;                    // cells; down below the floor
    std::vector<double> place_sigma;  // m, of columns
    std::vector<UpperEdge> edges;     // of the pictures; rows are those of the whole plane
    datasets::Outline outline;
  };

  // About where the surfaces lie that are looked at.
  double middle_z() const {
    return rig_.drum ? rig_.drum->centre.y() : rig_.floor_z + 0.25 * (rig_.to_x - rig_.from_x);
  }
  double middle_z(const Surface& surface) const {
    return rig_.drum ? middle_z()
                     : surface.seen.floor_z + 0.25 * (surface.seen.to_x - surface.seen.from_x);
  }

  EdgeOptions edge_options(const Surface& surface) const {
    return {.grain = grain_ / plane_.grid().cell(),
            .floor = static_cast<int>(std::floor(plane_.grid().row(surface.seen.floor_z))) -
                     surface.part.y,
            .noise = noise_};
  }

  GrainEvidence part_of(const Surface& surface, const GrainEvidence& evidence) const {
    return {.ratio = evidence.ratio(surface.part),
            .known = evidence.known(surface.part),
            .limit = evidence.limit};
  }

  UpperEdge edge_of(const Surface& surface,
                    const cv::Mat& plane,
                    const GrainEvidence& evidence) const {
    UpperEdge edge =
        find_upper_edge(plane(surface.part), part_of(surface, evidence), edge_options(surface));
    for (float& row : edge.row) row += static_cast<float>(surface.part.y);
    return edge;
  }

  // The parts of the plane, whose columns begin at `first` (m), in which surfaces are looked for.
  void set_up_surfaces(double first) {
    const PlaneGrid& grid = plane_.grid();
    for (const SeenOutline::Surface& seen : datasets::surfaces_of(rig_)) {
      Surface& surface = surfaces_.emplace_back();
      surface.seen = seen;
      surface.outline.surface = seen.name;
      surface.outline.column = datasets::outline_columns(seen, grain_);
      const std::vector<double>& columns = surface.outline.column;
      const auto before = static_cast<int>(std::lround((columns.front() - first) / width_));
      const int above = seen.top_z ? std::clamp(static_cast<int>(std::ceil(grid.row(*seen.top_z))),
                                                0,
                                                grid.size().height - 1)
                                   : 0;
      // What is one surface's floor is another one's sky
      const int below =
          seen.name.empty()
              ? grid.size().height
              : std::clamp(static_cast<int>(std::ceil(grid.row(seen.floor_z - 0.5 * grain_))),
                           above + 1,
                           grid.size().height);
      surface.part = cv::Rect(
          before * cells_, above, cells_ * static_cast<int>(columns.size()), below - above);
    }
  }

  // The grid: columns of half a grain, each a whole number of cells about as wide as a pixel, as
  // far up as the picture reaches.
  void set_up(const FilmCamera& camera) {
    lens_ = camera.calibration.camera;
    width_ = 0.5 * grain_;
    const double scale = lens_.scale(0.5 * (rig_.from_x + rig_.to_x), middle_z());  // px/m
    cells_ = std::max(1, static_cast<int>(std::ceil(width_ * scale)));
    constexpr double fewest_pixels = 4.0;
    if (grain_ * scale < fewest_pixels) coarse_ = grain_ * scale;
    const double cell = width_ / cells_;
    const std::vector<double> columns = datasets::outline_columns(rig_, grain_);
    if (columns.size() < 4)
      throw datasets::InputError(
          fmt::format("{}: the rig is not wider than two grains of {:.4g} mm, and has no outline",
                      film_.experiment.string(),
                      1e3 * grain_));
    const double left = columns.front() - 0.5 * width_ + 0.5 * cell;
    const int across = cells_ * static_cast<int>(columns.size());
    // Up to where the picture ends
    const double lowest = rig_.floor_z - 3.0 * grain_;
    const auto shows = [&](double z) {
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const Eigen::Vector2d at =
            lens_.project(rig_.from_x + share * (rig_.to_x - rig_.from_x), z);
        if (camera.region.contains(cv::Point(static_cast<int>(std::lround(at.x())),
                                             static_cast<int>(std::lround(at.y())))))
          return true;
      }
      return false;
    };
    const double most = lowest + 4.0 * (rig_.to_x - rig_.from_x);
    double top = rig_.floor_z;
    if (rig_.drum) {
      top = rig_.drum->centre.y() + rig_.drum->radius;
    } else {
      while (top < most && shows(top)) top += grain_;
    }
    const int down = static_cast<int>(std::ceil((top - lowest) / cell));
    const PlaneGrid grid(left, top, cell, cv::Size(across, down));
    cv::Mat1b masked;
    if (spec_.camera.masks)
      masked = masked_pixels(*spec_.camera.masks, {lens_.width(), lens_.height()});
    plane_ = PlanePicture(grid, lens_, camera.region, masked);
    set_up_surfaces(columns.front());
    domain_ = plane_.seen().clone();
    if (const auto& drum = rig_.drum) {
      cv::Mat1b inside(grid.size(), std::uint8_t{0});
      for (int row = 0; row < inside.rows; ++row)
        for (int column = 0; column < inside.cols; ++column)
          if (std::hypot(grid.x(column) - drum->centre.x(), grid.z(row) - drum->centre.y()) <
              drum->radius)
            inside(row, column) = 255;
      cv::bitwise_and(domain_, inside, domain_);
      turning_watcher_.emplace(*drum, lens_, camera.region);
    }
    if (rig_.mover && !rig_.mover->drawing.empty())
      lift_watcher_.emplace(with_thickness(*rig_.mover), grid, lens_.position());
  }

  // What is drawn as a line, a gate seen edge-on, is some part of a grain thick, across its way.
  SeenOutline::Mover with_thickness(SeenOutline::Mover mover) const {
    const Eigen::Index across = moves_sideways(mover) ? 1 : 0;
    double least = mover.drawing.front()[across], most = least;
    for (const Eigen::Vector2d& corner : mover.drawing) {
      least = std::min(least, corner[across]);
      most = std::max(most, corner[across]);
    }
    const double lacking = 0.5 * std::max(0.0, 0.5 * grain_ - (most - least));
    const SeenOutline::Polygon line = mover.drawing;
    if (lacking == 0.0) return mover;
    mover.drawing.clear();
    for (const Eigen::Vector2d& corner : line) {
      for (const double aside : {-lacking, lacking}) {
        mover.drawing.push_back(corner);
        mover.drawing.back()[across] += aside;
      }
    }
    return mover;
  }

  static bool moves_sideways(const SeenOutline::Mover& mover) {
    return std::abs(mover.velocity.x()) > std::abs(mover.velocity.y());
  }

  // Pictures at equal steps through the film; whoever knows how long a film is has read it.
  void keep(const cv::Mat& plane, int number) {
    if (number % stride_ != 0) return;
    samples_.push_back({number, plane});
    if (samples_.size() <= most_samples) return;
    stride_ *= 2;
    std::erase_if(samples_, [&](const Sample& sample) { return sample.number % stride_ != 0; });
  }

  double rise_at(double time) const { return lift_ ? lift_->height(time) : 0.0; }
  double sample_time(const Sample& sample) const {
    return times_[static_cast<std::size_t>(sample.number)];
  }
  bool is_before(double time) const {
    return lift_ && lift_->start_is_seen && time <= lift_->start;
  }

  cv::Mat1b inside(const std::vector<SeenOutline::Polygon>& polygons) const {
    cv::Mat1b mask(plane_.grid().size(), std::uint8_t{0});
    for (const SeenOutline::Polygon& polygon : polygons)
      cv::bitwise_or(mask, plane_.grid().inside(polygon), mask);
    cv::bitwise_and(mask, domain_, mask);
    return mask;
  }

  // What hides the grains behind it at this moment, with the cells that blur mixes with it.
  cv::Mat1b hiding_at(double time) const {
    cv::Mat1b mask(plane_.grid().size(), std::uint8_t{0});
    if (!lift_watcher_ || !lift_watcher_->is_seen()) return mask;
    mask = plane_.grid().inside(lift_watcher_->shadow(rise_at(time)));
    cv::dilate(mask, mask, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
    return mask;
  }

  void learn(TrackingSummary& summary) {
    if (last_.number != samples_.back().number) samples_.push_back(last_);
    if (lift_watcher_) {
      lift_ = lift_watcher_->lift();
      if (!lift_ && times_.size() > 1)
        summary.warn(fmt::format(
            "Nothing shows how the {} moves: neither when it began nor how fast it was is read "
            "from the film, and grains behind it may be lost.",
            rig_.mover->name));
    }
    if (turning_watcher_) turning_ = turning_watcher_->turning();
    const cv::Mat1b empty = inside(rig_.empty);
    noise_ = pixel_noise(last_.plane, cv::countNonZero(empty) > 100 ? empty : domain_);
    find_reference();
    learn_colours(summary);
    relearn_colours();
  }

  // Where grains may lie before the event, and some of them to the end: where they surely are, and
  // above that up to where none can be.
  cv::Mat1b may_be_filled_at_first() const {
    cv::Mat1b mask = inside(rig_.grains_before);
    if (!rig_.mover) return mask;
    const cv::Mat1b empty = inside(rig_.empty);
    for (int column = 0; column < mask.cols; ++column) {
      int row = 0;
      while (row < mask.rows && mask(row, column) == 0) ++row;
      if (row == mask.rows) continue;
      while (--row >= 0 && empty(row, column) == 0) mask(row, column) = domain_(row, column);
    }
    return mask;
  }

  // What is behind the grains, cell by cell: as it was before the event, or as it always is.
  void find_reference() {
    const cv::Size size = plane_.grid().size();
    cv::Mat sum(size, CV_32FC3, cv::Scalar::all(0)), sum_before = sum.clone();
    cv::Mat1f square(size, 0.0F);
    int before = 0;
    for (const Sample& sample : samples_) {
      cv::Mat exact;
      sample.plane.convertTo(exact, CV_32FC3);
      sum += exact;
      std::array<cv::Mat1f, 3> parts;
      cv::split(exact, parts.data());
      for (const cv::Mat1f& part : parts) square += part.mul(part);
      if (!is_before(sample_time(sample))) continue;
      sum_before += exact;
      ++before;
    }
    const auto count = static_cast<float>(samples_.size());
    reference_ = cv::Mat(size, CV_32FC3, cv::Scalar::all(0));
    has_reference_ = cv::Mat1b(size, std::uint8_t{0});
    const cv::Mat1b grains = may_be_filled_at_first();
    cv::Mat1b hiding = hiding_at(lift_ ? lift_->start : 0.0);
    // How much a colour of what surely never changes scatters in time, square of grey levels
    const cv::Mat1b empty = inside(rig_.empty);
    const auto variance_at = [&](int row, int column) {
      const cv::Vec3f mean = sum.at<cv::Vec3f>(row, column) * (1.0F / count);
      return std::max(0.0F, (square(row, column) / count - mean.dot(mean)) / 3.0F);
    };
    std::vector<float> still;
    for (int row = 0; row < size.height; ++row)
      for (int column = 0; column < size.width; ++column)
        if (empty(row, column) != 0 && hiding(row, column) == 0)
          still.push_back(variance_at(row, column));
    const auto usual =
        static_cast<float>(std::max(static_cast<double>(median(still)), noise_ * noise_));
    reference_variance_ = usual;
    // A variance from n pictures scatters by sqrt(2/(n - 1)); three of these and a factor for light
    const float never = usual * (1.0F + 3.0F * std::sqrt(2.0F / std::max(1.0F, count - 1.0F)));
    const bool motion_is_seen = (lift_ || turning_) && samples_.size() >= 8;
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        if (domain_(row, column) == 0 || grains(row, column) != 0) continue;
        if (before > 0 && hiding(row, column) == 0) {
          reference_.at<cv::Vec3f>(row, column) =
              sum_before.at<cv::Vec3f>(row, column) * (1.0F / static_cast<float>(before));
        } else if (motion_is_seen && variance_at(row, column) < never) {
          reference_.at<cv::Vec3f>(row, column) = sum.at<cv::Vec3f>(row, column) * (1.0F / count);
        } else {
          continue;
        }
        has_reference_(row, column) = 255;
      }
    }
  }

  // Before the bed moves, and once it is at rest or steady.
  bool shows_end(const Sample& sample) const {
    if (rig_.drum || samples_.size() == 1) return true;
    const double from = lift_ ? lift_->start : times_.front();
    return sample_time(sample) > from + 0.75 * (times_.back() - from);
  }

  void learn_colours(TrackingSummary& summary) {
    const cv::Mat1b before = inside(rig_.grains_before), after = inside(rig_.grains_after);
    const cv::Mat1b empty = inside(rig_.empty);
    std::vector<ColourModel::Colour> grains, ground;
    for (const Sample& sample : samples_) {
      const double time = sample_time(sample);
      cv::Mat1b visible;
      cv::bitwise_not(hiding_at(time), visible);
      cv::Mat1b mask;
      if (is_before(time)) {
        cv::bitwise_and(before, visible, mask);
        gather(sample.plane, mask, most_pixels, grains);
        cv::bitwise_and(has_reference_, visible, mask);
        gather(sample.plane, mask, most_pixels, ground);
      } else if (shows_end(sample)) {
        cv::bitwise_and(after, visible, mask);
        gather(sample.plane, mask, most_pixels, grains);
      }
      cv::bitwise_and(empty, visible, mask);
      gather(sample.plane, mask, most_pixels, ground);
    }
    if (grains.empty() || ground.empty())
      throw datasets::InputError(fmt::format(
          "{}: the film never shows a place where the rig says that {}; see whether the scale and "
          "the drawing of the rig fit the film",
          film_.video.string(),
          grains.empty() ? "grains surely are" : "no grains can be"));
    confusion_ = confusion(grains, ground, grain_colours, noise_);
    // Light on the same thing varies, and the pixels of an edge show some of both: colours are told
    // apart no finer than by a fiftieth of what parts grains from ground
    constexpr float finest = 0.02F;
    least_width_ =
        std::max(noise_, static_cast<double>(finest * (mean_of(grains) - mean_of(ground)).norm()));
    grain_model_ = ColourModel(grains, grain_colours, least_width_);
    ground_model_ = ColourModel(ground, ground_colours, least_width_);
    // One in ten pixels on the wrong side leaves the cut enough of a grain's own
    constexpr double much = 0.1;
    if (confusion_ > much)
      summary.warn(fmt::format(
          "Grains and what is behind them look alike: {:.0f} % of the pixels that surely show one "
          "of them could be the other. Put something of another colour behind the bed.",
          100.0 * confusion_));
  }

  // Once more from what was found, away from its edges: grains are lit otherwise at the top than
  // where they surely are.
  void relearn_colours() {
    std::vector<ColourModel::Colour> grains, ground;
    const int margin =
        std::max(1, static_cast<int>(std::lround(0.25 * grain_ / plane_.grid().cell())));
    for (const Sample& sample : samples_) {
      const double time = sample_time(sample);
      const GrainEvidence whole = evidence_in(sample.plane, time);
      for (const Surface& surface : surfaces_) {
        const EdgeOptions options = edge_options(surface);
        const GrainEvidence evidence = part_of(surface, whole);
        const std::vector<int> top = cut_along_columns(evidence, options);
        cv::Mat1b over(evidence.ratio.size(), std::uint8_t{0}), under = over.clone();
        for (int column = 0; column < over.cols; ++column) {
          const int cut = top[static_cast<std::size_t>(column)];
          for (int row = 0; row < over.rows; ++row) {
            if (evidence.known(row, column) == 0) continue;
            if (row < cut - margin && row < options.floor) over(row, column) = 255;
            if (row >= cut + margin && row < options.floor) under(row, column) = 255;
          }
        }
        // Cells beside a grain's side are above one column's cut and near another's
        cv::erode(over,
                  over,
                  cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * margin + 1, 2 * margin + 1}));
        cv::erode(under,
                  under,
                  cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * margin + 1, 2 * margin + 1}));
        gather(sample.plane(surface.part), under, most_pixels, grains);
        gather(sample.plane(surface.part), over, most_pixels, ground);
      }
    }
    if (grains.size() < most_pixels || ground.size() < most_pixels) return;
    const cv::Mat1b empty = inside(rig_.empty);
    gather(last_.plane, has_reference_, most_pixels, ground);
    gather(last_.plane, empty, most_pixels, ground);
    grain_model_ = ColourModel(grains, grain_colours, least_width_);
    ground_model_ = ColourModel(ground, ground_colours, least_width_);
  }

  GrainEvidence evidence_in(const cv::Mat& plane, double time) const {
    GrainEvidence evidence{.ratio = cv::Mat1f(plane.size(), 0.0F),
                           .known = cv::Mat1b(plane.size(), std::uint8_t{0}),
                           .limit = most_evidence};
    domain_.copyTo(evidence.known, hiding_at(time) == 0);
    // As it was, or now and then (one cell in ten) as light makes of the same thing
    const auto wide = static_cast<float>(
        std::max(least_width_ * least_width_, static_cast<double>(reference_variance_)));
    const float offset = -1.5F * std::log(reference_variance_);
    const float wide_offset = -1.5F * std::log(wide) - std::log(10.0F);
    for (int row = 0; row < plane.rows; ++row) {
      for (int column = 0; column < plane.cols; ++column) {
        if (evidence.known(row, column) == 0) continue;
        const auto& colour = plane.at<cv::Vec3b>(row, column);
        float ground = ground_model_.log_density(colour);
        if (has_reference_(row, column) != 0) {
          const cv::Vec3f off = cv::Vec3f(colour) - reference_.at<cv::Vec3f>(row, column);
          const float half = 0.5F * off.dot(off);
          ground =
              std::max({ground, offset - half / reference_variance_, wide_offset - half / wide});
        }
        evidence.ratio(row, column) =
            std::clamp(grain_model_.log_density(colour) - ground, -most_evidence, most_evidence);
      }
    }
    return evidence;
  }

  // What the calibration leaves open of each column's height, m.
  void find_place_errors() {
    for (Surface& surface : surfaces_)
      for (const double x : surface.outline.column)
        surface.place_sigma.push_back(
            std::sqrt(calibration_.point_covariance(x, middle_z(surface))(1, 1)));
  }

  // Means over columns of half a grain.
  void average(const UpperEdge& edge, Surface& surface) {
    datasets::Outline& outline = surface.outline;
    const double cell = plane_.grid().cell();
    for (std::size_t k = 0; k < outline.column.size(); ++k) {
      double sum = 0.0, square = 0.0, doubt = 0.0;
      int seen = 0, hidden = 0;
      for (int i = 0; i < cells_; ++i) {
        const auto c = k * static_cast<std::size_t>(cells_) + static_cast<std::size_t>(i);
        if (!std::isfinite(edge.row[c])) continue;
        if (edge.hidden[c] != 0) {
          ++hidden;
          continue;
        }
        sum += plane_.grid().z(edge.row[c]);
        square += edge.noise[c] * edge.noise[c];
        doubt += edge.doubt[c];
        ++seen;
      }
      const double needed = datasets::least_seen_share * cells_;
      if (seen < needed || hidden > cells_ - needed || seen == 0) {
        outline.height.push_back(nan);
        outline.sigma.push_back(nan);
        continue;
      }
      outline.height.push_back(sum / seen);
      // Lens, grid and compression leave it open where within a cell an edge lies, besides noise.
      // Some three neighbours err alike
      const double within_cell = seen / 12.0;
      const double noise = cell * std::sqrt(3.0 * (square + within_cell)) / seen;
      const double ways = cell * doubt / seen;
      outline.sigma.push_back(
          std::sqrt(noise * noise + ways * ways + surface.place_sigma[k] * surface.place_sigma[k]));
    }
  }

  void tell_event(TrackingSummary& summary) {
    std::optional<Event> seen;
    if (lift_) seen = {lift_->start, lift_->start_sigma, lift_->speed, lift_->scatter, "lift"};
    const Event event = start_of_a_film(seen, spec_.camera, summary);
    summary.event_time_s = event.time;
    summary.event_uncertainty_s = event.uncertainty;
    summary.event_source = event.how;
    if (lift_) {
      add_eye_to_speed();
      const SeenOutline::Mover& mover = *rig_.mover;
      tell_speed(summary,
                 moves_sideways(mover) ? "speed of the " + mover.name : "lift speed",
                 "mm/s",
                 1e3 * lift_->speed,
                 1e3 * lift_->speed_sigma,
                 mover.speed_is_stated ? 1e3 * mover.velocity.norm() : nan);
      tell_length(summary);
      if (!lift_->start_is_seen)
        summary.warn(
            "What is lifted off the bed or pulled from under it moves from the first frame on: "
            "when it began is worked out from its speed.");
      return;
    }
    if (rig_.drum && times_.size() > 1) {
      constexpr double rpm = 60.0 / (2.0 * std::numbers::pi);
      if (turning_) {
        tell_speed(summary,
                   "turning",
                   "rev/min",
                   rpm * turning_->rate,
                   rpm * turning_->sigma,
                   rig_.drum->turning != 0.0 ? rpm * rig_.drum->turning : nan);
      } else {
        summary.warn("Nothing is seen to go round with the drum: paint a line on its rim.");
      }
    }
  }

  // A slide lies in the plane of the scale and is as long as it is drawn, or the scale is off: by a
  // fiftieth is as much as speeds may differ. (The rims of a tube stand before the plane and mirror
  // what is round it, so that they tell no length.)
  void tell_length(TrackingSummary& summary) const {
    const SeenOutline::Mover& mover = *rig_.mover;
    if (!lift_->start_is_seen || !moves_sideways(mover)) return;
    const auto longer = lift_watcher_->longer_by(lift_->start);
    if (!longer) return;
    constexpr double surely = 3.0, plain = 0.02;
    const double length = lift_watcher_->length();
    if (std::abs(*longer) < surely * lift_->scatter || std::abs(*longer) < plain * length) return;
    summary.fail(
        fmt::format("The {} is {:.4g} mm long in the film, but {:.4g} mm in the rig: the scale is "
                    "off, or the rig is drawn wrongly.",
                    mover.name,
                    1e3 * (length + *longer),
                    1e3 * length));
  }

  static void tell_speed(TrackingSummary& summary,
                         const std::string& name,
                         const std::string& unit,
                         double seen,
                         double sigma,
                         double stated) {
    summary.findings.push_back(
        fmt::format("{} read from the film: {:.4g} +- {:.2g} {}", name, seen, sigma, unit));
    constexpr double plain = 3.0;
    if (std::isfinite(stated) && std::abs(seen - stated) > plain * sigma &&
        std::abs(seen / stated - 1.0) > 0.02)
      summary.fail(fmt::format("The film shows a {} of {:.4g} +- {:.2g} {}, but {:.4g} is stated.",
                               name,
                               seen,
                               sigma,
                               unit,
                               stated));
  }

  Eigen::Vector3d eye_sigma() const {
    Eigen::Matrix<double, 3, 10> derivative;
    for (int k = 0; k < 10; ++k) {
      Camera::Parameters forward = lens_.parameters(), backward = forward;
      const double delta = 1.0e-6;
      forward[k] += delta;
      backward[k] -= delta;
      const auto place = [&](const Camera::Parameters& p) {
        return Camera(lens_.width(), lens_.height(), p, lens_.principal_point()).position();
      };
      derivative.col(k) = (place(forward) - place(backward)) / (2.0 * delta);
    }
    return (derivative * calibration_.covariance * derivative.transpose())
        .diagonal()
        .cwiseMax(0.0)
        .cwiseSqrt();
  }

  // A tube's rim stands before the plane by a part of the eye's distance, which is not well known.
  void add_eye_to_speed() {
    const double share = 0.6 * rig_.mover->radius / lens_.position().z();
    const double relative = share * eye_sigma().z() / lens_.position().z();
    lift_->speed_sigma = std::hypot(lift_->speed_sigma, relative * lift_->speed);
  }

  void tell_quality(TrackingSummary& summary) {
    std::vector<double> sigmas;
    std::size_t all = 0;
    for (const datasets::Outline& outline : outlines_) {
      for (const double sigma : outline.sigma)
        if (std::isfinite(sigma)) sigmas.push_back(sigma);
      all += outline.sigma.size();
    }
    seen_share_ =
        static_cast<double>(sigmas.size()) / static_cast<double>(std::max<std::size_t>(1, all));
    sigma_mm_ = 1e3 * median(sigmas, nan);
    summary.shows_angle = false;
    summary.position_sigma_mm = sigma_mm_;
    if (coarse_ > 0.0)
      summary.warn(
          fmt::format("A grain is only {:.1f} pixels wide: the outline says nothing of "
                      "single grains.",
                      coarse_));
    if (sigmas.empty()) summary.fail("No free surface was found in any frame.");
  }

  datasets::TrackingSpec spec_;
  datasets::Film film_;
  SeenOutline rig_;
  double grain_ = 0.0;   // m, diameter
  double coarse_ = 0.0;  // px a grain, where these are few

  Camera lens_;
  Calibration calibration_;
  PlanePicture plane_;
  cv::Mat1b domain_;  // where grains can be seen
  std::vector<Surface> surfaces_;
  double width_ = 0.0;  // m, of a column
  int cells_ = 1;       // of a column

  // From the film as a whole
  std::vector<double> times_;  // s
  int stride_ = 1;
  std::vector<Sample> samples_;
  Sample last_;
  std::optional<LiftWatcher> lift_watcher_;
  std::optional<TurningWatcher> turning_watcher_;
  std::optional<Lift> lift_;
  std::optional<Turning> turning_;
  double noise_ = 1.0;        // grey levels
  double least_width_ = 1.0;  // grey levels, of a colour in the models
  cv::Mat reference_;         // what is behind the grains
  cv::Mat1b has_reference_;
  float reference_variance_ = 1.0F;
  ColourModel grain_model_, ground_model_;
  double confusion_ = 0.0;

  std::vector<double> seen_times_;
  std::vector<datasets::Outline> outlines_;  // when all is seen
  double seen_share_ = 0.0, sigma_mm_ = 0.0;
};

}  // namespace

std::unique_ptr<ParticleTracker> make_outline_tracker(const datasets::TrackingSpec& spec,
                                                      const datasets::Film& film) {
  if (!spec.rig.outline) return nullptr;
  return std::make_unique<OutlineTracker>(spec, film);
}

}  // namespace graintruth::tracking
