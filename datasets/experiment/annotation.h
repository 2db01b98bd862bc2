// What was clicked on the page of `graintruth annotate`: a file beside the experiment file, which
// [camera] annotation names. It states keys of the experiment, and is read as if they stood there.
#pragma once

#include <filesystem>

#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

struct AnnotatedFile {
  TomlFile file;                     // of the experiment, with the annotation included
  std::filesystem::path annotation;  // empty: there is none
};

// Throws InputError where the annotation is missing or contradicts the experiment file.
AnnotatedFile read_annotated(const std::filesystem::path& file);
// With this annotation in place of the one that the file names, if it names any.
AnnotatedFile read_annotated(const std::filesystem::path& file,
                             const std::filesystem::path& annotation);
// Where the experiment file has its annotation, or would have it: "annotation.toml" beside it.
std::filesystem::path annotation_of(const std::filesystem::path& file);
bool names_annotation(const std::filesystem::path& file);

}  // namespace graintruth::datasets
