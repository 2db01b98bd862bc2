#include "app/run/watch.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "datasets/store/input_error.h"
#include "reports/report.h"

namespace graintruth::app {

namespace {

constexpr std::chrono::seconds shortest_pause(5);
constexpr int pause_per_cost = 50;  // the page may take a fiftieth of the run's time

}  // namespace

Watch::Watch(bool is_on, Session& session, calibrate::EvaluationAgreement agreement)
    : is_on_(is_on), session_(session), agreement_(std::move(agreement)) {
  if (!is_on_) return;
  session_.write_record();
  show({.stage = "start", .best = std::nan("")});
  session_.progress().say("Open in a browser: " + session_.folder().report().string());
}

Watch::~Watch() {
  try {
    if (!is_on_ || !std::filesystem::exists(session_.folder().progress())) return;
    datasets::remove_progress(session_.folder());
    reports::write_report(session_.folder());
  } catch (const std::exception&) {
    // The run's own ending is what matters
  }
}

void Watch::show(const calibrate::CalibrationProgress& progress) {
  if (!is_on_ || Clock::now() < next_) return;
  const Clock::time_point start = Clock::now();
  const datasets::RunFolder& folder = session_.folder();
  nlohmann::ordered_json json = {{"stage", progress.stage},
                                 {"evaluations", progress.evaluations},
                                 {"budget", progress.budget},
                                 {"share", progress.share},
                                 {"best", nullptr},
                                 {"seconds", session_.seconds()}};
  if (std::isfinite(progress.best)) json["best"] = progress.best;
  datasets::write_whole(folder.progress(), json.dump(2) + "\n");
  calibrate::write_evaluations(
      folder.unfinished_table("evaluations"), progress.finished, agreement_);
  reports::write_report(folder);
  const auto cost = Clock::now() - start;
  next_ = Clock::now() + std::max<Clock::duration>(shortest_pause, pause_per_cost * cost);
}

}  // namespace graintruth::app
