// What users bring: tables, XML, meshes, experiments, scenes and decks.
#include <array>

#include "bench/fuzz/reader.h"
#include "datasets/experiment/experiment.h"
#include "datasets/imports/curve_files.h"
#include "datasets/imports/discharge_curve.h"
#include "datasets/imports/track_files.h"
#include "datasets/scene/geometry_files.h"
#include "datasets/scene/scene_file.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"

namespace graintruth::fuzz {

namespace {

using Path = std::filesystem::path;

const datasets::TrackSource track_source{.scale = 1000.0,
                                         .origin_px = std::array{1.0, 2.0},
                                         .usual_frame_rate = 50.0,
                                         .event_time = 0.02};

Reader table() {
  return {
      .name = "table",
      .extension = ".csv",
      .seeds = {"y,x,mass,ep,frame,particle\n30,200,99,0.1,0,0\n50,80,99,0.2,0,1\n",
                "LABEL;TRACK_ID;POSITION_X;POSITION_Y;POSITION_T;FRAME\nL;T;X;Y;T;F\nL;T;X;Y;T;F\n"
                ";;(mm);(mm);(sec);\nID7;2;1,5;3;0;0\nID9;2;1.204,5;3;0,02;1\n;;;;;\n",
                " \tTrack n\xb0\tSlice n\xb0\tX\tY\n1\t1\t1\t1,200\t30\n2\t1\t2\t998\t3\n",
                "sep=;\nTime (s);Mass (g)\n0,00;12,5\n0,01;\"12,5\"\n",
                "# made\n# Time (s) Mass (g)\n0.0 1e-3\n0.1 nan\n",
                "Time;Mass\ns;g\n1'000;0.5\n\xe2\x88\x92"
                "1;NA\n",
                "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tNo\n"
                "***End_of_Header***\t\nX0\t0\nDelta_X\t0,5\n***End_of_Header***\n"
                "X_Value\tWeight (g)\tComment\n\t0,5\n\t1\n",
                std::string("\xff\xfet\0,\0x\0\n\0"
                            "1\0,\0"
                            "2\0\n\0",
                            18)},
      .read = [](const Path& file) {
        each([&] { datasets::read_track_file(file, track_source); },
             [&] {
               datasets::read_discharge_curve(file, {.full_mass = 1.0, .particle_mass = 0.01});
             },
             [&] { datasets::read_curves(file, 0.0); },
             [&] { datasets::to_csv(datasets::read_csv(file)); });
      }};
}

Reader trackmate() {
  const std::string head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  const std::string particle =
      "<particle nSpots=\"2\">\n<detection t=\"0\" x=\"2\" y=\"3.5\" z=\"0.0\" />\n"
      "<detection t=\"1\" x=\"2\" y=\"4\" z=\"0.0\" />\n</particle>\n";
  return {
      .name = "trackmate",
      .extension = ".xml",
      .seeds = {head + "<Tracks spaceUnits=\"pixel\" frameInterval=\"0.02\" timeUnits=\"sec\">\n" +
                    particle + "</Tracks>\n",
                "<!-- a --><Tracks spaceUnits=\"mm\">" + particle + "</Tracks>",
                "<!DOCTYPE a [<!ENTITY b \"c\">]><Tracks><![CDATA[&b;]]></Tracks>"},
      .read = [](const Path& file) { datasets::read_track_file(file, track_source); }};
}

Reader stl() {
  const std::string text =
      "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 3 1e-1\n"
      "endloop\nendfacet\nendsolid one\n";
  return {
      .name = "stl",
      .extension = ".stl",
      .seeds = {text, text + text, content_of(bundled / "scenes/hopper.stl").substr(0, 84 + 150)},
      .read = [](const Path& file) {
        each([&] { datasets::read_stl(file, 1e-3); },
             [&] { datasets::read_sphere_list(file, 1e-3); });
      }};
}

Reader experiment() {
  return {.name = "experiment",
          .extension = ".toml",
          .seeds = {content_of(bundled / "micro/experiment.toml"),
                    content_of(bundled / "macro/experiment.toml"),
                    content_of(bundled / "scenes/micro_rig.toml"),
                    content_of(bundled / "scenes/shape_study.toml")},
          .read = [](const Path& file) {
            each([&] { datasets::load_experiment(file, datasets::Purpose::calibration); },
                 [&] { datasets::load_experiment(file, datasets::Purpose::tracking); },
                 [&] { datasets::load_scene(file); },
                 [&] { datasets::read_parameter_table(file); });
          }};
}

Reader deck() {
  std::vector<std::string> decks;
  for (const auto& entry : std::filesystem::directory_iterator(bundled / "scenes/decks")) {
    if (entry.path().extension() == ".txt") decks.push_back(content_of(entry.path()));
  }
  decks.emplace_back(
      "START\na deck\nBOT 10 1\nCON 1 0 0 0 10\nRAD 1\nPRO 10 0.3\nDENS 1000\nFRIC 0.3\nFRAC 0.2\n"
      "DAMP 0.1\nGRA 0 -9.81\nMOV 1\nCYC 1000 1e-5\nSTOP\n");
  const Path sidecar = [] {
    for (const auto& entry : std::filesystem::directory_iterator(bundled / "scenes/decks"))
      if (entry.path().extension() == ".toml") return entry.path();
    return Path();
  }();
  return {.name = "deck", .extension = ".txt", .seeds = decks, .read = [sidecar](const Path& file) {
            datasets::load_scene(file, sidecar);
          }};
}

}  // namespace

std::vector<Reader> readers() { return {table(), trackmate(), stl(), experiment(), deck()}; }

}  // namespace graintruth::fuzz
