// The verdict: the results in sentences.
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

std::string parameter_detail(const Json& parameter) {
  const std::string status = text(parameter, {"status"});
  const std::string interval = interval_of(parameter);
  if (status == "not_identified" && interval != nothing)
    return fmt::format("not identified by this experiment; {} by priors", interval);
  if (status == "not_identified") {
    return is_at_bench(parameter)
               ? "not identified by this experiment; held at its bench value"
               : "not identified by this experiment; at the value that fits best";
  }
  if (status == "fixed") return "given, not tuned";
  if (status == "at_bound") return "at the edge of its search bounds";
  return interval_words(parameter);
}

Json tiles(const RunData& data) {
  Json views = Json::array();
  for (const auto& [key, parameter] : at(data.result, {"parameters"}).items()) {
    const std::string status = text(parameter, {"status"});
    views.push_back({{"label", parameter_name(key)},
                     {"value", value_text(parameter)},
                     {"detail", parameter_detail(parameter)},
                     {"muted", status == "not_identified" || status == "fixed"}});
  }
  const double student = number(data.result, {"agreement", "percent_student_t"});
  const double thesis = number(data.result, {"agreement", "percent"});
  if (std::isfinite(student) || std::isfinite(thesis)) {
    views.push_back(
        {{"label", "Agreement"},
         {"value", percent(std::isfinite(student) ? student : thesis)},
         {"detail",
          std::isfinite(student)
              ? fmt::format("Student form; {} in the thesis form (1.96)", percent(thesis))
              : "thesis form (1.96)"},
         {"muted", false}});
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
    if (status == "tuned") {
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
      "{} lies inside the films' 95 % confidence interval for {} of all values ({} of every "
      "particle in every frame), with Student's interval. In the thesis's form with 1.96 it is {}.",
      who,
      percent(student),
      joined(quantities),
      percent(thesis));
}

std::string yardstick_sentence(const Json& agreement) {
  const double ceiling = number(agreement, {"ceiling_percent_student_t"});
  const double thesis_ceiling = number(agreement, {"ceiling_percent"});
  const double left_out = number(agreement, {"leave_one_out_percent_student_t"});
  const double thesis_left_out = number(agreement, {"leave_one_out_percent"});
  const double seeds = number(agreement, {"seeds"});
  const double replicates = number(agreement, {"replicates"});
  if (!std::isfinite(ceiling) && !std::isfinite(thesis_ceiling)) return "";
  const std::string next = std::isfinite(replicates)
                               ? ordinal(static_cast<int>(replicates) + 1) + " real replicate"
                               : std::string("further real replicate");
  return fmt::format(
      "Even a perfect model would not score 100 %, because the mean of {} replicates is uncertain. "
      "A perfect model averaged over M = {} runs would score {} ({} in the thesis form). A {} "
      "would score {} ({}).",
      std::isfinite(replicates) ? count(replicates) : "few",
      count(seeds),
      percent(ceiling),
      percent(thesis_ceiling),
      next,
      percent(left_out),
      percent(thesis_left_out));
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
        "The score is {} points above that ceiling. A perfect model would not be: either the "
        "search fitted the chance mean of these replicates, or values that move together fell "
        "inside together by chance.",
        decimal(score - ceiling, 1));
  }
  if (score > ceiling - close_percent)
    return "The score is at its ceiling: the agreement shows no difference between simulation and "
           "films.";
  if (!std::isfinite(left_out) || score >= left_out) {
    return fmt::format(
        "The score is {} points below its ceiling{}: simulation and films still differ. The ranks "
        "and tracks below show where.",
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
  const double thesis = number(agreement, {"single_run_median_percent"});
  if (!std::isfinite(student) && !std::isfinite(thesis)) return "";
  return fmt::format(
      "One simulated run alone scores {} in the median ({} in the thesis form). Compare this, and "
      "not the mean, with one more replicate.",
      percent(student),
      percent(thesis));
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

Json verdict_view(const RunData& data) {
  if (data.is_under_way()) {
    return {{"absence", progress_sentence(data.progress)},
            {"tiles", Json::array()},
            {"sentences", Json::array()},
            {"warnings", nullptr}};
  }
  if (data.result.is_null()) {
    return {{"absence",
             std::filesystem::exists(data.folder.result())
                 ? "There is no verdict: result.json cannot be read."
                 : "This run has no result yet: result.json is absent."},
            {"tiles", Json::array()},
            {"sentences", Json::array()},
            {"warnings", nullptr}};
  }
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
  return {{"absence", ""},
          {"tiles", tiles(data)},
          {"sentences", sentences},
          {"status", text(data.result, {"status"})},
          {"message", text(data.result, {"message"})},
          {"warnings", warnings.empty() ? Json() : Json{{"warning_sentences", warnings}}}};
}

}  // namespace graintruth::reports
