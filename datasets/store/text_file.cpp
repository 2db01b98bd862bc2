#include "datasets/store/text_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/locale/encoding_utf.hpp>
#include <cstdint>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::datasets {

namespace {

using namespace std::string_view_literals;
namespace conv = boost::locale::conv;

struct Format {
  std::string_view begins, holds;  // both must be there; an empty one always is
  std::string_view name;
  bool is_packed = false;  // another file is inside it
};

// By the bytes that files begin with; the first that fits counts.
constexpr std::array formats{
    Format{"PK\x03\x04"sv, "xl/"sv, "an Excel workbook (.xlsx)"},
    Format{"PK\x03\x04"sv, "opendocument.spreadsheet"sv, "an OpenDocument spreadsheet (.ods)"},
    Format{"PK\x03\x04"sv, "word/"sv, "a Word document (.docx)"},
    Format{"PK\x03\x04"sv, ""sv, "a zip archive", true},
    Format{"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"sv, ""sv, "an old Excel workbook (.xls)"},
    Format{"\x1f\x8b"sv, ""sv, "packed with gzip", true},
    Format{"BZh"sv, ""sv, "packed with bzip2", true},
    Format{"\xfd"
           "7zXZ\0"sv,
           ""sv,
           "packed with xz",
           true},
    Format{"\x28\xb5\x2f\xfd"sv, ""sv, "packed with zstd", true},
    Format{"7z\xbc\xaf\x27\x1c"sv, ""sv, "a 7z archive", true},
    Format{"%PDF"sv, ""sv, "a PDF"},
    Format{"{\\rtf"sv, ""sv, "a rich-text document (.rtf)"},
    Format{"\x89HDF\r\n\x1a\n"sv, ""sv, "an HDF5 file"},
    Format{"MATLAB 5.0 MAT-file"sv, ""sv, "a MATLAB file (.mat)"},
    Format{"\x93NUMPY"sv, ""sv, "a NumPy array (.npy)"},
    Format{"TDSm"sv, ""sv, "a LabVIEW measurement in binary (.tdms)"},
    Format{"SQLite format 3\0"sv, ""sv, "an SQLite database"},
    Format{"PAR1"sv, ""sv, "a Parquet file"},
    Format{"ARROW1"sv, ""sv, "a Feather file"},
    Format{"\x89PNG"sv, ""sv, "a picture (PNG)"},
    Format{"\xff\xd8\xff"sv, ""sv, "a picture (JPEG)"},
    Format{"II*\0"sv, ""sv, "a picture (TIFF)"},
    Format{"MM\0*"sv, ""sv, "a picture (TIFF)"},
};

[[noreturn]] void fail(const std::filesystem::path& file, std::string_view complaint) {
  throw InputError(fmt::format("{}: {}.", file.string(), complaint));
}

// What Windows-1252 has between 0x80 and 0x9f, where Latin-1 has nothing that is seen.
constexpr std::array<char32_t, 32> windows_1252 = {
    0x20ac, 0xfffd, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021, 0x02c6, 0x2030, 0x0160,
    0x2039, 0x0152, 0xfffd, 0x017d, 0xfffd, 0xfffd, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022,
    0x2013, 0x2014, 0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0xfffd, 0x017e, 0x0178};

std::string from_windows_1252(std::string_view content) {
  std::u32string points;
  points.reserve(content.size());
  for (const char letter : content) {
    const auto byte = static_cast<unsigned char>(letter);
    points += byte >= 0x80 && byte < 0xa0 ? windows_1252[byte - 0x80U] : char32_t{byte};
  }
  return conv::utf_to_utf<char>(points);
}

bool is_utf_8(std::string_view content) {
  try {
    conv::utf_to_utf<char32_t>(content.data(), content.data() + content.size(), conv::stop);
    return true;
  } catch (const conv::conversion_error&) {
    return false;
  }
}

enum class Wide { no, low_byte_first, high_byte_first };

// UTF-16 by its mark, or by letters of which every other byte is zero.
Wide wideness(std::string_view content) {
  if (content.starts_with("\xff\xfe")) return Wide::low_byte_first;
  if (content.starts_with("\xfe\xff")) return Wide::high_byte_first;
  const std::size_t looked_at = std::min<std::size_t>(content.size(), 1000) / 2;
  if (looked_at < 2) return Wide::no;
  std::array<std::size_t, 2> zeros{};
  for (std::size_t i = 0; i < 2 * looked_at; ++i) zeros[i % 2] += content[i] == '\0';
  const auto most = [&](std::size_t count) { return 10 * count >= 9 * looked_at; };
  const auto few = [&](std::size_t count) { return 10 * count <= looked_at; };
  if (most(zeros[1]) && few(zeros[0])) return Wide::low_byte_first;
  if (most(zeros[0]) && few(zeros[1])) return Wide::high_byte_first;
  return Wide::no;
}

std::string from_utf_16(const std::filesystem::path& file, std::string_view content, Wide wide) {
  std::u16string units(content.size() / 2, u'\0');
  const std::size_t low = wide == Wide::low_byte_first ? 0 : 1;
  for (std::size_t i = 0; i < units.size(); ++i) {
    units[i] = static_cast<char16_t>(static_cast<unsigned char>(content[2 * i + low]) |
                                     static_cast<unsigned char>(content[2 * i + 1 - low]) << 8U);
  }
  try {
    if (content.size() % 2 != 0) throw conv::conversion_error();
    return conv::utf_to_utf<char>(units.data(), units.data() + units.size(), conv::stop);
  } catch (const conv::conversion_error&) {
    fail(file, "is damaged: it is UTF-16 text with a broken character; save it as UTF-8");
  }
}

// '\n' in place of "\r\n", of "\r\r\n" (text that was translated twice) and of a lone '\r'.
void unify_line_ends(std::string& text) {
  std::size_t to = 0;
  for (std::size_t from = 0; from < text.size(); ++from) {
    if (text[from] != '\r') {
      text[to++] = text[from];
      continue;
    }
    std::size_t next = from;
    while (next + 1 < text.size() && text[next + 1] == '\r') ++next;
    if (next + 1 < text.size() && text[next + 1] == '\n') from = next + 1;
    text[to++] = '\n';
  }
  text.resize(to);
}

// Zero bytes at the end, and the line that they break off.
void leave_out_zeros(const std::filesystem::path& file, TextFile& read) {
  const std::size_t end = read.text.find_last_not_of('\0') + 1;  // 0 where there is nothing else
  const std::size_t zeros = read.text.size() - end;
  if (end == 0 && zeros > 0) fail(file, "holds nothing but zero bytes; copy it anew");
  read.text.resize(end);
  if (const std::size_t at = read.text.find('\0'); at != std::string::npos) {
    throw InputError(fmt::format(
        "{}:{}: holds a zero byte, which text never does: it is a binary file, or damaged.",
        file.string(),
        1 + std::count(
                read.text.begin(), read.text.begin() + static_cast<std::ptrdiff_t>(at), '\n')));
  }
  if (zeros == 0) return;
  const std::size_t whole = read.text.rfind('\n') + 1;
  const bool is_broken = whole < read.text.size();
  read.text.resize(whole);
  read.notes.push_back(
      fmt::format("{}: ends with {} zero bytes, as after a loss of power. They {}.",
                  file.string(),
                  zeros,
                  is_broken ? "are left out, with the line that they break off" : "are left out"));
}

}  // namespace

std::optional<std::string_view> known_format(std::string_view content) {
  for (const Format& format : formats) {
    if (content.starts_with(format.begins) && content.find(format.holds) != std::string_view::npos)
      return format.name;
  }
  return std::nullopt;
}

TextFile decode_text(const std::filesystem::path& file,
                     std::string content,
                     std::string_view way_round) {
  if (const auto name = known_format(content)) {
    const bool is_packed = std::any_of(formats.begin(), formats.end(), [&](const Format& format) {
      return format.name == *name && format.is_packed;
    });
    fail(file, fmt::format("is {}, not text; {}", *name, is_packed ? "unpack it" : way_round));
  }
  TextFile read;
  const std::string_view bytes = content;
  if (bytes.starts_with("\xff\xfe\0\0"sv) || bytes.starts_with("\0\0\xfe\xff"sv))
    fail(file, "is UTF-32 text, which hardly any program reads; save it as UTF-8");
  if (const Wide wide = wideness(content); wide != Wide::no) {
    read.text = from_utf_16(file, content, wide);
  } else if (is_utf_8(content)) {
    read.text = std::move(content);
  } else {
    read.text = from_windows_1252(content);
  }
  constexpr std::string_view mark = "\xef\xbb\xbf";
  while (read.text.starts_with(mark)) read.text.erase(0, mark.size());
  unify_line_ends(read.text);
  leave_out_zeros(file, read);
  return read;
}

TextFile read_text(const std::filesystem::path& file, std::string_view way_round) {
  return decode_text(file, read_whole(file), way_round);
}

}  // namespace graintruth::datasets
