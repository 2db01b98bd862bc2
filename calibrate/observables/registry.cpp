#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "calibrate/observables/observable.h"
#include "datasets/store/input_error.h"
#include "datasets/store/toml_section.h"

namespace graintruth::calibrate {

#define KIND(name) extern const ObservableKind name;
#include "calibrate/observables/kinds.def"
#undef KIND

// A quantity of the user's own has the name that [measure.<name>] gives it.
extern const ObservableKind own_curve_kind;

namespace {

constexpr std::array all_kinds = {
#define KIND(name) &(name),
#include "calibrate/observables/kinds.def"
#undef KIND
};

// A name that is none of these is one of the user's own, if [measure.<name>] says what it is.
const ObservableKind* kind_named(std::string_view name, bool has_settings) {
  for (const ObservableKind* kind : all_kinds) {
    if (kind->name == name) return kind;
  }
  return has_settings ? &own_curve_kind : nullptr;
}

}  // namespace

Observables::Observables(const datasets::Experiment& experiment) : experiment_(&experiment) {
  for (const datasets::RequestedObservable& requested : experiment.measurement.observables) {
    const ObservableKind* kind = kind_named(requested.name, requested.settings != nullptr);
    if (kind == nullptr) {
      std::vector<std::string_view> names;
      for (const ObservableKind* known : all_kinds) names.push_back(known->name);
      throw datasets::InputError(
          fmt::format("{}: key 'measure.observables' names '{}', but known are {}; one of your own "
                      "is described by a table [measure.{}].",
                      experiment.file.string(),
                      requested.name,
                      fmt::join(names, ", "),
                      requested.name));
    }
    compared_.push_back({add(requested.name, requested.settings.get()), requested.weight});
  }
}

std::size_t Observables::add(const std::string& name, datasets::TomlSection* settings) {
  if (const auto known = find(name)) return *known;
  const ObservableKind* kind = kind_named(name, settings != nullptr);
  all_.push_back(kind->make(*experiment_, settings));
  if (settings) settings->finish();
  const std::size_t place = all_.size() - 1;
  const std::shared_ptr<const Observable> made = all_.back();
  std::vector<std::string> needed = made->needs();
  for (const std::string& other : made->requested_form()) needed.push_back(other);
  for (const std::string& other : needed) add(other, nullptr);
  return place;
}

std::optional<std::size_t> Observables::find(std::string_view name) const {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (all_[i]->name() == name) return i;
  }
  return std::nullopt;
}

const Observable* Observables::of_agreement() const {
  for (const auto& [place, weight] : compared_) {
    if (all_[place]->gives_agreement()) return all_[place].get();
  }
  return nullptr;
}

std::vector<Observables::Compared> Observables::compared_by_request() const {
  std::vector<Compared> requested;
  for (const auto& [place, weight] : compared_) {
    for (const std::string& name : all_[place]->requested_form()) {
      const std::size_t other = *find(name);
      const bool is_new = std::none_of(
          requested.begin(), requested.end(), [&](const auto& one) { return one.place == other; });
      if (is_new) requested.push_back({other, weight});
    }
  }
  return requested;
}

std::vector<Channel> Observables::measure(const datasets::Recording& recording,
                                          const Situation& situation,
                                          const std::vector<Channel>* like) const {
  std::vector<Channel> channels;
  for (std::size_t i = 0; i < all_.size(); ++i)
    channels.push_back(all_[i]->measure(recording, situation, like ? &(*like)[i] : nullptr));
  return channels;
}

}  // namespace graintruth::calibrate
