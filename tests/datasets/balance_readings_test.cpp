// What balances write beside the mass: odd readings, noise, drift, readings that are stuck. In
// every case 24 of 30 particles of 0.332 g leave at 22 g/s, which was put in, and is found.
#include "datasets/imports/balance_readings.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "datasets/imports/discharge_curve.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

constexpr double particle_mass = 0.332, all = 30 * particle_mass, leaves = 24 * particle_mass;  // g
constexpr double rate = 22.0;  // g/s

struct Cell {
  double rest = 0.5;       // s before the event
  double after = 1.0;      // s
  double interval = 0.01;  // s
  double noise = 0.02;     // g
  double level = 12.5;     // g, before anything leaves
  unsigned seed = 7;
  // What the cell makes of what it should read: g of a reading with this number and time
  std::function<double(int number, double time, double reading)> faulty = {};
};

// Rows in grams, with the event at 0.
std::string table_of(const Cell& cell, const std::string& header = "Time (s),Mass (g)\n") {
  std::mt19937 random(cell.seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::string text = header;
  const int rows = static_cast<int>(std::lround((cell.rest + cell.after) / cell.interval));
  for (int i = 0; i <= rows; ++i) {
    const double time = -cell.rest + i * cell.interval;
    double reading = cell.level + std::clamp(rate * (time - 0.05), 0.0, leaves);
    reading += cell.noise * noise(random);
    if (cell.faulty) reading = cell.faulty(i, time, reading);
    text += fmt::format("{:.4f},{:.4f}\n", time, reading);
  }
  return text;
}

class Balance : public testing::Test {
 protected:
  DischargeCurve read(const std::string& text) {
    notes_.clear();
    return read_discharge_curve(folder_.write("cell.csv", text),
                                {.full_mass = 1e-3 * all, .particle_mass = 1e-3 * particle_mass},
                                &notes_);
  }
  std::string complaint_about(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  // Within a third of a particle, and when half of it has left within 10 ms.
  void expect_truth(const std::string& text, double allowed = particle_mass / 3.0) {
    const DischargeCurve curve = read(text);
    EXPECT_NEAR(1e3 * curve.mass.back(), leaves, allowed);
    const auto half = static_cast<std::size_t>(
        std::lower_bound(curve.mass.begin(), curve.mass.end(), 0.5e-3 * leaves) -
        curve.mass.begin());
    ASSERT_GT(half, 0U);
    ASSERT_LT(half, curve.mass.size());
    const double share =
        (0.5e-3 * leaves - curve.mass[half - 1]) / (curve.mass[half] - curve.mass[half - 1]);
    EXPECT_NEAR(
        std::lerp(curve.time[half - 1], curve.time[half], share), 0.05 + 0.5 * leaves / rate, 0.02);
    EXPECT_TRUE(std::is_sorted(curve.mass.begin(), curve.mass.end()));
  }
  void expect_note(const std::vector<std::string>& parts) {
    for (const std::string& note : notes_) {
      if (std::all_of(parts.begin(), parts.end(), [&](const std::string& part) {
            return note.find(part) != std::string::npos;
          }))
        return;
    }
    std::string heard;
    for (const std::string& note : notes_) heard += note + "\n";
    FAIL() << parts.front() << " is not in any of: " << heard;
  }
  void expect_complaint(const std::string& text, const std::vector<std::string>& parts) {
    const std::string sentence = complaint_about(text);
    for (const std::string& part : parts)
      EXPECT_NE(sentence.find(part), std::string::npos) << part << " is not in: " << sentence;
  }

  TemporaryFolder folder_;
  std::vector<std::string> notes_;
};

TEST_F(Balance, OfAGoodCellNothingIsSaid) {
  expect_truth(table_of({}));
  EXPECT_TRUE(notes_.empty()) << notes_.front();
  expect_truth(table_of({.noise = 0.0}));
  EXPECT_TRUE(notes_.empty()) << notes_.front();
}

// --- Tare

TEST_F(Balance, OddReadingsBeforeTheEventDoNotMoveTheTare) {
  const std::vector<std::function<double(int, double, double)>> faults = {
      [](int i, double, double reading) { return reading - (i == 0 ? 0.9 : 0.0); },
      [](int i, double, double reading) { return reading + (i == 0 ? 0.9 : 0.0); },
      // Three in the middle, the last before the event, and a cell that warms up
      [](int i, double, double reading) { return reading + (i >= 20 && i < 23 ? 5.0 : 0.0); },
      [](int i, double, double reading) { return reading - (i == 50 ? 4.0 : 0.0); },
      [](int i, double, double reading) { return reading + (i < 15 ? 3.0 - 0.2 * i : 0.0); }};
  for (const auto& fault : faults) {
    expect_truth(table_of({.faulty = fault}));
    expect_note({"cell.csv: ", "'Mass (g)'", "the first in line"});
  }
}

// --- Noise and mass that returns

TEST_F(Balance, NoiseIsNoReturnOfMass) {
  for (const double noise : {0.03, 0.06, 0.1}) {
    for (const double rest : {0.5, 5.0, 60.0}) {
      for (const unsigned seed : {1U, 2U, 3U}) {
        const Cell cell{.rest = rest, .after = 3.0, .noise = noise, .seed = seed};
        expect_truth(table_of(cell), particle_mass);
      }
    }
  }
}

TEST_F(Balance, MassThatReturnsIsRefusedWhateverTheNoise) {
  for (const double noise : {0.0, 0.03, 0.1}) {
    // Emptied, touched for a while, set to zero
    expect_complaint(
        table_of(
            {.noise = noise, .faulty = [](int, double t, double r) { return t > 0.7 ? 12.5 : r; }}),
        {"cell.csv:", "'Mass (g)'", "cannot fall"});
    expect_complaint(
        table_of(
            {.noise = noise,
             .faulty = [](int, double t, double r) { return t > 0.6 && t < 0.8 ? r - 2.0 : r; }}),
        {"cell.csv:", "'Mass (g)'", "cannot fall"});
    expect_complaint(
        table_of({.noise = noise,
                  .faulty = [](int, double t, double r) { return t > 0.2 ? r - 4.0 : r; }}),
        {"cell.csv:", "'Mass (g)'"});
  }
}

// --- Drift

TEST_F(Balance, DriftIsTakenOutAndTold) {
  for (const double drift : {0.2, -0.2, 1.0}) {  // g/s
    const auto drifts = [drift](int, double t, double r) { return r + drift * t; };
    expect_truth(table_of({.rest = 4.0, .faulty = drifts}));
    expect_note({"drifts by", "g/s", "out of the whole curve"});
    // Of a rest that is shorter than what follows too, where it is known well enough
    expect_truth(table_of({.rest = 2.0, .after = 6.0, .faulty = drifts}));
    expect_note({"drifts by", "out of the whole curve"});
  }
  // Else the tare is still that of the event, not that of the middle of the rest, which is 0.6 g
  // off
  const DischargeCurve curve = read(
      table_of({.rest = 0.4, .after = 0.5, .noise = 0.15, .faulty = [](int, double t, double r) {
                  return r + 3.0 * t;
                }}));
  expect_note({"drifts by", "up to the event only"});
  const auto early = std::lower_bound(curve.time.begin(), curve.time.end(), 0.02);
  EXPECT_NEAR(1e3 * curve.mass[static_cast<std::size_t>(early - curve.time.begin())], 0.0, 0.3);
  // None is seen in what is chance, or made of a step
  read(table_of({.rest = 4.0, .noise = 0.1}));
  EXPECT_TRUE(notes_.empty()) << notes_.front();
}

// --- Spikes and readings that are stuck or missing

TEST_F(Balance, SpikesAreLeftOutAndTold) {
  const std::vector<std::function<double(int, double, double)>> faults = {
      [](int i, double, double r) { return i == 70 ? 8388.607 : r; },   // in the flow
      [](int i, double, double r) { return i == 70 ? -8388.608 : r; },  // and downwards
      [](int i, double, double r) { return i == 120 || i == 121 ? r + 2.0 : r; },
      [](int i, double, double r) { return i == 120 ? 0.0 : r; },
      [](int i, double, double r) { return i == 150 ? r + 3.0 : r; }};  // the last one
  for (const double noise : {0.0, 0.02}) {
    for (const auto& fault : faults) {
      expect_truth(table_of({.noise = noise, .faulty = fault}));
      expect_note({"stand out from their neighbours", "the first in line", "left out"});
    }
  }
  expect_complaint(
      table_of({.faulty = [](int i, double, double r) { return i % 8 == 0 ? 500.0 : r; }}),
      {"cell.csv: ", "stand out", "the cell and its cable"});
}

TEST_F(Balance, StuckReadingsAreLeftOutAndTold) {
  // Over a fifth of a second of the flow, with the true readings before and after
  for (const double noise : {0.0, 0.02}) {
    expect_truth(table_of({.noise = noise, .faulty = [](int i, double, double r) {
                             return i >= 62 && i < 82 ? 12.5 + rate * 0.065 : r;
                           }}));
    expect_note({"is stuck at 13.93", "from line 64 to line 83", "a step of", "left out"});
  }
  // To the end, where the noise at rest tells
  const DischargeCurve curve =
      read(table_of({.faulty = [](int i, double, double r) { return i >= 70 ? 15.3 : r; }}));
  expect_note({"is stuck at 15.3", "not known"});
  EXPECT_LT(curve.time.back(), 0.25);
  // A display of 0.1 g that flickers at rest, and shows one value after the flow
  expect_truth(table_of({.after = 3.0, .level = 12.55, .faulty = [](int, double t, double r) {
                           return t > 0.5 ? 20.5 : 0.1 * std::round(10.0 * r);
                         }}));
  EXPECT_TRUE(notes_.empty()) << notes_.front();
  // A bed that stands still under an arch for 0.3 s goes on at its own pace
  for (const double noise : {0.0, 0.02}) {
    const DischargeCurve arch =
        read(table_of({.noise = noise, .faulty = [](int, double t, double r) {
                         const double flowing = std::min(t, 0.2) + std::max(0.0, t - 0.5);
                         const double left = std::clamp(rate * (flowing - 0.05), 0.0, leaves);
                         return r - std::clamp(rate * (t - 0.05), 0.0, leaves) + left;
                       }}));
    EXPECT_NEAR(1e3 * arch.mass.back(), leaves, particle_mass / 3.0);
    EXPECT_TRUE(notes_.empty()) << notes_.front();
  }
}

TEST_F(Balance, AMissingReadingIsRefusedWithItsLine) {
  for (const char* cell : {"", "nan", "inf"}) {
    std::string text = table_of({.noise = 0.0});
    const std::size_t at = text.find("-0.4000,") + 8;
    text.replace(at, text.find('\n', at) - at, cell);
    expect_complaint(text, {"cell.csv:12: ", "'Mass (g)'", "is empty"});
  }
}

// --- What the column tells

TEST_F(Balance, MassThatRemainsIsToldFromMassThatHasLeft) {
  const auto mirrored = [](int, double, double r) { return 40.0 - r; };
  for (const double noise : {0.0, 0.02, 0.1}) {
    // Also below 0: the cell was set to zero with the bin full
    for (const double level : {12.5, 40.0, 52.5}) {
      const Cell cell{.noise = noise, .level = level, .faulty = mirrored};
      expect_truth(table_of(cell, "time_s,remaining_mass_g\n"), particle_mass);
      expect_complaint(table_of(cell), {"cell.csv: ", "'Mass (g)' falls by", "remaining_mass_g"});
    }
    expect_complaint(table_of({.noise = noise}, "time_s,remaining_mass_g\n"),
                     {"cell.csv: ", "'remaining_mass_g' rises by", "discharged_mass_g"});
  }
}

TEST_F(Balance, UnitsAreThoseOfTheHeader) {
  const auto times = [](double factor) {
    return [factor](int, double, double r) { return factor * r; };
  };
  expect_truth(table_of({.faulty = times(1000.0)}, "time_s,mass_mg\n"));
  expect_truth(table_of({}, "t (s),Load (g)\n"));
  // A cell in newtons, with more decimals than the other tables have
  std::string text = "time_s,load_n\n";
  for (int i = 0; i <= 100; ++i) {
    const double time = 0.01 * (i - 20);
    text += fmt::format("{},{}\n", time, 9.81e-3 * std::clamp(rate * time, 0.0, leaves));
  }
  const DischargeCurve curve = read(text);
  EXPECT_NEAR(1e3 * curve.mass.back(), leaves, 1e-9);
  expect_complaint(table_of({}, "time_s,mass_kg\n"), {"cell.csv:", "weigh 9.96 g", "unit"});
  expect_complaint(table_of({}, "time_s,mass_mg\n"), {"cell.csv: no mass leaves", "0.332 g"});
  expect_complaint(table_of({}, "time_s,mass_lb\n"), {"cell.csv: ", "'discharged_mass_kg'"});
}

// --- Time

TEST_F(Balance, TimesThatDoNotRiseAreRefusedWithTheirLine) {
  for (const char* again : {"-0.4100", "-0.5000", "-0.4500"}) {
    std::string text = table_of({});
    text.replace(text.find("-0.4000,"), 7, again);
    expect_complaint(text, {"cell.csv:12: ", "'Time (s)' does not rise", again});
  }
}

TEST_F(Balance, FlowBeforeTheStatedEventIsTold) {
  const auto early = [](int, double t, double) {
    return 12.5 + std::clamp(rate * (t + 0.2), 0.0, leaves);
  };
  const DischargeCurve curve = read(table_of({.faulty = early}));
  EXPECT_NEAR(1e3 * curve.mass.back(), leaves, 1e-6);
  expect_note({"4.4 g have left before the start event", "correct event_s"});
}

// Flow all along is no drift.
TEST_F(Balance, FlowThroughTheStatedEventIsNoDrift) {
  for (const double speed : {5.0, 10.0, -5.0}) {  // g/s
    const auto flows = [speed](int, double t, double) { return 12.5 + speed * t; };
    const std::string text = table_of({.rest = 0.5, .after = 0.4, .faulty = flows});
    if (speed < 0.0) {
      expect_complaint(text, {"cell.csv: ", "'Mass (g)' falls by", "remaining_mass_g"});
      continue;
    }
    read(text);
    expect_note({"have left before the start event", "correct event_s"});
    for (const std::string& note : notes_) EXPECT_EQ(note.find("drift"), std::string::npos) << note;
  }
}

}  // namespace
}  // namespace graintruth::datasets
