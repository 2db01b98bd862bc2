// Bodies that a camera sees and that neither balls nor a plate describe: a kind by its name, with
// the lengths that the kind has. A tracker of the same name follows them.
#pragma once

#include <map>
#include <string>

namespace graintruth::datasets {

class TomlSection;

struct NamedBody {
  std::string kind;
  std::map<std::string, double> lengths;  // m, by the names of the kind
};

// Reads `body = "kind"` and its lengths; the section fails where they do not fit.
NamedBody read_named_body(TomlSection& section);

}  // namespace graintruth::datasets
