// Pictures of the run folder that the page holds in itself.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "datasets/store/run_folder.h"

namespace graintruth::reports {

enum class PictureState { whole, missing, cut_off };

struct EmbeddedPicture {
  PictureState state = PictureState::missing;
  std::string source;  // a data: address; empty unless whole
};

// The data: address of a whole JPEG picture.
std::string address_of_jpeg(std::string_view content);

// A JPEG file by its name within the folder; one that leads out of it is missing.
EmbeddedPicture embed_picture(const datasets::RunFolder& folder, const std::filesystem::path& name);

}  // namespace graintruth::reports
