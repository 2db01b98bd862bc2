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

struct Named {
  const ObservableKind* kind = nullptr;  // null: nobody knows the name
  std::string_view surface = {};         // of the rig's; empty: none
};

// A name that is none of these is one of the user's own, if [measure.<name>] says what it is.
Named kind_named(std::string_view name, const datasets::Rig& rig, bool has_settings) {
  for (const ObservableKind* kind : all_kinds) {
    if (kind->name == name) return {kind};
    if (!kind->make_of_surface || !rig.seen_outline || !name.starts_with(kind->name)) continue;
    for (const auto& surface : rig.seen_outline->surfaces)
      if (name.substr(kind->name.size()) == "_" + surface.name) return {kind, surface.name};
  }
  return {has_settings ? &own_curve_kind : nullptr};
}

// What can be compared of a rig, for sentences.
std::vector<std::string> names_of(const datasets::Rig& rig) {
  std::vector<std::string> names;
  for (const ObservableKind* kind : all_kinds) {
    if (!kind->make_of_surface || !rig.seen_outline || rig.seen_outline->surfaces.empty()) {
      names.emplace_back(kind->name);
      continue;
    }
    for (const auto& surface : rig.seen_outline->surfaces)
      names.push_back(fmt::format("{}_{}", kind->name, surface.name));
  }
  return names;
}

}  // namespace

Observables::Observables(const datasets::Experiment& experiment) : experiment_(&experiment) {
  for (const datasets::RequestedObservable& requested : experiment.measurement.observables) {
    if (!kind_named(requested.name, experiment.rig, requested.settings != nullptr).kind) {
      throw datasets::InputError(
          fmt::format("{}: key 'measure.observables' names '{}', but known are {}; one of your own "
                      "is described by a table [measure.{}].",
                      experiment.file.string(),
                      requested.name,
                      fmt::join(names_of(experiment.rig), ", "),
                      requested.name));
    }
    compared_.push_back({add(requested.name, requested.settings.get()), requested.weight});
  }
}

std::size_t Observables::add(const std::string& name, datasets::TomlSection* settings) {
  if (const auto known = find(name)) return *known;
  const auto [kind, surface] = kind_named(name, experiment_->rig, settings != nullptr);
  all_.push_back(surface.empty() ? kind->make(*experiment_, settings)
                                 : kind->make_of_surface(*experiment_, surface));
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
