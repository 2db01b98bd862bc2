// Parameters by name with their values, in the order of the registry.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace graintruth::datasets {

class ParameterSet {
 public:
  using Entry = std::pair<std::string, double>;

  ParameterSet() = default;
  ParameterSet(std::initializer_list<Entry> entries);

  bool has(std::string_view name) const;
  // Throws std::logic_error where there is no such parameter.
  double of(std::string_view name) const;
  double value_or(std::string_view name, double other) const;
  // Changes a value, or puts a new one in its place in the order of the registry.
  void set(std::string_view name, double value);

  std::vector<Entry>::const_iterator begin() const { return entries_.begin(); }
  std::vector<Entry>::const_iterator end() const { return entries_.end(); }
  std::size_t size() const { return entries_.size(); }

  friend bool operator==(const ParameterSet&, const ParameterSet&) = default;

 private:
  const Entry* find(std::string_view name) const;

  std::vector<Entry> entries_;
};

}  // namespace graintruth::datasets
