#include "reports/sections/pictures.h"

#include <array>
#include <string_view>

namespace graintruth::reports {

namespace {

// RFC 4648, with padding.
std::string base64(std::string_view bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t taken = std::min<std::size_t>(3, bytes.size() - i);
    std::array<unsigned, 3> triple = {};
    for (std::size_t k = 0; k < taken; ++k) triple[k] = static_cast<unsigned char>(bytes[i + k]);
    const unsigned bits = triple[0] << 16 | triple[1] << 8 | triple[2];
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= taken ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// Pictures lie in the run folder; a name that leads out of it is not followed.
bool stays_inside(const std::filesystem::path& name) {
  if (name.empty() || name.is_absolute()) return false;
  for (const auto& part : name.lexically_normal())
    if (part == "..") return false;
  return true;
}

// A JPEG file begins and ends with these marks (ITU T.81, table B.1).
bool is_whole_picture(std::string_view content) {
  return content.starts_with("\xFF\xD8") && content.ends_with("\xFF\xD9");
}

}  // namespace

std::string address_of_jpeg(std::string_view content) {
  return "data:image/jpeg;base64," + base64(content);
}

EmbeddedPicture embed_picture(const datasets::RunFolder& folder,
                              const std::filesystem::path& name) {
  const std::filesystem::path file = folder.root / name;
  if (!stays_inside(name) || !std::filesystem::is_regular_file(file)) return {};
  const std::string content = datasets::read_whole(file);
  if (!is_whole_picture(content)) return {PictureState::cut_off, ""};
  return {PictureState::whole, address_of_jpeg(content)};
}

}  // namespace graintruth::reports
