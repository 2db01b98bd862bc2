// Numbers as programs and spreadsheets of many countries write them: 1204.5, 1204,5, 1,204.5,
// 1.204,5, 1 204,5 or 1'204.5. What commas and points mean is decided once for a whole file.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graintruth::datasets {

// What a comma or a point is in the numbers of a file.
enum class MarkRole { none, decimal, thousands, unclear };

struct NumberStyle {
  MarkRole comma = MarkRole::none;
  MarkRole point = MarkRole::decimal;
  // Where a mark is unclear: why, as the rest of a sentence that begins with the number
  std::string complaint;
};

// What a cell says that has no value: nothing, nan, NA, N/A, #N/A, null, None.
bool is_missing(std::string_view cell);

// Whether a cell is written as a number is in any of the styles, or says that it has no value.
bool is_numeral(std::string_view cell);

// NaN for a missing value, none for what is no number in this style. A cell with an unclear mark is
// none too: is_numeral() tells the two apart.
std::optional<double> read_numeral(std::string_view cell, const NumberStyle& style);

// Hears every cell of a file, and decides.
class NumberVote {
 public:
  explicit NumberVote(std::vector<std::string> names)
      : names_(std::move(names)), columns_(names_.size()) {}

  void hear(std::string_view cell, std::size_t column, int line);

  // 1. What only one style allows decides: 0,5 and 12,25 have a decimal comma, 1,204,567 and
  //    1,204.5 have commas between thousands, and 1,204 has a decimal comma beside 1506 in the same
  //    column; points likewise. Two that contradict make both marks unclear.
  // 2. Where all commas stand before three digits, as in 1,204: commas between thousands if the
  //    plain numbers of the same column go up to where commas begin (998, 1,004). A decimal comma
  //    if no number of such a column is without one, and the cells are parted by semicolons, which
  //    only those write who have a decimal comma. Else unclear.
  // 3. Points before three digits are points between thousands by the same rule; else decimal.
  //    Where commas part the cells, a point is always decimal.
  NumberStyle decide(char separator) const;

 private:
  // The first cell that allows one meaning alone
  struct Witness {
    std::string cell;
    std::size_t column = 0;
    int line = 0;
  };
  struct Mark {
    std::optional<Witness> decimal, thousands;
  };
  // The numbers of a column with one mark before three digits, the mark taken for a decimal one
  struct OpenMarks {
    std::size_t count = 0;
    double least = 0.0, most = 0.0;
  };
  struct Column {
    OpenMarks comma, point;
    std::vector<double> plain;  // the numbers without a mark
  };
  enum class Likeness { none, only_marked, unlike, perhaps, surely };  // to marked thousands

  Likeness likeness(OpenMarks Column::*marks) const;
  std::string words(const Witness& witness) const;

  std::vector<std::string> names_;
  std::vector<Column> columns_;
  Mark comma_, point_;
};

}  // namespace graintruth::datasets
