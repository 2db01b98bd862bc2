#include "reports/page/page.h"

#include <kainjow/mustache.hpp>
#include <stdexcept>

#include "reports/page/assets.h"

namespace graintruth::reports {

namespace {

namespace mustache = kainjow::mustache;

// Absent, null and empty all mean "leave this part of the template out".
mustache::data mustache_data(const Json& json) {
  if (json.is_object()) {
    mustache::data object = mustache::data::type::object;
    for (const auto& [key, value] : json.items()) object.set(key, mustache_data(value));
    return object;
  }
  if (json.is_array()) {
    mustache::data array = mustache::data::type::list;
    for (const Json& value : json) array.push_back(mustache_data(value));
    return array;
  }
  if (json.is_string()) {
    const auto& text = json.get_ref<const std::string&>();
    return text.empty() ? mustache::data(false) : mustache::data(text);
  }
  if (json.is_boolean()) return mustache::data(json.get<bool>());
  return mustache::data(false);
}

}  // namespace

Section::Section(std::string_view id, std::string_view heading) : id_(id), heading_(heading) {}

void Section::begin_fold(std::string_view summary) {
  end_fold();
  blocks_.push_back({{"fold_begins", {{"fold_summary", summary}}}});
  is_folded_ = true;
}

void Section::end_fold() {
  if (is_folded_) blocks_.push_back({{"fold_ends", true}});
  is_folded_ = false;
}

void Section::add_heading(std::string_view text, std::string_view id) {
  end_fold();
  blocks_.push_back({{"subheading", text}, {"subheading_id", id}});
}

void Section::add_paragraph(std::string_view text) { blocks_.push_back({{"paragraph", text}}); }

void Section::add_absence(std::string_view text) { blocks_.push_back({{"absence", text}}); }

void Section::add_warnings(const std::vector<std::string>& sentences) {
  if (!sentences.empty()) blocks_.push_back({{"warnings", {{"sentences", sentences}}}});
}

void Section::add_table(const TableView& table) { blocks_.push_back({{"table", table.view()}}); }

void Section::add_figure(const Figure& figure) {
  blocks_.push_back({{"figure", figure_view(figure)}});
}

void Section::add_gallery(const std::vector<Picture>& pictures) {
  Json views = Json::array();
  for (const Picture& picture : pictures)
    views.push_back({{"picture_caption", picture.caption}, {"source", picture.source}});
  blocks_.push_back({{"gallery", {{"pictures", views}}}});
}

void Section::add_code(std::string_view text) { blocks_.push_back({{"code", text}}); }

void Section::add_folded_code(std::string_view summary, std::string_view text) {
  blocks_.push_back({{"folded", {{"summary", summary}, {"content", text}}}});
}

void Section::add_template(std::string_view name, const Json& view) {
  blocks_.push_back({{"html", render(name, view)}});
}

Json Section::view() const {
  Json blocks = blocks_;
  if (is_folded_) blocks.push_back({{"fold_ends", true}});
  return {{"id", id_}, {"heading", heading_}, {"blocks", blocks}};
}

std::string render(std::string_view name, const Json& view) {
  mustache::data data = mustache_data(view);
  for (const std::string_view partial : {"section", "table", "figure"}) {
    data.set("part_" + std::string(partial), mustache::partial([partial] {
               return std::string(asset(std::string(partial) + ".mustache"));
             }));
  }
  mustache::mustache page{std::string(asset(std::string(name) + ".mustache"))};
  std::string text = page.render(data);
  if (!page.is_valid()) throw std::logic_error(page.error_message());
  return text;
}

}  // namespace graintruth::reports
