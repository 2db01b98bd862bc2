// A rig as it is drawn over a picture, as data that needs no rig kind: every corner is a sum of
// products of dimensions, found from what the kind makes of changed dimensions. Who has the data
// can drag a corner and tell what the dimensions are then.
#pragma once

#include <string>
#include <vector>

#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

// A step into TOML: to the value of a key, or to an element of a list.
struct TomlStep {
  std::string key;         // empty: of a list
  std::size_t number = 0;  // from 0
};

// A key of [rig] on which the drawing depends.
struct DrawnDimension {
  std::vector<TomlStep> path;  // below [rig]
  std::string stem;            // the key without its unit
  double unit = 1.0;           // m or rad
  double value = 0.0;          // m or rad, of the drawing that was looked at
  std::string_view form;       // "plain", or the function of the angle that enters the products
  bool is_setting = false;     // a replicate may state it otherwise
};

// factor times the dimensions of these numbers; -1 stands for 1.
struct DrawnTerm {
  double factor = 0.0;
  int first = -1, second = -1;
};

struct RigDrawing {
  struct Corner {
    std::vector<DrawnTerm> x, z;  // m
  };
  struct Line {
    std::string name;
    std::size_t from = 0, to = 0;  // corners
  };
  struct Circle {
    std::string name;
    std::size_t centre = 0, rim = 0;  // corners; the rim is any point of it
  };
  std::vector<DrawnDimension> dimensions;
  std::vector<Corner> corners;
  std::vector<Line> lines;
  std::vector<Circle> circles;
  std::vector<std::string> optional_keys;  // of [rig], that may be left out
};

// `settings` are keys of replicates, each text one TOML table: they count where [rig] takes them
// and does not state them, the first one that does. Throws InputError where the rig cannot be read.
RigDrawing draw_rig(const TomlSection& rig,
                    const std::vector<std::string>& settings,
                    const RigContext& context);

}  // namespace graintruth::datasets
