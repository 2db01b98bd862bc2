#include "tracking/balls/whole_clip.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr double normal_quartile = 0.6745;

// What is unknown of the film, in this order: how paint seems to move with its place (a share), and
// where it seems to lie in all of the picture (m; x, z); the mean radius and separation (m).
//   Paint lies nearer to the camera than the balls' centres: if the camera stands elsewhere than
//   the plane of the dots can tell, all paint is seen beside its place.
constexpr int film_unknowns = 5;
// And of a body: along, across (m) and turn (rad) from its paint to its balls; radii, separation
// (m)
constexpr int body_unknowns = 6;
constexpr int row_size = film_unknowns + body_unknowns;
using Row = Eigen::Matrix<double, row_size, 1>;

// Of one body: where its paint lay, and what is known by now of where its balls lie in it.
struct Body {
  std::vector<PaintShift> shifts;  // one a frame
  std::vector<BodyPose> paint;     // one a frame, where a shift was found
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  BodyShape shape;
  double wander = 0.0;      // m, of one ball's paint, per axis, from what changes their distance
  std::vector<int> places;  // one a kept picture: the same while the body hardly moves
};

struct Film {
  double growth = 0.0;                              // share
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  // m
  double radius = 0.0, separation = 0.0;            // m, means
};

BodyPose pose_of(const Film& film, const Body& body, std::size_t frame) {
  BodyPose pose = moved(body.paint[frame], body.offset);
  pose.x += film.growth * pose.x + film.shift.x();
  pose.z += film.growth * pose.z + film.shift.y();
  return pose;
}

// How a pose changes with the film's unknowns and those of its body.
Eigen::Matrix<double, 3, row_size> derivative_of(const BodyPose& pose) {
  Eigen::Matrix<double, 3, row_size> derivative = Eigen::Matrix<double, 3, row_size>::Zero();
  derivative.col(0) << pose.x, pose.z, 0.0;
  derivative(0, 1) = derivative(1, 2) = 1.0;
  const double cosine = std::cos(pose.angle), sine = std::sin(pose.angle);
  derivative.block<3, 3>(0, film_unknowns) << cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0;
  return derivative;
}

// One ray of one picture.
struct Sighting {
  std::size_t group = 0;
  double miss = 0.0, variance = 0.0;  // px, px^2
  Row row = Row::Zero();              // px by the unknowns
};

// Rays that err alike, for what makes them err stays: one ball, seen from one side, while the body
// hardly moves.
struct Group {
  std::size_t body = 0;
  int side = 0;  // ball and direction: errors of light and shade last through the clip
  // Of its rays
  double miss = 0.0, variance = 0.0;
  double faintness = 0.0;  // px^2: what noise makes of one ray
  Row row = Row::Zero();
  bool seen = false;
};

constexpr int sides_per_ball = 12;
constexpr std::size_t fewest_rays = 3;  // of a group

// Mean of the rays of every group, outliers left out: `scatter` px is what a ray is off its group.
void average(std::vector<Group>& groups,
             const std::vector<Sighting>& rays,
             const std::vector<double>& scatters) {
  std::vector<std::vector<const Sighting*>> of(groups.size());
  for (const Sighting& ray : rays) of[ray.group].push_back(&ray);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    Group& group = groups[g];
    group.seen = of[g].size() >= fewest_rays;
    if (!group.seen) continue;
    const double scatter = scatters[group.body];
    std::vector<double> misses;
    for (const Sighting* ray : of[g]) misses.push_back(ray->miss);
    double middle = median(misses);
    double weights = 0.0, square = 0.0, faintness = 0.0;
    Row row = Row::Zero();
    for (int round = 0; round < 5; ++round) {
      double sum = 0.0;
      weights = square = faintness = 0.0;
      row.setZero();
      for (const Sighting* ray : of[g]) {
        const double variance = scatter * scatter + ray->variance;
        const double off = (ray->miss - middle) * (ray->miss - middle) / variance;
        const double weight = 1.0 / (variance * std::pow(1.0 + off / 6.0, 2));
        sum += weight * ray->miss;
        row += weight * ray->row;
        weights += weight;
        faintness += weight * ray->variance;
        square += weight * (ray->miss - middle) * (ray->miss - middle);
      }
      middle = sum / weights;
    }
    group.miss = middle;
    group.row = row / weights;
    group.faintness = faintness / weights;
    // Pictures of a body that rests show the same errors again: no more is gained than by one side
    // seen a few times over
    constexpr double most_rays = 12.0;
    const double count = std::min(most_rays, static_cast<double>(of[g].size()));
    group.variance = std::max(square / weights, 1.0 / weights) / count;
  }
}

// Where the unknown number i of a row of body b stands among all of them.
Eigen::Index index_of(std::size_t body, int i) {
  return i < film_unknowns
             ? static_cast<Eigen::Index>(i)
             : static_cast<Eigen::Index>(film_unknowns + body_unknowns * body) + i - film_unknowns;
}

// How alike real particles of one kind are, relative.
constexpr double radius_likeness = 0.007;     // balls of one size differ by less than a hundredth
constexpr double separation_likeness = 0.03;  // glue and drill are less exact
constexpr double size_tolerance = 0.03;       // of the stated sizes and the look of their edges

struct Unknowns {
  Eigen::VectorXd change;
  Eigen::MatrixXd covariance;
  std::vector<BodyCheck> checks;  // without what the paint says
};

// Sums of least squares, to which what is known beforehand and what was seen is added.
struct Equations {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;

  explicit Equations(Eigen::Index size)
      : normal(Eigen::MatrixXd::Zero(size, size)), right(Eigen::VectorXd::Zero(size)) {}

  void expect(Eigen::Index i, double value, double sigma) {
    normal(i, i) += 1.0 / (sigma * sigma);
    right[i] += value / (sigma * sigma);
  }
  // One that is like another, but for `difference`.
  void liken(Eigen::Index one, Eigen::Index other, double difference, double sigma) {
    const double weight = 1.0 / (sigma * sigma);
    normal(one, one) += weight;
    normal(other, other) += weight;
    normal(one, other) -= weight;
    normal(other, one) -= weight;
    right[one] += weight * difference;
    right[other] -= weight * difference;
  }
};

// What is known before any limb is looked at.
Equations known_beforehand(const FilmView& view,
                           const Film& film,
                           const std::vector<Body>& bodies) {
  Equations equations(static_cast<Eigen::Index>(film_unknowns + body_unknowns * bodies.size()));
  // The camera's distance and foot are known to a fifth of the distance or so
  constexpr double camera_doubt = 0.2;
  const double nearer = film.radius / view.lens().position().z();
  equations.expect(0, -film.growth, camera_doubt * nearer);
  equations.expect(1, -film.shift.x(), camera_doubt * film.radius);
  equations.expect(2, -film.shift.y(), camera_doubt * film.radius);
  const double radius = 0.5 * (view.nominal.radius[0] + view.nominal.radius[1]);
  equations.expect(3, radius - film.radius, 2.0 * size_tolerance * radius);
  equations.expect(
      4, view.nominal.separation - film.separation, 2.0 * size_tolerance * film.separation);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const BodyShape& shape = bodies[b].shape;
    for (std::size_t ball = 0; ball < 2; ++ball) {
      const double stated = view.nominal.radius[ball] - radius;
      equations.liken(index_of(b, film_unknowns + 3 + static_cast<int>(ball)),
                      3,
                      film.radius + stated - shape.radius[ball],
                      radius_likeness * film.radius);
    }
    equations.liken(index_of(b, film_unknowns + 5),
                    4,
                    film.separation - shape.separation,
                    separation_likeness * film.separation);
    // Nothing else may tell of a body whose limb was never seen
    for (int i = 0; i < 3; ++i)
      equations.expect(index_of(b, film_unknowns + i), 0.0, i < 2 ? film.radius : 1.0);
  }
  return equations;
}

// Errors that no ray's noise explains. A side that sees a shadow's edge or a faint limb errs in all
// frames alike, the more the fainter its limb is: its error's variance is `lasting` of its body and
// `share` times what noise makes of a ray there. The same share passes with the place.
struct Doubts {
  double share = 4.0;
  std::vector<double> lasting;                            // px^2, one a body
  std::map<std::pair<std::size_t, int>, double> outlier;  // by body and side: errs more than most
};

Unknowns fit_limb(const FilmView& view,
                  const Film& film,
                  const std::vector<Body>& bodies,
                  const std::vector<Group>& groups,
                  Doubts& doubts) {
  using Side = std::pair<std::size_t, int>;  // body and side
  std::map<Side, std::vector<const Group*>> sides;
  std::map<Side, double> faintness;  // mean over its places
  for (const Group& group : groups)
    if (group.seen) sides[{group.body, group.side}].push_back(&group);
  for (const auto& [side, list] : sides) {
    for (const Group* group : list)
      faintness[side] += group->faintness / static_cast<double>(list.size());
    doubts.outlier.try_emplace(side, 1.0);
  }
  const auto weight_of = [&](const Group& group) {
    return 1.0 / (group.variance + doubts.lasting[group.body] + doubts.share * group.faintness);
  };
  Unknowns result;
  constexpr int rounds = 8;
  for (int round = 0; round < rounds; ++round) {
    Equations equations = known_beforehand(view, film, bodies);
    for (const auto& [side, list] : sides) {
      // All places of a side share an error (Woodbury)
      const double own =
          doubts.outlier[side] * doubts.lasting[side.first] + doubts.share * faintness[side];
      double total = 0.0, misses = 0.0;
      Row rows = Row::Zero();
      for (const Group* group : list) {
        const double weight = weight_of(*group);
        total += weight;
        misses += weight * group->miss;
        rows += weight * group->row;
      }
      const double shared = own / (1.0 + own * total);
      Eigen::Matrix<double, row_size, row_size> block = -shared * rows * rows.transpose();
      Row right = -shared * misses * rows;
      for (const Group* group : list) {
        const double weight = weight_of(*group);
        block += weight * group->row * group->row.transpose();
        right += weight * group->miss * group->row;
      }
      for (int i = 0; i < row_size; ++i) {
        equations.right[index_of(side.first, i)] += right[i];
        for (int j = 0; j < row_size; ++j)
          equations.normal(index_of(side.first, i), index_of(side.first, j)) += block(i, j);
      }
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(equations.normal);
    result.change = factor.solve(equations.right);
    result.covariance =
        factor.solve(Eigen::MatrixXd::Identity(equations.normal.rows(), equations.normal.cols()));
    // What is left on each side, and how much that is
    std::map<Side, double> means;
    std::vector<double> sums(bodies.size(), 0.0), counts(bodies.size(), 0.0);
    double relative = 0.0;
    for (const auto& [side, list] : sides) {
      double total = 0.0, mean = 0.0;
      for (const Group* group : list) {
        double left = group->miss;
        for (int i = 0; i < row_size; ++i)
          left -= group->row[i] * result.change[index_of(side.first, i)];
        total += weight_of(*group);
        mean += weight_of(*group) * left;
      }
      mean /= total;
      means[side] = mean;
      sums[side.first] += mean * mean - 1.0 / total;
      counts[side.first] += 1.0;
      constexpr double most = 50.0;  // no single side decides
      relative += std::min(most, mean * mean / std::max(faintness[side], 1.0e-6)) /
                  static_cast<double>(sides.size());
    }
    // Neighbouring sides err alike, so that most of what they do looks like another place of the
    // body and is fitted away: errors are larger than what is left. How much larger was seen on
    // films of known truth.
    constexpr double hidden = 3.5;
    doubts.share = hidden * relative;
    double sum = 0.0, count = 0.0;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      counts[b] = std::max(0.0, counts[b] - body_unknowns);
      sum += sums[b];
      count += counts[b];
    }
    result.checks.assign(bodies.size(), {});
    for (const auto& [side, mean] : means) {
      BodyCheck& check = result.checks[side.first];
      check.outline_left += mean * mean;
      check.outline_usual += relative * faintness[side];
      ++check.sides;
    }
    for (BodyCheck& check : result.checks) {
      if (check.sides == 0) continue;
      check.outline_left = std::sqrt(check.outline_left / check.sides);
      check.outline_usual = std::sqrt(check.outline_usual / check.sides);
    }
    constexpr double least = 1.0e-4;  // px^2
    const double usual = std::max(least, sum / std::max(1.0, count));
    // A body of few sides is believed to err as the others do
    constexpr double usual_sides = 6.0;
    for (std::size_t b = 0; b < bodies.size(); ++b)
      doubts.lasting[b] =
          std::max(least, (usual_sides * usual + sums[b]) / (usual_sides + counts[b]));
    // Student's t with four degrees of freedom
    constexpr double freedom = 4.0;
    for (const auto& [side, mean] : means)
      doubts.outlier[side] =
          std::max(1.0, (freedom - 1.0 + mean * mean / doubts.lasting[side.first]) / freedom);
  }
  return result;
}

// Rays of all kept pictures, looked at from where the bodies are thought to lie.
struct Looks {
  std::vector<Sighting> rays;
  std::vector<Group> groups;
};

Looks look_again(const FilmView& view,
                 const std::vector<BodyTrack>& tracks,
                 const std::vector<KeptPicture>& pictures,
                 const Film& film,
                 const std::vector<Body>& bodies,
                 double reach) {
  Looks looks;
  std::map<std::array<int, 3>, std::size_t> group_of;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const EdgeImage image(pictures[i].part, pictures[i].corner, 0.8);
    const auto k = static_cast<std::size_t>(pictures[i].number);
    std::vector<std::optional<BodyPose>> poses(bodies.size());
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (bodies[b].shifts[k].found)
        poses[b] = pose_of(film, bodies[b], k);
      else if (tracks[b].fits[k])
        poses[b] = tracks[b].fits[k]->pose;
    }
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Body& body = bodies[b];
      if (!body.shifts[k].found) continue;
      Surroundings around;
      around.walls = pictures[i].walls;
      for (std::size_t other = 0; other < bodies.size(); ++other)
        if (other != b && poses[other]) around.add(*poses[other], bodies[other].shape);
      const BodyPose& pose = *poses[b];
      const std::array<double, 2> share = {-body.shape.first_share, 1.0 - body.shape.first_share};
      const Eigen::Vector2d axis(std::cos(pose.angle), std::sin(pose.angle));
      const Eigen::Vector2d across(-axis.y(), axis.x());
      const auto motion = derivative_of(pose);
      for (const SeenRay& seen : measure_limb(
               image, view.lens(), body.shape, pose, around, *view.limb, reach, view.edge_noise)) {
        const auto ball = static_cast<std::size_t>(seen.ball);
        const int side =
            seen.ball * sides_per_ball + seen.direction * sides_per_ball / rays_per_ball;
        const auto [at, is_new] =
            group_of.try_emplace({static_cast<int>(b), side, body.places[i]}, looks.groups.size());
        if (is_new) looks.groups.push_back({b, side});
        Sighting& ray = looks.rays.emplace_back();
        ray.group = at->second;
        ray.miss = seen.displacement;
        ray.variance = seen.variance;
        const Eigen::Vector2d by_centre = seen.derivative.head<2>();
        Eigen::Vector3d by_pose;
        by_pose << by_centre, by_centre.dot(across) * share[ball] * body.shape.separation;
        ray.row = motion.transpose() * by_pose;
        ray.row[film_unknowns + 3 + seen.ball] = seen.derivative[2];
        ray.row[film_unknowns + 5] = by_centre.dot(axis) * share[ball];
      }
    }
  }
  return looks;
}

// Of every body: how much a ray is off its group, px.
std::vector<double> scatters_of(const Looks& looks, std::size_t bodies) {
  std::vector<std::vector<double>> misses(looks.groups.size()), off(bodies);
  for (const Sighting& ray : looks.rays) misses[ray.group].push_back(ray.miss);
  std::vector<double> middles;
  for (const auto& list : misses) middles.push_back(median(list));
  for (const Sighting& ray : looks.rays)
    if (misses[ray.group].size() >= fewest_rays)
      off[looks.groups[ray.group].body].push_back(std::abs(ray.miss - middles[ray.group]));
  std::vector<double> scatters;
  constexpr double least = 0.02;  // px
  for (auto& list : off) scatters.push_back(std::max(least, median(list) / normal_quartile));
  return scatters;
}

std::vector<Body> follow_paint(const FilmView& view,
                               const std::vector<BodyTrack>& tracks,
                               const std::array<TextureGrid, 2>& grids,
                               const std::vector<KeptPicture>& pictures) {
  std::vector<Body> bodies(tracks.size());
  for (std::size_t b = 0; b < tracks.size(); ++b) {
    Body& body = bodies[b];
    body.shape = view.shape;
    const std::size_t frames = tracks[b].fits.size();
    std::vector<std::array<TexturePatch, 2>> patches(frames);
    for (std::size_t ball = 0; ball < 2; ++ball)
      for (std::size_t k = 0; k < std::min(frames, tracks[b].textures[ball].size()); ++k)
        if (tracks[b].fits[k]) patches[k][ball] = tracks[b].textures[ball][k];
    body.shifts = compare_paint(patches, view.shape, grids);
    body.paint.resize(frames);
    std::vector<double> stretches;
    for (std::size_t k = 0; k < frames; ++k) {
      if (!body.shifts[k].found) continue;
      body.paint[k] = moved(tracks[b].fits[k]->pose, body.shifts[k].change);
      stretches.push_back(body.shifts[k].stretch);
    }
    const double middle = median(stretches);
    for (double& stretch : stretches) stretch = std::abs(stretch - middle);
    body.wander = median(stretches) / normal_quartile / std::numbers::sqrt2;
    // A new place when it moved by a third of its radius, or turned by as much
    body.places.assign(pictures.size(), -1);
    std::optional<BodyPose> last;
    int place = -1;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const auto k = static_cast<std::size_t>(pictures[i].number);
      if (!body.shifts[k].found) continue;
      const BodyPose& pose = body.paint[k];
      constexpr double share = 1.0 / 3.0;
      if (!last || std::hypot(pose.x - last->x, pose.z - last->z) > share * view.shape.radius[0] ||
          std::abs(pose.angle - last->angle) > share) {
        last = pose;
        ++place;
      }
      body.places[i] = place;
    }
  }
  return bodies;
}

// In one frame: what is unknown of the body's place in its paint, and how the paint wanders.
Eigen::Matrix3d covariance_of(const Body& body,
                              std::size_t b,
                              const BodyPose& pose,
                              const PaintShift& shift,
                              const Eigen::MatrixXd& all) {
  Eigen::Matrix<double, row_size, row_size> own;
  for (int i = 0; i < row_size; ++i)
    for (int j = 0; j < row_size; ++j) own(i, j) = all(index_of(b, i), index_of(b, j));
  const auto derivative = derivative_of(pose);
  // Each ball's paint wanders by itself; a scatter includes the noise
  const double wander = body.wander * body.wander, separation = body.shape.separation;
  Eigen::Matrix3d passing =
      Eigen::Vector3d(0.5 * wander, 0.5 * wander, 2.0 * wander / (separation * separation))
          .asDiagonal();
  passing += shift.information.inverse();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(pose.angle).toRotationMatrix();
  return derivative * own * derivative.transpose() + axes * passing * axes.transpose();
}

}  // namespace

Clip solve_clip(const FilmView& view,
                const std::vector<BodyTrack>& tracks,
                const std::array<TextureGrid, 2>& grids,
                const std::vector<KeptPicture>& pictures) {
  // 1. How every body moved
  std::vector<Body> bodies = follow_paint(view, tracks, grids, pictures);
  Film film{0.0,
            Eigen::Vector2d::Zero(),
            0.5 * (view.shape.radius[0] + view.shape.radius[1]),
            view.shape.separation};
  // 2. Where its balls lie in its paint: looked at, moved there, and looked at again
  Unknowns unknowns;
  Doubts doubts;
  doubts.lasting.assign(bodies.size(), 0.01);
  constexpr std::array<double, 6> reaches = {2.75, 2.75, 2.0, 2.0, 1.5, 1.5};  // px
  for (const double reach : reaches) {
    Looks looks = look_again(view, tracks, pictures, film, bodies, reach);
    average(looks.groups, looks.rays, scatters_of(looks, bodies.size()));
    unknowns = fit_limb(view, film, bodies, looks.groups, doubts);
    const Eigen::VectorXd& change = unknowns.change;
    film.growth += change[0];
    film.shift += change.segment<2>(1);
    film.radius += change[3];
    film.separation += change[4];
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Eigen::Index at = index_of(b, film_unknowns);
      bodies[b].offset += change.segment<3>(at);
      for (int ball = 0; ball < 2; ++ball)
        bodies[b].shape.radius[static_cast<std::size_t>(ball)] += change[at + 3 + ball];
      bodies[b].shape.separation += change[at + 5];
    }
  }
  // 3. Poses
  Clip clip;
  clip.poses.resize(bodies.size());
  clip.checks = unknowns.checks;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const BodyPose& any = tracks[b].last;
    clip.checks[b].paint_wander = bodies[b].wander * view.lens().scale(any.x, any.z);
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    for (std::size_t k = 0; k < body.paint.size(); ++k) {
      ClipPose& pose = clip.poses[b].emplace_back();
      if (!body.shifts[k].found) continue;
      pose.found = true;
      pose.pose = pose_of(film, body, k);
      pose.covariance = covariance_of(body, b, pose.pose, body.shifts[k], unknowns.covariance);
    }
  }
  // 4. Sizes, and by how much particles differ beyond the errors of theirs
  Learned& learned = clip.learned;
  learned.radius_mean = film.radius;
  learned.separation_mean = film.separation;
  double radii = 0.0, separations = 0.0;
  const auto variance = [&](Eigen::Index i, Eigen::Index j) { return unknowns.covariance(i, j); };
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const BodyShape& shape = bodies[b].shape;
    const Eigen::Index at = index_of(b, film_unknowns) + 3;
    for (int ball = 0; ball < 2; ++ball)
      radii += 0.5 * (std::pow(shape.radius[static_cast<std::size_t>(ball)] - film.radius, 2) -
                      variance(at + ball, at + ball));
    const double stated = view.nominal.radius[1] - view.nominal.radius[0];
    const double difference_variance =
        variance(at, at) + variance(at + 1, at + 1) - 2.0 * variance(at, at + 1);
    learned.bodies.push_back(
        {.shape = shape,
         .radius_difference = std::hypot(shape.radius[1] - shape.radius[0] - stated,
                                         std::sqrt(difference_variance))});
    separations += std::pow(shape.separation - film.separation, 2) - variance(at + 2, at + 2);
  }
  const auto root = [&](double sum) {
    return std::sqrt(std::max(0.0, sum) / static_cast<double>(bodies.size()));
  };
  learned.radius_spread = root(radii);
  learned.separation_spread = root(separations);
  return clip;
}

}  // namespace graintruth::tracking
