#include "reports/page/tables.h"

#include <algorithm>
#include <cassert>

namespace graintruth::reports {

TableView::TableView(std::string caption, std::vector<Column> columns)
    : caption_(std::move(caption)), columns_(std::move(columns)) {}

void TableView::add_row(std::vector<std::string> cells) {
  assert(cells.size() == columns_.size());
  rows_.push_back({.cells = std::move(cells)});
}

void TableView::add_total(std::vector<std::string> cells) {
  add_row(std::move(cells));
  rows_.back().is_total = true;
}

void TableView::drop_empty_columns() {
  for (std::size_t column = columns_.size(); column-- > 0;) {
    if (std::any_of(
            rows_.begin(), rows_.end(), [&](const Row& row) { return !row.cells[column].empty(); }))
      continue;
    const auto at = static_cast<std::ptrdiff_t>(column);
    columns_.erase(columns_.begin() + at);
    for (Row& row : rows_) row.cells.erase(row.cells.begin() + at);
  }
}

Json TableView::view() const {
  // Bytes; longer cells may break into lines, sooner where many columns share the page
  const std::size_t longest_unbroken = columns_.size() > 5 ? 20 : 26;
  Json columns = Json::array();
  for (const Column& column : columns_)
    columns.push_back({{"text", column.heading}, {"numeric", column.align == Align::right}});
  Json rows = Json::array();
  for (const Row& row : rows_) {
    Json cells = Json::array();
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      cells.push_back({{"text", row.cells[i]},
                       {"numeric", columns_[i].align == Align::right},
                       {"head", i == 0},
                       {"short", row.cells[i].size() <= longest_unbroken}});
    }
    rows.push_back({{"cells", cells}, {"total", row.is_total}});
  }
  constexpr std::size_t most_on_paper = 9;  // columns in the print's usual size of letters
  return {{"caption", caption_},
          {"columns", columns},
          {"rows", rows},
          {"wide", columns_.size() > most_on_paper}};
}

}  // namespace graintruth::reports
