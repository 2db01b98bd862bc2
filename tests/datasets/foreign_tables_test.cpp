// Tables as programs and spreadsheets of many countries save them: what is one table must be read
// as one table, and what cannot be read must be called by its name.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "datasets/imports/column_names.h"
#include "datasets/imports/curve_files.h"
#include "datasets/imports/discharge_curve.h"
#include "datasets/imports/track_files.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"
#include "datasets/store/text_file.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using namespace std::string_literals;
using tests::TemporaryFolder;

template <class Action>
std::string complaint(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

void expect_words(const std::string& sentence, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    EXPECT_NE(sentence.find(word), std::string::npos) << word << " is not in: " << sentence;
  EXPECT_TRUE(sentence.ends_with('.')) << sentence;
}

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  for (std::size_t at = text.find(old); at != std::string::npos;
       at = text.find(old, at + by.size()))
    text.replace(at, old.size(), by);
  return text;
}

// The number in the first row of column x, of a table in this text.
double first_x(const TemporaryFolder& folder, const std::string& text) {
  return read_csv(folder.write("t.csv", text)).number(0, "x");
}

// --- Numbers ---

TEST(ForeignNumbers, AreReadByWhatTheWholeFileSays) {
  const TemporaryFolder folder;
  const std::pair<std::string, double> tables[] = {
      // A decimal comma, which one cell shows for all
      {"x;y\n1,204;0,5\n", 1.204},
      {"x\ty\n1,204\t12,5\n", 1.204},
      {"x\ty\n1,204\t1506,250\n", 1.204},
      {"x;y\n-1,5E-3;1\n", -1.5e-3},
      {"x,y\n\"1,5\",\"2,25\"\n", 1.5},
      // Commas between thousands
      {"x\ty\n1,204\t45.5\n", 1204.0},
      {"x\ty\n1,204\t1,234,567\n", 1204.0},
      {"x,y\n\"1,204.25\",3\n", 1204.25},
      {"x\ty\n-12,345\t0.5\n", -12345.0},
      // Points between thousands
      {"x;y\n1.204;0,5\n", 1204.0},
      {"x;y\n1.204,75;3\n", 1204.75},
      {"x;y\n1.204;1.234.567\n", 1204.0},
      // Blanks and apostrophes between thousands: plain, no-break, thin, narrow; both apostrophes
      {"x;y\n1 204,5;3\n", 1204.5},
      {"x;y\n1\u00a0204,5;3\n", 1204.5},
      {"x\ty\n12\u2009345.5\t3\n", 12345.5},
      {"x\ty\n1\u202f234\u202f567\t3\n", 1234567.0},
      {"x,y\n1'204.5,3\n", 1204.5},
      {"x;y\n1\u2019204.5;3\n", 1204.5},
      // The sign for minus
      {"x;y\n\u22121,5;3\n", -1.5},
      // A decimal point, as ever
      {"x,y\n1.204,998\n", 1.204},
      {"x\ty\n1.204\t0.5\n", 1.204},
      {"x\ty\n1.204\t998\n", 1.204}};
  for (const auto& [text, value] : tables) EXPECT_DOUBLE_EQ(first_x(folder, text), value) << text;
}

// Whole pixels below and above 1000, as spreadsheets show them
std::string whole_pixels(char mark, char separator, int first, int step, int rows) {
  std::string text = fmt::format("n{0}x{0}y\n", separator);
  for (int i = 0; i < rows; ++i) {
    const int x = first + step * i;
    const std::string shown =
        x < 1000 ? std::to_string(x) : fmt::format("{}{}{:03}", x / 1000, mark, x % 1000);
    text += fmt::format("{1}{0}{2}{0}{3}\n", separator, i, shown, 200 + i);
  }
  return text;
}

TEST(ForeignNumbers, WholePixelsHaveNoDecimalMark) {
  const TemporaryFolder folder;
  for (const char mark : {',', '.'}) {
    for (const char separator : {'\t', ';'}) {
      const Table table =
          read_csv(folder.write("t.csv", whole_pixels(mark, separator, 900, 17, 20)));
      for (std::size_t row = 0; row < 20; ++row)
        EXPECT_EQ(table.number(row, "x"), 900.0 + 17.0 * static_cast<double>(row)) << mark;
    }
  }
}

TEST(ForeignNumbers, OfWhichNothingTellsTheMarkAreRefusedWhereTheyAreUsed) {
  const TemporaryFolder folder;
  // 500.125 or 500125 px; 1.204 or 1204; a column where all is above 1000
  for (const std::string text : {"x;y\n500,125;3\n500;4\n499,875;5\n",
                                 "x\ty\n1,204\t3\n998\t4\n",
                                 "x\ty\n1,204\t3\n1,205\t4\n",
                                 "x,y\n\"1,204\",3\n",
                                 "x;y\n1.204;3\n998;4\n"}) {
    const Table table = read_csv(folder.write("t.csv", text));
    expect_words(complaint([&] { table.numbers("x"); }),
                 {"t.csv:2:", "column 'x' holds", "before three digits", "decimal point"});
    EXPECT_EQ(table.number(0, "y"), 3.0);  // has no mark, so nothing is unclear about it
  }
}

TEST(ForeignNumbers, ThatContradictEachOtherAreRefusedWithBothPlaces) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    const Table table = read_csv(folder.write("t.csv", text));
    expect_words(complaint([&] { table.numbers("x"); }), words);
  };
  refused("x;y\n1,5;1\n2,5;1.25\n",
          {"t.csv:2:", "'x'", "'1,5' in line 2", "'1.25' in line 3, column 'y'"});
  refused("x;y\n1,5;1\n1,234,567;1\n", {"'1,5' in line 2", "'1,234,567' in line 3"});
  refused("x\ty\n1.5\t1.234.567\n", {"'1.5'", "'1.234.567' in line 2, column 'y'"});
  refused("x\ty\n1,234,567\t1.234.567\n", {"'1,234,567'", "'1.234.567'"});
}

TEST(ForeignNumbers, ThatAreNoneStayNone) {
  const TemporaryFolder folder;
  for (const char* cell :
       {"1,23,456", "1.2.3", "04.05.2023", "12:30", "1,204.5.6", "1 20", "1e", "--3", "x"}) {
    const Table table = read_csv(folder.write("t.csv", "x;y\n"s + cell + ";0.5\n"));
    expect_words(complaint([&] { table.number(0, "x"); }),
                 {"t.csv:2:", cell, "a number is needed"});
  }
}

TEST(ForeignNumbers, WordsForNothingAreNoValue) {
  const TemporaryFolder folder;
  const Table table = read_csv(folder.write("t.csv", "x,y\nNA,1\n#N/A,1\n,1\nNaN,1\nnull,1\n"));
  for (const double value : table.numbers("x")) EXPECT_TRUE(std::isnan(value));
}

// --- Text ---

std::string utf_16(const std::string& ascii, bool low_byte_first, bool with_mark) {
  std::string wide = !with_mark ? "" : low_byte_first ? "\xff\xfe" : "\xfe\xff";
  for (const char letter : ascii) {
    if (low_byte_first) wide += letter;
    wide += '\0';
    if (!low_byte_first) wide += letter;
  }
  return wide;
}

TEST(ForeignText, IsOneTableInEveryEncodingAndWithEveryLineEnd) {
  const TemporaryFolder folder;
  const std::string plain = "Time (s),Mass (g)\n0,0\n1,20\n2,40\n3,60\n4,80\n";
  const std::string files[] = {
      plain,
      "\xef\xbb\xbf" + plain,
      utf_16(plain, true, true),
      utf_16(plain, true, false),
      utf_16(plain, false, true),
      utf_16(plain, false, false),
      utf_16(replaced(replaced(plain, ",", "\t"), "\n", "\r\n"), true, true),
      replaced(plain, "\n", "\r"),
      replaced(plain, "\n", "\r\n"),
      replaced(plain, "\n", "\r\r\n"),
      replaced(plain, "\n", ",\n"),
      replaced(plain, "\n", ",,\n") + ",,,\n,,,\n\n",
      replaced(plain, "\n", "\n\n"),
      plain + std::string(512, '\0'),
      plain + "4.5,8" + std::string(512, '\0'),
      replaced(replaced(plain, ",", "\",\""), "\n", "\"\n\"") + "\"",
      "sep=,\n" + plain,
      "SEP=;\r\n" + replaced(plain, ",", ";"),
      "\"sep=;\"\n" + replaced(plain, ",", ";"),
      "sep=|\n" + replaced(plain, ",", "|")};
  for (std::string text : files) {
    if (text.ends_with("\n\"\"")) text.resize(text.size() - 2);
    if (text.find("\",\"") != std::string::npos) text.insert(0, "\"");
    const DischargeCurve curve = read_discharge_curve(folder.write("c.csv", text),
                                                      {.full_mass = 0.1, .particle_mass = 1e-3});
    ASSERT_EQ(curve.time.size(), 5U) << text;
    EXPECT_EQ(curve.time[4], 4.0) << text;
    EXPECT_NEAR(curve.mass[4], 0.08, 1e-12) << text;
  }
}

TEST(ForeignText, ZerosAtItsEndAreSaid) {
  const TemporaryFolder folder;
  std::vector<std::string> notes;
  read_curves(
      folder.write("c.csv", "time_s,f_n\n0,1\n1,2\n2,3" + std::string(100, '\0')), 0.0, &notes);
  ASSERT_EQ(notes.size(), 1U);
  expect_words(notes[0], {"c.csv", "100 zero bytes", "the line that they break off"});
  expect_words(complaint([&] { read_csv(folder.write("z.csv", std::string(64, '\0'))); }),
               {"z.csv", "nothing but zero bytes"});
  expect_words(complaint([&] { read_csv(folder.write("m.csv", "a,b\n1,2\n"s + '\0' + "3,4\n")); }),
               {"m.csv:3:", "zero byte"});
}

TEST(ForeignText, SignsForMicroAndDegreesAreReadInLatin1) {
  const TemporaryFolder folder;
  const Table table = read_csv(folder.write("t.csv", "x [\xb5m];Angle (\xb0);ma\xdf\n1,5;90;2\n"));
  EXPECT_EQ(table.columns(), (std::vector<std::string>{"x [µm]", "Angle (°)", "maß"}));
  ASSERT_TRUE(find_column(table, columns::right));
  EXPECT_EQ(find_column(table, columns::right)->unit.in_si, 1e-6);
  ASSERT_TRUE(find_column(table, columns::direction));
  // An apostrophe of Windows
  EXPECT_EQ(first_x(folder,
                    "x;\xb5\n1\x92"
                    "204,5;3\n"),
            1204.5);
}

TEST(ForeignText, WhatIsNoTextIsCalledByItsName) {
  const TemporaryFolder folder;
  const std::pair<std::string, std::vector<std::string>> files[] = {
      {"PK\x03\x04 .. xl/worksheets/sheet1.xml",
       {"Excel workbook (.xlsx)", "save the table as CSV"}},
      {"PK\x03\x04mimetypeapplication/vnd.oasis.opendocument.spreadsheet", {"(.ods)", "CSV"}},
      {"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1 ..", {"old Excel workbook (.xls)", "CSV"}},
      {"PK\x03\x04 tracks.csv", {"a zip archive", "unpack it"}},
      {"\x1f\x8b\x08 ..", {"packed with gzip", "unpack it"}},
      {"%PDF-1.7", {"a PDF", "CSV"}},
      {"\x89HDF\r\n\x1a\n ..", {"HDF5", "CSV"}},
      {"TDSm ..", {".tdms", "CSV"}},
      {"<html><table>", {"web page or XML", "CSV"}},
      {"\xff\xfe\x41\x00\x42"s, {"UTF-16", "broken"}}};
  for (const auto& [content, words] : files) {
    const std::string file = folder.write("t.csv", content);
    expect_words(complaint([&] { read_csv(file); }), words);
  }
}

// --- Headers ---

TEST(ForeignHeaders, AreFoundWhereTheyStand) {
  const TemporaryFolder folder;
  const std::string rows = "0,0\n1,20\n2,40\n3,60\n4,80\n";
  const std::string blank_rows = replaced(rows, ",", " ");
  const std::string german_rows = "0,0;0,0\n1,0;20,0\n2,0;40,0\n3,0;60,0\n4,0;80,0\n";
  const std::pair<std::string, int> files[] = {
      {"# Time (s),Mass (g)\n" + rows, 1},  // np.savetxt
      {"# made on Monday\n# cell 3\n#\n# Time (s),Mass (g)\n" + rows, 4},
      {"# Time (s),Mass (g)\n# made on Monday\n" + rows, 1},
      {"# time_s mass_g\n" + blank_rows, 1},  // its default
      {"time_s mass_g\n" + replaced(rows, ",", "    "), 1},
      {"#time_s\tmass_g\n" + replaced(rows, ",", "\t"), 1},
      {"# free words\ntime_s,mass_g\n# more\n" + rows, 2},
      {"Time,Mass\ns,g\n" + rows, 1},  // units below
      {"Time;Mass\n[s];[g]\n" + replaced(rows, ",", ";"), 1},
      {"Time (s),Mass (g)\ns,g\n" + rows, 1},
      {"time_s,mass_g\ns,g\n" + rows, 1},
      {"\"Time, (s)\";\"Mass, (g)\"\n" + replaced(rows, ",", ";"), 1},
      {"Time, (s);Mass, (g)\n" + german_rows, 1},
      {"% made, on Monday\n% time_s mass_g\n" + replaced(german_rows, ";", " "), 2},
      {"Balance 7\nserial number 12\nTime (s),Mass (g)\n" + rows, 3},  // a preamble
      {"Balance;7;kitchen\n\nTime (s);Mass (g)\n" + replaced(rows, ",", ";"), 3},
      {"\"Time\n(s)\",\"Mass\n(g)\"\n" + rows, 1},                // Alt+Enter
      {"Time (s),,Mass (g),\n" + replaced(rows, ",", ",,"), 1}};  // empty columns
  for (const auto& [text, line] : files) {
    const auto file = folder.write("c.csv", text);
    const DischargeCurve curve =
        read_discharge_curve(file, {.full_mass = 0.1, .particle_mass = 1e-3});
    ASSERT_EQ(curve.time.size(), 5U) << text;
    EXPECT_NEAR(curve.mass[4], 0.08, 1e-12) << text;
    EXPECT_EQ(read_csv(file).header_words(),
              fmt::format(" (line {} was taken for the header)", line))
        << text;
  }
}

TEST(ForeignHeaders, AreNamedWhereAColumnIsMissing) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    const auto file = folder.write("c.csv", text);
    expect_words(complaint([&] { read_discharge_curve(file, {}); }), words);
  };
  refused("0.00,12.5\n0.01,12.5\n",
          {"no column tells the time", "The columns are 0.00, 12.5 (line 1 was"});
  refused("\n\nsecs,grams\n1,2\n", {"line 3 was taken for the header"});
  refused("Time (s),Weight\n0,1\n", {"'Weight' has the name, but no unit", "line 1"});
  refused("Time (s),Mass (lb)\n0,1\n", {"'Mass (lb)' has a unit that is not known", "line 1"});
  refused("Time (s),Mass (g)\n0,\n1,\n", {"'Mass (g)' holds no value", "line 1"});
  const Table table = read_csv(folder / "c.csv");
  expect_words(complaint([&] { table.number(0, "x_m"); }), {"'x_m' is missing", "line 1"});
  expect_words(complaint([&] { read_csv(folder.write("d.csv", "a,b\n1,2\n3\n")); }),
               {"d.csv:3:", "1 cells", "header (line 1) has 2"});
  expect_words(complaint([&] { read_csv(folder.write("d.csv", "a,b\n0,5,1,5\n")); }),
               {"d.csv:2:", "4 cells", "semicolons"});
  expect_words(complaint([&] { read_csv(folder.write("d.csv", "a,b\n\"1,2\n3,4\n")); }),
               {"d.csv:2:", "quotation mark"});
  expect_words(complaint([&] { read_csv(folder.write("d.csv", "sep=x\naxb\n1x2\n")); }),
               {"d.csv:1:", "'x'", "semicolon"});
}

std::string labview(const std::string& fields, const std::string& block, const std::string& rows) {
  return "LabVIEW Measurement\t\nWriter_Version\t2\n" + fields + "***End_of_Header***\t\n\t\n" +
         block + "***End_of_Header***\t\t\n" + rows;
}

TEST(ForeignHeaders, OfLabViewTellSeparatorAndTimes) {
  const TemporaryFolder folder;
  const std::string files[] = {
      labview("Separator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n",
              "Channels\t1\t\nY_Unit_Label\tg\t\nX_Dimension\tTime\t\n",
              "X_Value\tWeight\tComment\n0.0\t0\n0.5\t20\n1.0\t40\n1.5\t60\n2.0\t80\n"),
      labview("Separator\tTab\nDecimal_Separator\t,\nX_Columns\tMulti\n",
              "Channels\t1\t\nX_Dimension\tTime\t\n",
              "X_Value\tWeight (g)\tComment\n0,000\t0,000\tstart\n0,500\t20,000\n1,000\t40,000\n"
              "1,500\t60,000\n2,000\t80,000\n"),
      labview("Separator\tTab\nDecimal_Separator\t,\nX_Columns\tNo\n",
              "Channels\t1\t\nX0\t0,0E+0\t\nDelta_X\t0,5\t\n",
              "X_Value\tWeight (g)\tComment\n\t0\n\t20\n\t40\n\t60\n\t80\n"),
      replaced(labview("Separator\tComma\nDecimal_Separator\t.\nX_Columns\tOne\n",
                       "Channels\t1\t\nY_Unit_Label\tg\t\n",
                       "X_Value\tWeight\tComment\n0\t0\n0.5\t20\n1\t40\n1.5\t60\n2\t80\n"),
               "\t",
               ",")};
  for (const std::string& text : files) {
    const DischargeCurve curve = read_discharge_curve(folder.write("c.lvm", text),
                                                      {.full_mass = 0.1, .particle_mass = 1e-3});
    ASSERT_EQ(curve.time.size(), 5U) << text;
    EXPECT_NEAR(curve.time[3], 1.5, 1e-12) << text;
    EXPECT_NEAR(curve.mass[3], 0.06, 1e-12) << text;
  }
  expect_words(complaint([&] {
                 read_csv(folder.write("two.lvm",
                                       labview("", "", "X_Value\tA\n0\t1\n***End_of_Header***\n")));
               }),
               {"two.lvm:", "second block"});
  expect_words(
      complaint([&] { read_csv(folder.write("cut.lvm", "LabVIEW Measurement\nOperator\tlab\n")); }),
      {"cut.lvm:2:", "breaks off"});
}

// --- Columns without values ---

TEST(ForeignColumns, WithoutAnyValueAreNotThere) {
  const TemporaryFolder folder;
  const TrackSource source{.scale = 1000.0, .origin_px = std::array{0.0, 0.0}, .frame_rate = 50.0};
  // z would be a height, POSITION_X a second x, an angle would be one without a direction
  for (const std::string text : {"y,x,frame,particle,z\n3,2,0,1,\n4,2,1,1,\n",
                                 "y,x,frame,particle,z,angle\n3,2,0,1,nan,\n4,2,1,1,NaN,\n",
                                 "y,x,frame,particle,POSITION_X (mm)\n3,2,0,1,NA\n4,2,1,1,NA\n",
                                 "y,x,frame,particle,time_s,ep\n3,2,0,1,,\n4,2,1,1,,\n",
                                 "y,x,frame,particle,,,\n3,2,0,1,,,\n4,2,1,1,,,\n"}) {
    const Trajectories tracks = read_track_file(folder.write("t.csv", text), source).tracks;
    ASSERT_EQ(tracks.poses.size(), 2U) << text;
    EXPECT_NEAR(tracks.poses[0].x, 0.002, 1e-12) << text;
    EXPECT_NEAR(tracks.poses[1].z, -0.004, 1e-12) << text;
    EXPECT_NEAR(tracks.time[1], 0.02, 1e-12) << text;
    EXPECT_TRUE(tracks.sigmas.empty()) << text;
  }
  const auto curves = read_curves(
      folder.write("c.csv", "time_s,f_n,g_n,f_n_uncertainty\n0,1,,nan\n1,2,,nan\n"), 0.0);
  ASSERT_EQ(curves.size(), 1U);
  EXPECT_TRUE(curves.at("f_n").sigma.empty());
}

// --- Clocks ---

std::string track_of(
    const std::string& header, double step, int frame_step, int rows, bool numbered) {
  std::string text = header + "\n";
  for (int i = 0; i < rows; ++i) {
    text += fmt::format("1,{},{},{:.6f}", 2 + i, 3, step * i);
    text += numbered ? fmt::format(",{}\n", frame_step * i) : "\n";
  }
  return text;
}

TEST(ForeignClocks, ThatContradictTheCameraAreRefused) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text, double camera, std::optional<double> stated = {}) {
    TrackSource source{.scale = 1000.0, .origin_px = std::array{0.0, 0.0}};
    source.usual_frame_rate = camera;
    source.frame_rate = stated;
    return read_track_file(folder.write("t.csv", text), source);
  };
  const std::string with_frames = "particle,x,y,time_s,frame", without = "particle,x,y,time_s";
  // One second a frame; ten times too fast; 25 for 30
  for (const double step : {1.0, 0.002, 0.04}) {
    const std::string text = track_of(with_frames, step, 1, 90, true);
    expect_words(complaint([&] { read(text, 30.0); }),
                 {"t.csv", "'time_s'", "frame_rate_hz is 30"});
    EXPECT_NEAR(read(text, 30.0, 50.0).tracks.time[1], 0.02, 1e-12);  // said of this very file
  }
  for (const double step : {0.002, 0.04})
    expect_words(complaint([&] { read(track_of(without, step, 1, 90, false), 30.0); }),
                 {"t.csv", "'time_s'", "frame_rate_hz is 30"});
  // In agreement: every frame, every fifth, a nominal rate, times that are rounded
  EXPECT_TRUE(read(track_of(with_frames, 1.0 / 30.0, 1, 90, true), 30.0).notes.empty());
  EXPECT_TRUE(read(track_of(with_frames, 5.0 / 30.0, 5, 90, true), 30.0).notes.empty());
  EXPECT_TRUE(read(track_of(with_frames, 1.001 / 30.0, 1, 9000, true), 30.0).notes.empty());
  EXPECT_TRUE(read(track_of(without, 1.0 / 30.0, 1, 90, false), 30.0).notes.empty());
  // What might be either is said
  const auto notes = read(track_of(without, 1.0, 1, 90, false), 30.0).notes;
  ASSERT_EQ(notes.size(), 1U);
  expect_words(notes[0], {"t.csv", "every 30th frame"});
  const auto lonely = read(track_of(with_frames, 1.0, 1, 90, true), 0.0).notes;
  ASSERT_EQ(lonely.size(), 1U);
  expect_words(lonely[0], {"t.csv", "one frame a second", "frame_rate_hz"});
}

}  // namespace
}  // namespace graintruth::datasets
