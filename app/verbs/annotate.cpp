// graintruth annotate: a page to click on, and what it made put in place.
#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <sstream>

#include "app/annotate/annotation_page.h"
#include "app/run/assets.h"
#include "app/run/made_folders.h"
#include "app/verbs/commands.h"
#include "datasets/experiment/annotation.h"
#include "datasets/experiment/experiment.h"
#include "datasets/experiment/pictures.h"
#include "datasets/rigs/rig_kind.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/text_file.h"

namespace graintruth::app {

namespace {

using datasets::InputError;

constexpr const char* page_name = "annotate.html";

bool is_experiment(const std::filesystem::path& file) { return file.extension() == ".toml"; }

std::string quoted(const std::string& text) {
  std::string made = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') made += '\\';
    made += letter;
  }
  return made + "\"";
}

const datasets::RigKind& kind_named(const std::string& name) {
  for (const datasets::RigKind* kind : datasets::rig_kinds())
    if (kind->name == name) return *kind;
  throw InputError(fmt::format("there is no rig '{}'", name));
}

// One table of a template as it is written there, with its comments; empty where it has none.
std::string part_of(const std::string& text, const std::string& table) {
  std::string part, aside;  // remarks may belong to the table that follows
  bool is_in = false;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('['))
      is_in = line.starts_with("[" + table) || line.starts_with("[[" + table);
    if (!is_in) {
      aside.clear();
      continue;
    }
    aside += line + "\n";
    if (line.empty() || line.starts_with('#')) continue;
    part += aside;
    aside.clear();
  }
  return part;
}

// What the page cannot ask for: when what is compared, and what is sought.
std::string experiment_for(const datasets::RigKind& kind) {
  const std::string_view name = kind.template_name.empty() ? kind.name : kind.template_name;
  const std::string of_template(asset(fmt::format("new/{}/experiment.toml", name)));
  std::string text = fmt::format(
      "# What was clicked and typed on the page of graintruth annotate stands in annotation.toml "
      "and counts as if it stood\n# here. docs/experiment.md tells every key.\n"
      "title = {}\n\n[camera]\nannotation = \"annotation.toml\"\n",
      quoted(fmt::format("Films of {}", kind.meaning)));
  for (const char* table : {"measure", "tune"}) {
    const std::string part = part_of(of_template, table);
    if (!part.empty()) text += "\n" + part;
  }
  return text;
}

std::string first_annotation(const datasets::RigKind& kind,
                             const std::vector<std::filesystem::path>& films,
                             const std::filesystem::path& folder) {
  std::string text = fmt::format("[rig]\nkind = {}\n", quoted(std::string(kind.name)));
  for (const std::filesystem::path& film : films) {
    const auto path = std::filesystem::proximate(std::filesystem::absolute(film),
                                                 std::filesystem::absolute(folder));
    text += fmt::format("\n[[replicate]]\nvideo = {}\n", quoted(path.generic_string()));
  }
  return text;
}

// An experiment of films alone. Returns its file.
std::filesystem::path begin_experiment(const AnnotateCommand& command,
                                       const std::filesystem::path& folder) {
  if (command.rig.empty()) {
    throw InputError(
        "films without an experiment file need --rig, the kind of rig that they show; 'graintruth "
        "annotate --help' lists them");
  }
  for (const std::filesystem::path& film : command.inputs) {
    if (!datasets::is_film(film))
      throw InputError(fmt::format("{}: there is no such film", film.string()));
  }
  const std::filesystem::path experiment = folder / "experiment.toml";
  const std::filesystem::path annotation = folder / "annotation.toml";
  for (const std::filesystem::path& file : {experiment, annotation}) {
    if (!std::filesystem::exists(file)) continue;
    throw InputError(
        fmt::format("{}: is there already and is not overwritten; go on with 'graintruth annotate "
                    "{}', or give another --out",
                    file.string(),
                    experiment.string()));
  }
  const datasets::RigKind& kind = kind_named(command.rig);
  datasets::write_whole(annotation, first_annotation(kind, command.inputs, folder));
  datasets::write_whole(experiment, experiment_for(kind));
  return experiment;
}

void write_page(const std::filesystem::path& experiment, const std::filesystem::path& folder) {
  const AnnotationPage page = make_annotation_page(experiment, folder);
  const std::filesystem::path file = folder / page_name;
  datasets::write_whole(file, page.html);
  fmt::print("Open in a browser: {} ({:.1f} MB, {})\n",
             file.string(),
             1e-6 * static_cast<double>(page.html.size()),
             page.words);
}

// The text of an experiment file that names its annotation.
std::string naming_annotation(const std::string& text, const std::string& name) {
  const std::string line = fmt::format("annotation = {}", quoted(name));
  static const std::regex header(R"((^|\n)[ \t]*\[[ \t]*camera[ \t]*\][^\n]*)");
  std::smatch found;
  if (!std::regex_search(text, found, header))
    return fmt::format("{}{}\n[camera]\n{}\n", text, text.ends_with('\n') ? "" : "\n", line);
  const auto end = static_cast<std::size_t>(found.position() + found.length());
  return text.substr(0, end) + "\n" + line + text.substr(end);
}

void apply(const std::filesystem::path& experiment, const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file))
    throw InputError(fmt::format("{}: there is no such file", file.string()));
  // 1. Read as it would be in its place
  const datasets::Experiment read =
      datasets::load_experiment(experiment, file, datasets::Purpose::tracking);
  const std::filesystem::path place = datasets::annotation_of(experiment);
  // 2. Put there, and named by the experiment file
  const std::string text = datasets::read_whole(experiment);
  const bool is_named = datasets::names_annotation(experiment);
  datasets::write_whole(place, datasets::read_whole(file));
  if (!is_named) {
    datasets::write_whole(experiment, naming_annotation(text, place.filename().string()));
    try {
      datasets::load_experiment(experiment, datasets::Purpose::tracking);
    } catch (const InputError&) {
      datasets::write_whole(experiment, text);
      throw;
    }
  }
  fmt::print("{} is in place{}. {} film{}.\nNext: graintruth check {}\n",
             place.string(),
             is_named ? "" : fmt::format(", and {} names it", experiment.string()),
             read.replicates.size(),
             read.replicates.size() == 1 ? "" : "s",
             experiment.string());
}

}  // namespace

int run_annotate(const AnnotateCommand& command) {
  const bool is_of_experiment = command.inputs.size() == 1 && is_experiment(command.inputs[0]);
  if (!is_of_experiment &&
      std::any_of(command.inputs.begin(), command.inputs.end(), is_experiment)) {
    throw InputError("give one experiment file, or films; not both");
  }
  if (is_of_experiment && !command.rig.empty())
    throw InputError("--rig is for films alone; the experiment file states its rig");
  if (!command.apply.empty()) {
    if (!is_of_experiment)
      throw InputError("--apply needs the experiment file that the annotation belongs to");
    apply(command.inputs[0], command.apply);
    return 0;
  }
  std::filesystem::path folder = command.common.out;
  if (folder.empty())
    folder = is_of_experiment
                 ? std::filesystem::path("out") / datasets::experiment_name(command.inputs[0])
                 : "my-rig";
  const MadeFolders made(folder);
  datasets::make_folder(folder);
  const std::filesystem::path experiment =
      is_of_experiment ? command.inputs[0] : begin_experiment(command, folder);
  write_page(experiment, folder);
  return 0;
}

}  // namespace graintruth::app
