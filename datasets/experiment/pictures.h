// Films that are kept as single pictures: all of a folder, or those whose names fit a pattern.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::datasets {

// The pictures that a path names: of a folder all of them; of "folder/name*.png" those that fit,
// the star standing for anything; of "folder/name%04d.png" those that are numbered so. In the order
// of their names, numbers by value: 2 before 10. None where the path is a file or nothing.
std::vector<std::filesystem::path> pictures_of(const std::filesystem::path& path);

// The number by which the names of these pictures differ; none where they differ by anything else.
std::vector<long> numbers_of(const std::vector<std::filesystem::path>& pictures);

// Whether the path names a file, or pictures.
bool is_film(const std::filesystem::path& path);

// Of what it holds. Throws InputError when it cannot be opened.
std::string film_hash(const std::filesystem::path& path);

}  // namespace graintruth::datasets
