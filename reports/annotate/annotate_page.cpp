#include "reports/annotate/annotate_page.h"

#include "reports/page/assets.h"
#include "reports/page/page.h"

namespace graintruth::reports {

namespace {

// JSON in a script element: the only text that could end the element is escaped.
std::string as_script(const Json& data) {
  const std::string json = data.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(json.size());
  for (const char letter : json) {
    if (letter == '<')
      safe += "\\u003c";
    else
      safe += letter;
  }
  return safe;
}

}  // namespace

std::string annotate_page(const std::string& title,
                          const std::string& size_words,
                          const datasets::Json& data) {
  Json scripts = Json::array();
  for (const char* name : {"camera", "document", "rig", "view", "page"})
    scripts.push_back({{"script", asset("annotate/" + std::string(name) + ".js")}});
  return render("annotate/page",
                {{"title", title},
                 {"size", size_words},
                 {"style", asset("annotate/page.css")},
                 {"toml", asset("smol-toml.cjs")},
                 {"data", as_script(data)},
                 {"scripts", scripts}});
}

}  // namespace graintruth::reports
