// The command line: verbs, options and exit statuses. What a verb does stands in the file of its
// name.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/commands.h"
#include "calibrate/calibration.h"
#include "datasets/input_error.h"

namespace {

using namespace graintruth;

enum ExitStatus { done = 0, unusable_input = 2, too_many_failures = 3, interrupted = 130 };

void add_common_options(CLI::App& verb, app::CommonOptions& options) {
  verb.add_option("--out", options.out, "Run folder (default: out/<experiment name>)")
      ->type_name("DIR");
  verb.add_option(
          "--jobs", options.jobs, "Threads (default: all cores); the result does not depend on it")
      ->check(CLI::Range(1, 1024));
  verb.add_option("--seed", options.seed, "Seed of every random choice")->capture_default_str();
  verb.add_flag("--quiet", options.quiet, "No progress line");
  verb.add_flag("--json", options.json, "Result as JSON on stdout, everything else on stderr");
}

void add_experiment(CLI::App& verb, std::filesystem::path& experiment) {
  verb.add_option("experiment", experiment, "Experiment file")
      ->type_name("EXPERIMENT.toml")
      ->required();
}

CLI::App& add_verb(CLI::App& program, const char* name, const char* what, const char* example) {
  CLI::App& verb = *program.add_subcommand(name, what);
  verb.footer(fmt::format("Example:\n  graintruth {}", example));
  return verb;
}

std::string joined(int argc, char** argv) {
  std::string line = "graintruth";
  for (int i = 1; i < argc; ++i) line += std::string(" ") + argv[i];
  return line;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program("Lab videos of grain to calibrated discrete-element parameters, with a report.",
                   "graintruth");
  program.set_version_flag("--version", GRAINTRUTH_VERSION);
  program.require_subcommand(1);
  program.footer(
      "Exit status: 0 done, 1 a requirement is not met, 2 unusable input, 3 too many failed "
      "simulations, 130 "
      "interrupted (run the same command again to resume).");

  app::CalibrateCommand calibrate;
  app::TrackCommand track;
  app::ValidateCommand validate;
  app::ReproduceCommand reproduce;
  app::ReportCommand report;
  int status = done;

  CLI::App& calibrate_verb =
      add_verb(program,
               "calibrate",
               "Track films, find friction, restitution and time step, write the report",
               "calibrate datasets/micro/experiment.toml --out out/micro");
  add_experiment(calibrate_verb, calibrate.experiment);
  calibrate_verb
      .add_option("--budget", calibrate.budget, "Evaluations of the search (default: 80)")
      ->check(CLI::Range(20, 100000));
  calibrate_verb
      .add_option("--time-limit",
                  calibrate.time_limit,
                  "Seconds after which the search ends with what it has")
      ->check(CLI::PositiveNumber);
  add_common_options(calibrate_verb, calibrate.common);
  calibrate_verb.callback([&] { status = run_calibrate(calibrate); });

  CLI::App& track_verb = add_verb(program,
                                  "track",
                                  "Films to tracks, quality figures and overlay videos",
                                  "track datasets/micro/experiment.toml --out out/tracks");
  add_experiment(track_verb, track.experiment);
  add_common_options(track_verb, track.common);
  track_verb.callback([&] { status = run_track(track); });

  CLI::App& validate_verb = add_verb(program,
                                     "validate",
                                     "Compare at given parameters, no tuning",
                                     "validate datasets/micro/experiment.toml --parameters "
                                     "out/micro/result.json --require-agreement 60");
  add_experiment(validate_verb, validate.experiment);
  validate_verb
      .add_option(
          "--parameters", validate.parameters, "A result.json, or a TOML table name = value")
      ->type_name("FILE")
      ->required();
  validate_verb
      .add_option("--require-agreement",
                  validate.require_agreement,
                  "Exit 1 below this percentage (Student form)")
      ->type_name("PCT")
      ->check(CLI::Range(0.0, 100.0));
  validate_verb.add_option("--runs", validate.runs, "Runs whose mean is scored")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  add_common_options(validate_verb, validate.common);
  validate_verb.callback([&] { status = run_validate(validate); });

  CLI::App& reproduce_verb = add_verb(program,
                                      "reproduce",
                                      "Thesis statistics: printed, recomputed, verdict",
                                      "reproduce table-4.2");
  reproduce_verb.add_option("targets", reproduce.targets, "Names from --list (default: all)")
      ->type_name("TARGET");
  reproduce_verb.add_flag("--list", reproduce.list, "Name the targets");
  reproduce_verb.callback([&] { status = run_reproduce(reproduce); });

  CLI::App& report_verb = add_verb(
      program, "report", "Make the report of a run anew from its folder", "report out/micro");
  report_verb.add_option("run_folder", report.run_folder, "Folder of a run")
      ->type_name("RUN_DIR")
      ->required();
  report_verb.callback([&] { status = run_report(report); });

  const std::string command_line = joined(argc, argv);
  for (app::CommonOptions* options : {&calibrate.common, &track.common, &validate.common}) {
    options->command_line = command_line;
  }
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? done : unusable_input;
  } catch (const datasets::InputError& error) {
    fmt::print(stderr, "graintruth: {}\n", error.what());
    return unusable_input;
  } catch (const calibrate::TooManyFailures& error) {
    fmt::print(stderr, "graintruth: {}\n", error.what());
    return too_many_failures;
  } catch (const calibrate::Interrupted& error) {
    fmt::print(stderr, "graintruth: {}\n", error.what());
    return interrupted;
  }
  return status;
}
