// Tracks as other programs write them: small files of each form, all of the same two particles,
// that must come out as the same trajectories.
#include "datasets/imports/track_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

// The picture: 10 px a millimetre, the rig's origin at column 100 and row 80, 50 frames a second,
// the event in frame 1. One particle stays at (10, 5) mm, the other falls from (-2, 3) mm by 1 mm a
// frame.
TrackSource picture() {
  return {.scale = 10000.0,
          .origin_px = std::array{100.0, 80.0},
          .usual_frame_rate = 50.0,
          .event_time = 0.02};
}

void expect_the_two(const ReadTracks& read) {
  const Trajectories& tracks = read.tracks;
  EXPECT_FALSE(read.numbered_by_place);
  ASSERT_EQ(tracks.particles, 2);
  ASSERT_EQ(tracks.frames(), 3U);
  for (std::size_t frame = 0; frame < 3; ++frame) {
    EXPECT_NEAR(tracks.time[frame], 0.02 * static_cast<double>(frame) - 0.02, 1e-12);
    const Pose& still = tracks.poses[tracks.index(frame, 0)];
    EXPECT_NEAR(still.x, 0.010, 1e-12);
    EXPECT_NEAR(still.z, 0.005, 1e-12);
    const Pose& falling = tracks.poses[tracks.index(frame, 1)];
    EXPECT_NEAR(falling.x, -0.002, 1e-12);
    EXPECT_NEAR(falling.z, 0.003 - 0.001 * static_cast<double>(frame), 1e-12);
  }
}

std::string complaint_about(const std::filesystem::path& file, const TrackSource& source) {
  try {
    read_track_file(file, source);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void expect_words(const std::string& sentence, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    EXPECT_NE(sentence.find(word), std::string::npos) << word << " is not in: " << sentence;
}

// trackpy.link(...).to_csv(index=False): y before x, frames from 0, particles from 0, no unit
constexpr const char* trackpy =
    "y,x,mass,size,ecc,signal,raw_mass,ep,frame,particle\n"
    "30,200,99,2.1,0.1,9,900,0.1,0,0\n50,80,99,2.1,0.1,9,900,0.2,0,1\n"
    "30,200,99,2.1,0.1,9,900,0.1,1,0\n60,80,99,2.1,0.1,9,900,0.2,1,1\n"
    "30,200,99,2.1,0.1,9,900,0.1,2,0\n70,80,99,2.1,0.1,9,900,0.2,2,1\n";

TEST(TrackFile, OfTrackpyIsReadWithItsErrors) {
  const TemporaryFolder folder;
  const ReadTracks read = read_track_file(folder.write("t.csv", trackpy), picture());
  expect_the_two(read);
  ASSERT_EQ(read.tracks.sigmas.size(), 6U);
  EXPECT_NEAR(read.tracks.sigmas[1].x, 0.2e-4, 1e-12);
  EXPECT_NEAR(read.tracks.sigmas[1].z, 0.2e-4, 1e-12);
  EXPECT_TRUE(std::isnan(read.tracks.poses[0].angle));
}

// A microscope's calibration has been told to TrackMate: positions in mm, times in s. One spot is
// in no track.
constexpr const char* trackmate =
    "LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME,RADIUS,ELLIPSE_"
    "THETA\n"
    "Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,Radius,Ellipse angle\n"
    "Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,R,El. angle\n"
    ",,,(quality),(mm),(mm),(mm),(sec),,(mm),(radians)\n"
    "ID7,7,2,9.1,20,3,0,0,0,0.6,0.25\nID8,8,5,9.1,8,5,0,0,0,0.6,0\nID3,3,,9.1,1,1,0,0,0,0.6,0\n"
    "ID9,9,2,9.1,20,3,0,0.02,1,0.6,0.25\nID11,11,5,9.1,8,6,0,0.02,1,0.6,0\n"
    "ID12,12,2,9.1,20,3,0,0.04,2,0.6,0.25\nID13,13,5,9.1,8,7,0,0.04,2,0.6,0\n";

TEST(TrackFile, OfTrackMatesSpotsHasItsUnitsInTheFourthRow) {
  const TemporaryFolder folder;
  const ReadTracks read = read_track_file(folder.write("t.csv", trackmate),
                                          {.origin = std::array{0.010, 0.008}, .event_time = 0.02});
  expect_the_two(read);
  // Its angle turns with its own axes: clockwise as one sees it, because y points down.
  EXPECT_NEAR(read.tracks.poses[0].angle, -0.25, 1e-12);
}

std::string trackmate_in(const std::string& unit, const std::string& clock) {
  std::string text = trackmate;
  for (std::size_t at = text.find("(mm)"); at != std::string::npos; at = text.find("(mm)", at + 1))
    text.replace(at, 4, unit);
  return text.replace(text.find("(sec)"), 5, clock);
}

TEST(TrackFile, OfTrackMateWithoutACalibrationCountsPixelsAndFrames) {
  const TemporaryFolder folder;
  TrackSource source = picture();
  source.scale = 1000.0;  // the numbers above, taken for pixels
  source.origin_px = std::array{10.0, 8.0};
  expect_the_two(
      read_track_file(folder.write("t.csv", trackmate_in("(pixel)", "(frame)")), source));
}

TEST(TrackFile, SignForMicroIsNoMetre) {
  const TemporaryFolder folder;
  const ReadTracks read = read_track_file(folder.write("t.csv", trackmate_in("(\u00b5m)", "(sec)")),
                                          {.event_time = 0.02});
  EXPECT_NEAR(read.tracks.poses[0].x, 20e-6, 1e-15);
  expect_words(complaint_about(folder.write("u.csv", trackmate_in("(furlong)", "(sec)")), {}),
               {"u.csv", "POSITION_X (furlong)", "unit", "'x_mm'"});
}

std::string xml(const std::string& head, const std::string& body) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Tracks " + head + ">\n" + body +
         "</Tracks>\n";
}

constexpr const char* detections =
    "<particle nSpots=\"3\">\n<detection t=\"0\" x=\"200\" y=\"30\" z=\"0.0\" />\n"
    "<detection t=\"1\" x=\"200\" y=\"30\" z=\"0.0\" />\n"
    "<detection t=\"2\" x=\"200\" y=\"30\" z=\"0.0\" />\n</particle>\n"
    "<particle nSpots=\"3\">\n<detection t=\"0\" x=\"80\" y=\"50\" z=\"0.0\" />\n"
    "<detection t=\"1\" x=\"80\" y=\"60\" z=\"0.0\" />\n"
    "<detection t=\"2\" x=\"80\" y=\"70\" z=\"0.0\" />\n</particle>\n";

TEST(TrackFile, OfTrackMatesXmlTellsItsUnitsItself) {
  const TemporaryFolder folder;
  const std::string head =
      "nTracks=\"2\" spaceUnits=\"pixel\" frameInterval=\"0.02\" timeUnits=\"sec\"";
  TrackSource source = picture();
  expect_the_two(read_track_file(folder.write("t.xml", xml(head, detections)), source));
  source.usual_frame_rate = 7.0;  // the camera's: one of the two is wrong
  expect_words(complaint_about(folder / "t.xml", source),
               {"t.xml", "50 frames a second", "frame_rate_hz is 7"});
  // What the laboratory says of this very file counts more: a film in slow motion.
  source.frame_rate = 100.0;
  source.event_time = 0.01;
  EXPECT_NEAR(read_track_file(folder / "t.xml", source).tracks.time[2], 0.01, 1e-12);
}

TEST(TrackFile, XmlOfAnotherKindIsRefusedWithItsLine) {
  const TemporaryFolder folder;
  expect_words(
      complaint_about(folder.write("a.xml", "<?xml version=\"1.0\"?>\n<TrackMate/>\n"), {}),
      {"a.xml:2:", "<Tracks>", "Export tracks to XML"});
  expect_words(complaint_about(folder.write("b.xml", "<Tracks>\n<particle>\n"), {}),
               {"b.xml:", "no XML"});
  const std::string head = "spaceUnits=\"mm\" frameInterval=\"1\" timeUnits=\"sec\"";
  expect_words(complaint_about(folder.write("c.xml", xml(head, "")), {}),
               {"c.xml:2:", "no tracks"});
  expect_words(complaint_about(folder.write("d.xml", xml("spaceUnits=\"cubit\"", detections)), {}),
               {"d.xml:2:", "spaceUnits is 'cubit'", "micron"});
  expect_words(
      complaint_about(
          folder.write("e.xml", xml(head, "<particle>\n<detection t=\"0\" x=\"1\"/>\n</particle>")),
          {}),
      {"e.xml:4:", "no attribute 'y'"});
  const std::string whole = xml(head, detections);
  for (const std::size_t share : {2U, 3U, 5U})  // broken off
    expect_words(
        complaint_about(folder.write("f.xml", whole.substr(0, whole.size() * share / 6)), {}),
        {"f.xml:", "no XML", "broken off"});
  expect_words(complaint_about(folder.write("g.xml",
                                            "<!DOCTYPE Tracks [<!ENTITY a \"ha\"><!ENTITY b "
                                            "\"&a;&a;&a;&a;\">]>\n<Tracks>&b;</Tracks>\n"),
                               {}),
               {"g.xml:1:", "entities"});
  expect_words(
      complaint_about(folder.write("h.xml", xml(head, "<particle><detection></particle>")), {}),
      {"h.xml:3:", "no XML"});
  expect_words(complaint_about(folder.write("i.xml", ""), {}), {"i.xml", "no XML"});
  expect_words(
      complaint_about(folder.write("j.xml",
                                   xml(head,
                                       "<particle>\n<detection t=\"0\" x=\"left\" y=\"1\"/>\n"
                                       "</particle>")),
                      {}),
      {"j.xml:4:", "'left'"});
  // By its content, whatever it is called, and in UTF-16
  TrackSource source = picture();
  const std::string pixels =
      xml("spaceUnits=\"pixel\" frameInterval=\"0.02\" timeUnits=\"sec\"", detections);
  expect_the_two(read_track_file(folder.write("named.csv", pixels), source));
  std::string wide = "\xff\xfe";
  for (const char letter : pixels) (wide += letter) += '\0';
  expect_the_two(read_track_file(folder.write("wide.xml", wide), source));
}

// Tab-separated, with the degree sign in Latin-1, and slices from 1
TEST(TrackFile, OfImageJsManualTracking) {
  const TemporaryFolder folder;
  expect_the_two(read_track_file(
      folder.write("t.xls",
                   " \tTrack n\xb0\tSlice n\xb0\tX\tY\tDistance\tVelocity\tPixel Value\n"
                   "1\t1\t1\t200\t30\t-1\t-1\t9\n2\t1\t2\t200\t30\t0\t0\t9\n"
                   "3\t1\t3\t200\t30\t0\t0\t9\n4\t2\t1\t80\t50\t-1\t-1\t9\n"
                   "5\t2\t2\t80\t60\t10\t1\t9\n6\t2\t3\t80\t70\t10\t1\t9\n"),
      picture()));
}

TEST(TrackFile, OfMTrackJsPoints) {
  const TemporaryFolder folder;
  expect_the_two(
      read_track_file(folder.write("t.csv",
                                   "Nr,TID,PID,x [pixel],y [pixel],t [sec],I [val]\n"
                                   "1,1,1,200,30,0.00,9\n2,1,2,200,30,0.02,9\n3,1,3,200,30,0.04,9\n"
                                   "4,2,1,80,50,0.00,9\n5,2,2,80,60,0.02,9\n6,2,3,80,70,0.04,9\n"),
                      picture()));
}

// ImageJ's own table of results: an angle in degrees, counter-clockwise as one sees the picture. A
// German spreadsheet has been over it.
TEST(TrackFile, OfImageJsResultsFromASpreadsheet) {
  const TemporaryFolder folder;
  const ReadTracks read =
      read_track_file(folder.write("t.csv",
                                   " ;Track;Frame;X;Y;Angle\n"
                                   "1;1;0;200,0;30,0;90,0\n2;2;0;80,0;50,0;45,5\n"
                                   "3;1;1;200;30;90\n4;2;1;80;60;45,5\n"
                                   "5;1;2;200;30;90\n6;2;2;80;70;45,5\n"),
                      picture());
  expect_the_two(read);
  EXPECT_NEAR(read.tracks.poses[0].angle, std::numbers::pi / 2.0, 1e-12);
  EXPECT_NEAR(read.tracks.poses[1].angle, 45.5 * std::numbers::pi / 180.0, 1e-12);
}

TEST(TrackFile, TakesYUpwardsWhereTheLaboratorySaysSo) {
  const TemporaryFolder folder;
  TrackSource source = picture();
  source.y_is_up = true;
  const auto read = read_track_file(folder.write("t.csv", trackpy), source);
  EXPECT_NEAR(read.tracks.poses[0].z, -0.005, 1e-12);
}

TEST(TrackFile, AsksForWhatPixelsDoNotTell) {
  const TemporaryFolder folder;
  const auto file = folder.write("t.csv", trackpy);
  TrackSource source = picture();
  source.scale.reset();
  expect_words(complaint_about(file, source), {"t.csv", "'x'", "pixels", "scale_px_per_mm"});
  source = picture();
  source.origin_px.reset();
  expect_words(complaint_about(file, source), {"t.csv", "origin_px = [x, y]"});
  source = picture();
  source.usual_frame_rate = 0.0;
  expect_words(complaint_about(file, source), {"t.csv", "'frame'", "frame_rate_hz"});
  source = picture();
  source.origin_px.reset();
  expect_words(complaint_about(folder.write("m.csv", trackmate), source),
               {"m.csv", "not in pixels", "leave out scale_px_per_mm"});
}

TEST(TrackFile, UnusableOnesAreRefusedWithTheirLine) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    expect_words(complaint_about(folder.write("t.csv", text), picture()), words);
  };
  refused(std::string(trackpy) + "31,201,99,2.1,0.1,9,900,0.1,2,0\n",
          {"t.csv:8:", "particle 0", "second time", "line 6"});
  refused("y,x,frame,particle\n", {"t.csv", "no rows"});
  refused("y,x,frame\n1,1,1\n", {"t.csv", "which particle", "'particle'", "track_id"});
  refused("y,frame,particle\n1,1,1\n", {"t.csv", "position to the right"});
  refused("x,y,z,frame,particle\n1,1,1,0,0\n1,2,3,1,0\n", {"t.csv", "'y'", "'z'", "both change"});
  refused("y,x,frame,particle\n1,left,0,0\n", {"t.csv:2:", "'x'", "left"});
  refused("y,x,frame,particle\n1,1,,0\n1,1,1,0\n", {"t.csv:2:", "'frame'", "empty"});
  refused("y,x,time_s,particle\n1,1,0,0\n1,1,nan,0\n", {"t.csv:3:", "'time_s'", "empty"});
}

// An uncertainty that is none would count for nothing, or for everything.
TEST(TrackFile, UncertaintiesThatAreNoneAreRefusedWithTheirLine) {
  const TemporaryFolder folder;
  const auto sentence = [&](const std::string& header, const std::string& second) {
    const auto file = folder.write("t.csv",
                                   "time_s,particle,x_m,z_m,angle_rad," + header +
                                       "\n0,1,0,0,0,0.1,0.1,0.01\n1,1,0,0,0," + second + "\n");
    return complaint_about(file, {});
  };
  const std::string all = "sigma_x_m,sigma_z_m,sigma_angle_rad";
  EXPECT_EQ(sentence(all, "0.1,0.1,0.01"), "");
  for (const char* bad : {"", "0", "-0.1", "nan", "inf"}) {
    const std::string value = bad;
    expect_words(sentence(all, value + ",0.1,0.01"), {"t.csv:3:", "'sigma_x_m'", "above 0"});
    expect_words(sentence(all, "0.1," + value + ",0.01"), {"t.csv:3:", "'sigma_z_m'", "above 0"});
    expect_words(sentence(all, "0.1,0.1," + value), {"t.csv:3:", "'sigma_angle_rad'", "above 0"});
    const auto file =
        folder.write("ep.csv", "y,x,frame,particle,ep\n31,201,0,0,0.1\n31,201,1,0," + value + "\n");
    expect_words(complaint_about(file, picture()), {"ep.csv:3:", "'ep'", "above 0"});
  }
  expect_words(sentence("sigma_x_m,one,other", "0.1,0.1,0.01"), {"t.csv: ", "'sigma_x_m'", "both"});
  expect_words(sentence("one,sigma_z_m,other", "0.1,0.1,0.01"), {"t.csv: ", "'sigma_z_m'", "both"});
  expect_words(sentence("one,other,sigma_angle_rad", "0.1,0.1,0.01"),
               {"t.csv: ", "'sigma_angle_rad'", "both"});
}

// What is not known is written as nothing, and read so.
TEST(TrackFile, TracksWithoutUncertaintiesAreReadBack) {
  const TemporaryFolder folder;
  Trajectories tracks = make_trajectories(2, 1, false);
  tracks.time = {0.0, 1.0};
  for (Pose& pose : tracks.poses) pose = {0.1, 0.2, 0.3};
  write_tracks(folder / "t.csv", tracks);
  EXPECT_TRUE(read_tracks(folder / "t.csv").sigmas.empty());
}

// Files of ours that were damaged or made elsewhere
TEST(TrackFiles, RefusePlacesThatAreNotFiniteAndNumbersWithHugeGaps) {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& row) {
    return complaint_about(folder.write("a.csv", "time_s,particle,x_m,z_m\n0,1,0.1,0.2\n" + row),
                           {});
  };
  EXPECT_EQ(said("0,3,0.1,0.3\n"), "");  // the second is not seen
  expect_words(said("0,2,inf,0.3\n"), {"a.csv:3", "'x_m'", "finite"});
  expect_words(said("0,2,0.1,-inf\n"), {"a.csv:3", "'z_m'", "finite"});
  expect_words(said("0,2,1e999,0.3\n"), {"a.csv:3", "'x_m'"});
  expect_words(said("0,1999999999,0.1,0.3\n"), {"a.csv", "1999999999", "without large gaps"});
  expect_words(said("0,0,0.1,0.3\n"), {"a.csv:3", "numbered from 1"});
  expect_words(said("0,2.5,0.1,0.3\n"), {"a.csv:3", "whole number"});
}

}  // namespace
}  // namespace graintruth::datasets
