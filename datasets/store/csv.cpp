// CSV files in and out of Table. Quotes are taken apart by fast-cpp-csv-parser; numbers are
// converted by Table, because that library reads 0.3 as 0.30000000000000004 and an empty field as
// 0.
#include <fmt/format.h>
#include <libfccp/csv.h>

#include <algorithm>
#include <array>
#include <limits>  // csv.h needs it and does not include it
#include <map>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"
#include "datasets/store/text_file.h"

namespace graintruth::datasets {

namespace {

using Blanks = io::trim_chars<' ', '\t'>;
using Cells = std::vector<std::string>;

struct Line {
  std::string text;
  int number = 0;

  bool is_comment() const { return text.starts_with('#') || text.starts_with('%'); }
};

template <char separator>
Cells split_at(std::string text) {
  using Quotes = io::double_quote_escape<separator, '"'>;
  Cells cells;
  char* rest = text.data();
  while (rest != nullptr) {
    char* begin = nullptr;
    char* end = nullptr;
    io::detail::chop_next_column<Quotes>(rest, begin, end);
    Blanks::trim(begin, end);
    Quotes::unescape(begin, end);
    cells.emplace_back(begin, end);
  }
  return cells;
}

// Any number of blanks and tabs between two cells
Cells split_at_blanks(std::string_view text) {
  std::string parted;
  bool is_quoted = false;
  for (const char letter : text) {
    is_quoted = is_quoted != (letter == '"');
    const bool is_blank = !is_quoted && (letter == ' ' || letter == '\t');
    if (!is_blank) parted += letter;
    if (is_blank && !parted.empty() && parted.back() != '\t') parted += '\t';
  }
  while (parted.ends_with('\t')) parted.pop_back();
  return split_at<'\t'>(std::move(parted));
}

constexpr std::string_view separators = ",;\t| ";

Cells split(const Line& line, char separator, const std::filesystem::path& file) {
  try {
    switch (separator) {
      case '\t':
        return split_at<'\t'>(line.text);
      case ';':
        return split_at<';'>(line.text);
      case '|':
        return split_at<'|'>(line.text);
      case ' ':
        return split_at_blanks(line.text);
      default:
        return split_at<','>(line.text);
    }
  } catch (const io::error::base&) {
    throw InputError(fmt::format(
        "{}:{}: a quotation mark is opened and not closed.", file.string(), line.number));
  }
}

bool is_empty(const std::string& cell) {
  return cell.find_first_not_of(" \t\u00a0") == std::string::npos;
}

bool is_number(const std::string& cell) { return !is_missing(cell) && is_numeral(cell); }

bool are_all_numbers(const Cells& cells) {
  return std::any_of(cells.begin(), cells.end(), is_number) &&
         std::all_of(cells.begin(), cells.end(), is_numeral);
}

bool has_number(const Cells& cells) { return std::any_of(cells.begin(), cells.end(), is_number); }

// As many cells as the header has names. Empty ones may be too many, and those without a name be
// missing at the end.
bool fits(const Cells& cells, const Cells& names) {
  std::size_t named = names.size();
  while (named > 0 && is_empty(names[named - 1])) --named;
  const std::size_t known = std::min(cells.size(), names.size());
  return cells.size() >= std::max<std::size_t>(named, 1) &&
         std::all_of(cells.begin() + static_cast<std::ptrdiff_t>(known), cells.end(), is_empty);
}

std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos && !cell.starts_with('#') &&
      !cell.starts_with('%'))
    return cell;
  std::string text = "\"";
  for (const char c : cell) {
    if (c == '"') text += '"';
    text += c;
  }
  text += '"';
  return text;
}

void append_row(const std::vector<std::string>& cells, std::string& text) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) text += ',';
    text += quoted(cells[i]);
  }
  text += '\n';
}

}  // namespace

// The steps from text to a table.
class CsvReader {
 public:
  CsvReader(const std::filesystem::path& file, TextFile content) : file_(file) {
    table_.file_ = file;
    table_.notes_ = std::move(content.notes);
    find_lines(content.text);
  }

  Table read() {
    if (lines_.empty())
      throw InputError(
          fmt::format("{}: the file is empty; a header row is needed.", file_.string()));
    if (lines_.front().text.starts_with('<')) {
      throw InputError(fmt::format("{}: is a web page or XML, not a table; save the table as CSV.",
                                   file_.string()));
    }
    if (lines_.front().text.starts_with("LabVIEW Measurement")) {
      take_labview_header();
    } else {
      take_separator_line();
      drop_comments_but_before_the_first_row();
      find_header();
    }
    read_rows();
    take_units_row();
    leave_out_nameless_columns();
    if (!is_style_stated_) decide_style();
    return std::move(table_);
  }

 private:
  [[noreturn]] void fail(int line, std::string_view complaint) const {
    throw InputError(fmt::format("{}:{}: {}.", file_.string(), line, complaint));
  }

  Cells cells_of(const Line& line) const { return split(line, separator_, file_); }

  // Lines that hold something. A quoted cell may go over several lines: they become one.
  void find_lines(const std::string& text) {
    constexpr int most_lines_of_a_cell = 20;
    int number = 0, open_lines = 0;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      std::string line = text.substr(begin, end - begin);
      begin = end + 1;
      ++number;
      if (open_lines > 0 && open_lines < most_lines_of_a_cell) {
        lines_.back().text += ' ' + line;
      } else if (is_empty(line)) {
        continue;
      } else {
        lines_.push_back({std::move(line), number});
      }
      const std::string& whole = lines_.back().text;
      const bool is_open =
          !lines_.back().is_comment() && std::count(whole.begin(), whole.end(), '"') % 2 != 0;
      open_lines = is_open ? open_lines + 1 : 0;
    }
  }

  // `sep=;`, as Excel reads and writes it
  void take_separator_line() {
    std::string line = lines_.front().text;
    line.erase(std::remove(line.begin(), line.end(), '"'), line.end());
    if (line.size() < 5) return;
    std::string word = line.substr(0, 4);
    std::transform(word.begin(), word.end(), word.begin(), [](char letter) {
      return static_cast<char>(letter >= 'A' && letter <= 'Z' ? letter + 32 : letter);
    });
    if (word != "sep=" || line.find_first_not_of(' ', 5) != std::string::npos) return;
    if (separators.find(line[4]) == std::string_view::npos) {
      fail(lines_.front().number,
           fmt::format("cells are parted by '{}', but it must be a comma, a semicolon, a tab, a "
                       "blank or |",
                       line[4]));
    }
    separator_ = line[4];
    is_separator_stated_ = true;
    lines_.erase(lines_.begin());
    if (lines_.empty())
      throw InputError(
          fmt::format("{}: the file is empty; a header row is needed.", file_.string()));
  }

  void drop_comments_but_before_the_first_row() {
    const auto first = std::find_if_not(
        lines_.begin(), lines_.end(), [](const Line& line) { return line.is_comment(); });
    comments_.assign(lines_.begin(), first);
    lines_.erase(lines_.begin(), first);
    std::erase_if(lines_, [](const Line& line) { return line.is_comment(); });
    if (!lines_.empty()) return;
    throw InputError(
        fmt::format("{}: every line is a comment; a header row is needed.", file_.string()));
  }

  // What parts the cells of a line that is a header: of the marks in it those that part the next
  // row into numbers, else tabs, else the most frequent.
  char separator_of(const Line& header, std::size_t next_row) const {
    if (is_separator_stated_) return separator_;
    std::map<char, int> count;
    bool is_quoted = false;
    for (const char letter : header.text) {
      is_quoted = is_quoted != (letter == '"');
      if (!is_quoted) ++count[letter];
    }
    std::vector<char> marks;
    for (const char mark : {'\t', ',', ';', '|'})
      if (count[mark] > 0) marks.push_back(mark);
    std::stable_sort(marks.begin(), marks.end(), [&](char a, char b) {
      return a != '\t' && b != '\t' ? count[a] > count[b] : a == '\t';
    });
    const auto parts_numbers = [&](char mark) {
      const Cells row = split(lines_[next_row], mark, file_);
      return row.size() > 1 && are_all_numbers(row);
    };
    if (next_row < lines_.size()) {
      if (marks.empty()) return parts_numbers(' ') ? ' ' : ',';
      for (const char mark : marks) {
        if (marks.size() > 1 && parts_numbers(mark) &&
            fits(split(lines_[next_row], mark, file_), split(header, mark, file_)))
          return mark;
      }
    }
    return marks.empty() ? ',' : marks.front();
  }

  void take_header(const Line& line, char separator) {
    separator_ = separator;
    table_.columns_ = cells_of(line);
    table_.header_line_ = line.number;
  }

  // The nearest of the comments under which the first row is numbers, or nothing.
  bool find_header_in_comments() {
    for (auto comment = comments_.rbegin(); comment != comments_.rend(); ++comment) {
      Line names = *comment;
      names.text.erase(0, std::min(names.text.find_first_not_of("#% \t"), names.text.size()));
      const char separator = separator_of(names, 0);
      const Cells cells = split(names, separator, file_);
      const Cells row = split(lines_.front(), separator, file_);
      if (has_number(cells) || !are_all_numbers(row) || cells.size() != row.size()) continue;
      take_header(names, separator);
      return true;
    }
    return false;
  }

  // See read_csv.
  void find_header() {
    if (find_header_in_comments()) return;
    separator_ = separator_of(lines_.front(), 1);
    std::size_t header = 0;
    if (!next_row_fits_under_the_first()) {
      constexpr std::size_t most_lines_above = 100;
      for (std::size_t at = 1; at < std::min(lines_.size(), most_lines_above); ++at) {
        if (!rows_fit_under(at)) continue;
        header = at;
        table_.notes_.push_back(fmt::format(
            "{}: line {} is taken for the header; what stands above it is no part of the table.",
            file_.string(),
            lines_[at].number));
        break;
      }
    }
    take_header(lines_[header], separator_of(lines_[header], header + 1));
    lines_.erase(lines_.begin(), lines_.begin() + static_cast<std::ptrdiff_t>(header) + 1);
  }

  // A title is no header: it has one cell, and what follows is no number.
  bool next_row_fits_under_the_first() const {
    if (lines_.size() < 2) return true;
    const Cells names = cells_of(lines_[0]), next = cells_of(lines_[1]);
    return fits(next, names) && (names.size() > 1 || is_numeral(next.front()));
  }

  // Whether a line of names is followed by two rows of numbers under them; between them at most
  // three more rows of words, as TrackMate writes them.
  bool rows_fit_under(std::size_t header) const {
    constexpr int most_further_headers = 3, enough = 2;
    const char separator = separator_of(lines_[header], header + 1);
    const Cells names = split(lines_[header], separator, file_);
    if (names.size() < 2 || has_number(names)) return false;
    int words = 0, rows = 0;
    for (std::size_t at = header + 1; at < lines_.size() && rows < enough; ++at) {
      const Cells cells = split(lines_[at], separator, file_);
      if (!fits(cells, names)) return false;
      if (has_number(cells)) {
        ++rows;
      } else if (rows > 0 || ++words > most_further_headers) {
        return false;
      }
    }
    return rows == enough;
  }

  void read_rows() {
    const std::size_t columns = table_.columns_.size();
    for (const Line& line : lines_) {
      Cells cells = cells_of(line);
      if (may_lack_cells_ && cells.size() < columns) cells.resize(columns);
      if (std::all_of(cells.begin(), cells.end(), is_empty) && columns > 1) continue;
      if (!fits(cells, table_.columns_)) refuse_row(line, cells);
      cells.resize(columns);
      table_.cells_.push_back(std::move(cells));
      table_.lines_.push_back(line.number);
    }
  }

  [[noreturn]] void refuse_row(const Line& line, const Cells& cells) const {
    const std::size_t columns = table_.columns_.size();
    const bool may_be_decimal_commas =
        separator_ == ',' && cells.size() == 2 * columns && are_all_numbers(cells);
    fail(line.number,
         fmt::format("the row has {} cells, but the header (line {}) has {} columns{}",
                     cells.size(),
                     table_.header_line_,
                     columns,
                     may_be_decimal_commas
                         ? "; if its commas are decimal ones, part the cells by semicolons"
                         : ""));
  }

  // A second row of units: words above numbers, followed by a row of numbers.
  void take_units_row() {
    auto& rows = table_.cells_;
    if (rows.size() < 2 || has_number(rows[0]) || !has_number(rows[1])) return;
    for (std::size_t i = 0; i < rows[0].size(); ++i) {
      if (!is_empty(rows[0][i]) && !is_missing(rows[0][i]) && !is_numeral(rows[1][i])) return;
    }
    for (std::size_t i = 0; i < rows[0].size(); ++i) {
      std::string unit = rows[0][i];
      if (unit.size() > 2 && std::string_view("([").find(unit.front()) != std::string_view::npos)
        unit = unit.substr(1, unit.size() - 2);
      std::string& name = table_.columns_[i];
      const bool is_stated = name.find_first_of("([") != std::string::npos ||
                             name.ends_with("_" + unit) || name.ends_with(" " + unit);
      if (!is_missing(unit) && unit != "-" && !is_stated) name += fmt::format(" ({})", unit);
    }
    rows.erase(rows.begin());
    table_.lines_.erase(table_.lines_.begin());
  }

  void leave_out_nameless_columns() {
    auto& rows = table_.cells_;
    for (std::size_t i = table_.columns_.size(); i-- > 0;) {
      if (!is_empty(table_.columns_[i]) || rows.empty()) continue;
      if (!std::all_of(
              rows.begin(), rows.end(), [&](const Cells& row) { return is_empty(row[i]); }))
        continue;
      const auto at = static_cast<std::ptrdiff_t>(i);
      table_.columns_.erase(table_.columns_.begin() + at);
      for (Cells& row : rows) row.erase(row.begin() + at);
    }
  }

  void decide_style() {
    NumberVote vote(table_.columns_);
    for (std::size_t row = 0; row < table_.cells_.size(); ++row) {
      for (std::size_t i = 0; i < table_.columns_.size(); ++i)
        vote.hear(table_.cells_[row][i], i, table_.lines_[row]);
    }
    table_.style_ = vote.decide(separator_);
  }

  // A LabVIEW measurement (.lvm): lines of "key, value" up to ***End_of_Header***, those of the
  // block up to a second such line, then the names of the columns: X_Value, the channels, Comment.
  // (National Instruments, "Specification for the LabVIEW Measurement File (.lvm)", 2.0)
  void take_labview_header() {
    std::vector<std::size_t> ends;
    for (std::size_t at = 0; at < lines_.size(); ++at) {
      if (lines_[at].text.starts_with("***End_of_Header***")) ends.push_back(at);
    }
    if (ends.empty()) fail(lines_.back().number, "breaks off: ***End_of_Header*** is missing");
    if (ends.size() > 2) {
      fail(lines_[ends[2]].number,
           "a second block of measurements begins here; keep one block in a file");
    }
    if (ends.back() + 1 >= lines_.size())
      fail(lines_.back().number, "breaks off: the names of the columns are missing");
    std::map<std::string, Cells> block;
    for (std::size_t at = 0; at < ends.back(); ++at) {
      const Line& line = lines_[at];
      Cells cells = split(line, line.text.find('\t') != std::string::npos ? '\t' : ',', file_);
      const std::string key = cells.front();
      block[key] = std::move(cells);
    }
    const auto value = [&](const std::string& key) {
      const auto found = block.find(key);
      return found != block.end() && found->second.size() > 1 ? found->second[1] : std::string();
    };
    is_style_stated_ = true;
    if (value("Decimal_Separator") == ",") table_.style_ = {MarkRole::decimal, MarkRole::none, {}};
    const char separator = value("Separator") == "Comma" ? ',' : '\t';
    const Line names = lines_[ends.back() + 1];
    lines_.erase(lines_.begin(), lines_.begin() + static_cast<std::ptrdiff_t>(ends.back()) + 2);
    take_header(names, separator);
    may_lack_cells_ = true;  // comments
    name_labview_columns(value("X_Dimension"), block["Y_Unit_Label"]);
    if (value("X_Columns") == "No") write_labview_times(value("X0"), value("Delta_X"));
  }

  void name_labview_columns(const std::string& dimension, const Cells& units) {
    Cells& columns = table_.columns_;
    std::size_t channel = 0;
    for (std::string& name : columns) {
      if (name == "X_Value") {
        if (dimension.empty() || dimension == "Time") name = "Time (s)";
      } else if (name != "Comment" && ++channel < units.size() && !is_empty(units[channel])) {
        name += fmt::format(" ({})", units[channel]);
      }
    }
  }

  // Where only the start and the step are stated, the first cell of each row is empty.
  void write_labview_times(const std::string& start, const std::string& step) {
    const auto first = read_numeral(start, table_.style_), each = read_numeral(step, table_.style_);
    if (!first || !each || !(*each > 0.0)) {
      throw InputError(fmt::format(
          "{}: X_Columns is No, so X0 and Delta_X must tell the times, but they are '{}' and '{}'.",
          file_.string(),
          start,
          step));
    }
    double row = 0.0;
    for (Line& line : lines_) {
      std::string time = number_text(*first + *each * row++);
      if (table_.style_.comma == MarkRole::decimal)
        std::replace(time.begin(), time.end(), '.', ',');
      if (separator_ == ',') time = fmt::format("\"{}\"", time);
      line.text = time + line.text;
    }
  }

  const std::filesystem::path& file_;
  Table table_;
  std::vector<Line> lines_;     // rows, once the header is found
  std::vector<Line> comments_;  // above the first of them
  char separator_ = ',';
  bool is_separator_stated_ = false;
  bool is_style_stated_ = false;
  bool may_lack_cells_ = false;  // at the end of a row
};

Table read_csv(const std::filesystem::path& file) {
  return CsvReader(file, read_text(file, "save the table as CSV")).read();
}

std::string to_csv(const Table& table) {
  std::string text;
  append_row(table.columns(), text);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::vector<std::string> cells;
    for (const std::string& column : table.columns()) cells.push_back(table.text(row, column));
    append_row(cells, text);
  }
  return text;
}

void write_csv(const std::filesystem::path& file, const Table& table) {
  write_whole(file, to_csv(table));
}

}  // namespace graintruth::datasets
