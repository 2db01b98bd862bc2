// A film that is kept as single pictures: those of a folder or of a pattern of names (see
// datasets/experiment/pictures.h), one file, or the pages of a TIFF file.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace graintruth::tracking {

struct SinglePicture {
  std::filesystem::path file;
  int page = 0;
};

// In order; none where the path is no picture and names none. Throws InputError where the same
// picture lies there twice, as .png and as .jpg, say.
std::vector<SinglePicture> single_pictures(const std::filesystem::path& path);

// 8-bit BGR. Throws InputError when it cannot be read.
cv::Mat read_picture(const SinglePicture& picture);

// What the numbers in the names of pictures tell of those that are lacking.
struct Numbering {
  std::vector<double> moments;  // of each picture, in intervals after the first; empty: no gaps
  std::string warning;          // which are lacking; empty where none are
};
Numbering numbering_of(const std::vector<SinglePicture>& pictures);

}  // namespace graintruth::tracking
