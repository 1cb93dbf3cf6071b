// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "film/exr/film_file.h"
#include "io/atomic_file.h"
#include "job/report/trace_file.h"
#include "job/report/write_report.h"
#include "page/page_picture.h"
#include "page/report_page.h"
#include "page/timeline.h"

namespace eikon {
namespace {

/// R, G and B as `shown` has them, and the variance of those of the film.
Image with_variance(const Film& film, const Image& shown) {
  const Crop& crop = film.layout().crop;
  Image image{.width = crop.width(), .height = crop.height(), .channels = {}, .planes = {}, .metadata = {}};
  for (std::uint32_t channel = 0; channel < 3; ++channel) {
    const std::string name = kRgb[channel];
    image.channels.push_back(name);
    image.planes.push_back(*shown.plane(name));
    image.channels.push_back("variance." + name);
    std::vector<float>& plane = image.planes.emplace_back();
    plane.reserve(crop.pixel_count());
    std::vector<double> means(crop.width()), variances(crop.width());
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y) {
      film.row_means_and_variances(y, channel, means.data(), variances.data());
      for (const double variance : variances) plane.push_back(float(variance));
    }
  }
  return image;
}

}  // namespace

Json report_picture(const ReportPicture& picture) {
  return page_picture(
      with_variance(picture.film, picture.denoised != nullptr ? *picture.denoised : to_image(picture.film)));
}

void write_report(const std::filesystem::path& path, const Json& stats, const ReportPicture& picture,
                  const Trace& trace) {
  write_text(path, report_page({.stats = stats,
                                .picture = report_picture(picture),
                                .timeline = page_timeline(trace_events(trace)),
                                .display = {{"exposure", picture.display.exposure()},
                                            {"tone", name_of(picture.display.tone_map)}}}));
}

}  // namespace eikon
