#include "app/annotate/annotation_page.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "app/annotate/film_look.h"
#include "app/run/assets.h"
#include "datasets/experiment/annotation.h"
#include "datasets/experiment/experiment.h"
#include "datasets/experiment/pictures.h"
#include "datasets/experiment/replicates.h"
#include "datasets/rigs/rig_drawing.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/text_file.h"
#include "reports/annotate/annotate_page.h"

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;
using datasets::InputError;
using datasets::TomlSection;

// Of a page, in bytes. Pictures are stored as text, four letters for three bytes; what else is on
// it takes the rest.
constexpr std::size_t largest_page = 8'000'000;
constexpr std::size_t all_but_pictures = 400'000;

std::size_t budget_of(std::size_t films) {
  return (largest_page - all_but_pictures) / 4 * 3 / films;
}

// The experiment as far as a tracker would read it, or what is missing.
struct SoFar {
  std::optional<datasets::Experiment> experiment;
  std::string complaint;
};

SoFar read_so_far(const std::filesystem::path& file) {
  try {
    return {datasets::load_experiment(file, datasets::Purpose::tracking), ""};
  } catch (const InputError& error) {
    return {std::nullopt, error.what()};
  }
}

std::vector<LookedAtFilm> films_of(TomlSection& root,
                                   const std::filesystem::path& folder,
                                   const SoFar& so_far,
                                   const std::filesystem::path& run_folder) {
  std::optional<double> rate;
  if (auto camera = root.optional_section("camera"))
    rate = camera->optional_quantity("frame_rate", datasets::rate_units, datasets::positive);
  std::vector<LookedAtFilm> films;
  for (TomlSection& section : root.sections("replicate")) {
    const auto video = section.optional_text("video");
    if (!video) continue;
    LookedAtFilm film{.video = folder / *video};
    if (!datasets::is_film(film.video)) {
      section.fail("video",
                   fmt::format("names '{}', but there is no such file", film.video.string()));
    }
    film.name = section.optional_text("name").value_or(datasets::usual_name(film.video));
    film.frame_rate =
        section.optional_quantity("frame_rate", datasets::rate_units, datasets::positive);
    if (!film.frame_rate) film.frame_rate = rate;
    film.tracks = datasets::RunFolder{run_folder}.tracks(film.name);
    if (so_far.experiment) {
      for (const datasets::Replicate& replicate : so_far.experiment->replicates) {
        if (replicate.name == film.name)
          film.spec = datasets::make_tracking_spec(*so_far.experiment, replicate);
      }
    }
    films.push_back(std::move(film));
  }
  if (films.empty())
    root.fail("replicate", "names no film; write [[replicate]] and video = \"...\" for each");
  return films;
}

std::string template_of(const datasets::RigKind& kind) {
  return std::string(asset(fmt::format(
      "new/{}/experiment.toml", kind.template_name.empty() ? kind.name : kind.template_name)));
}

// What the page draws, drags and asks for of the rig. A template stands in for what is not said
// yet.
Json rig_json(TomlSection& root, const std::filesystem::path& folder, const SoFar& so_far) {
  Json json = {{"words", ""},
               {"keys", Json::array()},
               {"values", Json::array()},
               {"corners", Json::array()},
               {"lines", Json::array()},
               {"circles", Json::array()},
               {"optional", Json::array()},
               {"template", ""}};
  auto rig = root.optional_section("rig");
  if (!rig) return json;
  const datasets::RigKind& kind = datasets::rig_kind_named(*rig);
  json["words"] = fmt::format("{}: {}.", kind.name, kind.meaning);
  const std::string text = template_of(kind);
  json["template"] = text;
  // 1. The rig as stated, completed by the template
  const datasets::TomlFile whole = datasets::TomlFile::of_text(text, "template");
  TomlSection of_template = whole.root();
  const TomlSection complete = of_template.section("rig").overridden_by(*rig);
  std::vector<std::string> settings;
  for (TomlSection* from : {&root, &of_template}) {
    for (const TomlSection& replicate : from->sections("replicate"))
      settings.push_back(replicate.text_without({"name", "video"}));
  }
  // 2. Its drawing, with the grains of the experiment; where they are not known yet with those of
  // the template, or with specks that get through everywhere
  std::vector<datasets::RigContext> contexts(2, datasets::RigContext{.folder = folder});
  std::optional<datasets::Particle> grain;
  if (so_far.experiment && !kind.brings_grains) {
    grain = so_far.experiment->particle;
  } else if (of_template.has("particle")) {
    std::vector<std::filesystem::path> inputs;
    grain = datasets::read_particle(
        of_template.section("particle"), datasets::Purpose::tracking, true, folder, inputs);
  }
  if (grain) contexts.front().particle = &*grain;
  std::optional<datasets::RigDrawing> found;
  bool is_whole = false;
  for (const TomlSection* stated : std::initializer_list<const TomlSection*>{&*rig, &complete}) {
    for (const datasets::RigContext& context : contexts) {
      try {
        if (found) continue;
        found = datasets::draw_rig(*stated, settings, context);
        is_whole = stated == &*rig;
      } catch (const InputError&) {
        // What is wrong with it is told when the experiment is read
      }
    }
  }
  if (!found) return json;
  const datasets::RigDrawing& drawing = *found;
  for (const datasets::DrawnDimension& dimension : drawing.dimensions) {
    Json path = Json::array();
    for (const datasets::TomlStep& step : dimension.path)
      path.push_back(step.key.empty() ? Json(step.number) : Json(step.key));
    json["keys"].push_back({{"path", path},
                            {"stem", dimension.stem},
                            {"unit", dimension.unit},
                            {"as", dimension.form},
                            {"is_setting", dimension.is_setting}});
    json["values"].push_back(dimension.value);
  }
  const auto terms = [](const std::vector<datasets::DrawnTerm>& list) {
    Json all = Json::array();
    for (const auto& [factor, first, second] : list) all.push_back({factor, first, second});
    return all;
  };
  for (const auto& [x, z] : drawing.corners)
    json["corners"].push_back({{"x", terms(x)}, {"z", terms(z)}});
  for (const auto& [name, from, to] : drawing.lines)
    json["lines"].push_back({{"name", name}, {"corners", {from, to}}});
  for (const auto& [name, centre, rim] : drawing.circles)
    json["circles"].push_back({{"name", name}, {"centre", centre}, {"rim", rim}});
  for (const std::string& key : drawing.optional_keys) json["optional"].push_back("rig." + key);
  // A rig that is whole without a key of the template does not need it
  for (const std::string& key : of_template.section("rig").keys())
    if (is_whole && !rig->has(key)) json["optional"].push_back("rig." + key);
  return json;
}

}  // namespace

AnnotationPage make_annotation_page(const std::filesystem::path& experiment,
                                    const std::filesystem::path& run_folder) {
  // 1. What is said so far
  const std::filesystem::path annotation = datasets::annotation_of(experiment);
  const bool is_there = std::filesystem::is_regular_file(annotation);
  const datasets::AnnotatedFile both =
      is_there ? datasets::read_annotated(experiment, annotation)
               : datasets::AnnotatedFile{datasets::TomlFile(experiment), {}};
  TomlSection root = both.file.root();
  const SoFar so_far = read_so_far(experiment);
  const std::filesystem::path folder = experiment.parent_path();
  // 2. Films
  const std::vector<LookedAtFilm> films = films_of(root, folder, so_far, run_folder);
  Json looks = Json::array();
  std::size_t shown = 0, pictures = 0;
  for (const LookedAtFilm& film : films) {
    looks.push_back(look_at_film(film, budget_of(films.size())));
    shown += looks.back()["pictures"].size();
    pictures += looks.back()["frames"].get<std::size_t>();
  }
  // 3. The rig, and all together
  Json rig = rig_json(root, folder, so_far);
  const std::string text_of_template = rig["template"].get<std::string>();
  const auto text_of = [](const std::filesystem::path& file) {
    return datasets::read_text(file, "save it as plain text").text;
  };
  const bool says_all = so_far.experiment.has_value();
  const std::string title =
      root.optional_text("title").value_or(datasets::experiment_name(experiment));
  Json data = {{"experiment_text", text_of(experiment)},
               {"annotation_text", is_there ? text_of(annotation) : ""},
               {"annotation_name", annotation.filename().string()},
               {"template", text_of_template},
               {"optional", rig["optional"]},
               {"from_nothing", !says_all},
               {"complaint", so_far.complaint},
               {"apply",
                fmt::format("graintruth annotate {} --apply {}",
                            experiment.string(),
                            annotation.filename().string())},
               {"rig", std::move(rig)},
               {"films", std::move(looks)}};
  AnnotationPage page;
  page.words = fmt::format("{} of {} pictures of {} film{}",
                           shown,
                           pictures,
                           films.size(),
                           films.size() == 1 ? "" : "s");
  page.html = reports::annotate_page(
      title,
      fmt::format(
          "The page holds {}: the first, those about the start, the last, and some between. "
          "It is never larger than 8 MB unless the first pictures alone are.",
          page.words),
      data);
  return page;
}

}  // namespace graintruth::app
