#include "datasets/experiment/tracking_spec.h"

#include "datasets/experiment/pictures.h"
#include "datasets/store/archive.h"
#include "datasets/store/fingerprint.h"

namespace graintruth::datasets {

template <class Archive>
void list_fields(Archive& archive, AxialSphere& sphere) {
  auto& [offset, radius] = sphere;
  archive("offset", offset)("radius", radius);
}

template <class Archive>
void list_fields(Archive& archive, SeenBody& body) {
  auto& [kind, balls, lengths, count] = body;
  archive("kind", kind)("balls", balls)("lengths", lengths)("count", count);
}

template <class Archive>
void list_fields(Archive& archive, Fiducial& fiducial) {
  auto& [x, z, diameter] = fiducial;
  archive("x", x)("z", z)("diameter", diameter);
}

template <class Archive>
void list_fields(Archive& archive, CameraPoint& point) {
  auto& [column, row, x, z] = point;
  archive("column", column)("row", row)("x", x)("z", z);
}

template <class Archive>
void list_fields(Archive& archive, StatedPicture& picture) {
  archive("hash", picture.hash);  // where it lies decides nothing
}

template <class Archive>
void list_fields(Archive& archive, Chessboard& board) {
  auto& [columns, rows, square, x, z, picture] = board;
  archive("columns", columns)("rows", rows)("square", square)("x", x)("z", z)("picture", picture);
}

template <class Archive>
void list_fields(Archive& archive, Stick& stick) {
  auto& [from, to, length, length_uncertainty, origin] = stick;
  archive("from", from)("to", to)("length", length)("length_uncertainty", length_uncertainty)(
      "origin", origin);
}

template <class Archive>
void list_fields(Archive& archive, CheckedLength& check) {
  auto& [from, to, length, length_uncertainty] = check;
  archive("from", from)("to", to)("length", length)("length_uncertainty", length_uncertainty);
}

template <class Archive>
void list_fields(Archive& archive, MaskPolygon& mask) {
  auto& [corners] = mask;
  archive("corners", corners);
}

template <class Archive>
void list_fields(Archive& archive, LensBoard& lens) {
  auto& [columns, rows, pictures] = lens;
  archive("columns", columns)("rows", rows)("pictures", pictures);
}

template <class Archive>
void list_fields(Archive& archive, Camera& camera) {
  auto& [frame_rate,
         pixel_aspect,
         fiducials,
         points,
         chessboard,
         stick,
         click_error,
         lens,
         region,
         noted_event_time,
         checks,
         masks] = camera;
  archive("frame_rate", frame_rate)("pixel_aspect", pixel_aspect)("fiducials", fiducials)(
      "points", points)("chessboard", chessboard)("stick", stick)("click_error", click_error)(
      "lens", lens)("region", region)("noted_event_time", noted_event_time)("checks", checks)(
      "masks", masks);
}

template <class Archive>
void list_fields(Archive& archive, StartPlace& start) {
  auto& [x, z, angle] = start;
  archive("x", x)("z", z)("angle", angle);
}

template <class Archive>
void list_fields(Archive& archive, Wall& wall) {
  auto& [name, from_x, from_z, to_x, to_z] = wall;  // what it is called decides nothing
  archive("from_x", from_x)("from_z", from_z)("to_x", to_x)("to_z", to_z);
}

template <class Archive>
void list_fields(Archive& archive, MovingFace& face) {
  auto& [face_z, left_x, right_x, velocity_z] = face;
  archive("z", face_z)("left_x", left_x)("right_x", right_x)("velocity_z", velocity_z);
}

template <class Archive>
void list_fields(Archive& archive, OpenBox& box) {
  auto& [width, height, opening] = box;
  archive("width", width)("height", height)("opening", opening);
}

template <class Archive>
void list_fields(Archive& archive, SeenOutline::Mover& mover) {
  auto& [name, drawing, velocity, speed_is_stated, radius] = mover;  // its name decides nothing
  archive("drawing", drawing)("velocity", velocity)("speed_is_stated", speed_is_stated)("radius",
                                                                                        radius);
}

template <class Archive>
void list_fields(Archive& archive, SeenOutline::Drum& drum) {
  auto& [centre, radius, turning] = drum;
  archive("centre", centre)("radius", radius)("turning", turning);
}

template <class Archive>
void list_fields(Archive& archive, SeenOutline::Surface& surface) {
  auto& [name, from_x, to_x, floor_z, top_z] = surface;
  archive("name", name)("from_x", from_x)("to_x", to_x)("floor_z", floor_z)("top_z", top_z);
}

template <class Archive>
void list_fields(Archive& archive, SeenOutline& outline) {
  auto& [from_x, to_x, floor_z, grains_before, grains_after, empty, mover, drum, surfaces] =
      outline;
  archive("from_x", from_x)("to_x", to_x)("floor_z", floor_z)("grains_before", grains_before)(
      "grains_after", grains_after)("empty", empty)("mover", mover)("drum", drum);
  list_if_any(archive, "surfaces", surfaces);
}

template <class Archive>
void list_fields(Archive& archive, SeenRig& rig) {
  auto& [walls, face, box, pane_gap, gravity, outline] = rig;
  archive("walls", walls)("face", face)("box", box)("pane_gap", pane_gap)("gravity", gravity)(
      "outline", outline);
}

template <class Archive>
void list_fields(Archive& archive, TrackingSpec& spec) {
  auto& [tracker, film_hash, corrections_hash, body, camera, starts, rig] = spec;
  archive("tracker", tracker)("film_hash", film_hash)("corrections_hash", corrections_hash)(
      "body", body)("camera", camera)("starts", starts)("rig", rig);
}

namespace {

SeenBody seen_body(const Particle& particle) {
  SeenBody body{.kind = "balls", .balls = particle.spheres};
  if (particle.count > 0) body.count = particle.count;
  if (particle.body) {
    body.kind = particle.body->kind;
    body.balls.clear();
    body.lengths = particle.body->lengths;
  }
  return body;
}

SeenRig seen_rig(const Rig& rig) {
  SeenRig seen{.walls = rig.walls,
               .face = rig.moving_face,
               .pane_gap = rig.front_back_gap,
               .gravity = rig.gravity,
               .outline = rig.seen_outline};
  if (const auto& bed = rig.bed)
    seen.box = {bed->width(), bed->height, rig.opening ? rig.opening->width() : 0.0};
  return seen;
}

}  // namespace

Film film_of(const Experiment& experiment, const Replicate& replicate) {
  return {replicate.name, replicate.video, replicate.corrections, experiment.file};
}

TrackingSpec make_tracking_spec(const Experiment& experiment, const Replicate& replicate) {
  const Experiment filmed = as_filmed(experiment, replicate);
  return {.film_hash = film_hash(replicate.video),
          .corrections_hash = replicate.corrections.empty() ? "" : file_hash(replicate.corrections),
          .body = seen_body(filmed.particle),
          .camera = filmed.camera,
          .starts = filmed.starts,
          .rig = seen_rig(filmed.rig)};
}

std::string fingerprint(const TrackingSpec& spec) { return content_hash(json_text(spec)); }

std::string json_text(const Camera& camera) { return to_json(camera).dump(); }

std::string json_text(const TrackingSpec& spec) { return to_json(spec).dump(); }

TrackingSpec read_tracking_spec(const std::string& json) {
  return from_json<TrackingSpec>(Json::parse(json));
}

}  // namespace graintruth::datasets
