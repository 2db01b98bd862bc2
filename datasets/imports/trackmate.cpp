#include "datasets/imports/trackmate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <pugixml.hpp>

#include "datasets/imports/column_names.h"
#include "datasets/store/input_error.h"
#include "datasets/store/text_file.h"

namespace graintruth::datasets {

namespace {

constexpr std::size_t further_header_rows = 3;

// An XML file that knows where its nodes stand.
class XmlFile {
 public:
  explicit XmlFile(const std::filesystem::path& file)
      : file_(file),
        content_(
            read_text(file, "choose 'Export tracks to XML file' among TrackMate's actions").text) {
    const pugi::xml_parse_result parsed = document_.load_buffer(
        content_.data(), content_.size(), pugi::parse_default, pugi::encoding_utf8);
    if (const std::size_t at = content_.find("<!ENTITY"); at != std::string::npos)
      fail(static_cast<std::ptrdiff_t>(at), "declares entities, which no file of tracks needs");
    if (!parsed)
      fail(parsed.offset,
           fmt::format("is no XML: {}; it may have broken off, so export or copy it anew",
                       parsed.description()));
  }

  pugi::xml_node root() const { return document_.document_element(); }
  int line(std::ptrdiff_t offset) const {
    const auto end =
        content_.begin() +
        std::clamp<std::ptrdiff_t>(offset, 0, static_cast<std::ptrdiff_t>(content_.size()));
    return 1 + static_cast<int>(std::count(content_.begin(), end, '\n'));
  }
  [[noreturn]] void fail(std::ptrdiff_t offset, std::string_view complaint) const {
    throw InputError(fmt::format("{}:{}: {}.", file_.string(), line(offset), complaint));
  }

 private:
  std::filesystem::path file_;
  std::string content_;
  pugi::xml_document document_;
};

// How a table names a quantity in this unit, or a sentence about the unit.
std::string column_in_unit(const XmlFile& xml,
                           const pugi::xml_node& root,
                           const char* attribute,
                           const Quantity& quantity) {
  const std::string unit = root.attribute(attribute).as_string();
  const std::string column = unit.empty() ? std::string(quantity.names.front())
                                          : fmt::format("{} ({})", quantity.names.front(), unit);
  bool known = false;
  try {
    known = find_column(Table({column}), quantity).has_value();
  } catch (const InputError&) {
    // Said below, with file and line
  }
  if (!known) {
    std::string all;
    for (const Unit& each : quantity.units) {
      if (!each.suffix.empty()) all += fmt::format("{}{}", all.empty() ? "" : ", ", each.suffix);
    }
    xml.fail(root.offset_debug(),
             fmt::format("{} is '{}', which is not known; {} may be in {}",
                         attribute,
                         unit,
                         quantity.words,
                         all));
  }
  return column;
}

}  // namespace

Table without_trackmate_headers(Table table) {
  const bool is_trackmate = table.has("TRACK_ID") && table.has("POSITION_X") &&
                            table.rows() >= further_header_rows &&
                            !table.is_number(0, "POSITION_X");
  if (!is_trackmate) return table;

  // 1. Units from the last of the headers: "(micron)", "(sec)"; other brackets are no units
  std::vector<std::string> columns;
  for (const std::string& column : table.columns()) {
    const std::string& unit = table.text(further_header_rows - 1, column);
    const bool is_frame = column == "POSITION_T" && unit.find("frame") != std::string::npos;
    if (is_frame) {
      columns.push_back("POSITION_T_IN_FRAMES");
    } else {
      columns.push_back(column.starts_with("POSITION_") ? column + " " + unit : column);
    }
  }
  // 2. Spots of tracks
  Table tracks = table.emptied(std::move(columns));
  for (std::size_t row = further_header_rows; row < table.rows(); ++row) {
    const std::string& track = table.text(row, "TRACK_ID");
    if (track.empty() || track == "None") continue;
    std::vector<std::string> cells;
    for (const std::string& column : table.columns()) cells.push_back(table.text(row, column));
    tracks.add(std::move(cells), table.line(row));
  }
  if (tracks.rows() == 0) {
    throw InputError(
        fmt::format("{}: no spot belongs to a track; link them in TrackMate before "
                    "exporting.",
                    table.file().string()));
  }
  return tracks;
}

bool is_xml(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& letter : extension)
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  if (extension == ".xml") return true;
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 512> begin{};
  stream.read(begin.data(), begin.size());
  const std::string_view text(begin.data(), static_cast<std::size_t>(stream.gcount()));
  return text.find("<?xml") != std::string_view::npos ||
         text.find("<Tracks") != std::string_view::npos;
}

Table read_trackmate_xml(const std::filesystem::path& file) {
  const XmlFile xml(file);
  const pugi::xml_node root = xml.root();
  if (std::string_view(root.name()) != "Tracks") {
    xml.fail(root.offset_debug(),
             fmt::format("begins with <{}>, but <Tracks> is needed; choose 'Export tracks to XML "
                         "file' among TrackMate's actions",
                         root.name()));
  }
  const std::string x = column_in_unit(xml, root, "spaceUnits", columns::right);
  const std::string y = column_in_unit(xml, root, "spaceUnits", columns::vertical);
  const std::string z = column_in_unit(xml, root, "spaceUnits", columns::height);

  // Times as a file of frames without a clock has them where the interval is one frame
  const std::string time_unit = root.attribute("timeUnits").as_string("frame");
  const bool has_clock = !time_unit.starts_with("frame");
  const double interval = root.attribute("frameInterval").as_double();
  std::vector<std::string> columns = {"particle", "frame", x, y, z};
  if (has_clock) {
    columns.push_back(column_in_unit(xml, root, "timeUnits", columns::time));
    if (!(interval > 0.0)) xml.fail(root.offset_debug(), "frameInterval must be a number above 0");
  }
  Table table(columns, file);
  int particle = 0;
  for (const pugi::xml_node& track : root.children("particle")) {
    for (const pugi::xml_node& detection : track.children("detection")) {
      std::vector<std::string> cells = {std::to_string(particle)};
      for (const char* name : {"t", "x", "y", "z"}) {
        const pugi::xml_attribute value = detection.attribute(name);
        if (!value && std::string_view(name) != "z") {
          xml.fail(detection.offset_debug(),
                   fmt::format("a <detection> has no attribute '{}'", name));
        }
        cells.emplace_back(value.as_string("0"));
      }
      if (has_clock) cells.push_back(number_text(detection.attribute("t").as_double() * interval));
      table.add(std::move(cells), xml.line(detection.offset_debug()));
    }
    ++particle;
  }
  if (table.rows() == 0)
    xml.fail(root.offset_debug(), "no <particle> with a <detection> is in it: there are no tracks");
  return table;
}

}  // namespace graintruth::datasets
