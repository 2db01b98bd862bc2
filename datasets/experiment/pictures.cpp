#include "datasets/experiment/pictures.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string>
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

// "img_*.png", where the star stands for anything, or "img_%04d.png", for a number of at least four
// digits that has no more than it needs.
class Pattern {
 public:
  explicit Pattern(const std::string& name) {
    const std::size_t star = name.find('*');
    if (star != std::string::npos) {
      split(name, star, star + 1);
      return;
    }
    const std::size_t percent = name.find('%');
    if (percent == std::string::npos) return;
    std::size_t end = percent + 1;
    while (end < name.size() && is_digit(name[end])) ++end;
    if (end == name.size() || (name[end] != 'd' && name[end] != 'i' && name[end] != 'u')) return;
    const std::string width = name.substr(percent + 1, end - percent - 1);
    if (width.size() > 3) return;
    fewest_digits_ = width.empty() ? 1 : std::max<std::size_t>(1, std::stoul(width));
    split(name, percent, end + 1);
  }

  bool is_pattern() const { return is_pattern_; }

  bool fits(const std::string& name) const {
    if (name.size() < before_.size() + after_.size() || !name.starts_with(before_) ||
        !name.ends_with(after_))
      return false;
    if (fewest_digits_ == 0) return true;
    const std::string number =
        name.substr(before_.size(), name.size() - before_.size() - after_.size());
    return number.size() >= fewest_digits_ && std::all_of(number.begin(), number.end(), is_digit) &&
           (number.size() == fewest_digits_ || number.front() != '0');
  }

 private:
  void split(const std::string& name, std::size_t at, std::size_t end) {
    is_pattern_ = true;
    before_ = name.substr(0, at);
    after_ = name.substr(end);
  }

  bool is_pattern_ = false;
  std::string before_, after_;
  std::size_t fewest_digits_ = 0;  // 0: anything
};

// A name in turns of other characters and numbers: "a12b" is "a", "12", "b".
std::vector<std::string> parts_of(const std::string& name) {
  std::vector<std::string> parts(1);
  for (const char c : name) {
    const bool is_number = parts.size() % 2 == 0;
    if (is_digit(c) != is_number) parts.emplace_back();
    parts.back() += c;
  }
  return parts;
}

}  // namespace

std::vector<fs::path> pictures_of(const fs::path& path) {
  const Pattern pattern(path.filename().string());
  const bool is_pattern = pattern.is_pattern() && !fs::is_directory(path);
  const fs::path folder = is_pattern ? path.parent_path() : path;
  std::error_code error;
  std::vector<fs::path> pictures;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const bool fits = !is_pattern || pattern.fits(entry.path().filename().string());
    if (fits && entry.is_regular_file() && is_picture(entry.path()))
      pictures.push_back(entry.path());
  }
  std::sort(pictures.begin(), pictures.end(), comes_before);
  return pictures;
}

std::vector<long> numbers_of(const std::vector<fs::path>& pictures) {
  constexpr std::size_t longest = 15;  // digits
  if (pictures.size() < 2) return {};
  std::vector<std::vector<std::string>> names;
  for (const fs::path& picture : pictures) names.push_back(parts_of(picture.filename().string()));
  std::optional<std::size_t> counted;
  for (const auto& name : names) {
    if (name.size() != names.front().size()) return {};
    for (std::size_t part = 0; part < name.size(); ++part) {
      if (name[part] == names.front()[part] || counted == part) continue;
      if (counted || part % 2 == 0) return {};
      counted = part;
    }
  }
  if (!counted) return {};
  std::vector<long> numbers;
  for (const auto& name : names) {
    if (name[*counted].size() > longest) return {};
    numbers.push_back(std::stol(name[*counted]));
  }
  return numbers;
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
