// A thousand scenes and decks with a slip of the pen: each is run or refused in one sentence.
#include <gtest/gtest.h>

#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <cmath>
#include <sstream>

#include "calibrate/engines/scene_run.h"
#include "datasets/store/input_error.h"
#include "tests/app/laboratory.h"
#include "tests/app/small_scene.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::app {
namespace {

using tests::content_of;
using tests::TemporaryFolder;

// Seeded; the small bias of a modulus does not matter here.
class Slips {
 public:
  explicit Slips(std::uint64_t seed) : generator_(seed) {}

  std::size_t below(std::size_t count) { return count > 0 ? generator_() % count : 0; }

  std::string applied_to(std::string text) {
    const std::size_t slips = 1 + below(3);
    for (std::size_t i = 0; i < slips; ++i) text = slip(std::move(text));
    return text;
  }

 private:
  std::string slip(std::string text) {
    switch (below(7)) {
      case 0:
      case 1:
      case 2:
        return other_number(std::move(text));
      case 3:
        return without_line(text);
      case 4:
        return text.insert(below(text.size() + 1), 1, static_cast<char>(32 + below(95)));
      case 5:
        return text.empty() ? text : text.erase(below(text.size()), 1 + below(3));
      default:
        return below(4) == 0 ? text.substr(0, below(text.size() + 1)) : twice_a_line(text);
    }
  }

  std::string other_number(std::string text) {
    static constexpr std::array numbers = {"0",
                                           "-1",
                                           "1e9",
                                           "1e-9",
                                           "nan",
                                           "inf",
                                           "-inf",
                                           "1e300",
                                           "\"x\"",
                                           "3",
                                           "0.5",
                                           "-0.001",
                                           "[]",
                                           "true"};
    std::vector<std::size_t> starts;
    for (std::size_t i = 1; i < text.size(); ++i) {
      const bool is_digit = std::isdigit(static_cast<unsigned char>(text[i])) != 0;
      if (is_digit && std::string_view(" [,-").find(text[i - 1]) != std::string_view::npos) {
        starts.push_back(i);
      }
    }
    if (starts.empty()) return text;
    const std::size_t from = starts[below(starts.size())];
    std::size_t to = from;
    while (to < text.size() &&
           std::string_view("0123456789.e+-").find(text[to]) != std::string_view::npos) {
      ++to;
    }
    return text.replace(from, to - from, numbers[below(numbers.size())]);
  }

  std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }
  static std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
  }
  std::string without_line(const std::string& text) {
    std::vector<std::string> lines = lines_of(text);
    if (!lines.empty()) lines.erase(lines.begin() + static_cast<long>(below(lines.size())));
    return joined(lines);
  }
  std::string twice_a_line(const std::string& text) {
    std::vector<std::string> lines = lines_of(text);
    if (lines.empty()) return text;
    const std::string line = lines[below(lines.size())];
    lines.insert(lines.begin() + static_cast<long>(below(lines.size())), line);
    return joined(lines);
  }

  boost::random::mt19937_64 generator_;
};

struct Pages {
  std::string name, text, beside;
};

constexpr const char* deck_text =
    "START 40.0 20.0 40.0 500 18 4 2 10\nFOUR PAIRS ON TWO BELTS\nBOT 20.0 10.0 1.0 18.0 10.0\n"
    "RAD 1.0 1\nRAD 1.5 2\nPRO 1.0 0.5\nDENS 2.0\nFRIC 0.0 0.1\nFRAC 1.0\nDAMP 0.0 0.5\n"
    "GRA 0.0 0.0 -9.81\nCYC 1000 1 10\nFRIC 0.3 0.4\nMOV 25.0 -20.0\nCYC 2000 10 10\nSTOP\n";
constexpr const char* beside_text =
    "elastic_modulus_mpa = 100\npoisson_ratio = 0.3\nwalls = \"rigid\"\ndimensions = 3\n"
    "length_unit = \"cm\"\nspeed_unit = \"cm_per_s\"\ndensity_unit = \"g_per_cm3\"\n"
    "acceleration_unit = \"m_per_s2\"\nmoving = \"upper_lower\"\norifice = \"open\"\n";

std::vector<Pages> originals() {
  std::vector<Pages> all = {{"deck", deck_text, beside_text}, {"small", tests::small_scene(), ""}};
  const std::filesystem::path scenes =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/scenes";
  for (const char* name : {"micro_rig",
                           "macro_bin",
                           "shape_study_bed",
                           "conveyor",
                           "rotating_disk",
                           "mesh_hopper",
                           "box_3d"}) {
    all.push_back({name, content_of(scenes / (std::string(name) + ".toml")), ""});
  }
  return all;
}

void expect_finite(const calibrate::SceneRun& run, const std::string& name) {
  for (const sim::Body& body : run.scene.bodies) {
    ASSERT_TRUE(body.position.allFinite() && body.velocity.allFinite() &&
                body.orientation.coeffs().allFinite())
        << name;
  }
  for (const calibrate::SceneFrame& frame : run.frames) {
    ASSERT_TRUE(std::isfinite(frame.energy.total())) << name;
  }
}

TEST(SceneFuzz, EveryFileIsRunOrRefusedInOneSentence) {
  const TemporaryFolder folder;
  const std::vector<Pages> pages = originals();
  folder.write(
      "hopper.stl",
      content_of(std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/scenes/hopper.stl"));
  int run_count = 0, refused = 0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    Slips slips(seed);
    const Pages& page = pages[seed % pages.size()];
    const std::string name = page.name + ", seed " + std::to_string(seed);
    const bool is_deck = !page.beside.empty();
    const bool in_beside = is_deck && slips.below(3) == 0;
    if (is_deck) folder.write("f.toml", in_beside ? slips.applied_to(page.beside) : page.beside);
    const auto file = folder.write(is_deck ? "f.txt" : "g.toml",
                                   in_beside ? page.text : slips.applied_to(page.text));
    try {
      expect_finite(
          calibrate::run_scene(datasets::load_scene(file), {.seed = seed, .step_limit = 2}), name);
      ++run_count;
    } catch (const datasets::InputError& error) {
      const std::string sentence = error.what();
      EXPECT_EQ(sentence.find('\n'), std::string::npos) << name << ": " << sentence;
      EXPECT_TRUE(sentence.ends_with('.') || sentence.ends_with('?')) << name << ": " << sentence;
      EXPECT_GT(sentence.size(), 20u) << name;
      ++refused;
    }
    ASSERT_FALSE(HasFatalFailure());
  }
  // Neither does the door refuse everything, nor is nothing wrong
  EXPECT_GT(run_count, 100);
  EXPECT_GT(refused, 300);
}

}  // namespace
}  // namespace graintruth::app
