// The command line: verbs, options and exit statuses. What a verb does stands in the file of its
// name.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <system_error>

#include "app/run/command_line_text.h"
#include "app/verbs/commands.h"
#include "calibrate/calibration.h"
#include "datasets/rigs/rig_kind.h"
#include "datasets/store/input_error.h"

namespace {

using namespace graintruth;

enum ExitStatus { done = 0, unusable_input = 2, too_many_failures = 3, interrupted = 130 };

// One sentence on stderr, whatever the ending of the text and however many lines it has.
int refuse(std::string text, ExitStatus status) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && std::string_view(" \n.").find(text.back()) != std::string_view::npos)
    text.pop_back();
  fmt::print(stderr, "graintruth: {}{}\n", text, text.ends_with('?') ? "" : ".");
  return status;
}

void add_common_options(CLI::App& verb,
                        app::CommonOptions& options,
                        const char* folder = "out/<experiment name>") {
  verb.add_option("--out", options.out, fmt::format("Run folder (default: {})", folder))
      ->type_name("DIR");
  verb.add_option(
          "--jobs", options.jobs, "Threads (default: all cores); the result does not depend on it")
      ->check(CLI::Range(1, 1024));
  verb.add_option("--seed", options.seed, "Seed of all random choices")->capture_default_str();
  verb.add_flag("--quiet", options.quiet, "Print no progress line");
  verb.add_flag(
      "--json", options.json, "Print the result as JSON on stdout, everything else on stderr");
}

void add_experiment(CLI::App& verb, std::filesystem::path& experiment) {
  verb.add_option("experiment", experiment, "Experiment file")
      ->type_name("EXPERIMENT.toml")
      ->required();
}

CLI::App& add_verb(CLI::App& program,
                   const std::string& name,
                   const std::string& what,
                   const std::string& example) {
  CLI::App& verb = *program.add_subcommand(name, what);
  verb.footer(fmt::format("Example:\n  graintruth {}", example));
  return verb;
}

std::vector<std::string> names_of_parts(const CLI::App& verb) {
  std::vector<std::string> names;
  for (const CLI::App* part : verb.get_subcommands({})) names.push_back(part->get_name());
  return names;
}

// What is wrong with the command line, in one sentence.
std::string complaint(const CLI::App& program,
                      int argc,
                      char** argv,
                      const CLI::ParseError& error) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first.empty()) return "a verb is missing; 'graintruth --help' lists them";
  const std::vector<std::string> verbs = names_of_parts(program);
  const bool known = std::find(verbs.begin(), verbs.end(), first) != verbs.end();
  if (!known && !first.starts_with('-')) {
    return fmt::format("there is no verb '{}'; the verbs are {}", first, fmt::join(verbs, ", "));
  }
  if (known) {
    const std::vector<std::string> parts = names_of_parts(*program.get_subcommand(first));
    const std::string second = argc > 2 ? argv[2] : "";
    if (!parts.empty() && !second.starts_with('-') &&
        std::find(parts.begin(), parts.end(), second) == parts.end()) {
      return fmt::format("'graintruth {}' is followed by {}{}; see 'graintruth {} --help'",
                         first,
                         fmt::join(parts, " or "),
                         second.empty() ? "" : fmt::format(", not by '{}'", second),
                         first);
    }
  }
  std::string text = error.what();
  for (char& letter : text) letter = letter == '\n' ? ' ' : letter;
  return fmt::format("{}; see 'graintruth {}--help'", text, known ? first + " " : std::string());
}

void add_parameters(CLI::App& verb, std::filesystem::path& parameters) {
  verb.add_option("--parameters", parameters, "A result.json, or a TOML table name = value")
      ->type_name("FILE")
      ->required();
}

void add_step_limit(CLI::App& verb, app::CommonOptions& options) {
  verb.add_option("--step-limit",
                  options.step_limit,
                  "Steps of one simulation; one that takes more has failed, and is simulated again "
                  "by the next run (default: 20 times what its filling and phases take)")
      ->type_name("N")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 53));
}

void add_executor(CLI::App& verb, app::CommonOptions& options) {
  verb.add_option("--engine",
                  options.engine,
                  "What simulates: embedded, lammps, liggghts, or the command of [simulation] "
                  "(default: as the experiment file says, else embedded)")
      ->type_name("NAME")
      ->check(CLI::IsMember({"embedded", "lammps", "liggghts", "command"}));
  verb.add_option(
          "--executor",
          options.executor,
          "Where simulations run: threads of this machine, or the cluster's slurm (default: "
          "as [execution] of the experiment file says, else threads); the result does not "
          "depend on it")
      ->type_name("NAME")
      ->check(CLI::IsMember({"threads", "slurm"}));
}

void add_evaluate(CLI::App& program, app::EvaluateCommand& command, int& status) {
  CLI::App& verb = add_verb(
      program,
      "evaluate",
      "Simulate given parameters and print the objective, for programs that drive this one",
      "evaluate datasets/micro/experiment.toml --parameters trial.toml --json");
  add_experiment(verb, command.experiment);
  add_parameters(verb, command.parameters);
  verb.add_option(
          "--runs", command.runs, "Number of seeds (default: as in the search of calibrate)")
      ->check(CLI::Range(1, 10000));
  add_step_limit(verb, command.common);
  add_executor(verb, command.common);
  add_common_options(verb, command.common);
  verb.callback([&] { status = run_evaluate(command); });
}

void add_check(CLI::App& program, app::CheckCommand& command, int& status) {
  CLI::App& verb = add_verb(program,
                            "check",
                            "Say what calibrate will do, what is missing and how long it may take",
                            "check datasets/heap/experiment.toml --out out/heap");
  add_experiment(verb, command.experiment);
  verb.add_option("--out", command.common.out, "Folder for the pictures (default: out/<name>)")
      ->type_name("DIR");
  verb.add_option("--budget",
                  command.budget,
                  "Evaluations that you will give to calibrate (default: 120; for a bin 60, for "
                  "outlines 40)")
      ->check(CLI::Range(20, 100000));
  verb.add_option("--jobs", command.common.jobs, "Threads that you will give to calibrate")
      ->check(CLI::Range(1, 1024));
  verb.callback([&] { status = run_check(command); });
}

void add_annotate(CLI::App& program, app::AnnotateCommand& command, int& status) {
  CLI::App& verb = add_verb(
      program,
      "annotate",
      "Make a page on which scale, rig, starts and masks are clicked, or put in place what it made",
      "annotate datasets/micro/experiment.toml --out out/micro");
  verb.add_option("inputs", command.inputs, "Experiment file; or films, with --rig")
      ->type_name("EXPERIMENT.toml|FILM...")
      ->required();
  std::vector<std::string> kinds;
  for (const datasets::RigKind* kind : datasets::rig_kinds()) kinds.emplace_back(kind->name);
  verb.add_option("--rig", command.rig, "Of films alone: the kind of their rig")
      ->type_name("KIND")
      ->check(CLI::IsMember(kinds));
  verb.add_option("--apply", command.apply, "Check this annotation and put it in place")
      ->type_name("FILE");
  verb.add_option("--out",
                  command.common.out,
                  "Folder for the page (default: out/<name>; of films alone my-rig, which gets an "
                  "experiment file too)")
      ->type_name("DIR");
  verb.callback([&] { status = run_annotate(command); });
}

void add_simulate(CLI::App& program, app::SimulateCommand& command, int& status) {
  CLI::App& verb = add_verb(program,
                            "simulate",
                            "Run the simulator alone on a scene file or a deck of the thesis",
                            "simulate datasets/scenes/conveyor.toml --out out/conveyor --render");
  verb.add_option("scene", command.scene, "Scene file, or a deck of the thesis")
      ->type_name("SCENE")
      ->required();
  verb.add_option(
          "--sidecar",
          command.sidecar,
          "File with what a deck leaves out (default: the .toml beside it, or the bundled one "
          "with its name)")
      ->type_name("FILE");
  verb.add_flag(
      "--render", command.render, "Draw the simulation: simulation.mp4 and simulation.png");
  verb.add_flag(
      "--povray", command.povray, "Write every frame for the ray tracer POV-Ray (povray/*.pov)");
  verb.add_flag("--paraview", command.paraview, "Write every frame for ParaView (paraview/*.pvd)");
  verb.add_flag("--ovito", command.ovito, "Write every frame for OVITO (dump.lammpstrj)");
  verb.add_option("--time-limit",
                  command.time_limit,
                  "End the simulation after so many seconds, with what it has")
      ->check(CLI::PositiveNumber);
  add_common_options(verb, command.common, "out/<scene name>");
  verb.callback([&] { status = run_simulate(command); });
}

void add_new(CLI::App& program, app::NewCommand& command, int& status) {
  CLI::App& verb = add_verb(
      program, "new", "Write an experiment file with comments to start from", "new micro my-rig");
  verb.require_subcommand(1);
  for (const datasets::RigKind* kind : datasets::rig_kinds()) {
    const std::string name(kind->template_name.empty() ? kind->name : kind->template_name);
    CLI::App& part = add_verb(verb,
                              name,
                              fmt::format("{}, kind \"{}\"", kind->meaning, kind->name),
                              fmt::format("new {} my-rig", name));
    part.add_option("folder", command.folder, "Folder in which experiment.toml is written")
        ->type_name("DIR")
        ->required();
    part.callback([&command, &status, name] {
      command.kind = name;
      status = run_new(command);
    });
  }
}

void add_export(CLI::App& program, app::ExportCommand& command, int& status) {
  CLI::App& verb =
      add_verb(program,
               "export",
               "Write the calibrated particle and contact for another engine, or plain tables",
               "export out/micro --to liggghts");
  verb.add_option("run_folder", command.run_folder, "Folder of a run")
      ->type_name("RUN_DIR")
      ->required();
  verb.add_option("--to", command.to, "liggghts, lammps, yade, or csv (tables of everything)")
      ->check(CLI::IsMember({"liggghts", "lammps", "yade", "csv"}))
      ->required();
  verb.add_option("--out", command.out, "Folder in which to write (default: RUN_DIR/export/<to>)")
      ->type_name("DIR");
  verb.callback([&] { status = run_export(command); });
}

// An option whose unit is in its name, stored in SI.
void add_length(CLI::App& verb, const char* name, const char* what, double& metres) {
  constexpr double millimetre = 1e-3;
  verb.add_option_function<double>(
          name, [&metres](double value) { metres = value * millimetre; }, what)
      ->type_name("MM")
      ->check(CLI::PositiveNumber);
}

void add_fit(CLI::App& program, app::FitCommand& command, int& status) {
  CLI::App& verb = add_verb(program,
                            "fit",
                            "Fit Beverloo's law or the kinematic law to a table of your own",
                            "fit beverloo rates.csv --diameter-mm 12.1");
  verb.require_subcommand(1);
  const auto add = [&](const char* name, const char* what, const char* example) -> CLI::App& {
    CLI::App& part = add_verb(verb, name, what, example);
    part.add_option(
            "data", command.data, "Table with a header; each column name ends with its unit")
        ->type_name("DATA.csv")
        ->required();
    add_length(part, "--diameter-mm", "Diameter of a particle", command.diameter);
    part.add_option("--form", command.form, "default, or the form of the thesis")
        ->capture_default_str()
        ->check(CLI::IsMember({"default", "thesis"}));
    part.add_option("--out", command.common.out, "Folder for result.json")->type_name("DIR");
    part.add_flag("--json", command.common.json, "Print the result as JSON on stdout");
    return part;
  };
  CLI::App& beverloo =
      add("beverloo",
          "Find C and k from flow rates through orifices of several widths. Columns: orifice_cm, "
          "flow_rate_g_per_s, and areal_density_g_per_cm2 (slot) or bulk_density_g_per_cm3 "
          "(circular). Optional columns: flow_rate_standard_uncertainty_g_per_s, "
          "particle_diameter_mm",
          "fit beverloo datasets/thesis/table_4_4_beverloo_experiment.csv --diameter-mm 12.095");
  beverloo.add_option("--law", command.law, "slot (one layer) or circular (a round hole)")
      ->capture_default_str()
      ->check(CLI::IsMember({"slot", "circular"}));
  beverloo.add_option("--k", command.imposed_k, "Use this k, and find C for each row")
      ->check(CLI::NonNegativeNumber);
  beverloo.add_option("--gravity-m-per-s2", command.gravity, "Gravity")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  beverloo.callback([&] { status = run_fit_beverloo(command); });
  CLI::App& kinematic = add(
      "kinematic",
      "Find B from a velocity profile across the bed. Columns: x_cm, velocity_cm_per_s. Optional "
      "column: velocity_standard_uncertainty_cm_per_s",
      "fit kinematic profile.csv --height-mm 90 --orifice-mm 75 --diameter-mm 12.1");
  add_length(kinematic, "--height-mm", "Height of the profile above the orifice", command.height);
  kinematic.get_option("--height-mm")->required();
  add_length(kinematic, "--orifice-mm", "Width of the orifice", command.orifice);
  add_length(
      kinematic, "--bin-width-mm", "Width of the bin; no place lies outside", command.bin_width);
  kinematic.callback([&] { status = run_fit_kinematic(command); });
}

void add_journal(CLI::App& program, app::JournalCommand& command, int& status) {
  CLI::App& verb = add_verb(program,
                            "journal",
                            "Show, copy or change the record of simulations of a run",
                            "journal list out/micro");
  verb.require_subcommand(1);
  const auto add = [&](const char* name,
                       const char* what,
                       const char* example,
                       app::JournalAction action) -> CLI::App& {
    CLI::App& part = add_verb(verb, name, what, example);
    part.add_option("run_folder", command.run_folder, "Folder of a run")
        ->type_name("RUN_DIR")
        ->required();
    part.callback([&command, &status, action] {
      command.action = action;
      status = run_journal(command);
    });
    return part;
  };
  add("list",
      "List the simulations by problem, stage and status",
      "journal list out/micro",
      app::JournalAction::list);
  add("show", "Show one simulation", "journal show out/micro 12", app::JournalAction::show)
      .add_option("id", command.ids, "Number of the simulation in the journal")
      ->type_name("ID")
      ->expected(1)
      ->required();
  add("export",
      "Write the record as CSV: to journal.csv, another file, or stdout",
      "journal export out/micro --out -",
      app::JournalAction::export_rows)
      .add_option(
          "--out", command.out, "File to write, or - for stdout (default: RUN_DIR/journal.csv)")
      ->type_name("FILE");
  CLI::App& drop = add("drop",
                       "Remove simulations, so that they are run again",
                       "journal drop out/micro --failed",
                       app::JournalAction::drop);
  CLI::Option_group& which = *drop.add_option_group("which");
  which.add_flag("--failed", command.failed, "All simulations that did not complete");
  which.add_flag("--damaged", command.damaged, "All rows that cannot be read or were changed");
  which.add_option("--problem", command.problem, "All simulations of one problem")
      ->type_name("HASH");
  which.add_option("--id", command.ids, "The simulations with these numbers")->type_name("ID");
  which.require_option(1);
  add("merge",
      "Add the simulations of another run that this one does not have",
      "journal merge out/micro out/micro-on-another-machine",
      app::JournalAction::merge)
      .add_option("other", command.other, "Folder of the other run")
      ->type_name("OTHER_RUN_DIR")
      ->required();
}

void add_run_task(CLI::App& program, app::RunTaskCommand& command, int& status) {
  CLI::App& verb = add_verb(program,
                            "run-task",
                            "Run one task of a batch system (--executor slurm starts it)",
                            "run-task out/micro/tasks/graintruth-<hash> 0");
  verb.add_option("folder", command.folder, "Folder of a job array in the task folder")
      ->type_name("FOLDER")
      ->required();
  verb.add_option("index", command.index, "Which of its tasks, from 0")
      ->type_name("INDEX")
      ->check(CLI::NonNegativeNumber)
      ->required();
  verb.callback([&] { status = run_run_task(command); });
}

// What no part of the program should let through. It is ours, and the user can only tell us.
int refuse_fault(const std::string& what) {
  return refuse(fmt::format("a fault of this program, not of your input: {}. Please report it with "
                            "this sentence, the command line and the experiment file",
                            what),
                unusable_input);
}

// What is written as JSON must be.
bool is_utf8(const std::string& text) {
  using Json = nlohmann::json;
  const Json json(text);
  return json.dump(-1, ' ', false, Json::error_handler_t::ignore) ==
         json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string joined(int argc, char** argv) {
  std::string line = "graintruth";
  for (int i = 1; i < argc; ++i) line += std::string(" ") + argv[i];
  return line;
}

int run(int argc, char** argv) {
  // The decoder's own complaints about a film are of no use to the user; ours name file and frame.
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  // A file that may not grow any more is an error of writing, and no end without a word
  std::signal(SIGXFSZ, SIG_IGN);
  CLI::App program(
      "Calibrates a discrete-element model of grains on an experiment, and writes a report.",
      "graintruth");
  program.set_version_flag("--version", GRAINTRUTH_VERSION);
  program.require_subcommand(1);
  program.footer(
      "Exit status: 0 done, 1 a requirement is not met, 2 unusable input, 3 too many failed "
      "simulations, 130 interrupted (run the same command again to resume). A fault of the program "
      "itself ends with 2 and asks to be reported.");

  app::CalibrateCommand calibrate;
  app::TrackCommand track;
  app::ValidateCommand validate;
  app::ReproduceCommand reproduce;
  app::ReportCommand report;
  app::ExportCommand exported;
  app::EvaluateCommand evaluate;
  app::CheckCommand check;
  app::NewCommand new_experiment;
  app::AnnotateCommand annotate;
  app::SimulateCommand simulate;
  app::JournalCommand journal;
  app::FitCommand fit;
  app::RunTaskCommand run_task;
  int status = done;

  CLI::App& calibrate_verb =
      add_verb(program,
               "calibrate",
               "Track films, find the parameters and the time step, write the report",
               "calibrate datasets/micro/experiment.toml --out out/micro");
  add_experiment(calibrate_verb, calibrate.experiment);
  calibrate_verb
      .add_option("--budget",
                  calibrate.budget,
                  "Evaluations of the search (default: 120; for a bin 60, for outlines 40)")
      ->check(CLI::Range(20, 100000));
  calibrate_verb
      .add_option("--time-limit",
                  calibrate.time_limit,
                  "End the search after so many seconds, with what it has")
      ->check(CLI::PositiveNumber);
  calibrate_verb.add_flag("--watch",
                          calibrate.watch,
                          "Keep report.html up to date during the run; a browser reloads it");
  calibrate_verb.add_flag("--use-failed-tracks",
                          calibrate.use_failed_tracks,
                          "Calibrate on films too whose tracking has failed");
  add_step_limit(calibrate_verb, calibrate.common);
  add_executor(calibrate_verb, calibrate.common);
  add_common_options(calibrate_verb, calibrate.common);
  calibrate_verb.callback([&] { status = run_calibrate(calibrate); });

  CLI::App& track_verb = add_verb(program,
                                  "track",
                                  "Make tracks, quality figures and overlay videos from films",
                                  "track datasets/micro/experiment.toml --out out/tracks");
  add_experiment(track_verb, track.experiment);
  add_common_options(track_verb, track.common);
  track_verb.callback([&] { status = run_track(track); });

  CLI::App& validate_verb =
      add_verb(program,
               "validate",
               "Compare simulations at given parameters with the experiment; tune nothing",
               "validate datasets/micro/experiment.toml --parameters "
               "out/micro/result.json --require-agreement 60");
  add_experiment(validate_verb, validate.experiment);
  add_parameters(validate_verb, validate.parameters);
  validate_verb
      .add_option("--require-agreement",
                  validate.require_agreement,
                  "Exit with status 1 below this percentage (Student's form)")
      ->type_name("PCT")
      ->check(CLI::Range(0.0, 100.0));
  validate_verb
      .add_option("--runs", validate.runs, "Number of seeds; the mean of these runs is scored")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  add_step_limit(validate_verb, validate.common);
  add_executor(validate_verb, validate.common);
  add_common_options(validate_verb, validate.common);
  validate_verb.callback([&] { status = run_validate(validate); });

  CLI::App& reproduce_verb =
      add_verb(program,
               "reproduce",
               "Check the thesis number by number: printed, recomputed, simulated again",
               "reproduce table-4.2 fig-3.5-text --out out/reproduce");
  reproduce_verb
      .add_option("targets",
                  reproduce.targets,
                  "Names from --list; or printed, all-quick, all (default: all-quick)")
      ->type_name("TARGET");
  reproduce_verb.add_flag("--list", reproduce.list, "List the targets");
  add_common_options(reproduce_verb, reproduce.common);
  reproduce_verb.get_option("--out")->description("Run folder (default: out/reproduce)");
  reproduce_verb.callback([&] { status = run_reproduce(reproduce); });

  CLI::App& report_verb = add_verb(
      program, "report", "Make the report of a run again from its folder", "report out/micro");
  report_verb.add_option("run_folder", report.run_folder, "Folder of a run")
      ->type_name("RUN_DIR")
      ->required();
  report_verb.add_flag("--pdf", report.pdf, "Print the report to report.pdf too (needs Chromium)");
  report_verb.callback([&] { status = run_report(report); });

  add_export(program, exported, status);
  add_simulate(program, simulate, status);
  add_evaluate(program, evaluate, status);
  add_check(program, check, status);
  add_new(program, new_experiment, status);
  add_annotate(program, annotate, status);
  add_fit(program, fit, status);
  add_journal(program, journal, status);
  add_run_task(program, run_task, status);

  // For the build, which installs both; "" as the group keeps them out of --help
  program
      .add_flag_callback(
          "--print-man-page",
          [&] {
            fmt::print("{}", app::man_page(program, GRAINTRUTH_VERSION));
            throw CLI::Success();
          },
          "")
      ->group("");
  program
      .add_flag_callback(
          "--print-bash-completion",
          [&] {
            fmt::print("{}", app::bash_completion(program));
            throw CLI::Success();
          },
          "")
      ->group("");

  const std::string command_line = joined(argc, argv);
  if (!is_utf8(command_line)) {
    return refuse(
        "the command line holds letters that are not UTF-8, in which all files of a run are "
        "written; rename what it names",
        unusable_input);
  }
  for (app::CommonOptions* options : {&calibrate.common,
                                      &track.common,
                                      &validate.common,
                                      &evaluate.common,
                                      &simulate.common,
                                      &reproduce.common}) {
    options->command_line = command_line;
  }
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // help or version
    return refuse(complaint(program, argc, argv, error), unusable_input);
  } catch (const datasets::InputError& error) {
    return refuse(error.what(), unusable_input);
  } catch (const calibrate::TooManyFailures& error) {
    return refuse(error.what(), too_many_failures);
  } catch (const calibrate::TasksFailed& error) {
    return refuse(error.what(), too_many_failures);
  } catch (const calibrate::Interrupted& error) {
    return refuse(error.what(), interrupted);
  } catch (const std::system_error& error) {  // files, folders, threads
    return refuse(error.what(), unusable_input);
  } catch (const std::bad_alloc&) {
    return refuse(
        "the memory of this machine does not suffice; give fewer --jobs, a shorter film or a "
        "smaller scene",
        unusable_input);
  } catch (const std::exception& error) {
    return refuse_fault(error.what());
  } catch (...) {
    return refuse_fault("it does not say what went wrong");
  }
  // What was printed may still wait for room
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    return refuse(
        fmt::format("what was printed cannot be written ({}); all files of the run are there",
                    std::strerror(errno)),
        unusable_input);
  }
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (...) {
    std::fputs("graintruth: error: no memory is left for the sentence that says what is wrong\n",
               stderr);
    return unusable_input;
  }
}
