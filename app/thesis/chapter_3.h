// What the studies of chapter 3 share: the button's material, the thesis's critical time step.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "app/thesis/studies.h"
#include "app/thesis/thesis_data.h"

namespace graintruth::app::chapter_3 {

inline const std::string misc = "ch3_misc";

double critical_step(const ThesisData& thesis);  // s

// All that chapter 3's studies share, and the study's own settings.
std::string inputs_of(const ThesisData& thesis, const std::string& study);

double number_at(const Studies::Json& json, const char* key);
std::vector<double> numbers_at(const Studies::Json& json, const char* key);
double largest_of(const std::vector<double>& values);

}  // namespace graintruth::app::chapter_3
