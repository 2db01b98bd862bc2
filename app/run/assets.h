// The files that are built into the program: templates of what export and new write.
#pragma once

#include <string_view>
#include <vector>

namespace graintruth::app {

// The content of an embedded file by its path below app, e.g. "export/yade/drop.py.mustache".
// Another name is a mistake of ours and throws std::logic_error.
std::string_view asset(std::string_view name);
std::vector<std::string_view> asset_names();

}  // namespace graintruth::app
