// A kind of rig: how [rig] states it, and what data it makes. One file of this folder defines a
// kind, one line of kinds.def makes it known.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/experiment/particle.h"
#include "datasets/rigs/rig.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

// [rig] of an experiment, and the keys with which a replicate sets something else.
class RigSection {
 public:
  // `replicate` is null for the rig alone, which then may lack what only replicates tell.
  RigSection(TomlSection& rig, TomlSection* replicate) : rig_(rig), replicate_(replicate) {}

  TomlSection& rig() { return rig_; }

  // A setting that a replicate may have otherwise: it is looked for there first. None where
  // neither states it; of a replicate, that is refused.
  std::optional<double> setting(std::string_view stem, Units units, const Range& range, Rig& rig);
  // Says what is wrong with a setting where it stands.
  [[noreturn]] void fail(std::string_view stem, Units units, std::string_view complaint);

 private:
  bool states(TomlSection& section, std::string_view stem, Units units) const;

  TomlSection& rig_;
  TomlSection* replicate_;
};

struct RigContext {
  std::filesystem::path folder;                          // of the experiment file
  const Particle* particle = nullptr;                    // null where the rig brings the grains
  std::vector<std::filesystem::path>* inputs = nullptr;  // other files that were read
  std::vector<std::string>* notes = nullptr;             // sentences on how they were understood
};

// Says at the setting of a width (m), by its stem, that no grain gets through, where that is so.
void require_passage(RigSection& section,
                     std::string_view stem,
                     double width,
                     const Particle& particle,
                     Passage passage);

struct RigKind {
  std::string_view name;
  std::string_view meaning;  // "flat V hopper above a column in which a piston sinks"
  // What `graintruth new` calls its template, app/new/<template_name>; empty: its own name
  std::string_view template_name = {};
  bool brings_grains = false;  // [particle] and [material] are not needed
  bool is_one_layer = true;    // of grains between panes, where it does not bring them
  bool pours_a_bed = false;    // and may say how many grains there are instead of [particle]
  void (*read)(RigSection& section, const RigContext& context, Rig& rig);
};

std::span<const RigKind* const> rig_kinds();

// Throws InputError where `kind` is none.
const RigKind& rig_kind_named(TomlSection& rig);

// The whole of [rig], for one replicate or (null) for all.
Rig read_rig(TomlSection rig, TomlSection* replicate, const RigContext& context);

}  // namespace graintruth::datasets
