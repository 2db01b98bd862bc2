// What identifies contents: 32 hexadecimal digits that change when the content does. They identify
// and do not protect (XXH3, 128 bit; Collet).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace graintruth::datasets {

std::string content_hash(std::string_view content);

// The same of a file, read piece by piece. Throws InputError when it cannot be opened.
std::string file_hash(const std::filesystem::path& file);

}  // namespace graintruth::datasets
