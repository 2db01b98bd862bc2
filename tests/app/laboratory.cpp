#include "tests/app/laboratory.h"

#include <gtest/gtest.h>

#include <sstream>
#include <stdexcept>

#include "tests/support/read_rows.h"

namespace graintruth::tests {

namespace {

constexpr int replicates = 5;
constexpr double event_time = 0.2;  // s of film, datasets/micro/experiment.toml

}  // namespace

std::filesystem::path bundled_micro() {
  return std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/micro";
}

std::string film_experiment() {
  std::string text = content_of(bundled_micro() / "experiment.toml");
  for (int n = 1; n <= replicates; ++n) {
    const std::string film = "rep" + std::to_string(n) + ".mp4";
    text = with(text, film, (bundled_micro() / film).string());
  }
  return text;
}

std::string track_experiment() {
  std::string text = content_of(bundled_micro() / "experiment.toml");
  for (int n = 1; n <= replicates; ++n) {
    const std::string stem = "rep" + std::to_string(n);
    text = with(text, "video = \"" + stem + ".mp4\"", "tracks = \"" + stem + ".csv\"");
  }
  text = with(text, "elastic_modulus_gpa = 6.89", "elastic_modulus_mpa = 50");
  return with(text, "frames = 25", "frames = 7");
}

void write_tracks_of_truth(const TemporaryFolder& folder) {
  for (int n = 1; n <= replicates; ++n) {
    const std::string stem = "rep" + std::to_string(n);
    std::ostringstream tracks;
    tracks.precision(10);
    tracks << "time_s,particle,x_m,z_m,angle_rad\n";
    for (const Row& row : read_rows(bundled_micro() / "truth" / (stem + "_tracks.csv"))) {
      tracks << number(row, "time_s") - event_time << ',' << row.at("particle") << ','
             << row.at("x_m") << ',' << row.at("z_m") << ',' << row.at("angle_rad") << '\n';
    }
    folder.write(stem + ".csv", tracks.str());
  }
}

std::string with(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("no such text: " + std::string(from));
  return text.replace(at, from.size(), to);
}

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  EXPECT_TRUE(stream) << file << " cannot be read";
  std::ostringstream content;
  content << stream.rdbuf();
  return std::move(content).str();
}

}  // namespace graintruth::tests
