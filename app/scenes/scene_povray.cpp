#include "app/scenes/scene_povray.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "app/scenes/scene_look.h"
#include "app/scenes/wall_patches.h"

namespace graintruth::app {

namespace {

using sim::Vec3;

// POV-Ray's axes are left-handed: x right, y up, z away.
std::string text_of(const Vec3& v) { return fmt::format("<{}, {}, {}>", v.x(), v.z(), v.y()); }

// A film's shape, 1280 x 800, seen under 36 degrees from left to right.
constexpr double aspect = 1.6, half_angle_deg = 18.0;

// Far enough that a sphere around the box fills the height of the picture.
std::string camera(const sim::Box& box, const Vec3& away) {
  const Vec3 middle = 0.5 * (box.low + box.high);
  const double half_angle = half_angle_deg * EIGEN_PI / 180.0;
  const double half_height = std::atan(std::tan(half_angle) / aspect);
  const double distance = 0.5 * (box.high - box.low).norm() / std::sin(half_height);
  return fmt::format(
      "camera {{\n  perspective\n  location {}\n  right {}*x\n  angle {}\n  look_at {}\n}}\n"
      "light_source {{ {} rgb 1 area_light {}*x, {}*y, 4, 4 adaptive 1 }}\n"
      "light_source {{ {} rgb 0.35 shadowless }}\n",
      text_of(middle - distance * away),
      aspect,
      2.0 * half_angle_deg,
      text_of(middle),
      text_of(middle + distance * Vec3(-0.7, -0.7, 0.9)),
      0.1 * distance,
      0.1 * distance,
      text_of(middle + distance * Vec3(0.8, -1.0, 0.3)));
}

std::string scene_inc(const sim::Box& box, bool is_planar) {
  const double elevation = 0.1;  // rad; a layer, so that floor and walls show their depth
  const Vec3 away =
      is_planar ? Vec3(0.0, std::cos(elevation), -std::sin(elevation)) : spatial_sight().away;
  std::string text =
      "// Lengths in metres. Axes: x right, y up, z away from the camera.\n"
      "global_settings { assumed_gamma 1 }\n"
      "background { srgb <0.965, 0.973, 0.98> }\n";
  text += camera(box, away);
  text +=
      "#declare grain_finish = finish { ambient 0.12 diffuse 0.75 specular 0.25 roughness 0.03 }\n"
      "#declare wall_texture = texture {\n"
      "  pigment { srgbt <0.55, 0.62, 0.7, 0.72> } finish { ambient 0.2 diffuse 0.5 } }\n";
  for (std::size_t colour = 0; colour < palette.size(); ++colour) {
    const auto& [red, green, blue] = palette[colour];
    fmt::format_to(std::back_inserter(text),
                   "#declare grain_{} = texture {{\n"
                   "  pigment {{ srgb <{}, {}, {}>/255 }} finish {{ grain_finish }} }}\n",
                   colour,
                   red,
                   green,
                   blue);
  }
  return text;
}

void add_bodies(const calibrate::SceneRun& run,
                const sim::State& state,
                const std::vector<std::size_t>& colours,
                std::string& text) {
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    for (const sim::ElementSphere& sphere : run.scene.types[run.scene.bodies[i].type].spheres) {
      const Vec3 centre = state.position[i] + state.orientation[i] * sphere.centre;
      fmt::format_to(std::back_inserter(text),
                     "sphere {{ {}, {} texture {{ grain_{} }} }}\n",
                     text_of(centre),
                     sphere.radius,
                     colours[i]);
    }
  }
}

// A polygon ends where it began.
void add_patch(const Patch& patch, std::string& text) {
  fmt::format_to(std::back_inserter(text), "polygon {{ {}", patch.size() + 1);
  for (const Vec3& corner : patch) text += ", " + text_of(corner);
  text += ", " + text_of(patch.front()) + " texture { wall_texture } no_shadow }\n";
}

}  // namespace

void write_povray(const datasets::RunFolder& folder,
                  const datasets::SceneFile& file,
                  const calibrate::SceneRun& run) {
  if (run.frames.empty()) return;
  const std::filesystem::path root = folder.root / "povray";
  datasets::make_folder(root);
  const sim::Box box = scene_box(run);
  const std::vector<std::size_t> colours = body_colours(run);
  datasets::write_whole(root / "scene.inc", scene_inc(box, file.is_planar));
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    const sim::State& state = run.frames[f].state;
    std::string text = fmt::format("// {:.6g} s\n#version 3.7;\n#include \"scene.inc\"\n",
                                   state.time - run.event_time);
    add_bodies(run, state, colours, text);
    for (const sim::Wall& wall : run.walls_at(f))
      for (const Patch& patch : patches_of(wall, box)) add_patch(patch, text);
    datasets::write_whole(root / fmt::format("frame_{:05}.pov", f), text);
  }
}

}  // namespace graintruth::app
