// What can be reproduced, in the order of the thesis, except that Table 5.2 comes after the study
// that it reads. A target has a part from printed data, a part
// that is simulated again, or both.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/thesis/examination.h"
#include "app/thesis/studies.h"

namespace graintruth::app {

struct Target {
  const char* name;
  const char* what;
  void (*from_printed)(Examination&, const ThesisData&);
  void (*simulated)(Examination&, const ThesisData&, Studies&);
  bool is_quick;  // all-quick takes it
};

std::span<const Target> all_targets();

// Chapters 1 and 2
void examine_equations(Examination& exam, const ThesisData& thesis);
void examine_table_1_1(Examination& exam, const ThesisData& thesis);
void examine_time_step(Examination& exam, const ThesisData& thesis);
void examine_profile_fit(Examination& exam, const ThesisData& thesis);

// Chapter 3
void examine_table_3_1(Examination& exam, const ThesisData& thesis);
void examine_table_3_2(Examination& exam, const ThesisData& thesis);
void examine_table_3_3(Examination& exam, const ThesisData& thesis);
void examine_table_3_4(Examination& exam, const ThesisData& thesis);
void examine_table_3_5(Examination& exam, const ThesisData& thesis);
void examine_table_3_6(Examination& exam, const ThesisData& thesis);
void examine_impulse(Examination& exam, const ThesisData& thesis);
void simulate_table_3_1(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_table_3_2(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_table_3_3(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_pseudo_friction(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_run_time_of_clumps(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_run_time_of_spheres(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_collision(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_sliding(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_contact_count(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_conveyor(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_impulse(Examination& exam, const ThesisData& thesis, Studies& studies);

// Chapter 4
void examine_table_4_1(Examination& exam, const ThesisData& thesis);
void examine_rms(Examination& exam, const ThesisData& thesis);
void examine_table_4_2(Examination& exam, const ThesisData& thesis);
void examine_table_4_3(Examination& exam, const ThesisData& thesis);
void examine_table_4_4(Examination& exam, const ThesisData& thesis);
void examine_table_4_5(Examination& exam, const ThesisData& thesis);
void examine_beverloo_lines(Examination& exam, const ThesisData& thesis);
void examine_table_4_6(Examination& exam, const ThesisData& thesis);
void examine_table_4_7(Examination& exam, const ThesisData& thesis);
void examine_kinematic(Examination& exam, const ThesisData& thesis);
void simulate_micro(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_macro(Examination& exam, const ThesisData& thesis, Studies& studies);

// Chapter 5
void examine_eq_5_1(Examination& exam, const ThesisData& thesis);
void examine_table_5_1(Examination& exam, const ThesisData& thesis);
void examine_table_5_2(Examination& exam, const ThesisData& thesis);
void simulate_shapes(Examination& exam, const ThesisData& thesis, Studies& studies);
// Reads what study-shape has stored; runs nothing
void simulate_table_5_2(Examination& exam, const ThesisData& thesis, Studies& studies);

// Appendices
void examine_decks(Examination& exam, const ThesisData& thesis);
void examine_appendix_e(Examination& exam, const ThesisData& thesis);
void simulate_deck_a(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_deck_b(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_deck_c(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_deck_d(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_deck_e(Examination& exam, const ThesisData& thesis, Studies& studies);
void simulate_deck_f(Examination& exam, const ThesisData& thesis, Studies& studies);

}  // namespace graintruth::app
