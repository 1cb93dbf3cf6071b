// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "core/trace.h"
#include "film/film.h"
#include "io/json_text.h"
#include "job/render_options.h"

namespace eikon {

/// The picture that the page of --report shows.
struct ReportPicture {
  const Film& film;
  const Image* denoised = nullptr;  // shown instead of the film's R, G and B; null: there is none
  const PngOptions& display;        // the exposure and tone curve with which the page shows the picture first
};

/// The picture as the page has it, which is most of the page.
[[nodiscard]] Json report_picture(const ReportPicture& picture);

/// Writes --report: a page that needs no other file.
/// trace  after Trace::end()
/// throws InputError when the file cannot be written
void write_report(const std::filesystem::path& path, const Json& stats, const ReportPicture& picture,
                  const Trace& trace);

}  // namespace eikon
