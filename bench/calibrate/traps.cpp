// Experiments with one thing wrong, calibrated as users would: a wrong rate, radius, scale, speed,
// gravity, slope or mass, a mirrored, late or slow film, a replicate of another experiment, a
// duplicate. Prints for each how the program ended, what it said first, and whether the intervals
// hold the truth. An interval that misses the truth without a warning in the first line is a trap
// that caught the program; the exit status is then 1.
//   bench_calibration_traps [FIGURES.json] [BUDGET] [NAMES...]
#include <fmt/ostream.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/read_rows.h"
#include "tests/support/run_program.h"

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using graintruth::tests::number;
using graintruth::tests::ProgramOutcome;
using graintruth::tests::read_rows;
using graintruth::tests::Row;

constexpr int replicates = 5;
constexpr double event_s = 0.2;
const std::vector<std::pair<std::string, double>> truths = {
    {"friction_particle_particle", 0.12},
    {"friction_particle_wall", 0.17},
    {"restitution", 0.82}};  // datasets/micro/truth/truth.toml

const fs::path micro = fs::path(GRAINTRUTH_SOURCE_DIR) / "datasets" / "micro";

std::string content_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  return std::move(content).str();
}

// `text` with every `from` replaced.
std::string with(std::string text, std::string_view from, std::string_view to) {
  std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error(fmt::format("no text '{}' to replace", from));
  for (; at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

// What a trap may change: the experiment's text and what each replicate's file holds.
struct Experiment {
  fs::path folder;
  std::string text;
};

struct Trap {
  std::string name;
  std::function<void(Experiment&)> set;
};

// ---- of tracks -------------------------------------------------------------------------------

using Rows = std::vector<Row>;

void write_tracks(const Experiment& experiment, int replicate, const Rows& rows) {
  std::ofstream stream(experiment.folder / fmt::format("rep{}.csv", replicate));
  stream << "time_s,particle,x_m,z_m,angle_rad\n";
  for (const Row& row : rows) {
    fmt::print(stream,
               "{:.10g},{},{:.10g},{:.10g},{:.10g}\n",
               number(row, "time_s"),
               row.at("particle"),
               number(row, "x_m"),
               number(row, "z_m"),
               number(row, "angle_rad"));
  }
}

Rows tracks(int replicate) {
  Rows rows = read_rows(micro / "truth" / fmt::format("rep{}_tracks.csv", replicate));
  for (Row& row : rows) row["time_s"] = fmt::format("{:.10g}", number(row, "time_s") - event_s);
  return rows;
}

void change_tracks(const Experiment& experiment,
                   int replicate,
                   const std::function<void(Row&)>& change) {
  Rows rows = tracks(replicate);
  for (Row& row : rows) change(row);
  write_tracks(experiment, replicate, rows);
}

void change_every_track(const Experiment& experiment, const std::function<void(Row&)>& change) {
  for (int n = 1; n <= replicates; ++n) change_tracks(experiment, n, change);
}

std::function<void(Row&)> times(const char* column, double factor) {
  return [=](Row& row) { row[column] = fmt::format("{:.10g}", number(row, column) * factor); };
}

void mirror(Row& row) {
  times("x_m", -1.0)(row);
  row["angle_rad"] = fmt::format("{:.10g}", 3.14159265358979 - number(row, "angle_rad"));
}

void scale(Row& row, double factor) {
  times("x_m", factor)(row);
  times("z_m", factor)(row);
}

// ---- of films --------------------------------------------------------------------------------

// A copy of a film with every picture changed; fewer pictures where `from` is above 0.
void change_film(const Experiment& experiment,
                 int replicate,
                 const std::function<void(cv::Mat&)>& change,
                 double rate_hz = 50.0,
                 int from = 0) {
  const std::string name = fmt::format("rep{}.mp4", replicate);
  cv::VideoCapture film((micro / name).string());
  cv::VideoWriter writer;
  cv::Mat frame;
  for (int k = 0; film.read(frame); ++k) {
    if (k < from) continue;
    change(frame);
    if (!writer.isOpened())
      writer.open((experiment.folder / name).string(),
                  cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                  rate_hz,
                  frame.size());
    writer.write(frame);
  }
}

void mirror_film(cv::Mat& frame) { cv::flip(frame, frame, 1); }
void leave_film(cv::Mat&) {}

// ----------------------------------------------------------------------------------------------

std::vector<Trap> track_traps() {
  const auto replaced = [](std::string from, std::string to) {
    return [=](Experiment& e) { e.text = with(e.text, from, to); };
  };
  const std::string speed = "piston_speed_mm_per_s = 46", slope = "slope_angle_deg = 60",
                    radius = "radius_mm = 22.225", note = "title = ";
  return {
      {"nothing wrong", [](Experiment&) {}},
      {"clock twice too fast", [](Experiment& e) { change_every_track(e, times("time_s", 0.5)); }},
      {"clock twice too slow", [](Experiment& e) { change_every_track(e, times("time_s", 2.0)); }},
      {"radius 5 % too large", replaced(radius, "radius_mm = 23.336")},
      {"radius 5 % too small", replaced(radius, "radius_mm = 21.114")},
      {"places 5 % too far apart",
       [](Experiment& e) { change_every_track(e, [](Row& row) { scale(row, 1.05); }); }},
      {"places 5 % too close",
       [](Experiment& e) { change_every_track(e, [](Row& row) { scale(row, 0.95); }); }},
      {"tracks mirrored", [](Experiment& e) { change_every_track(e, mirror); }},
      {"speed 10 % too high", replaced(speed, "piston_speed_mm_per_s = 50.6")},
      {"speed 10 % too low", replaced(speed, "piston_speed_mm_per_s = 41.4")},
      {"gravity of the moon", replaced(note, "gravity_m_per_s2 = 1.62\ntitle = ")},
      {"slope 5 degrees too steep", replaced(slope, "slope_angle_deg = 65")},
      {"slope 5 degrees too flat", replaced(slope, "slope_angle_deg = 55")},
      {"mass twice too large", replaced("mass_g = 142", "mass_g = 284")},
      {"mass in kilograms", replaced("mass_g = 142", "mass_g = 0.142")},
      {"one replicate mirrored", [](Experiment& e) { change_tracks(e, 3, mirror); }},
      {"one replicate twice too slow",
       [](Experiment& e) { change_tracks(e, 3, times("time_s", 2.0)); }},
      {"one replicate late by 0.4 s",
       [](Experiment& e) {
         change_tracks(e, 3, [](Row& row) {
           row["time_s"] = fmt::format("{:.10g}", number(row, "time_s") - 0.4);
         });
       }},
      {"a duplicate replicate", [](Experiment& e) { write_tracks(e, 3, tracks(2)); }},
  };
}

std::vector<Trap> film_traps() {
  const auto every_film =
      [](const std::function<void(cv::Mat&)>& change, double rate_hz, int from) {
        return [=](Experiment& e) {
          for (int n = 1; n <= replicates; ++n) change_film(e, n, change, rate_hz, from);
        };
      };
  const auto one_film = [](const std::function<void(cv::Mat&)>& change, double rate_hz, int from) {
    return [=](Experiment& e) { change_film(e, 3, change, rate_hz, from); };
  };
  const auto fiducials = [](double factor) {
    return [=](Experiment& e) {
      for (const int place : {290, 220, 160, 110}) {
        e.text = with(e.text, fmt::format("{},", place), fmt::format("{:.2f},", place * factor));
        e.text = with(e.text, fmt::format("{}]", place), fmt::format("{:.2f}]", place * factor));
      }
    };
  };
  const auto rate = [](int hz) {
    return [=](Experiment& e) {
      e.text = with(with(e.text, "frame_rate_hz = 50", fmt::format("frame_rate_hz = {}", hz)),
                    "noted_event_s",
                    "# noted_event_s");
    };
  };
  return {
      {"films: nothing wrong", [](Experiment&) {}},
      {"films: rate twice too high", rate(100)},
      {"films: rate half as high", rate(25)},
      {"films: slow motion in the container",
       [=](Experiment& e) {
         every_film(leave_film, 25.0, 0)(e);
         e.text = with(with(e.text, "frame_rate_hz = 50", ""), "noted_event_s", "# noted_event_s");
       }},
      {"films: fiducials 5 % too far apart", fiducials(1.05)},
      {"films: fiducials 5 % too close", fiducials(0.95)},
      {"films: mirrored", every_film(mirror_film, 50.0, 0)},
      {"films: begin after the event", every_film(leave_film, 50.0, 30)},
      {"films: one mirrored", one_film(mirror_film, 50.0, 0)},
      {"films: one begins after the event", one_film(leave_film, 50.0, 30)},
      {"films: a duplicate",
       [](Experiment& e) {
         fs::copy_file(
             e.folder / "rep2.mp4", e.folder / "rep3.mp4", fs::copy_options::overwrite_existing);
       }},
  };
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

// The row of a trap: what the program said, and whether an interval misses the truth.
Json calibrated(const Trap& trap, Experiment& experiment, int budget) {
  fs::remove_all(experiment.folder);
  fs::create_directories(experiment.folder);
  const bool filmed = trap.name.starts_with("films");
  experiment.text = content_of(micro / "experiment.toml");
  for (int n = 1; n <= replicates; ++n) {
    const std::string stem = fmt::format("rep{}", n);
    if (filmed) {
      fs::copy_file(micro / (stem + ".mp4"), experiment.folder / (stem + ".mp4"));
    } else {
      experiment.text =
          with(experiment.text, "video = \"" + stem + ".mp4", "tracks = \"" + stem + ".csv");
      write_tracks(experiment, n, tracks(n));
    }
  }
  trap.set(experiment);
  std::ofstream(experiment.folder / "experiment.toml") << experiment.text;

  const fs::path run = experiment.folder / "run";
  const ProgramOutcome outcome =
      graintruth::tests::run_program({"calibrate",
                                      (experiment.folder / "experiment.toml").string(),
                                      "--out",
                                      run.string(),
                                      "--budget",
                                      std::to_string(budget),
                                      "--quiet"});
  Json row = {{"trap", trap.name}, {"exit", outcome.status}, {"says", first_line(outcome.err)}};
  if (!fs::exists(run / "result.json")) return row;
  const Json result = Json::parse(content_of(run / "result.json"));
  row["verdict"] = result.at("verdict").at("mark");
  row["says"] = result.at("verdict").at("reason");
  row["misses"] = Json::array();
  for (const auto& [name, truth] : truths) {
    const Json& parameter = result.at("parameters").at(name);
    if (!parameter.contains("lower") || parameter["lower"].is_null()) continue;
    row["intervals"][name] = {parameter["lower"], parameter["upper"]};
    if (truth < parameter["lower"].get<double>() || truth > parameter["upper"].get<double>())
      row["misses"].push_back(name);
  }
  return row;
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path figures = argc > 1 ? argv[1] : "traps.json";
  const int budget = argc > 2 ? std::stoi(argv[2]) : 40;
  const std::vector<std::string> chosen(argv + std::min(argc, 3), argv + argc);
  std::vector<Trap> traps = track_traps();
  std::ranges::move(film_traps(), std::back_inserter(traps));
  Json rows = Json::array();
  int caught = 0;
  for (const Trap& trap : traps) {
    const auto is_meant = [&](const std::string& part) {
      return trap.name.find(part) != std::string::npos;
    };
    if (!chosen.empty() && std::ranges::none_of(chosen, is_meant)) continue;
    Experiment experiment{.folder = fs::temp_directory_path() /
                                    fmt::format("graintruth-traps-{}", ::getpid())};
    Json row = calibrated(trap, experiment, budget);
    fs::remove_all(experiment.folder);
    const bool unwarned =
        row.contains("misses") && !row["misses"].empty() && row["verdict"] == "agrees";
    caught += unwarned;
    fmt::print("{:36} exit {}  {:26} {} {}\n    {}\n",
               trap.name,
               row["exit"].get<int>(),
               row.value("verdict", "refused"),
               row.contains("intervals") ? row["intervals"].dump() : "",
               unwarned ? "MISSES THE TRUTH WITHOUT A WARNING" : "",
               row["says"].get<std::string>());
    std::fflush(stdout);
    rows.push_back(std::move(row));
  }
  std::ofstream(figures) << rows.dump(2) << "\n";
  return caught == 0 ? 0 : 1;
}
