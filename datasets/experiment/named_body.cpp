#include "datasets/experiment/named_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

namespace {

struct Kind {
  std::string_view name;
  std::vector<std::string_view> lengths;  // from the longest to the shortest
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = {
      {"disc", {"diameter"}},
      {"rod", {"length", "diameter"}},
  };
  return all;
}

}  // namespace

NamedBody read_named_body(TomlSection& section) {
  NamedBody body{section.text("body"), {}};
  const auto kind = std::find_if(
      kinds().begin(), kinds().end(), [&](const Kind& one) { return one.name == body.kind; });
  if (kind == kinds().end()) {
    std::string known;
    for (const Kind& one : kinds())
      known += fmt::format("{}\"{}\"", known.empty() ? "" : " or ", one.name);
    section.fail("body",
                 fmt::format("is \"{}\", but must be {}; balls are given by 'spheres', a plate by "
                             "'plate'",
                             body.kind,
                             known));
  }
  double longer = 0.0;
  for (const std::string_view name : kind->lengths) {
    const double length = section.quantity(name, length_units, positive);
    if (longer > 0.0 && length > longer) {
      section.fail(section.key_of(name, length_units),
                   fmt::format("must not exceed '{}'", kind->lengths.front()));
    }
    body.lengths[std::string(name)] = longer = length;
  }
  return body;
}

}  // namespace graintruth::datasets
