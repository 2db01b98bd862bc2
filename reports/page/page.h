// The page: sections made of paragraphs, tables, figures and pictures, set by mustache templates
// that escape what they are given.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reports/page/plot.h"
#include "reports/page/run_data.h"
#include "reports/page/tables.h"

namespace graintruth::reports {

struct Picture {
  std::string caption;
  std::string source;  // a data: address
};

// A part of the page under its own heading; shows its blocks in the order in which they were added.
class Section {
 public:
  Section(std::string_view id, std::string_view heading);
  void add_heading(std::string_view text, std::string_view id = {});
  void add_paragraph(std::string_view text);
  void add_absence(std::string_view text);  // what the run did not leave behind, in one sentence
  void add_warnings(const std::vector<std::string>& sentences);
  void add_table(const TableView& table);
  void add_figure(const Figure& figure);
  void add_gallery(const std::vector<Picture>& pictures);
  void add_code(std::string_view text);
  void add_folded_code(std::string_view summary, std::string_view text);
  void add_template(std::string_view name, const Json& view);  // name.mustache, embedded
  // What is added from here on is folded under this summary: the reader opens it, and paper shows
  // it. A fold ends at the next one, at the next heading and at end_fold().
  void begin_fold(std::string_view summary);
  void end_fold();

  // What section.mustache draws.
  Json view() const;

 private:
  std::string id_;
  std::string heading_;
  Json blocks_ = Json::array();
  bool is_folded_ = false;
};

// Sets name.mustache with the view. Partials are the other embedded templates.
std::string render(std::string_view name, const Json& view);

}  // namespace graintruth::reports
