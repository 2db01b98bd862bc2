// run.json: what was run, on what, with what, and how long each stage took.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/verbs/commands.h"
#include "calibrate/calibration.h"
#include "datasets/experiment/experiment.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

struct RunRecord {
  std::string verb;
  std::string started_at;  // UTC, ISO 8601
  int jobs = 0;
  std::map<std::string, std::string> input_hashes;
  std::map<std::string, std::string> options;  // resolved, beyond those common to all verbs
  std::vector<calibrate::StageTime> stages;
  // False where films are only tracked, and of several experiments together, each of which has a
  // record of its own
  bool compares = true;
  int simulations_run = 0;  // by this command; the others were in the journal already
};

std::string utc_now();
void write_run_record(const datasets::RunFolder& folder,
                      const CommonOptions& options,
                      const datasets::Experiment& experiment,
                      const RunRecord& record);

}  // namespace graintruth::app
