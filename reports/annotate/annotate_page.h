// The page of `graintruth annotate`: one file that opens from disk and asks nothing of any network.
#pragma once

#include <string>

#include "datasets/store/json_values.h"

namespace graintruth::reports {

// `data` is what its scripts read, see templates/annotate/page.js. Nothing of it can become markup.
std::string annotate_page(const std::string& title,
                          const std::string& size_words,
                          const datasets::Json& data);

}  // namespace graintruth::reports
