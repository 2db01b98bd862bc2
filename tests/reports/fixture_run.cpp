#include "fixture_run.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "datasets/store/table.h"

namespace graintruth::tests {

namespace {

using Json = nlohmann::ordered_json;
using datasets::number_text;
using datasets::Table;

constexpr int particles = 10;
constexpr int frames = 26;

// -1..1, from a fixed linear congruential sequence (Numerical Recipes).
class Wobble {
 public:
  double next() {
    state_ = state_ * 1664525u + 1013904223u;
    return static_cast<double>(state_ >> 8) / 8388608.0 - 1.0;
  }

 private:
  std::uint32_t state_ = 20u;
};

// A grey picture of 8 x 8 pixels.
std::string grey_jpeg() {
  std::string bytes("\xFF\xD8\xFF\xDB\x00\x43\x00", 7);
  bytes += std::string(64, '\x10');
  bytes += std::string("\xFF\xC0\x00\x0B\x08\x00\x08\x00\x08\x01\x01\x11\x00", 13);
  bytes +=
      std::string("\xFF\xC4\x00\x14\x00\x01", 6) + std::string(15, '\0') + std::string(1, '\0');
  bytes +=
      std::string("\xFF\xC4\x00\x14\x10\x01", 6) + std::string(15, '\0') + std::string(1, '\0');
  bytes += std::string("\xFF\xDA\x00\x08\x01\x01\x00\x00\x3F\x00\x3F\xFF\xD9", 13);
  return bytes;
}

void write_json(const std::filesystem::path& file, const Json& json) {
  datasets::write_whole(file, json.dump(1));
}

std::string cell(double value) { return number_text(std::round(value * 1e6) / 1e6); }

Json parameter(double value, double lower, double upper, double bench) {
  return {{"value", value},
          {"lower", lower},
          {"upper", upper},
          {"unit", "-"},
          {"status", "tuned"},
          {"bench_value", bench},
          {"bound_lower", 0.0},
          {"bound_upper", 0.6},
          {"confidence", 0.95},
          {"objective_range", 2.9},
          {"objective_range_of_noise", 0.021},
          {"sobol_total", 0.61},
          {"method", "values not significantly worse than the best"}};
}

Json step(double friction, double fraction, double objective, const Json& change, double cpu) {
  return {{"friction_particle_particle", friction},
          {"friction_particle_wall", friction},
          {"restitution", 0.725},
          {"fraction", fraction},
          {"seconds", 6.25e-5 * fraction},
          {"objective", objective},
          {"change", change},
          {"half_width", change.is_null() ? Json() : Json(0.0031)},
          {"allowed", change.is_null() ? Json() : Json(0.0092)},
          {"seeds", 8},
          {"cpu_seconds", cpu}};
}

Json result() {
  return {
      {"status", "done"},
      {"message", "The search ended within its budget."},
      {"experiment", "fixture"},
      {"title", "Fixture: made-up numbers that test the page"},
      {"note", "Nothing here was measured or simulated; a test wrote these numbers."},
      {"kind", "calibration"},
      {"parameters",
       {{"friction_particle_particle", parameter(0.1234, 0.1041, 0.1397, 0.36)},
        {"friction_particle_wall", parameter(0.1712, 0.1480, 0.1957, 0.35)},
        {"restitution",
         {{"value", 0.83},
          {"unit", "-"},
          {"status", "not_identified"},
          {"bench_value", 0.83},
          {"bound_lower", 0.5},
          {"bound_upper", 0.95}}}}},
      {"time_step",
       {{"fraction", 0.2},
        {"seconds", 1.25e-5},
        {"discretisation_error", 0.0021},
        {"study",
         {step(0.12, 0.2, 0.2413, 0.0021, 12.4),
          step(0.12, 0.1, 0.2392, -0.0009, 24.6),
          step(0.12, 0.05, 0.2401, nullptr, 49.9),
          step(0.4, 0.2, 1.513, -0.004, 11.9),
          step(0.4, 0.1, 1.517, 0.002, 24.1),
          step(0.4, 0.05, 1.515, nullptr, 48.2)}}}},
      {"agreement",
       {{"percent", 77.9},
        {"percent_student_t", 88.7},
        {"ceiling_percent", 81.5},
        {"ceiling_percent_student_t", 91.4},
        {"leave_one_out_percent", 55.5},
        {"leave_one_out_percent_student_t", 75.0},
        {"replicates", 5},
        {"seeds", 10},
        {"single_run_median_percent", 51.3},
        {"single_run_median_percent_student_t", 66.2},
        {"without_first_frame", {{"percent", 79.1}, {"percent_student_t", 90.2}}},
        {"per_particle", Json::array()}}},
      {"emulator", {{"leave_one_out_error", 0.1}, {"value_spread", 0.5}}},
      {"surrogate", {{"leave_one_out_error", 0.31}, {"value_spread", 1.9}, {"roughness", 0.11}}},
      {"posterior",
       {{"effective_size", 312.4},
        {"friction_particle_particle",
         {{"mean", 0.1221}, {"standard_deviation", 0.0093}, {"lower", 0.103}, {"upper", 0.141}}},
        {"friction_particle_wall",
         {{"mean", 0.1718}, {"standard_deviation", 0.0121}, {"lower", 0.149}, {"upper", 0.197}}}}},
      {"rms_position_m", 0.00734},
      {"objective",
       {{"best", 0.2389},
        {"noise", 0.0058},
        {"stop_reason", "the polish moved by less than the noise"}}},
      {"evaluations", 112},
      {"simulations", 1136},
      {"failed", 3},
      {"wall_time_s", 754.0},
      {"warnings",
       {"Fixture warning: the two frictions trade off; a sliding test would separate them."}}};
}

Json run() {
  Json walls = Json::array();
  const auto wall = [&](double x0, double z0, double x1, double z1) {
    walls.push_back({{"from_x_m", x0}, {"from_z_m", z0}, {"to_x_m", x1}, {"to_z_m", z1}});
  };
  wall(-0.0675, -0.28, -0.0675, 0.0);
  wall(0.0675, -0.28, 0.0675, 0.0);
  wall(-0.0675, 0.0, -0.2407, 0.3);
  wall(0.0675, 0.0, 0.2407, 0.3);
  return {
      {"version", "0.1.0"},
      {"command", "graintruth calibrate fixture.toml --budget 112 --seed 7"},
      {"started_at", "2020-01-02T03:04:05Z"},
      {"configuration",
       {{"search", {{"budget", 112}}},
        {"seeds", 10},
        {"particle",
         {{"mass_kg", 0.142},
          {"spheres",
           {{{"offset_m", -0.013915}, {"radius_m", 0.022225}},
            {{"offset_m", 0.013915}, {"radius_m", 0.022225}}}}}},
        {"material", {{"elastic_modulus_pa", 6.89e9}, {"poisson_ratio", 0.35}}}}},
      {"seed", 7},
      {"jobs", 4},
      {"input_hashes", {{"fixture.toml", "0123456789abcdef"}, {"rep1.mp4", "fedcba9876543210"}}},
      {"stages",
       {{{"name", "track"}, {"seconds", 41.2}},
        {{"name", "search"}, {"seconds", 598.0}},
        {{"name", "confirm"}, {"seconds", 114.8}}}},
      {"rig",
       {{"walls", walls},
        {"gravity_m_per_s2", 9.81},
        {"piston", {{"face_z_m", 0.0}, {"half_width_m", 0.0675}}}}}};
}

Json tracking() {
  Json replicates = Json::array();
  for (int r = 1; r <= 5; ++r) {
    const std::string name = fmt::format("rep{}", r);
    replicates.push_back(
        {{"name", name},
         {"film", name + ".mp4"},
         {"scale_px_per_mm", 1.1 + 0.001 * r},
         {"calibration_rms_mm", 0.11 + 0.01 * r},
         {"calibration_max_mm", 0.29},
         {"calibration_leave_one_out_mm", 0.21},
         {"scale_from", "14 fiducials"},
         {"fiducials_found", 14},
         {"frames", 261},
         {"completeness", r == 3 ? 0.984 : 1.0},
         {"gaps", r == 3 ? 4 : 0},
         {"suspected_swaps", 0},
         {"pixel_error_px", 0.31},
         {"event_time_s", 0.2},
         {"event_time_sigma_s", 0.006},
         {"frames_per_second", 50.0},
         {"grade", r == 3 ? "fair" : "good"},
         {"warnings", r == 3 ? Json{"Particle 9 is hidden for 4 frames."} : Json::array()},
         {"annotated_frames",
          {fmt::format("tracks/{}.first.jpg", name), fmt::format("tracks/{}.last.jpg", name)}}});
  }
  return {{"replicates", replicates}};
}

// Tables of tracks; what they show as a channel.
Json write_bands(const datasets::RunFolder& folder, Wobble& wobble) {
  // Moment after moment, within a moment x, z and angle of particle after particle
  std::map<std::string, std::vector<double>> channel;
  for (const char* key : {"measured", "lower", "upper", "simulated"})
    channel[key].resize(3 * particles * frames);
  Table bands({"frame",
               "time_s",
               "particle",
               "quantity",
               "replicate_mean",
               "lower_196",
               "upper_196",
               "lower_t",
               "upper_t",
               "simulated_mean",
               "simulated_lower",
               "simulated_upper"});
  Table ranks({"frame", "time_s", "particle", "rank", "rank_student_t"});
  Table agreement(
      {"particle", "rank0", "rank1", "rank2", "rank3", "points", "percent", "percent_student_t"});
  constexpr double student = 2.776 / 1.96;
  for (int p = 1; p <= particles; ++p) {
    std::array<int, 4> counts = {};
    int points_thesis = 0;
    int points_student = 0;
    const double x0 = -0.13 + 0.028 * p;
    const double z0 = 0.03 + 0.011 * p + 0.02 * (p % 3);
    std::array<double, 3> drift = {};
    for (int f = 0; f < frames; ++f) {
      const double t = 0.2 * f;
      const double fallen = 0.046 * std::max(0.0, t - 0.12 * p / 3.0);
      const std::array<double, 3> mean = {
          x0 * (0.45 + 0.55 * std::exp(-fallen / 0.08)),
          z0 - fallen,
          0.3 * p + 1.4 * std::tanh(fallen / 0.05) * (p % 2 == 0 ? 1 : -1)};
      const std::array<double, 3> scale = {0.002, 0.002, 0.12};
      constexpr std::array<const char*, 3> names = {"x", "z", "angle"};
      int rank = 0;
      int rank_student = 0;
      for (std::size_t q = 0; q < 3; ++q) {
        const double half = scale[q] * (0.12 + 0.3 * t);
        drift[q] += 0.25 * scale[q] * wobble.next();
        const double simulated = mean[q] + drift[q];
        const std::size_t place = 3 * static_cast<std::size_t>(f * particles + p - 1) + q;
        channel["measured"][place] = mean[q];
        channel["lower"][place] = mean[q] - student * half;
        channel["upper"][place] = mean[q] + student * half;
        channel["simulated"][place] = simulated;
        rank += std::abs(drift[q]) < half ? 1 : 0;
        rank_student += std::abs(drift[q]) < student * half ? 1 : 0;
        bands.add({std::to_string(f),
                   cell(t),
                   std::to_string(p),
                   names[q],
                   cell(mean[q]),
                   cell(mean[q] - half),
                   cell(mean[q] + half),
                   cell(mean[q] - student * half),
                   cell(mean[q] + student * half),
                   cell(simulated),
                   cell(simulated - 1.8 * half),
                   cell(simulated + 1.8 * half)});
      }
      ranks.add({std::to_string(f),
                 cell(t),
                 std::to_string(p),
                 std::to_string(rank),
                 std::to_string(rank_student)});
      ++counts[static_cast<std::size_t>(rank)];
      points_thesis += rank;
      points_student += rank_student;
    }
    agreement.add({std::to_string(p),
                   std::to_string(counts[0]),
                   std::to_string(counts[1]),
                   std::to_string(counts[2]),
                   std::to_string(counts[3]),
                   std::to_string(points_thesis),
                   cell(100.0 * points_thesis / (3.0 * frames)),
                   cell(100.0 * points_student / (3.0 * frames))});
  }
  datasets::write_csv(folder.table("bands"), bands);
  datasets::write_csv(folder.table("ranks"), ranks);
  datasets::write_csv(folder.table("agreement"), agreement);
  Json json = {{"observable", "tracks"},
               {"title", "Tracks"},
               {"condition", ""},
               {"unit", "m, m, rad"},
               {"axis", {{"name", "time"}, {"unit", "s"}, {"values", Json::array()}}},
               {"held_out", false}};
  for (int f = 0; f < frames; ++f) json["axis"]["values"].push_back(0.2 * f);
  for (const auto& [key, values] : channel) json[key] = values;
  return json;
}

void write_search(const datasets::RunFolder& folder, Wobble& wobble) {
  Table evaluations({"evaluation",
                     "stage",
                     "friction_particle_particle",
                     "friction_particle_wall",
                     "restitution",
                     "objective",
                     "best",
                     "agreement_percent",
                     "failed",
                     "seconds"});
  double best = 1e9;
  for (int i = 1; i <= 112; ++i) {
    const bool design = i <= 45;
    const double reach = design ? 0.3 : 0.12 * std::exp(-(i - 45) / 25.0) + 0.006;
    const double x = (design ? 0.3 : 0.1234) + reach * wobble.next();
    const double y = (design ? 0.3 : 0.1712) + reach * wobble.next();
    const double a = (x - 0.1234) / 0.1;
    const double b = (y - 0.1712) / 0.12;
    const double objective =
        0.2389 + 0.08 * (a * a + b * b + 0.9 * a * b) + 0.004 * (1.0 + wobble.next());
    const bool failed = i == 9 || i == 23 || i == 31;
    if (!failed) best = std::min(best, objective);
    evaluations.add({std::to_string(i),
                     design    ? "design"
                     : i <= 80 ? "polish 1"
                               : "polish 2",
                     cell(x),
                     cell(y),
                     "0.83",
                     cell(objective),
                     best < 1e9 ? cell(best) : "",
                     cell(78.0 - 60.0 * (objective - 0.2389)),
                     failed ? "1" : "0",
                     "5.2"});
  }
  datasets::write_csv(folder.table("evaluations"), evaluations);

  Table profile({"parameter", "value", "objective", "excess", "allowed_excess", "compatible"});
  for (const auto& [name, centre] :
       {std::pair{"friction_particle_particle", 0.1234}, {"friction_particle_wall", 0.1712}}) {
    for (int i = -4; i <= 4; ++i) {
      const double excess = 0.0045 * i * i;
      const double allowed = i == 0 ? 0.0 : 0.03;
      profile.add({name,
                   cell(centre + 0.008 * i),
                   cell(0.2389 + excess),
                   cell(excess),
                   cell(allowed),
                   excess <= allowed ? "1" : "0"});
    }
  }
  datasets::write_csv(folder.table("profile"), profile);
}

Json compared(double orifice, bool held_out, double filmed, double simulated) {
  const Json jams = {{"jams", 0}, {"runs", 3}, {"lower", 0.0}, {"upper", 0.54}};
  return {{"orifice_m", orifice},
          {"held_out", held_out},
          {"filmed_kg_per_s", filmed},
          {"simulated_kg_per_s", simulated},
          {"error_kg_per_s", simulated - filmed},
          {"validation_uncertainty_kg_per_s", 0.04 * filmed},
          {"film_uncertainty_kg_per_s", 0.02 * filmed},
          {"run_uncertainty_kg_per_s", 0.02 * filmed},
          {"input_uncertainty_kg_per_s", 0.025 * filmed},
          {"numerical_uncertainty_kg_per_s", 0.01 * filmed},
          {"filmed_jams", jams},
          {"simulated_jams", jams},
          {"curve_inside", 0.95}};
}

// Distances of replicates from the simulated mean: the third lies three times as far as the others.
void write_residuals(const datasets::RunFolder& folder, Wobble& wobble) {
  Table residuals({"frame", "time_s", "particle", "quantity", "replicate", "residual"});
  for (int r = 1; r <= 5; ++r) {
    for (int f = 0; f < frames; f += 5) {
      for (int p = 1; p <= particles; ++p) {
        for (const auto& [name, scale] : {std::pair{"x", 0.002}, {"z", 0.002}, {"angle", 0.12}}) {
          residuals.add({std::to_string(f),
                         cell(0.2 * f),
                         std::to_string(p),
                         name,
                         fmt::format("rep{}", r),
                         cell((r == 3 ? 3.0 : 1.0) * scale * wobble.next())});
        }
      }
    }
  }
  datasets::write_csv(folder.table("residuals"), residuals);
}

// Three stills of film and simulation.
void write_side_by_side(const datasets::RunFolder& folder) {
  Json list = {{"replicate", "rep2"}, {"film", "side_by_side.mp4"}, {"stills", Json::array()}};
  datasets::make_folder(folder.side_by_side_still(0).parent_path());
  for (std::size_t i = 0; i < 3; ++i) {
    const std::filesystem::path file = folder.side_by_side_still(i);
    datasets::write_whole(file, grey_jpeg());
    list["stills"].push_back(
        {{"time_s", -0.0004 + 2.4 * static_cast<double>(i)},
         {"file", std::filesystem::relative(file, folder.root).generic_string()}});
  }
  write_json(folder.side_by_side_list(), list);
}

constexpr double orifices[] = {0.05, 0.1};  // m; the first is held out
constexpr int columns = 11;                 // across the bed

double place_of(int column) { return 0.014 * (column - 5); }
double velocity_at(double orifice, double x) { return 2.0 * orifice * std::exp(-400.0 * x * x); }

// The channels of one observable. `interval` is its half width, `error` simulated less measured.
void add_channels(const char* observable,
                  const char* title,
                  const char* unit,
                  double interval,
                  double error,
                  const std::function<double(double orifice, double x)>& measured,
                  bool is_profile,
                  Json& channels) {
  for (const double orifice : orifices) {
    Json json = {{"observable", observable},
                 {"title", title},
                 {"condition", fmt::format("orifice width {:.0f} mm", 1e3 * orifice)},
                 {"unit", unit},
                 {"axis",
                  {{"name", is_profile ? "x" : ""},
                   {"unit", is_profile ? "m" : ""},
                   {"values", Json::array()}}},
                 {"held_out", orifice == orifices[0]}};
    for (int column = 0; column < (is_profile ? columns : 1); ++column) {
      const double value = measured(orifice, place_of(column));
      if (is_profile) json["axis"]["values"].push_back(place_of(column));
      json["measured"].push_back(value);
      json["lower"].push_back(value - interval);
      json["upper"].push_back(value + interval);
      json["simulated"].push_back(value + error);
    }
    channels.push_back(std::move(json));
  }
}

// What a flow leaves beside parameters, time step and search.
void write_flow(const datasets::RunFolder& folder) {
  Json json = result();
  json.erase("agreement");
  json["objective"]["shares"] = {
      {"discharge_rate", 0.1}, {"what_stays", 0.3}, {"velocity_profile", 0.2}};
  json["comparison"] = {compared(0.05, true, 0.053, 0.047), compared(0.1, false, 0.15, 0.152)};
  for (const char* source : {"experiment", "simulation"}) {
    json["beverloo"][source] = {{"C", 0.6},
                                {"k", 1.2},
                                {"covariance", {{0.0004, 0.0001}, {0.0001, 0.0025}}},
                                {"form", "joint"}};
    json["kinematic"].push_back({{"orifice_m", 0.1},
                                 {"B_over_d", 0.6},
                                 {"lower", 0.4},
                                 {"upper", nullptr},
                                 {"source", source}});
  }
  datasets::Table curves({"orifice_m",
                          "time_s",
                          "filmed_count",
                          "filmed_lower",
                          "filmed_upper",
                          "simulated_count",
                          "simulated_lower",
                          "simulated_upper"});
  datasets::Table boundaries({"orifice_m", "x_m", "filmed_height_m", "simulated_height_m"});
  datasets::Table profiles({"orifice_m", "x_m", "source", "velocity_m_per_s", "lowest", "highest"});
  for (const double orifice : orifices) {
    for (int i = 0; i < columns; ++i) {
      const double count = 1900.0 * orifice * i / 10.0;
      curves.add({cell(orifice),
                  cell(0.1 * i),
                  cell(count),
                  cell(0.9 * count),
                  cell(1.1 * count),
                  cell(0.95 * count),
                  cell(0.8 * count),
                  cell(1.05 * count)});
      const double x = place_of(i);
      boundaries.add({cell(orifice), cell(x), cell(0.5 * std::abs(x)), cell(0.6 * std::abs(x))});
      const double velocity = velocity_at(orifice, x);
      for (const char* source : {"experiment", "simulation"}) {
        profiles.add({cell(orifice),
                      cell(x),
                      source,
                      cell(velocity),
                      cell(0.8 * velocity),
                      cell(1.2 * velocity)});
      }
    }
  }
  Json& channels = json["channels"];
  const auto rate = [](double orifice, double) { return 1.5 * orifice; };
  const auto three = [](double, double) { return 3.0; };
  add_channels("discharge_rate", "Discharge rate", "kg/s", 0.004, -0.006, rate, false, channels);
  add_channels("what_stays", "Grains that stay", "-", 2.0, 1.0, three, false, channels);
  add_channels(
      "velocity_profile", "Velocity profile", "m/s", 0.02, 0.01, velocity_at, true, channels);
  write_json(folder.result(), json);
  datasets::write_csv(folder.table("discharge_curves"), curves);
  datasets::write_csv(folder.table("velocity_comparison"), profiles);
  datasets::write_csv(folder.table("stagnant_boundary"), boundaries);
}

}  // namespace

std::string spoken(std::string page) {
  const std::string unbreakable = "\u00a0";
  for (auto place = page.find(unbreakable); place != std::string::npos;
       place = page.find(unbreakable, place))
    page.replace(place, unbreakable.size(), " ");
  return page;
}

std::string visible_text(const std::string& page) {
  std::string text;
  int folds = 0;
  bool is_summary = false;
  for (std::size_t at = page.find("<body"); at < page.size();) {
    if (page[at] != '<') {
      if (folds == 0 || is_summary) text += page[at];
      ++at;
      continue;
    }
    const auto begins = [&](const char* tag) {
      return page.compare(at, std::strlen(tag), tag) == 0;
    };
    if (begins("<script")) {
      at = page.find("</script>", at);
      if (at == std::string::npos) break;
    }
    if (begins("<details")) ++folds;
    if (begins("</details")) --folds;
    if (begins("<summary")) is_summary = folds == 1;
    if (begins("</summary")) is_summary = false;
    text += ' ';
    at = page.find('>', at) + 1;
  }
  return text;
}

int words_in(const std::string& text) {
  std::istringstream stream(text);
  int count = 0;
  for (std::string word; stream >> word;) ++count;
  return count;
}

int occurrences(const std::string& text, const std::string& part) {
  int found = 0;
  for (auto place = text.find(part); place != std::string::npos; place = text.find(part, place + 1))
    ++found;
  return found;
}

std::filesystem::path empty_folder(const std::string& name) {
  const std::filesystem::path root = std::filesystem::temp_directory_path() /
                                     fmt::format("graintruth-reports-{}-{}", name, ::getpid());
  std::filesystem::remove_all(root);
  std::filesystem::create_directories(root);
  return root;
}

datasets::RunFolder write_fixture_run(const std::filesystem::path& root) {
  const datasets::RunFolder folder = datasets::open_run_folder(root);
  Wobble wobble;
  write_json(folder.run(), run());
  Json measured = {{"replicates", {"rep1", "rep2", "rep3", "rep4", "rep5"}},
                   {"particles", particles}};
  for (int f = 0; f < frames; ++f) measured["frames"].push_back(0.2 * f);
  write_json(folder.measured(), measured);
  write_json(folder.tracking(), tracking());
  for (int r = 1; r <= 5; ++r)
    for (const char* moment : {"first", "last"})
      datasets::write_whole(folder.annotated_frame(fmt::format("rep{}", r), moment), grey_jpeg());
  write_side_by_side(folder);
  Json json = result();
  json["channels"].push_back(write_bands(folder, wobble));
  write_json(folder.result(), json);
  write_search(folder, wobble);
  write_residuals(folder, wobble);
  return folder;
}

datasets::RunFolder write_fixture_flow_run(const std::filesystem::path& root) {
  const datasets::RunFolder folder = write_fixture_run(root);
  for (const char* name : {"agreement", "ranks", "bands", "residuals"})
    std::filesystem::remove(folder.table(name));
  write_flow(folder);
  return folder;
}

datasets::RunFolder write_fixture_run_of_several(const std::filesystem::path& root) {
  const datasets::RunFolder folder = write_fixture_run(root);
  for (const char* name : {"agreement", "ranks", "bands", "residuals"})
    std::filesystem::remove(folder.table(name));
  for (const auto& file : {folder.measured(), folder.tracking()}) std::filesystem::remove(file);
  Json json = result();
  json.erase("agreement");
  json["experiments"] = {{{"name", "piston"},
                          {"title", "Balls <on> a piston"},
                          {"compared", Json::array({"tracks"})},
                          {"replicates", 5},
                          {"weight", 1.0},
                          {"objective", 0.3},
                          {"agreement_percent_student_t", 87.2},
                          {"ceiling_percent_student_t", 91.4}},
                         {{"name", "bin"},
                          {"title", "Out of a bin"},
                          {"compared", {"discharge_rate", "what_stays"}},
                          {"replicates", 9},
                          {"weight", 2.0},
                          {"objective", 0.35},
                          {"mean_signed_error", -0.021},
                          {"orifices", 4},
                          {"held_out_orifices", 1}}};
  write_json(folder.result(), json);
  return folder;
}

}  // namespace graintruth::tests
