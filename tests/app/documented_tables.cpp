#include "tests/app/documented_tables.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <regex>

#include "tests/app/laboratory.h"

namespace graintruth::tests {

namespace {

// Columns by file, of one heading's table: "| `FILE` | `COLUMN,COLUMN` | ..."
std::map<std::string, std::string> documented_under(const std::string& heading) {
  const std::string text =
      content_of(std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "docs/run_folder.md");
  const auto first = text.find("\n## " + heading + "\n");
  if (first == std::string::npos) return {};
  const std::string section = text.substr(first + 1, text.find("\n## ", first + 1) - first - 1);
  const std::regex row("\\| `([^`]+\\.csv)` \\| `([^`]+)` \\|");
  std::map<std::string, std::string> columns;
  for (std::sregex_iterator at(section.begin(), section.end(), row), end; at != end; ++at)
    columns[(*at)[1]] = (*at)[2];
  return columns;
}

}  // namespace

std::vector<std::string> undocumented_tables(const std::filesystem::path& run_folder,
                                             const std::vector<std::string>& headings) {
  std::map<std::string, std::string> documented;
  for (const std::string& heading : headings) documented.merge(documented_under(heading));
  std::vector<std::string> differences;
  if (documented.empty()) differences.emplace_back("the document has no such tables");
  std::map<std::string, std::string> unseen = documented;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(run_folder)) {
    if (entry.path().extension() != ".csv") continue;
    std::string name = std::filesystem::relative(entry.path(), run_folder).generic_string();
    for (const char* any : {"tracks/<film>.csv", "tables/<target>.csv"}) {
      const std::string place(any, std::strchr(any, '<') - any);
      if (name.starts_with(place) && !documented.contains(name) && documented.contains(any))
        name = any;
    }
    const std::string content = content_of(entry.path());
    const std::string columns = content.substr(0, content.find('\n'));
    unseen.erase(name);
    if (!documented.contains(name)) {
      differences.push_back(name + " is not in the document");
    } else if (documented.at(name) != columns) {
      differences.push_back(name + " has " + columns + ", the document " + documented.at(name));
    }
  }
  for (const auto& [name, columns] : unseen) differences.push_back(name + " was not written");
  return differences;
}

}  // namespace graintruth::tests
