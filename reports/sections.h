// The sections of the page, one file each, in the order in which the reader meets them.
#pragma once

#include "reports/page.h"
#include "reports/run_data.h"

namespace graintruth::reports {

Json verdict_view(const RunData& data);  // verdict.mustache: what came out, and how to read it
Section parameters_section(const RunData& data);
// What the flow section shows, in sentences; empty where no flow was compared.
std::vector<std::string> flow_sentences(const RunData& data);
Section flow_section(const RunData& data);
Section agreement_section(const RunData& data);
Section tracks_section(const RunData& data);
Section search_section(const RunData& data);
Section rms_section(const RunData& data);
Section time_step_section(const RunData& data);
Section films_section(const RunData& data);
Section provenance_section(const RunData& data);

}  // namespace graintruth::reports
