// A film as the page of annotate shows it: some of its pictures, and what the program found on it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "datasets/experiment/tracking_spec.h"

namespace graintruth::app {

struct LookedAtFilm {
  std::string name;
  std::filesystem::path video;
  std::optional<double> frame_rate;            // Hz, where it is stated
  std::optional<datasets::TrackingSpec> spec;  // where the experiment is known that far
  std::filesystem::path tracks;                // of an earlier run; need not be there
};

// Reads the film twice from end to end. Pictures are JPEG, at most `budget` bytes of them; the
// first one is always there, compressed as strongly as that takes. Throws datasets::InputError
// where the film cannot be read.
nlohmann::ordered_json look_at_film(const LookedAtFilm& film, std::size_t budget);

}  // namespace graintruth::app
