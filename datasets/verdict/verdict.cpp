#include "datasets/verdict/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <cctype>
#include <cmath>
#include <numbers>
#include <vector>

#include "datasets/parameters/parameter.h"
#include "datasets/store/json_values.h"

namespace graintruth::datasets {

namespace {

// ------------------------------------------------------------------ how well a simulation agrees

enum class Fit { unknown, agrees, partly, differs };

// One thing that was compared.
struct Compared {
  Fit fit = Fit::unknown;
  std::string words;  // how it came out, a clause
};

std::string percent_words(double value) { return fmt::format("{:.0f} %", value); }

// The scores of particles scatter as the score does from one part of the experiment to another:
// half of the 95 % interval of their mean (Student).
double margin_of_score(const Json& agreement) {
  constexpr double of_one_body = 2.0;  // points; 15 of 750 values, fewer than move together
  std::vector<double> scores;
  for (const Json& particle : list(agreement, {"per_particle"})) {
    const double score = number(particle, {"percent_student_t"});
    if (std::isfinite(score)) scores.push_back(score);
  }
  if (scores.size() < 2) return of_one_body;
  const auto n = static_cast<double>(scores.size());
  double sum = 0.0, squares = 0.0;
  for (const double score : scores) sum += score;
  for (const double score : scores) squares += (score - sum / n) * (score - sum / n);
  const boost::math::students_t distribution(n - 1.0);
  return boost::math::quantile(distribution, 0.975) * std::sqrt(squares / (n - 1.0) / n);
}

Compared compare_score(const Json& agreement) {
  const double score = number(agreement, {"percent_student_t"});
  const double perfect = number(agreement, {"ceiling_percent_student_t"});
  const double further = number(agreement, {"leave_one_out_percent_student_t"});
  if (!std::isfinite(score) || !std::isfinite(perfect)) return {};
  if (score < further) {
    return {Fit::differs,
            fmt::format("only {} of the simulated values lie inside the replicates' interval (a "
                        "further replicate: {})",
                        percent_words(score),
                        percent_words(further))};
  }
  return {score + margin_of_score(agreement) < perfect ? Fit::partly : Fit::agrees,
          fmt::format("{} of the simulated values lie inside the replicates' interval (a perfect "
                      "model on average: {})",
                      percent_words(score),
                      percent_words(perfect))};
}

// How many of how many values differ by more than chance puts apart.
struct Tally {
  std::string title;
  bool is_predicted = false;
  int values = 0, differing = 0;
  double independent = 0.0;  // that so many are worth; 0: all of them

  void add(double apart, double allowed) {
    if (!std::isfinite(apart) || !std::isfinite(allowed)) return;
    ++values;
    if (std::abs(apart) > allowed) ++differing;
  }
};

Compared compare_values(const Tally& tally) {
  constexpr double by_chance = 0.05;  // of the values of a perfect model
  if (tally.values == 0) return {};
  Fit fit = Fit::agrees;
  if (2 * tally.differing > tally.values) {
    fit = Fit::differs;
  } else if (tally.differing > 0) {
    // Values that vary together differ together: as many as they are worth, with the same share
    const double values =
        tally.independent > 0.0 ? std::min<double>(tally.independent, tally.values) : tally.values;
    const double differing = tally.differing * values / tally.values;
    if (boost::math::ibeta(differing, values - differing + 1.0, by_chance) < by_chance)
      fit = Fit::partly;
  }
  const char* predicted = tally.is_predicted ? " (predicted, not fitted)" : "";
  return {fit,
          tally.values == 1 ? fmt::format("{}{} {} by more than chance",
                                          tally.title,
                                          predicted,
                                          fit == Fit::agrees ? "does not differ" : "differs")
                            : fmt::format("{}{}: {} of {} values differ by more than chance",
                                          tally.title,
                                          predicted,
                                          tally.differing,
                                          tally.values)};
}

// Units of the values of one moment in turn, "m, m, rad": directions repeat every half turn.
bool is_direction(const Json& channel, std::size_t i, std::size_t values) {
  const std::size_t moments = list(channel, {"axis", "values"}).size();
  if (moments < 2 || values <= moments) return false;
  std::vector<std::string> units;
  std::string rest = text(channel, {"unit"});
  for (auto comma = rest.find(", "); comma != std::string::npos; comma = rest.find(", ")) {
    units.push_back(rest.substr(0, comma));
    rest.erase(0, comma + 2);
  }
  units.push_back(rest);
  return units[i % units.size()] == "rad";
}

void add_channel(const Json& channel, Tally& tally) {
  const std::vector<double> measured = numbers(channel, {"measured"}),
                            simulated = numbers(channel, {"simulated"}),
                            lower = numbers(channel, {"lower"}),
                            upper = numbers(channel, {"upper"});
  const std::size_t values = std::min({simulated.size(), lower.size(), upper.size()});
  for (std::size_t i = 0; i < values; ++i) {
    double apart = simulated[i] - 0.5 * (lower[i] + upper[i]);
    if (is_direction(channel, i, measured.size())) apart = std::remainder(apart, std::numbers::pi);
    tally.add(apart, std::numbers::sqrt2 * 0.5 * (upper[i] - lower[i]));
  }
  // Of several conditions together
  const double independent = number(channel, {"independent_values"});
  if (std::isfinite(independent)) tally.independent += independent;
}

Tally& tally_of(std::vector<Tally>& all, const std::string& title, bool is_predicted) {
  for (Tally& tally : all)
    if (tally.title == title && tally.is_predicted == is_predicted) return tally;
  all.push_back({.title = title, .is_predicted = is_predicted});
  return all.back();
}

// Everything that was compared, once each: what the score is of, and rates with their own
// uncertainty, are not told again by their channels.
std::vector<Compared> compare_all(const Json& result) {
  std::vector<Compared> all;
  const Json& agreement = at(result, {"agreement"});
  if (agreement.is_object()) all.push_back(compare_score(agreement));
  const bool is_calibration = !text(result, {"kind"}).ends_with("validation");
  const Json& rates = list(result, {"comparison"});
  std::vector<Tally> tallies;
  for (const Json& rate : rates) {
    Tally& tally =
        tally_of(tallies, "Discharge rate", is_calibration && at(rate, {"held_out"}) == true);
    tally.add(number(rate, {"error_kg_per_s"}),
              2.0 * number(rate, {"validation_uncertainty_kg_per_s"}));
  }
  for (const Json& channel : list(result, {"channels"})) {
    const std::string name = text(channel, {"observable"});
    const bool is_predicted = is_calibration && at(channel, {"held_out"}) == true;
    const bool is_scored = agreement.is_object() && (name == "tracks" || name == "heap_height");
    if ((is_scored && !is_predicted) || (name == "discharge_rate" && !rates.empty())) continue;
    std::string title = text(channel, {"title"});
    if (title.empty()) title = name;
    add_channel(channel, tally_of(tallies, title, is_predicted));
  }
  for (const Tally& tally : tallies) all.push_back(compare_values(tally));
  for (const Json& experiment : list(result, {"experiments"})) {
    const auto own = verdict_in(experiment);
    if (!own) continue;
    const Fit fit = own->mark == Mark::agrees                     ? Fit::agrees
                    : own->mark == Mark::agrees_with_reservations ? Fit::partly
                    : own->mark == Mark::does_not_agree           ? Fit::differs
                                                                  : Fit::unknown;
    std::string words(words_of(own->mark));
    words[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(words[0])));
    all.push_back({fit, fmt::format("experiment {} {}", text(experiment, {"name"}), words)});
  }
  std::erase_if(all, [](const Compared& one) { return one.fit == Fit::unknown; });
  return all;
}

// ------------------------------------------------------------------ what is known of parameters

struct Parameters {
  std::vector<std::string> determined, not_determined, unfinished, half_finished, at_bound;
  bool are_sought() const {
    return !determined.empty() || !not_determined.empty() || !unfinished.empty() ||
           !half_finished.empty();
  }
};

std::string phrase_of(const std::string& name) {
  const auto parameter = find_parameter(name);
  return parameter ? parameter->phrase() : name;
}

Parameters parameters_of(const Json& result) {
  Parameters all;
  for (const auto& item : at(result, {"parameters"}).items()) {
    const std::string& name = item.key();
    const auto& parameter = item.value();
    const std::string status = text(parameter, {"status"});
    const auto is_unfinished = [&](const char* end) {
      return text(parameter, {end}) == "budget_ended";
    };
    const auto is_found = [&](const char* end) {
      const std::string kind = text(parameter, {end});
      return kind.empty() || kind == "found";
    };
    if (status == "not_identified") {
      all.not_determined.push_back(phrase_of(name));
    } else if (status == "tuned" || status == "at_bound") {
      const bool is_open = !is_found("lower_end") && !is_found("upper_end");
      const bool budget_ended = is_unfinished("lower_end") || is_unfinished("upper_end");
      if (status == "at_bound") all.at_bound.push_back(phrase_of(name));
      (!budget_ended ? all.determined
       : is_open     ? all.unfinished
                     : all.half_finished)
          .push_back(phrase_of(name));
    }
  }
  return all;
}

// "a", "a and b", "a and 2 others"
std::string joined(const std::vector<std::string>& all) {
  if (all.size() == 2) return all[0] + " and " + all[1];
  return all.size() < 2 ? all[0] : fmt::format("{} and {} others", all[0], all.size() - 1);
}

std::size_t words_in(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), ' ')) + 1;
}

std::string capitalised(std::string words) {
  if (!words.empty())
    words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  return words;
}

// ------------------------------------------------------------------ the rules

struct Facts {
  bool is_calibration = false;
  int replicates = -1;                     // that the score is of; -1: no score
  double failed = 0.0, simulations = 0.0;  // NaN where a result does not tell
  std::vector<Compared> compared;
  Parameters parameters;
  struct Doubt {
    std::string cause, next_step;
  };
  std::vector<Doubt> doubts;  // warnings of the first line

  bool budget_ended() const {
    return !parameters.unfinished.empty() || !parameters.half_finished.empty();
  }
  const Compared* first(Fit fit) const {
    const auto found = std::find_if(
        compared.begin(), compared.end(), [&](const Compared& one) { return one.fit == fit; });
    return found == compared.end() ? nullptr : &*found;
  }
};

Facts facts_of(const Json& result) {
  Facts facts{.is_calibration = !text(result, {"kind"}).ends_with("validation"),
              .failed = number(result, {"failed"}),
              .simulations = number(result, {"simulations"}),
              .compared = compare_all(result),
              .parameters = parameters_of(result)};
  const double replicates = number(result, {"agreement", "replicates"});
  if (std::isfinite(replicates)) facts.replicates = static_cast<int>(replicates);
  for (const Json& warning : list(result, {"first_line_warnings"}))
    facts.doubts.push_back({text(warning, {"cause"}), text(warning, {"next_step"})});
  if (facts.is_calibration && at(result, {"time_step", "converged"}) == false &&
      at(result, {"first_line_warnings"}).is_null())  // of versions without that list
    facts.doubts.push_back({"the time step is not resolved, so the result depends on it",
                            "Look at the time-step study"});
  return facts;
}

constexpr std::size_t most_words = 20;  // of a reason
constexpr const char* larger_budget = "Repeat the command with a larger --budget";

std::optional<Verdict> most_failed(const Facts& facts) {
  if (!(2.0 * facts.failed > facts.simulations)) return std::nullopt;
  return Verdict{
      Mark::cannot_be_judged,
      fmt::format("{:.0f} of {:.0f} simulations failed.", facts.failed, facts.simulations),
      "See journal.csv for why they failed"};
}

std::optional<Verdict> nothing_compared(const Facts& facts) {
  if (!facts.compared.empty()) return std::nullopt;
  return Verdict{
      Mark::cannot_be_judged,
      "No compared quantity has both an interval of the replicates and a simulated value.",
      "Film more replicates, or look at why simulations failed"};
}

std::optional<Verdict> differs_before_the_search_ended(const Facts& facts) {
  const Compared* worst = facts.first(Fit::differs);
  if (worst == nullptr || !facts.budget_ended()) return std::nullopt;
  return Verdict{Mark::cannot_be_judged,
                 fmt::format("The budget ended before the search did: {}.", worst->words),
                 larger_budget};
}

std::optional<Verdict> differs(const Facts& facts) {
  const Compared* worst = facts.first(Fit::differs);
  if (worst == nullptr) return std::nullopt;
  Verdict verdict{Mark::does_not_agree,
                  capitalised(worst->words) + ".",
                  facts.is_calibration
                      ? "Check rig, grains, start and bounds in the experiment file"
                      : "Check rig and grains, or calibrate on these data"};
  if (facts.doubts.empty()) return verdict;
  verdict.reason += fmt::format(" {}.", capitalised(facts.doubts[0].cause));
  verdict.next_step = facts.doubts[0].next_step;
  return verdict;
}

std::optional<Verdict> too_few_replicates(const Facts& facts) {
  constexpr int needed = 3;  // so that one can be judged by the others
  if (facts.replicates < 0 || facts.replicates >= needed) return std::nullopt;
  return Verdict{Mark::cannot_be_judged,
                 fmt::format("With {} replicates the interval is so wide that a wrong model would "
                             "pass too.",
                             facts.replicates),
                 "Film more replicates: three at least, five are better"};
}

std::optional<Verdict> no_interval_found(const Facts& facts) {
  const Parameters& parameters = facts.parameters;
  if (!facts.budget_ended() || !parameters.determined.empty() || !parameters.half_finished.empty())
    return std::nullopt;
  return Verdict{Mark::cannot_be_judged,
                 "The budget ended before the interval of any parameter was found. This is no word "
                 "of the data.",
                 larger_budget};
}

std::optional<Verdict> nothing_determined(const Facts& facts) {
  const Parameters& parameters = facts.parameters;
  if (!facts.is_calibration || parameters.not_determined.empty() ||
      !parameters.determined.empty() || facts.budget_ended())
    return std::nullopt;
  return Verdict{Mark::cannot_be_judged,
                 fmt::format("Simulation and data agree at any value of {}: these data do not "
                             "determine {}.",
                             joined(parameters.not_determined),
                             parameters.not_determined.size() == 1 ? "it" : "them"),
                 "Measure what depends on it more, or take a bench value"};
}

// The gravest first; as many are named as a glance takes in.
std::optional<Verdict> with_reservations(const Facts& facts) {
  std::vector<Facts::Doubt> all = facts.doubts;
  std::vector<std::string> unfinished = facts.parameters.unfinished;
  unfinished.insert(unfinished.end(),
                    facts.parameters.half_finished.begin(),
                    facts.parameters.half_finished.end());
  if (!unfinished.empty()) {
    all.push_back(
        {fmt::format("the budget ended before the interval of {} was found", joined(unfinished)),
         larger_budget});
  }
  if (const Compared* partly = facts.first(Fit::partly); partly != nullptr)
    all.push_back({partly->words, "Look at the figures below for where they differ"});
  if (!facts.parameters.at_bound.empty()) {
    all.push_back(
        {fmt::format("{} ended at a bound of the search", joined(facts.parameters.at_bound)),
         "Widen the bounds and repeat the command"});
  }
  if (all.empty()) return std::nullopt;
  std::string reason = capitalised(all[0].cause) + ".";
  std::size_t named = 1;
  for (; named < all.size(); ++named) {
    const std::string more = fmt::format(" {}.", capitalised(all[named].cause));
    if (words_in(reason) + words_in(more) > most_words) break;
    reason += more;
  }
  if (named < all.size()) reason += fmt::format(" {} more below.", all.size() - named);
  return Verdict{Mark::agrees_with_reservations, reason, all[0].next_step};
}

std::optional<Verdict> agrees(const Facts& facts) {
  std::string reason = capitalised(facts.compared.front().words) + ".";
  const auto& open = facts.parameters.not_determined;
  if (!open.empty()) {
    reason += fmt::format(" These data do not determine {}.", joined(open));
  }
  return Verdict{Mark::agrees,
                 reason,
                 facts.is_calibration ? "Export the parameters, or validate them on other films"
                                      : "Use these parameters for motions like this one"};
}

using Rule = std::optional<Verdict> (*)(const Facts& facts);
constexpr std::array<Rule, 9> rules = {most_failed,
                                       nothing_compared,
                                       differs_before_the_search_ended,
                                       differs,
                                       too_few_replicates,
                                       no_interval_found,
                                       nothing_determined,
                                       with_reservations,
                                       agrees};

constexpr std::array all_marks = {
    Mark::agrees, Mark::agrees_with_reservations, Mark::does_not_agree, Mark::cannot_be_judged};

}  // namespace

std::string_view name_of(Mark mark) {
  switch (mark) {
    case Mark::agrees:
      return "agrees";
    case Mark::agrees_with_reservations:
      return "agrees_with_reservations";
    case Mark::does_not_agree:
      return "does_not_agree";
    case Mark::cannot_be_judged:
      return "cannot_be_judged";
  }
  return "";
}

std::string_view words_of(Mark mark) {
  switch (mark) {
    case Mark::agrees:
      return "Agrees";
    case Mark::agrees_with_reservations:
      return "Agrees with reservations";
    case Mark::does_not_agree:
      return "Does not agree";
    case Mark::cannot_be_judged:
      return "Cannot be judged";
  }
  return "";
}

std::string next_words(const Verdict& verdict) {
  std::string step = verdict.next_step;
  // An abbreviation keeps its capitals
  if (step.size() > 1 && std::islower(static_cast<unsigned char>(step[1])) != 0)
    step[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(step[0])));
  return fmt::format("Next: {}.", step);
}

std::string sentence_of(const Verdict& verdict) {
  return fmt::format("{}. {} {}", words_of(verdict.mark), verdict.reason, next_words(verdict));
}

Verdict judge(const Json& result) {
  const Facts facts = facts_of(result);
  for (const Rule rule : rules)
    if (auto verdict = rule(facts)) return *std::move(verdict);
  return {};  // the last rule always applies
}

void add_verdict(Json& result) {
  const Verdict verdict = judge(result);
  result["verdict"] = {{"mark", name_of(verdict.mark)},
                       {"reason", verdict.reason},
                       {"next_step", verdict.next_step},
                       {"sentence", sentence_of(verdict)}};
}

std::optional<Verdict> verdict_in(const Json& result) {
  const std::string name = text(result, {"verdict", "mark"});
  for (const Mark mark : all_marks) {
    if (name_of(mark) == name)
      return Verdict{
          mark, text(result, {"verdict", "reason"}), text(result, {"verdict", "next_step"})};
  }
  return std::nullopt;
}

}  // namespace graintruth::datasets
