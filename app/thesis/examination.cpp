#include "app/thesis/examination.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "calibrate/compare/hypothesis_tests.h"

namespace graintruth::app {

namespace {

// A number that lies exactly between two roundings may be printed either way.
constexpr double edge = 1.0 + 1e-9;

bool within(double value, double wanted, double tolerance) {
  return std::abs(value - wanted) <= tolerance * edge;
}

void append(std::string& note, const std::string& sentence) {
  if (sentence.empty()) return;
  if (!note.empty()) note += "; ";
  note += sentence;
}

}  // namespace

std::string_view word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::reproduced:
      return "reproduced";
    case Verdict::misprint:
      return "misprint";
    case Verdict::input:
      return "input";
    case Verdict::confirmed:
      return "confirmed";
    case Verdict::not_confirmed:
      return "not confirmed";
    case Verdict::contradicted:
      return "contradicted";
    case Verdict::fail:
      return "FAIL";
  }
  throw std::logic_error("no such verdict");
}

Simulated over_seeds(const std::vector<double>& values) {
  if (values.empty()) return {};
  if (values.size() == 1) return {.mean = values.front()};
  const calibrate::SampleSummary summary = calibrate::summarise(values);
  return {summary.mean, summary.standard_deviation, summary.count};
}

Examination::Examination(std::string target, std::string what, const ThesisData& thesis)
    : result_{.name = std::move(target), .what = std::move(what)}, thesis_(thesis) {
  for (Erratum& erratum : thesis.errata()) {
    if (erratum.target == result_.name) errata_.push_back(std::move(erratum));
  }
  met_.assign(errata_.size(), false);
}

const Erratum* Examination::erratum_at(const std::string& where) {
  for (std::size_t i = 0; i < errata_.size(); ++i) {
    if (errata_[i].where != where) continue;
    met_[i] = true;
    return &errata_[i];
  }
  return nullptr;
}

Row& Examination::add(const std::string& where, const Printed& printed, const std::string& note) {
  auto row = std::find_if(result_.rows.begin(), result_.rows.end(), [&](const Row& earlier) {
    return earlier.where == where && earlier.was_not_run;
  });
  if (row == result_.rows.end()) row = result_.rows.emplace(row);
  *row = {.where = where,
          .printed = printed.text,
          .unit = printed.unit,
          .note = note,
          .source = printed.source};
  if (printed.source.starts_with("derived")) append(row->note, "not printed: derived from what is");
  return *row;
}

Row& Examination::compare(const std::string& where,
                          const Printed& printed,
                          double recomputed,
                          const std::string& note) {
  return compare_within(where, printed, recomputed, printed.rounding(), note);
}

Row& Examination::compare_within(const std::string& where,
                                 const Printed& printed,
                                 double recomputed,
                                 double tolerance,
                                 const std::string& note) {
  Row& row = add(where, printed, note);
  row.recomputed = recomputed;
  row.tolerance = tolerance;
  const bool agrees = within(recomputed, printed.value(), tolerance);
  const Erratum* erratum = erratum_at(where);
  if (erratum == nullptr) {
    row.verdict = agrees ? Verdict::reproduced : Verdict::fail;
    if (!agrees) append(row.note, "differs, and no erratum says why");
    return row;
  }
  row.errata = erratum->number;
  const Printed correct{erratum->correct, printed.unit, ""};
  const bool is_known =
      erratum->printed == printed.text && within(recomputed, correct.value(), correct.rounding());
  if (!agrees && is_known)
    row.verdict = erratum->tag == "UNX" ? Verdict::not_confirmed : Verdict::misprint;
  append(row.note, erratum->evidence);
  if (agrees) append(row.note, "the digits agree, although an erratum says that they do not");
  if (!agrees && !is_known) {
    append(row.note,
           fmt::format(
               "the erratum is about {} and says {} is right", erratum->printed, erratum->correct));
  }
  return row;
}

Row& Examination::compare_worded(const std::string& where,
                                 double recomputed,
                                 const std::string& note) {
  return compare(where, thesis_.worded(result_.name, where), recomputed, note);
}

Row& Examination::take(const std::string& where, const Printed& printed, const std::string& note) {
  Row& row = add(where, printed, note);
  row.verdict = Verdict::input;
  return row;
}

Row& Examination::claim(const std::string& where,
                        const Printed& printed,
                        const Simulated& simulated,
                        double tolerance,
                        bool agrees,
                        const std::string& note) {
  Row& row = add(where, printed, note);
  row.simulated = simulated.mean;
  row.spread = simulated.spread;
  row.seeds = simulated.seeds;
  row.tolerance = tolerance;
  row.verdict = agrees ? Verdict::confirmed : Verdict::not_confirmed;
  if (const Erratum* erratum = erratum_at(where)) {
    row.errata = erratum->number;
    append(row.note, erratum->evidence);
  }
  return row;
}

Row& Examination::claim_value(const std::string& where,
                              const Printed& printed,
                              const Simulated& simulated,
                              double tolerance,
                              const std::string& note) {
  return claim(where,
               printed,
               simulated,
               tolerance,
               within(simulated.mean, printed.value(), tolerance),
               note);
}

Row& Examination::contradictable(const std::string& where,
                                 const Printed& printed,
                                 const Simulated& simulated,
                                 double tolerance,
                                 bool agrees,
                                 bool compatible_run_agrees,
                                 const std::string& note) {
  constexpr int enough_seeds = 5;
  Row& row = claim(where, printed, simulated, tolerance, agrees, note);
  if (!agrees && compatible_run_agrees && simulated.seeds >= enough_seeds)
    row.verdict = Verdict::contradicted;
  return row;
}

Row& Examination::not_run(const std::string& where,
                          const Printed& printed,
                          const std::string& note) {
  Row& row = add(where, printed, note);
  row.verdict = Verdict::not_confirmed;
  row.was_not_run = true;
  return row;
}

TargetResult Examination::finish() {
  for (std::size_t i = 0; i < errata_.size(); ++i) {
    if (met_[i] || errata_[i].correct.empty()) continue;
    Row& row = add(errata_[i].where, {errata_[i].printed, "", ""}, "");
    row.errata = errata_[i].number;
    row.verdict = Verdict::fail;
    row.note = "the errata list this, but no row of the target bears it out";
  }
  return std::move(result_);
}

}  // namespace graintruth::app
