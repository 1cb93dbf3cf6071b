// SPDX-License-Identifier: Apache-2.0
#include "page/report_page.h"

#include <filesystem>
#include <nlohmann/json.hpp>

namespace eikon {
namespace {

std::string data_page(const std::string& title, const Json& data) {
  return make_page("report.html", {.title = title,
                                   .styles = {"style.css", "report.css"},
                                   .scripts = {"parts.js", "tone.js", "charts.js", "feature_costs.js", "report.js"},
                                   .data = data});
}

/// The file's name at the end of a path, if `value` is one.
std::string name_in(const Json* value) {
  return value != nullptr && value->is_string() ? std::filesystem::path(value->get<std::string>()).filename().string()
                                                : "";
}

}  // namespace

std::string report_page(const RenderPage& parts) {
  const Json* const scene = parts.stats.is_object() ? member(parts.stats, "scene") : nullptr;
  const std::string name = name_in(scene != nullptr && scene->is_object() ? member(*scene, "path") : nullptr);
  return data_page(name + " - eikon report", {{"kind", "render"},
                                              {"stats", parts.stats},
                                              {"picture", parts.picture},
                                              {"timeline", parts.timeline},
                                              {"display", parts.display}});
}

std::string batch_page(const Json& batch) {
  return data_page(name_in(member(batch, "name")) + " - eikon batch report", {{"kind", "batch"}, {"batch", batch}});
}

}  // namespace eikon
