// Holds one target's printed numbers beside what comes out, and finds the word for each.
#pragma once

#include <string>

#include "app/thesis/row.h"
#include "app/thesis/thesis_data.h"

namespace graintruth::app {

// What several runs gave.
struct Simulated {
  double mean = no_number;
  double spread = no_number;  // standard deviation over the seeds; NaN for one
  int seeds = 1;
};
Simulated over_seeds(const std::vector<double>& values);

class Examination {
 public:
  Examination(std::string target, std::string what, const ThesisData& thesis);

  // From printed data. Reproduced when `recomputed` rounds to the printed digits (or lies within
  // `tolerance`, where that is given: the rounding of what it was computed from). Otherwise the
  // errata must list these digits, and the correct ones must be those recomputed: misprint (not
  // confirmed where the errata cannot explain them either). All else is FAIL, as is an erratum
  // about digits that agree.
  Row& compare(const std::string& where,
               const Printed& printed,
               double recomputed,
               const std::string& note = "");
  Row& compare_within(const std::string& where,
                      const Printed& printed,
                      double recomputed,
                      double tolerance,
                      const std::string& note = "");
  // The same of a number in the running text.
  Row& compare_worded(const std::string& where, double recomputed, const std::string& note = "");

  // A measured value that is taken as it is.
  Row& take(const std::string& where, const Printed& printed, const std::string& note = "");

  // A claim of the thesis about its simulations, held against ours: confirmed when `agrees`,
  // otherwise not confirmed.
  Row& claim(const std::string& where,
             const Printed& printed,
             const Simulated& simulated,
             double tolerance,
             bool agrees,
             const std::string& note = "");
  // Confirmed when the mean lies within `tolerance` of the printed value.
  Row& claim_value(const std::string& where,
                   const Printed& printed,
                   const Simulated& simulated,
                   double tolerance,
                   const std::string& note = "");
  // The same with a run in the thesis's own manner beside it. Contradicted when ours does not agree
  // with five seeds or more while that run does, which shows why.
  Row& contradictable(const std::string& where,
                      const Printed& printed,
                      const Simulated& simulated,
                      double tolerance,
                      bool agrees,
                      bool compatible_run_agrees,
                      const std::string& note);
  // A claim that no run of ours has looked at. The row gives way where a later one is about the
  // same place.
  Row& not_run(const std::string& where, const Printed& printed, const std::string& note);

  void add_curve(Curve curve) { result_.curves.push_back(std::move(curve)); }
  void add_note(std::string sentence) { result_.notes.push_back(std::move(sentence)); }

  const std::string& target() const { return result_.name; }

  // All rows, and a FAIL for every erratum of this target that gives a correct number and met no
  // row.
  TargetResult finish();

 private:
  const Erratum* erratum_at(const std::string& where);
  Row& add(const std::string& where, const Printed& printed, const std::string& note);

  TargetResult result_;
  const ThesisData& thesis_;
  std::vector<Erratum> errata_;  // of this target
  std::vector<bool> met_;        // one an erratum
};

}  // namespace graintruth::app
