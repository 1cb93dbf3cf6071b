// SPDX-License-Identifier: Apache-2.0
// The report of a render, or of many, as one page.
#pragma once
#include <string>

#include "page/page.h"

namespace eikon {

/// The page of one render.
/// stats     as --stats has them (job/report/stats_schema.json)
/// picture   of page_picture(), or null
/// timeline  of page_timeline(), or null
/// display   {"exposure": EV, "tone": name of a tone curve}, with which the picture is shown first
struct RenderPage {
  const Json &stats, &picture, &timeline, &display;
};
[[nodiscard]] std::string report_page(const RenderPage& parts);

/// The page of a batch.
/// batch  {"name", "command", "version", "seconds", "jobs": [{"line", "state", "command", "output",
///        "seconds", "render_seconds", "samples", "relmse", "message"}, ...]}; what is unknown is
///        null
[[nodiscard]] std::string batch_page(const Json& batch);

}  // namespace eikon
