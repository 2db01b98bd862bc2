// The sections of the page, one file each, in the order in which the reader meets them.
#pragma once

#include "datasets/verdict/verdict.h"
#include "reports/page/page.h"
#include "reports/page/run_data.h"

namespace graintruth::reports {

Json verdict_view(const RunData& data);  // verdict.mustache: whether it can be used, and what next
// Mark, reason and next step of verdict.mustache.
Json view_of(const datasets::Verdict& verdict);
// Whether the run left what these sections show.
bool has_comparisons(const RunData& data);
bool has_tracks(const RunData& data);
bool has_outlines(const RunData& data);
// What section "What was compared" shows, in sentences; without what the agreement and the flow
// tell.
std::vector<std::string> compared_sentences(const RunData& data);
// What the flow section shows; empty where no flow was compared.
std::vector<std::string> flow_sentences(const RunData& data);
// What the experiments section shows; empty unless several were calibrated together.
std::vector<std::string> experiment_sentences(const RunData& data);

// Each fills the empty section that it is given. Throws datasets::InputError when a table that it
// needs cannot be understood.
Section parameters_section(const RunData& data, Section section);
Section experiments_section(const RunData& data, Section section);
Section side_by_side_section(const RunData& data, Section section);
Section compared_section(const RunData& data, Section section);
Section surface_section(const RunData& data, Section section);
Section flow_section(const RunData& data, Section section);
Section agreement_section(const RunData& data, Section section);
Section thesis_section(const RunData& data, Section section);
Section tracks_section(const RunData& data, Section section);
Section search_section(const RunData& data, Section section);
Section time_step_section(const RunData& data, Section section);
Section films_section(const RunData& data, Section section);
Section provenance_section(const RunData& data, Section section);

}  // namespace graintruth::reports
