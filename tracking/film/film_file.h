// A film's file: what its container says of the pictures, and the pictures as they are stored, read
// by the libraries of FFmpeg. Not by OpenCV, whose version 4.6 turns films by a quarter the wrong
// way round, counts pictures that an edit list hides, reads a cover in place of the film, and
// passes over in silence what it cannot decode.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace graintruth::tracking {

// How stored pictures are to be shown, by the container's display matrix: as a phone notes how it
// was held.
struct Turn {
  bool swaps_axes = false;  // rows become columns, before anything else
  bool flips_x = false, flips_y = false;

  bool is_none() const { return !swaps_axes && !flips_x && !flips_y; }
  // A turn keeps left and right apart, a mirror does not.
  bool is_mirror() const { return (swaps_axes + flips_x + flips_y) % 2 == 1; }
  int degrees() const;  // clockwise, 0 to 270; of a mirror after left and right were exchanged
  cv::Mat of(const cv::Mat& stored) const;
};

// What the container says, without a picture being decoded. Pictures that players do not show (what
// an edit list cuts off) count nowhere.
struct Container {
  int films = 1;  // streams of moving pictures; the first is read
  Turn turn;
  int width = 0, height = 0;  // px, as stored
  int shown = 0;              // pictures that lie in the file
  int announced = 0;          // by header or index; as `shown` where they do not say
  std::vector<double> times;  // s, of the pictures in the file as they are shown; may be empty
  double frame_rate = 0.0;    // Hz, as usual in this film; 0 where the container does not say
  double tick = 0.0;          // s; times are whole multiples of it

  bool ends_early = false;  // the file is shorter than it says itself

  // More pictures are lacking than containers miscount: at the end, or in between.
  bool is_cut_off() const;
  bool has_holes() const;
};

// Whether so many are lacking of a film that it is not worth being tracked: more than 2 %, and more
// than the one or two that containers miscount.
bool are_too_many(int lacking, int frames);

// The numbers of pictures that come earlier or later after the one before than usual: by more than
// containers round.
std::vector<int> uneven_steps(const Container& container);

struct StoredPicture {
  cv::Mat picture;          // 8-bit BGR; not yet turned
  int place = 0;            // among the pictures that are shown, from 0
  bool is_patched = false;  // parts could not be decoded, and were made up
};

class FilmFile {
 public:
  // Throws InputError where there is no file, or no film in it that can be read.
  explicit FilmFile(const std::filesystem::path& file);
  ~FilmFile();
  FilmFile(FilmFile&&) noexcept;
  FilmFile& operator=(FilmFile&&) noexcept;

  // Reads the whole file once, without decoding it.
  const Container& container();
  // The next picture that can be decoded; false after the last.
  bool read(StoredPicture& next);
  // So far; each is a picture that cannot be decoded, or part of one.
  int refused_packets() const;

 private:
  struct Streams;
  std::unique_ptr<Streams> streams_;
};

}  // namespace graintruth::tracking
