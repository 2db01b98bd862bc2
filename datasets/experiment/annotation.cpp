#include "datasets/experiment/annotation.h"

#include <fmt/format.h>

#include "datasets/experiment/replicates.h"

namespace graintruth::datasets {

namespace {

constexpr const char* usual_file = "annotation.toml";

std::string name_of_replicate(std::string_view list, TomlSection& table) {
  if (list != "replicate") return "";
  if (const auto name = table.optional_text("name")) return *name;
  for (const char* key : {"video", "tracks", "discharge", "curves"})
    if (const auto file = table.optional_text(key)) return usual_name(*file);
  return "";
}

std::optional<std::string> stated_in(const TomlFile& file) {
  auto camera = file.root().optional_section("camera");
  return camera ? camera->optional_text("annotation") : std::nullopt;
}

}  // namespace

AnnotatedFile read_annotated(const std::filesystem::path& file) {
  const TomlFile parsed(file);
  const auto stated = stated_in(parsed);
  if (!stated) return {parsed, {}};
  const std::filesystem::path annotation = file.parent_path() / *stated;
  if (!std::filesystem::is_regular_file(annotation)) {
    parsed.root().section("camera").fail(
        "annotation",
        fmt::format("names '{}', but there is no such file; graintruth annotate {} makes a page "
                    "that does",
                    annotation.string(),
                    file.string()));
  }
  return read_annotated(file, annotation);
}

AnnotatedFile read_annotated(const std::filesystem::path& file,
                             const std::filesystem::path& annotation) {
  AnnotatedFile both{TomlFile(file), annotation};
  both.file.include(annotation, name_of_replicate);
  return both;
}

bool names_annotation(const std::filesystem::path& file) {
  return stated_in(TomlFile(file)).has_value();
}

std::filesystem::path annotation_of(const std::filesystem::path& file) {
  return file.parent_path() / stated_in(TomlFile(file)).value_or(usual_file);
}

}  // namespace graintruth::datasets
