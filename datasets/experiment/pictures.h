// Films that are kept as single pictures: all of a folder, or those whose names fit a pattern.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::datasets {

// The pictures that a path names: of a folder all of them; of "folder/name*.png" those that fit,
// the star standing for anything. In the order of their names, numbers by value: 2 before 10. None
// where the path is a file or nothing.
std::vector<std::filesystem::path> pictures_of(const std::filesystem::path& path);

// Whether the path names a file, or pictures.
bool is_film(const std::filesystem::path& path);

// Of what it holds. Throws InputError when it cannot be opened.
std::string film_hash(const std::filesystem::path& path);

}  // namespace graintruth::datasets
