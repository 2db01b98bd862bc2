// The verdict: its mark, reason and next step, and folded under it the results in sentences.
#include "datasets/verdict/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "reports/page/parameter_words.h"
#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

std::string confidence_text(const Json& parameter) {
  const double confidence = number(parameter, {"confidence"});
  if (!std::isfinite(confidence)) return "95\u00a0%";
  return plain(confidence <= 1.0 ? 100.0 * confidence : confidence) + "\u00a0%";
}

// "95 % interval 0.10 to 0.14", and what the films alone give where priors are counted.
std::string interval_words(const Json& parameter) {
  const std::string interval = interval_of(parameter);
  if (interval == nothing) return "no interval";
  const std::string alone = interval_of(at(parameter, {"data_alone"}));
  return fmt::format(
      "{} interval {}{}",
      confidence_text(parameter),
      interval,
      alone == nothing ? "" : fmt::format(" with priors, {} from the films alone", alone));
}

// Beside the number: its interval, or why there is none.
std::string parameter_detail(const Json& parameter) {
  const std::string interval = interval_of(parameter);
  if (interval == nothing) return status_words(parameter);
  if (text(parameter, {"status"}) == "not_identified") return interval + " by priors";
  return text(parameter, {"status"}) == "at_bound" ? interval + ", at bound" : interval;
}

// One a parameter that was sought or given. Where nothing can be trusted all are pale.
Json tiles(const RunData& data, const datasets::Verdict& verdict) {
  const bool is_doubtful = verdict.mark == datasets::Mark::does_not_agree ||
                           verdict.mark == datasets::Mark::cannot_be_judged;
  Json views = Json::array();
  for (const auto& [key, parameter] : at(data.result, {"parameters"}).items()) {
    const std::string status = text(parameter, {"status"});
    views.push_back(
        {{"label", parameter_axis(key)},
         {"value", is_undetermined(parameter) ? std::string(nothing) : value_text(parameter)},
         {"detail", is_doubtful ? "" : parameter_detail(parameter)},
         {"muted", is_doubtful || is_undetermined(parameter) || status == "fixed"}});
  }
  return views;
}

bool has_priors(const RunData& data) {
  const Json& parameters = at(data.result, {"parameters"});
  return std::any_of(parameters.begin(), parameters.end(), [](const Json& parameter) {
    return at(parameter, {"prior"}).is_object();
  });
}

std::vector<std::string> parameter_sentences(const RunData& data) {
  std::vector<std::string> tuned;
  std::vector<std::string> sentences;
  std::vector<std::string> others;
  for (const auto& [key, parameter] : at(data.result, {"parameters"}).items()) {
    const std::string status = text(parameter, {"status"});
    const std::string phrase = parameter_phrase(key);
    if (status == "tuned" && is_undetermined(parameter)) {
      others.push_back(fmt::format(
          "The budget ended before the interval of the {} was found. This is no word of the data. "
          "The best value so far is {}. Repeat the command with a larger --budget.",
          phrase,
          value_text(parameter)));
    } else if (status == "tuned") {
      tuned.push_back(
          fmt::format("a {} of {} ({})", phrase, value_text(parameter), interval_words(parameter)));
    } else if (status == "at_bound") {
      others.push_back(fmt::format(
          "The {} ended at the edge of its search bounds, at {}. This is a limit of the "
          "search and not a measurement. Widen the bounds and run again.",
          phrase,
          value_text(parameter)));
    } else if (status == "not_identified") {
      const bool shows_alone =
          number(parameter, {"objective_range"}) > number(parameter, {"objective_range_of_noise"});
      const char* reason =
          shows_alone ? "every value of it fits as well, once the other parameters follow it"
                      : "what was compared hardly changes with it";
      const std::string interval = interval_of(parameter);
      others.push_back(
          interval == nothing
              ? fmt::format(
                    "The {} is not identified: {}. It is held at {} ({}) and has no interval.",
                    phrase,
                    reason,
                    is_at_bench(parameter) ? "its bench value" : "the value that fits best",
                    value_text(parameter))
              : fmt::format(
                    "The {} is not identified: {}. Its value {} and its interval {} rest on "
                    "priors.",
                    phrase,
                    reason,
                    value_text(parameter),
                    interval));
    } else if (status == "fixed") {
      others.push_back(fmt::format("The {} was held at {}.", phrase, value_text(parameter)));
    }
  }
  if (!tuned.empty())
    sentences.push_back(fmt::format("{} {}.",
                                    has_priors(data)
                                        ? "Films and priors together give"
                                        : "The simulation agrees best with the films at",
                                    joined(tuned)));
  sentences.insert(sentences.end(), others.begin(), others.end());
  return sentences;
}

std::string agreement_sentence(const Json& agreement, const std::vector<std::string>& quantities) {
  const double student = number(agreement, {"percent_student_t"});
  const double thesis = number(agreement, {"percent"});
  const double seeds = number(agreement, {"seeds"});
  if (!std::isfinite(student) && !std::isfinite(thesis)) return "";
  const std::string who = std::isfinite(seeds) && seeds > 1
                              ? fmt::format("The mean of {} simulations", count(seeds))
                              : std::string("The simulation");
  return fmt::format(
      "{} lies inside the 95 % interval of the replicates for {} of all values ({} of every "
      "particle in every frame).",
      who,
      percent(std::isfinite(student) ? student : thesis),
      joined(quantities));
}

std::string yardstick_sentence(const Json& agreement) {
  const double ceiling = number(agreement, {"ceiling_percent_student_t"});
  const double left_out = number(agreement, {"leave_one_out_percent_student_t"});
  const double seeds = number(agreement, {"seeds"});
  const double replicates = number(agreement, {"replicates"});
  if (!std::isfinite(ceiling)) return "";
  const std::string next = std::isfinite(replicates)
                               ? ordinal(static_cast<int>(replicates) + 1) + " real replicate"
                               : std::string("further real replicate");
  return fmt::format(
      "Even a perfect model would not score 100 %, because the mean of {} replicates is uncertain. "
      "A perfect model averaged over M = {} runs would score {} on average.{}",
      std::isfinite(replicates) ? count(replicates) : "few",
      count(seeds),
      percent(ceiling),
      std::isfinite(left_out) ? fmt::format(" A {} would score {}.", next, percent(left_out)) : "");
}

// The score beside its ceiling and one more replicate. Two points are about fifteen of 750 values,
// less than neighbouring frames move together.
std::string standing_sentence(const Json& agreement) {
  constexpr double close_percent = 2.0;
  const double score = number(agreement, {"percent_student_t"});
  const double ceiling = number(agreement, {"ceiling_percent_student_t"});
  const double left_out = number(agreement, {"leave_one_out_percent_student_t"});
  if (!std::isfinite(score) || !std::isfinite(ceiling)) return "";
  if (score > ceiling + close_percent) {
    return fmt::format(
        "The score is {} points above what a perfect model reaches on average. This is no "
        "contradiction: the search fitted the mean of just these replicates, and values that move "
        "together fall inside together.",
        decimal(score - ceiling, 1));
  }
  if (score > ceiling - close_percent)
    return "This is what a perfect model reaches: the agreement shows no difference between "
           "simulation and films.";
  if (!std::isfinite(left_out) || score >= left_out) {
    return fmt::format(
        "The score is {} points below that of a perfect model{}: simulation and films still "
        "differ. The ranks and tracks below show where.",
        decimal(ceiling - score, 1),
        std::isfinite(left_out) ? " and above that of one more replicate" : "");
  }
  return fmt::format(
      "The score is {} points below that of one more replicate: simulation and films differ more "
      "than the films differ from each other.",
      decimal(left_out - score, 1));
}

std::string single_run_sentence(const Json& agreement) {
  const double student = number(agreement, {"single_run_median_percent_student_t"});
  if (!std::isfinite(student)) return "";
  return fmt::format(
      "One simulated run alone scores {} in the median. Compare this, and not the mean, with one "
      "more replicate.",
      percent(student));
}

const char* sign_of(datasets::Mark mark) {
  switch (mark) {
    case datasets::Mark::agrees:
      return "\u2713";
    case datasets::Mark::agrees_with_reservations:
      return "!";
    case datasets::Mark::does_not_agree:
      return "\u2717";
    case datasets::Mark::cannot_be_judged:
      return "?";
  }
  return "";
}

// The stage of the run, and how much of it is done.
std::string progress_sentence(const Json& progress) {
  const double share = number(progress, {"share"});
  const double best = number(progress, {"best"});
  return fmt::format(
      "This run is under way, at the stage \u201c{}\u201d: {} of {} evaluations, about {} done "
      "after {}.{} The page reloads itself. If nothing changes, the run was interrupted: give the "
      "same command again, and it continues.",
      text(progress, {"stage"}),
      count(number(progress, {"evaluations"})),
      count(number(progress, {"budget"})),
      percent(100.0 * share),
      seconds(number(progress, {"seconds"})),
      std::isfinite(best) ? fmt::format(" Lowest objective so far: {}.", significant(best)) : "");
}

}  // namespace

Json view_of(const datasets::Verdict& verdict) {
  return {{"mark", datasets::words_of(verdict.mark)},
          {"mark_class", datasets::name_of(verdict.mark)},
          {"mark_sign", sign_of(verdict.mark)},
          {"reason", verdict.reason},
          {"next_step", datasets::next_words(verdict)}};
}

Json verdict_view(const RunData& data) {
  if (data.is_under_way()) return {{"absence", progress_sentence(data.progress)}};
  if (data.result.is_null()) {
    return {{"absence",
             std::filesystem::exists(data.folder.result())
                 ? "There is no verdict: result.json cannot be read."
                 : "This run has no result yet: result.json is absent."}};
  }
  // Runs of older versions have none: it is made of the same data by the same rules
  const auto stated = datasets::verdict_in(data.result);
  const datasets::Verdict verdict = stated ? *stated : datasets::judge(data.result);
  const Json& agreement = at(data.result, {"agreement"});
  const Json& warnings = list(data.result, {"warnings"});
  std::vector<std::string> sentences = parameter_sentences(data);
  for (std::string sentence : {agreement_sentence(agreement, compared_quantities(data)),
                               yardstick_sentence(agreement),
                               standing_sentence(agreement),
                               single_run_sentence(agreement)})
    if (!sentence.empty()) sentences.push_back(std::move(sentence));
  for (const std::vector<std::string>& more :
       {compared_sentences(data), flow_sentences(data), experiment_sentences(data)})
    sentences.insert(sentences.end(), more.begin(), more.end());
  if (!data.is_calibration()) {
    sentences.emplace_back(
        "The parameters were given, and nothing was tuned in this run. This page does not know "
        "whether these films served to find them.");
  } else if (!data.has_held_out()) {
    sentences.emplace_back(
        "The same films served to find these values and to score them. Nothing was held out, so "
        "this is a calibration and not a validation.");
  }
  Json view = view_of(verdict);
  view["tiles"] = tiles(data, verdict);
  view["told"] = true;
  view["sentences"] = sentences;
  view["status"] = text(data.result, {"status"});
  view["message"] = text(data.result, {"message"});
  view["warnings"] = warnings.empty() ? Json() : Json{{"warning_sentences", warnings}};
  return view;
}

}  // namespace graintruth::reports
