// Text as other programs write it: its encoding and its line ends are taken away, and what is no
// text is called by its name.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graintruth::datasets {

struct TextFile {
  std::string text;                // UTF-8; a line ends with '\n' and nothing else
  std::vector<std::string> notes;  // sentences on what of the file was left out
};

// Reads UTF-8 and UTF-16, with or without a byte-order mark, and Windows-1252, which holds Latin-1.
// Lines may end as on Unix, Windows or an old Mac. Zero bytes at the end, which a loss of power
// leaves, are left out, with the line that they break off. Throws InputError where the file holds
// no text. `way_round` is what would be right, for that sentence: "save the table as CSV".
TextFile read_text(const std::filesystem::path& file, std::string_view way_round);

// The same of what was read already.
TextFile decode_text(const std::filesystem::path& file,
                     std::string content,
                     std::string_view way_round);

// What a file that begins like this is, where that is a well-known format other than text:
// "an Excel workbook (.xlsx)".
std::optional<std::string_view> known_format(std::string_view content);

}  // namespace graintruth::datasets
