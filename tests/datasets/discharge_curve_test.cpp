// What a load cell writes.
#include "datasets/imports/discharge_curve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

// 100 particles of 1 g
constexpr DischargeSource source{.full_mass = 0.1, .particle_mass = 1e-3};

std::string complaint_about(const std::filesystem::path& file,
                            const DischargeSource& how = source) {
  try {
    read_discharge_curve(file, how);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(DischargeCurve, IsTheSameInEveryForm) {
  const TemporaryFolder folder;
  const std::string files[] = {
      "time_s,discharged_mass_g\n0,0\n1,20\n2,40\n3,60\n4,80\n",
      "Time (s),Mass (kg)\n0,1.5\n1,1.52\n2,1.54\n3,1.56\n4,1.58\n",  // the tare is 1.5 kg
      "t_ms;remaining_mass_g\n0;100\n1000;80\n2000;60\n3000;40\n4000;20\n",
      "time_s\tdischarged_percent\n0\t0\n1\t20\n2\t40\n3\t60\n4\t80\n"};
  for (const std::string& text : files) {
    const DischargeCurve curve = read_discharge_curve(folder.write("c.csv", text), source);
    ASSERT_EQ(curve.time.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_NEAR(curve.time[i], static_cast<double>(i), 1e-12) << text;
      EXPECT_NEAR(curve.mass[i], 0.02 * static_cast<double>(i), 1e-12) << text;
    }
  }
}

// Noise moves the smoothed curve neither up nor down, as a running maximum would.
TEST(DischargeCurve, NoiseOfTheCellIsSmoothedWithoutBias) {
  const TemporaryFolder folder;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.3);
  std::string text = "time_s,mass_g\n0,0\n";
  constexpr int rows = 2000;
  for (int i = 1; i <= rows; ++i)
    text += fmt::format("{},{}\n", 0.01 * i, 80.0 * i / rows + noise(random));
  const DischargeCurve curve = read_discharge_curve(folder.write("c.csv", text), source);
  EXPECT_TRUE(std::is_sorted(curve.mass.begin(), curve.mass.end()));
  double bias = 0.0;
  for (std::size_t i = 0; i < curve.mass.size(); ++i)
    bias += (curve.mass[i] - 0.08 * static_cast<double>(i) / rows) / static_cast<double>(rows);
  // 0.3 g / sqrt(2000) is 7 mg; the running maximum lies some 0.6 g too high
  EXPECT_NEAR(bias, 0.0, 20e-6);
}

TEST(DischargeCurve, ImpossibleOnesAreRefusedWithTheirLine) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    const std::string sentence = complaint_about(folder.write("c.csv", text));
    for (const std::string& word : words)
      EXPECT_NE(sentence.find(word), std::string::npos) << word << " is not in: " << sentence;
  };
  refused("time_s,mass_g\n0,0\n1,20\n2,40\n3,35\n4,80\n",
          {"c.csv:5:", "'mass_g'", "35 g", "40 g", "cannot fall"});
  refused("time_s,mass_g\n0,0\n1,20\n1,40\n3,45\n4,80\n",
          {"c.csv:4:", "'time_s'", "does not rise"});
  refused("time_s,mass_kg\n0,0\n1,20\n2,40\n3,45\n4,80\n",
          {"c.csv:3:", "weigh 100 g", "unit", "particle.mass_g"});
  refused("time_s,mass_g\n0.5,10\n1,20\n2,40\n3,45\n4,80\n",
          {"c.csv:2:", "0.5 s after", "event_s"});
  refused("time_s,mass_g\n0,0\n1,0\n2,0\n3,0\n4,0\n", {"c.csv", "no mass leaves"});
  refused("time_s,mass_g\n0,0\n1,20\n", {"c.csv", "at least 5 rows"});
  refused("time_s,mass_lb\n0,0\n1,20\n2,40\n3,45\n4,80\n",
          {"c.csv", "mass", "'discharged_mass_kg'"});
  refused("mass_g\n0\n1\n2\n3\n4\n", {"c.csv", "the time", "'time_s'"});
  refused("time_s,mass_g\n0,0\n1,\n2,40\n3,45\n4,80\n", {"c.csv:3:", "'mass_g'", "empty"});
  EXPECT_NE(complaint_about(folder.write("c.csv", "time_s,mass_g\n0,0\n1,2\n2,4\n3,5\n4,8\n"),
                            {.event_time = 9.0, .full_mass = 0.1, .particle_mass = 1e-3})
                .find("event_s"),
            std::string::npos);
}

}  // namespace
}  // namespace graintruth::datasets
