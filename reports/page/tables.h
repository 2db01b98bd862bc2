// A table as the reader sees it: text cells under headings, numbers to the right.
#pragma once

#include <string>
#include <vector>

#include "reports/page/run_data.h"

namespace graintruth::reports {

enum class Align { left, right };

class TableView {
 public:
  struct Column {
    std::string heading;
    Align align = Align::right;
  };

  TableView(std::string caption, std::vector<Column> columns);
  // As many cells as columns.
  void add_row(std::vector<std::string> cells);
  // A row set off from the others: a sum or a mean.
  void add_total(std::vector<std::string> cells);
  // Leaves out columns in which no row has anything to say.
  void drop_empty_columns();
  bool is_empty() const { return rows_.empty(); }
  // What table.mustache draws.
  Json view() const;

 private:
  struct Row {
    std::vector<std::string> cells;
    bool is_total = false;
  };

  std::string caption_;
  std::vector<Column> columns_;
  std::vector<Row> rows_;
};

}  // namespace graintruth::reports
