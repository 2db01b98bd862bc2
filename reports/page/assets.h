// The files that are built into the program: plotly, the page's templates, its style sheet and its
// script.
#pragma once

#include <string_view>

namespace graintruth::reports {

// The content of an embedded file, e.g. "page.mustache". The names are listed in CMakeLists.txt;
// another name is a mistake of ours and throws std::logic_error.
std::string_view asset(std::string_view name);

}  // namespace graintruth::reports
