#include "datasets/experiment/pictures.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "datasets/store/fingerprint.h"

namespace graintruth::datasets {

namespace {

namespace fs = std::filesystem;

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

bool is_picture(const fs::path& file) {
  constexpr std::array<std::string_view, 8> endings = {
      ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm"};
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

// The number that starts at `at`, without leading zeros; moves behind it.
std::string_view number_at(std::string_view text, std::size_t& at) {
  while (at < text.size() && text[at] == '0') ++at;
  const std::size_t from = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  return text.substr(from, at - from);
}

bool comes_before(const fs::path& one, const fs::path& other) {
  const std::string a = one.filename().string(), b = other.filename().string();
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string_view x = number_at(a, i), y = number_at(b, j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  const std::size_t left = a.size() - i, other_left = b.size() - j;
  return left != other_left ? left < other_left : a < b;
}

}  // namespace

std::vector<fs::path> pictures_of(const fs::path& path) {
  const std::string pattern = path.filename().string();
  const std::size_t star = pattern.find('*');
  const bool is_pattern = star != std::string::npos;
  const fs::path folder = is_pattern ? path.parent_path() : path;
  std::error_code error;
  std::vector<fs::path> pictures;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const bool fits = !is_pattern || (name.size() + 1 >= pattern.size() &&
                                      name.starts_with(pattern.substr(0, star)) &&
                                      name.ends_with(pattern.substr(star + 1)));
    if (fits && entry.is_regular_file() && is_picture(entry.path()))
      pictures.push_back(entry.path());
  }
  std::sort(pictures.begin(), pictures.end(), comes_before);
  return pictures;
}

bool is_film(const fs::path& path) {
  return fs::is_regular_file(path) || !pictures_of(path).empty();
}

std::string film_hash(const fs::path& path) {
  const std::vector<fs::path> pictures = pictures_of(path);
  if (pictures.empty()) return file_hash(path);
  std::string hashes;
  for (const fs::path& picture : pictures) hashes += file_hash(picture);
  return content_hash(hashes);
}

}  // namespace graintruth::datasets
