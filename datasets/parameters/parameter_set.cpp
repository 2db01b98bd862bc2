#include "datasets/parameters/parameter_set.h"

#include <algorithm>
#include <stdexcept>

#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

ParameterSet::ParameterSet(std::initializer_list<Entry> entries) {
  for (const auto& [name, value] : entries) set(name, value);
}

const ParameterSet::Entry* ParameterSet::find(std::string_view name) const {
  const auto found = std::find_if(
      entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.first == name; });
  return found == entries_.end() ? nullptr : &*found;
}

bool ParameterSet::has(std::string_view name) const { return find(name) != nullptr; }

double ParameterSet::of(std::string_view name) const {
  if (const Entry* entry = find(name)) return entry->second;
  throw std::logic_error("the set has no parameter " + std::string(name));
}

double ParameterSet::value_or(std::string_view name, double other) const {
  const Entry* entry = find(name);
  return entry ? entry->second : other;
}

void ParameterSet::set(std::string_view name, double value) {
  if (const Entry* entry = find(name)) {
    entries_[static_cast<std::size_t>(entry - entries_.data())].second = value;
    return;
  }
  const auto later = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return comes_before(name, entry.first);
  });
  entries_.insert(later, {std::string(name), value});
}

}  // namespace graintruth::datasets
