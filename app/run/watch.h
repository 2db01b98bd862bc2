// calibrate --watch: the report follows the run, so that a browser on it shows the search.
#pragma once

#include <chrono>

#include "app/run/session.h"
#include "calibrate/search/evaluation_table.h"
#include "calibrate/search/search.h"

namespace graintruth::app {

// Makes the report anew now and then, with a note in the run folder that the run is under way
// (progress.json), which Session::finish removes. Where the run ends otherwise, the page is made
// once more without the note.
class Watch {
 public:
  // Does nothing unless `is_on`.
  Watch(bool is_on, Session& session, calibrate::EvaluationAgreement agreement);
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  // Cheap: makes the page at most every five seconds, and for at most a fiftieth of the time.
  void show(const calibrate::CalibrationProgress& progress);

 private:
  using Clock = std::chrono::steady_clock;

  bool is_on_;
  Session& session_;
  calibrate::EvaluationAgreement agreement_;
  Clock::time_point next_;
};

}  // namespace graintruth::app
