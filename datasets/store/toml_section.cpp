#include "datasets/store/toml_section.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "datasets/store/input_error.h"
#include "datasets/store/text_file.h"

namespace graintruth::datasets {

namespace {

constexpr std::string_view not_finite = "has a number that is not finite";

// Levenshtein distance: the fewest single-letter changes that turn one word into the other.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string with_unit(std::string_view stem, const Unit& unit) {
  return unit.suffix.empty() ? std::string(stem) : fmt::format("{}_{}", stem, unit.suffix);
}

std::string spellings(std::string_view stem, Units units) {
  std::string all;
  for (const Unit& unit : units) {
    all += fmt::format("{}'{}'", all.empty() ? "" : " or ", with_unit(stem, unit));
  }
  return all;
}

// "file:line". A part of a file that another one includes remembers where it stands.
std::string place_of(const toml::node& node, const std::filesystem::path& file) {
  const toml::source_region& source = node.source();
  return fmt::format("{}:{}", source.path ? *source.path : file.string(), source.begin.line);
}

}  // namespace

TomlSection::TomlSection(std::shared_ptr<const toml::table> table,
                         std::filesystem::path file,
                         std::string name)
    : table_(std::move(table)), file_(std::move(file)), name_(std::move(name)) {}

std::string TomlSection::qualified(std::string_view key) const {
  return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

const toml::node* TomlSection::find(std::string_view key) {
  known_.emplace(key);
  return table_->get(key);
}

bool TomlSection::has(std::string_view key) { return find(key) != nullptr; }

bool TomlSection::is_text(std::string_view key) {
  const toml::node* node = find(key);
  return node != nullptr && node->is_string();
}

bool TomlSection::is_table(std::string_view key) {
  const toml::node* node = find(key);
  return node != nullptr && node->is_table();
}

void TomlSection::fail(std::string_view key, std::string_view complaint) const {
  const toml::node* node = table_->get(key);
  throw InputError(fmt::format("{}: key '{}' {}{}",
                               place_of(node != nullptr ? *node : *table_, file_),
                               qualified(key),
                               complaint,
                               complaint.ends_with('?') ? "" : "."));
}

std::optional<double> TomlSection::optional_quantity(std::string_view stem,
                                                     Units units,
                                                     const Range& range) {
  std::optional<double> found;
  for (const Unit& unit : units) {
    const std::string key = with_unit(stem, unit);
    const toml::node* node = find(key);
    if (node == nullptr) continue;
    if (found) fail(key, fmt::format("gives '{}' a second time", stem));
    const auto value = node->value<double>();
    if (!value || !(node->is_number())) {
      fail(
          key,
          fmt::format(
              "holds {}, but {} is needed", node->is_string() ? "text" : "no number", range.words));
    }
    const double in_si = *value * unit.in_si;
    if (const auto complaint = complaint_about(*value, in_si, range)) fail(key, *complaint);
    found = in_si;
  }
  return found;
}

double TomlSection::quantity(std::string_view stem, Units units, const Range& range) {
  const auto found = optional_quantity(stem, units, range);
  if (!found) fail_missing(stem, units);
  return *found;
}

void TomlSection::fail_missing(std::string_view stem, Units units) const {
  // A key with the right stem but a unit of another kind deserves its own sentence.
  for (const auto& [key, node] : *table_) {
    const std::string_view name = key.str();
    if (name.starts_with(stem) && name.size() > stem.size() && name[stem.size()] == '_' &&
        !known_.contains(name)) {
      fail(name, fmt::format("has no unit that fits; write {}", spellings(stem, units)));
    }
  }
  // A key that is nearly right is the likeliest reason.
  for (const auto& [key, node] : *table_) {
    if (known_.contains(key.str())) continue;
    std::string nearest;
    std::size_t fewest = 3;  // changes; more make another word of it
    for (const Unit& unit : units) {
      const std::string wanted = with_unit(stem, unit);
      if (edits(key.str(), wanted) >= fewest) continue;
      fewest = edits(key.str(), wanted);
      nearest = wanted;
    }
    if (!nearest.empty()) fail(key.str(), fmt::format("is unknown; did you mean '{}'?", nearest));
  }
  fail(with_unit(stem, *units.begin()),
       fmt::format("is missing; write {}", spellings(stem, units)));
}

std::optional<int> TomlSection::optional_whole_number(std::string_view key, int lower, int upper) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const auto value = node->is_integer() ? node->value<std::int64_t>() : std::nullopt;
  if (!value || *value < lower || *value > upper) {
    fail(key, fmt::format("must be a whole number from {} to {}", lower, upper));
  }
  return static_cast<int>(*value);
}

int TomlSection::whole_number(std::string_view key, int lower, int upper) {
  const auto found = optional_whole_number(key, lower, upper);
  if (!found)
    fail(key, fmt::format("is missing; a whole number from {} to {} is needed", lower, upper));
  return *found;
}

std::optional<std::string> TomlSection::optional_text(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_string()) fail(key, "must be text in quotes");
  return node->value<std::string>();
}

std::string TomlSection::text(std::string_view key) {
  auto found = optional_text(key);
  if (!found) fail(key, "is missing; text in quotes is needed");
  return *std::move(found);
}

std::vector<std::string> TomlSection::texts(std::string_view key) {
  const toml::node* node = find(key);
  const toml::array* list = node == nullptr ? nullptr : node->as_array();
  if (list == nullptr) return {text(key)};
  std::vector<std::string> all;
  for (const toml::node& one : *list) {
    if (!one.is_string()) fail(key, "must be text in quotes, or a list of such texts");
    all.push_back(*one.value<std::string>());
  }
  return all;
}

std::optional<TomlSection> TomlSection::optional_section(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_table())
    fail(key, fmt::format("must be a table: write [{}] above its keys", qualified(key)));
  return TomlSection({table_, node->as_table()}, file_, qualified(key));
}

TomlSection TomlSection::section(std::string_view key) {
  auto found = optional_section(key);
  if (!found) fail(key, fmt::format("is missing; a table [{}] is needed", qualified(key)));
  return *std::move(found);
}

std::vector<TomlSection> TomlSection::sections(std::string_view key) {
  const toml::node* node = find(key);
  std::vector<TomlSection> all;
  if (node == nullptr) return all;
  const toml::array* array = node->as_array();
  if (array == nullptr)
    fail(key, fmt::format("must be a list of tables: write [[{}]]", qualified(key)));
  for (const toml::node& element : *array) {
    if (!element.is_table())
      fail(key, fmt::format("must be a list of tables: write [[{}]]", qualified(key)));
    all.emplace_back(
        std::shared_ptr<const toml::table>(table_, element.as_table()), file_, qualified(key));
  }
  return all;
}

std::vector<std::vector<double>> TomlSection::rows(std::string_view stem,
                                                   std::size_t width,
                                                   Units units) {
  std::vector<std::vector<double>> all;
  for (const Unit& unit : units) {
    const std::string key = with_unit(stem, unit);
    const toml::node* node = find(key);
    if (node == nullptr) continue;
    const std::string needed = fmt::format("must be a list of lists of {} numbers", width);
    if (!all.empty()) fail(key, fmt::format("gives '{}' a second time", stem));
    if (!node->is_array()) fail(key, needed);
    for (const toml::node& element : *node->as_array()) {
      const toml::array* row = element.as_array();
      if (row == nullptr || row->size() != width) fail(key, needed);
      std::vector<double> numbers;
      for (const toml::node& cell : *row) {
        const auto value = cell.is_number() ? cell.value<double>() : std::nullopt;
        if (!value) fail(key, needed);
        if (!std::isfinite(*value)) fail(key, not_finite);
        numbers.push_back(*value * unit.in_si);
      }
      all.push_back(std::move(numbers));
    }
  }
  return all;
}

std::optional<std::vector<double>> TomlSection::optional_numbers(std::string_view stem,
                                                                 std::size_t width,
                                                                 Units units) {
  std::optional<std::vector<double>> found;
  for (const Unit& unit : units) {
    const std::string key = with_unit(stem, unit);
    const toml::node* node = find(key);
    if (node == nullptr) continue;
    const std::string needed = fmt::format("must be a list of {} numbers", width);
    if (found) fail(key, fmt::format("gives '{}' a second time", stem));
    const toml::array* list = node->as_array();
    if (list == nullptr || list->size() != width) fail(key, needed);
    found.emplace();
    for (const toml::node& cell : *list) {
      const auto value = cell.is_number() ? cell.value<double>() : std::nullopt;
      if (!value) fail(key, needed);
      if (!std::isfinite(*value)) fail(key, not_finite);
      found->push_back(*value * unit.in_si);
    }
  }
  return found;
}

std::vector<double> TomlSection::numbers(std::string_view stem, std::size_t width, Units units) {
  auto found = optional_numbers(stem, width, units);
  if (!found) fail_missing(stem, units);
  return *std::move(found);
}

std::optional<bool> TomlSection::optional_flag(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_boolean()) fail(key, "must be true or false");
  return node->value<bool>();
}

std::vector<std::string> TomlSection::keys() const {
  std::vector<std::string> all;
  for (const auto& [key, node] : *table_) all.emplace_back(key.str());
  return all;
}

std::string TomlSection::text_without(std::initializer_list<std::string_view> keys) const {
  toml::table rest = *table_;
  for (const std::string_view key : keys) rest.erase(key);
  std::ostringstream text;
  text << rest;
  return text.str();
}

TomlSection TomlSection::overridden_by(const TomlSection& other) const {
  toml::table both = *table_;
  for (const auto& [key, value] : *other.table_) both.insert_or_assign(key.str(), value);
  return {std::make_shared<const toml::table>(std::move(both)), other.file_, other.name_};
}

std::string TomlSection::key_of(std::string_view stem, Units units) const {
  for (const Unit& unit : units)
    if (table_->contains(with_unit(stem, unit))) return with_unit(stem, unit);
  return with_unit(stem, units.front());
}

void TomlSection::finish() const {
  for (const auto& [key, node] : *table_) {
    const std::string_view name = key.str();
    if (known_.contains(name)) continue;
    std::string_view nearest;
    std::size_t fewest = name.size() / 2 + 1;  // changes; more make another word of it
    for (const std::string& known : known_) {
      if (edits(name, known) >= fewest) continue;
      fewest = edits(name, known);
      nearest = known;
    }
    fail(name,
         nearest.empty() ? fmt::format("is unknown; known here are {}", fmt::join(known_, ", "))
                         : fmt::format("is unknown; did you mean '{}'?", nearest));
  }
}

std::optional<std::vector<std::string>> TomlSection::optional_texts(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const toml::array* list = node->as_array();
  if (list == nullptr) fail(key, "must be a list of texts in quotes");
  std::vector<std::string> texts;
  for (const toml::node& element : *list) {
    if (!element.is_string()) fail(key, "must be a list of texts in quotes");
    texts.push_back(*element.value<std::string>());
  }
  return texts;
}

namespace {

toml::table parsed(std::string_view content, const std::filesystem::path& file) {
  try {
    return toml::parse(content, file.string());
  } catch (const toml::parse_error& error) {
    // The library quotes what it saw, line ends included; a sentence has none
    std::string description(error.description());
    std::replace_if(
        description.begin(), description.end(), [](unsigned char c) { return c < ' '; }, ' ');
    throw InputError(fmt::format("{}:{}: this is not valid TOML: {}.",
                                 file.string(),
                                 error.source().begin.line,
                                 description));
  }
}

toml::table parsed(const std::filesystem::path& file) {
  return parsed(read_text(file, "save it as plain text").text, file);
}

}  // namespace

TomlFile::TomlFile(std::filesystem::path file)
    : file_(std::move(file)), table_(std::make_shared<toml::table>(parsed(file_))) {}

TomlFile::TomlFile(std::filesystem::path file, std::shared_ptr<toml::table> table)
    : file_(std::move(file)), table_(std::move(table)) {}

TomlFile TomlFile::of_text(std::string text, const std::filesystem::path& name) {
  return {name, std::make_shared<toml::table>(parsed(text, name))};
}

namespace {

// Numbers by value: 135 is 135.0.
bool are_same(const toml::node& one, const toml::node& other) {
  if (one.is_number() && other.is_number()) return one.value<double>() == other.value<double>();
  const toml::array* list = one.as_array();
  const toml::array* other_list = other.as_array();
  if (list != nullptr && other_list != nullptr) {
    return std::equal(list->begin(), list->end(), other_list->begin(), other_list->end(), are_same);
  }
  const toml::table* table = one.as_table();
  const toml::table* other_table = other.as_table();
  if (table != nullptr && other_table != nullptr) {
    return table->size() == other_table->size() &&
           std::all_of(table->begin(), table->end(), [&](const auto& entry) {
             const toml::node* twin = other_table->get(entry.first.str());
             return twin != nullptr && are_same(entry.second, *twin);
           });
  }
  return one.is_string() ? one.value<std::string>() == other.value<std::string>()
                         : one.type() == other.type() && one.value<bool>() == other.value<bool>();
}

class Inclusion {
 public:
  Inclusion(std::filesystem::path file,
            std::filesystem::path other,
            const TomlFile::NameInList& name_in_list)
      : file_(std::move(file)), other_(std::move(other)), name_in_list_(name_in_list) {}

  void add(toml::table& into, toml::table& from, const std::string& name) const {
    for (auto&& [key, node] : from) {
      const std::string path =
          name.empty() ? std::string(key.str()) : fmt::format("{}.{}", name, key.str());
      toml::node* there = into.get(key.str());
      if (there == nullptr) {
        into.insert_or_assign(key.str(), std::move(node));
      } else if (there->is_table() && node.is_table()) {
        add(*there->as_table(), *node.as_table(), path);
      } else if (!are_same(*there, node)) {
        if (there->is_array_of_tables() && node.is_array_of_tables())
          add_list(*there->as_array(), *node.as_array(), path);
        else
          refuse(*there, node, path);
      }
    }
  }

 private:
  void add_list(toml::array& into, toml::array& from, const std::string& path) const {
    const auto name_of = [&](toml::node& node) {
      TomlSection table(
          std::shared_ptr<const toml::table>(std::shared_ptr<void>(), node.as_table()),
          file_,
          path);
      return name_in_list_(path, table);
    };
    for (toml::node& node : from) {
      const std::string name = name_of(node);
      if (name.empty()) refuse(into.front(), node, path);
      const auto same = std::find_if(
          into.begin(), into.end(), [&](toml::node& there) { return name_of(there) == name; });
      if (same == into.end()) {
        throw InputError(fmt::format("{}: key '{}' says something of '{}', which is not in {}.",
                                     place_of(node, other_),
                                     path,
                                     name,
                                     file_.string()));
      }
      add(*same->as_table(), *node.as_table(), path);
    }
  }

  [[noreturn]] void refuse(const toml::node& there,
                           const toml::node& node,
                           const std::string& path) const {
    throw InputError(fmt::format("{}: key '{}' is stated otherwise in {}; keep one of them.",
                                 place_of(node, other_),
                                 path,
                                 place_of(there, file_)));
  }

  std::filesystem::path file_, other_;
  const TomlFile::NameInList& name_in_list_;
};

}  // namespace

void TomlFile::include(const std::filesystem::path& other, const NameInList& name_in_list) {
  toml::table table = parsed(other);
  Inclusion(file_, other, name_in_list).add(*table_, table, "");
}

TomlSection TomlFile::root() const { return TomlSection(table_, file_, ""); }

}  // namespace graintruth::datasets
