// One table of a TOML file, read key by key with units converted at the door. For the .cpp files of
// this folder and of those who read sections of their own.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/store/units.h"

// The library stays in the .cpp file of this header.
namespace toml {
inline namespace v3 {
class node;
class table;
}  // namespace v3
}  // namespace toml

namespace graintruth::datasets {

class TomlSection;

// A TOML file that has been parsed. Throws InputError with file and line where it is no TOML.
class TomlFile {
 public:
  explicit TomlFile(std::filesystem::path file);
  // `text` stands in for the file of that name.
  static TomlFile of_text(std::string text, const std::filesystem::path& name);
  TomlSection root() const;

  // Names a table of a list, [[key]], so that both files may say something of it: "" where it has
  // no name.
  using NameInList = std::function<std::string(std::string_view key, TomlSection& table)>;
  // Adds what another file states of the same tables. Sentences about its keys name that file and
  // its lines. A key of both must have one value. Tables of a list are the same where they have one
  // name; other lists stand in one of the files. Throws InputError where both contradict each
  // other.
  void include(const std::filesystem::path& other, const NameInList& name_in_list);

 private:
  TomlFile(std::filesystem::path file, std::shared_ptr<toml::table> table);

  std::filesystem::path file_;
  std::shared_ptr<toml::table> table_;
};

// Remembers which keys were asked for, so that finish() can name those that nobody knows.
class TomlSection {
 public:
  // A part of a file that stays as long as any section of it.
  TomlSection(std::shared_ptr<const toml::table> table,
              std::filesystem::path file,
              std::string name);

  bool has(std::string_view key);
  // Of a key that may hold the one or the other; false where there is none.
  bool is_text(std::string_view key);
  bool is_table(std::string_view key);
  // The value under `stem` with one of the units, e.g. stem "gap" finds gap_mm. Throws InputError
  // when it is missing, given twice, no number, or outside the range.
  double quantity(std::string_view stem, Units units, const Range& range = any_number);
  std::optional<double> optional_quantity(std::string_view stem,
                                          Units units,
                                          const Range& range = any_number);
  int whole_number(std::string_view key, int lower, int upper);
  std::optional<int> optional_whole_number(std::string_view key, int lower, int upper);
  std::string text(std::string_view key);
  std::optional<std::string> optional_text(std::string_view key);
  // One text, or a list of them.
  std::vector<std::string> texts(std::string_view key);
  TomlSection section(std::string_view key);
  std::optional<TomlSection> optional_section(std::string_view key);
  // An array of tables, [[key]] or key = [{...}, ...]; empty where there is none.
  std::vector<TomlSection> sections(std::string_view key);
  // Rows of exactly `width` numbers under stem with a length unit, e.g. fiducials_mm = [[0, 1], [2,
  // 3]].
  std::vector<std::vector<double>> rows(std::string_view stem, std::size_t width, Units units);
  // Exactly `width` numbers under stem with a unit, e.g. centre_mm = [0, 1, 2].
  std::vector<double> numbers(std::string_view stem, std::size_t width, Units units);
  std::optional<std::vector<double>> optional_numbers(std::string_view stem,
                                                      std::size_t width,
                                                      Units units);
  std::optional<bool> optional_flag(std::string_view key);
  // A list of texts.
  std::optional<std::vector<std::string>> optional_texts(std::string_view key);
  // All keys of the table, as written (for tables whose keys are names).
  std::vector<std::string> keys() const;

  // The same keys, and those of the other, which win.
  TomlSection overridden_by(const TomlSection& other) const;

  // What the table states, as TOML, but for some keys.
  std::string text_without(std::initializer_list<std::string_view> keys) const;

  // The key under which a quantity is given, with its unit.
  std::string key_of(std::string_view stem, Units units) const;

  // Throws InputError for the first key that was never asked for, with the nearest one that exists.
  void finish() const;
  // Throws InputError about a key of this section: "file:line: key 'section.key' ...".
  [[noreturn]] void fail(std::string_view key, std::string_view complaint) const;

  const std::string& name() const { return name_; }

 private:
  const toml::node* find(std::string_view key);
  // Says what is wrong where no key under `stem` was found.
  [[noreturn]] void fail_missing(std::string_view stem, Units units) const;
  std::string qualified(std::string_view key) const;

  std::shared_ptr<const toml::table> table_;
  std::filesystem::path file_;
  std::string name_;
  std::set<std::string, std::less<>> known_;
};

}  // namespace graintruth::datasets
