// Whether a result can be used, in one line: a mark, its reason, and what to do next.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace graintruth::datasets {

enum class Mark { agrees, agrees_with_reservations, does_not_agree, cannot_be_judged };
// As result.json calls it: "agrees_with_reservations".
std::string_view name_of(Mark mark);
// As a reader reads it: "Agrees with reservations".
std::string_view words_of(Mark mark);

struct Verdict {
  Mark mark = Mark::cannot_be_judged;
  std::string reason;     // whole sentences
  std::string next_step;  // one sentence
};

// "Next: export the parameters."
std::string next_words(const Verdict& verdict);
// The mark, its reason and "Next: " with the next step, as the terminal, result.json and the page
// show it. At most 45 words.
std::string sentence_of(const Verdict& verdict);

// Decides from result.json alone, by the first of these rules that applies:
//   0. More than half of the simulations failed: cannot be judged.
//   1. Nothing was compared, or no scatter between replicates is known: cannot be judged.
//   2. The simulation differs and the budget ended the search: cannot be judged.
//   3. The simulation differs: does not agree.
//   4. Fewer than three replicates were compared by their tracks: cannot be judged, because their
//      interval is so wide that a wrong model passes too.
//   5. The budget ended before any interval was found: cannot be judged.
//   6. The data determine none of the parameters: cannot be judged, because every value agrees.
//   7. A warning of the first line, an interval that the budget left unfinished, a parameter at its
//      bound, or values that differ here and there: agrees with reservations.
//   8. Otherwise: agrees.
// "Differs" is, of tracks and heights, a score below that of one more replicate. Of all other
// quantities it is more than half of the values beyond sqrt(2) times the half-width of the measured
// interval, because the simulated mean scatters as the measured one does; of rates of a bin, beyond
// 2 u_val (ASME V&V 20). "Here and there" is a score below that of a perfect model by more than
// particles differ from each other (95 %), or more values beyond than chance puts there (95 %).
Verdict judge(const nlohmann::ordered_json& result);

// What result.json holds of it, and back; nothing where an older version wrote none.
void add_verdict(nlohmann::ordered_json& result);
std::optional<Verdict> verdict_in(const nlohmann::ordered_json& result);

}  // namespace graintruth::datasets
