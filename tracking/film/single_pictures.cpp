#include "tracking/film/single_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "datasets/experiment/pictures.h"
#include "datasets/store/input_error.h"
#include "tracking/median.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

bool may_have_pages(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  return ending == ".tif" || ending == ".tiff" || ending == ".TIF" || ending == ".TIFF";
}

void add(const std::filesystem::path& file, std::vector<SinglePicture>& pictures) {
  const int pages =
      may_have_pages(file) ? static_cast<int>(cv::imcount(file.string(), cv::IMREAD_COLOR)) : 1;
  for (int page = 0; page < std::max(1, pages); ++page) pictures.push_back({file, page});
}

void refuse_twins(const std::vector<std::filesystem::path>& files) {
  std::map<std::filesystem::path, std::filesystem::path> by_stem;
  for (const std::filesystem::path& file : files) {
    const auto [twin, is_new] = by_stem.emplace(file.stem(), file);
    if (is_new) continue;
    throw InputError(
        fmt::format("{}: shows the same as {}, going by their names; give a pattern of one "
                    "kind of file, such as \"*{}\"",
                    file.string(),
                    twin->second.filename().string(),
                    file.extension().string()));
  }
}

}  // namespace

std::vector<SinglePicture> single_pictures(const std::filesystem::path& path) {
  std::vector<SinglePicture> pictures;
  if (std::filesystem::is_regular_file(path)) {
    if (cv::haveImageReader(path.string())) add(path, pictures);
    return pictures;
  }
  const std::vector<std::filesystem::path> files = datasets::pictures_of(path);
  refuse_twins(files);
  for (const std::filesystem::path& file : files) add(file, pictures);
  return pictures;
}

cv::Mat read_picture(const SinglePicture& picture) {
  cv::Mat read;
  if (may_have_pages(picture.file)) {
    std::vector<cv::Mat> pages;
    cv::imreadmulti(picture.file.string(), pages, picture.page, 1, cv::IMREAD_COLOR);
    if (!pages.empty()) read = pages.front();
  } else {
    read = cv::imread(picture.file.string(), cv::IMREAD_COLOR);
  }
  if (read.empty()) {
    throw InputError(
        fmt::format("{}: the picture cannot be read; copy it again", picture.file.string()));
  }
  return read;
}

// Numbers count pictures where most steps are alike; a step of several of these leaves some out.
// Else they are something else, times of day for instance.
Numbering numbering_of(const std::vector<SinglePicture>& pictures) {
  std::vector<std::filesystem::path> files;
  for (const SinglePicture& picture : pictures) files.push_back(picture.file);
  const std::vector<long> numbers = datasets::numbers_of(files);
  if (numbers.size() < 3) return {};
  std::vector<long> steps;
  for (std::size_t k = 1; k < numbers.size(); ++k) steps.push_back(numbers[k] - numbers[k - 1]);
  const long usual = median(steps);
  const auto alike = std::count(steps.begin(), steps.end(), usual);
  const bool is_counted = usual > 0 && 2 * alike > static_cast<long>(steps.size()) &&
                          std::all_of(steps.begin(), steps.end(), [&](long step) {
                            return step > 0 && step % usual == 0;
                          });
  if (!is_counted || alike == static_cast<long>(steps.size())) return {};
  Numbering numbering;
  long lacking = 0;
  std::string where;
  constexpr int shown = 3;
  int gaps = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    numbering.moments.push_back(static_cast<double>((numbers[k] - numbers[0]) / usual));
    if (k == 0 || steps[k - 1] == usual) continue;
    lacking += steps[k - 1] / usual - 1;
    if (++gaps <= shown)
      where += fmt::format("{}{} and {}",
                           gaps > 1 ? ", " : "",
                           files[k - 1].filename().string(),
                           files[k].filename().string());
  }
  if (gaps > shown) where += fmt::format(" and at {} more places", gaps - shown);
  numbering.warning = fmt::format(
      "By the numbers in their names {} {} lacking between {}; the times of the others go by their "
      "numbers.",
      lacking,
      lacking == 1 ? "picture is" : "pictures are",
      where);
  return numbering;
}

}  // namespace graintruth::tracking
