// SPDX-License-Identifier: Apache-2.0
// Estimates the seconds from the last sample of a render to its last file, for --time.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/clock.h"
#include "core/error.h"
#include "film/exr/film_file.h"
#include "film/layers.h"
#include "io/atomic_file.h"
#include "io/private_folder.h"
#include "job/report/metadata.h"
#include "job/report/write_report.h"
#include "job/render_job.h"

namespace eikon {
namespace {

constexpr std::uint32_t kParts = 8, kMinRows = 32;  // a trial takes the rows of a strip: of so many, one

/// Lets `write` write a file, and removes it again.
template <class Write>
void write_and_remove(const char* ending, const Write& write) {
  std::filesystem::path folder;
  try {
    folder = make_private_folder("eikon_trial");
    write(folder / fmt::format("trial{}", ending));
  } catch (const InputError&) {  // the estimate is then too small, and the render goes on
  }
  std::error_code none;
  if (!folder.empty()) std::filesystem::remove_all(folder, none);
}

std::uint32_t rows_of_trial(std::uint32_t height) { return std::min(height, std::max(height / kParts, kMinRows)); }

}  // namespace

double RenderJob::finish_seconds(const Film& film) {
  constexpr double kReserve_s = 0.05;  // for the last units, which may be late, and what the strip does not have
  const Crop& whole = film.layout().crop;
  const auto seconds_of = [&](std::uint32_t rows) {
    const double begin_s = host_seconds();
    write_trial(film.rows(whole.y0, whole.y0 + rows));
    return host_seconds() - begin_s;
  };
  const std::uint32_t rows = rows_of_trial(whole.height());
  (void)seconds_of(1);  // the first time, libraries are loaded
  const double one_s = seconds_of(1), strip_s = std::max(seconds_of(rows), one_s);
  const double row_s = rows > 1 ? (strip_s - one_s) / (rows - 1) : 0;
  return one_s + row_s * (whole.height() - 1) + series_seconds(film) + kReserve_s;
}

// The images of a series are alike, so the last and longest stands for all of them. Its trial has
// as many rows as the strips of all would have together: what is done with a strip finds its memory
// at hand, and took 0.7 of the time of as many rows of a whole image.
double RenderJob::series_seconds(const Film& film) {
  const Crop& whole = film.layout().crop;
  const auto count = static_cast<std::uint32_t>(settings().depth_series.size());
  if (count == 0) return 0;
  const ExrOptions exr = options_of_series(exr_options());
  const auto seconds_of = [&](const Film& rows) {
    const double begin_s = host_seconds();
    const Film part = scattered_at_most(rows, settings().depth_series.back());
    (void)part.predicted_error();
    write_trial_picture(part, exr);
    return host_seconds() - begin_s;
  };
  const std::uint32_t rows = std::min(whole.height(), rows_of_trial(whole.height()) * count);
  if (rows == whole.height()) return seconds_of(film) * count;
  const double one_s = seconds_of(film.rows(whole.y0, whole.y0 + 1));
  const double strip_s = std::max(seconds_of(film.rows(whole.y0, whole.y0 + rows)), one_s);
  return (one_s + (strip_s - one_s) / (rows - 1) * (whole.height() - 1)) * count;
}

void RenderJob::write_trial(const Film& film) {
  (void)film.predicted_error();
  if (!options_.stats.empty()) (void)film.mean_radiance();
  std::optional<Image> denoised;
  if (denoiser_) denoised = denoise(film);
  ExrOptions exr = exr_options();
  exr.denoised = denoised ? &*denoised : nullptr;
  write_trial_picture(film, exr);
  if (!options_.checkpoint.file.empty())
    write_and_remove(".exr", [&](const auto& file) {
      write_exr(file, film, describe_image(prepared_), {.exact_sums = true, .record = {}, .quick = true});
    });
  if (!options_.report.empty())
    write_and_remove(".html", [&](const auto& file) {
      write_text(
          file,
          report_picture({.film = film, .denoised = denoised ? &*denoised : nullptr, .display = options_.png}).dump());
    });
}

void RenderJob::write_trial_picture(const Film& film, const ExrOptions& exr) {
  write_and_remove(".exr", [&](const auto& file) { write_exr(file, film, describe_image(prepared_), exr); });
  if (options_.png.file.empty()) return;
  write_and_remove(".png", [&](const auto& file) {
    PngOptions png = options_.png;
    png.file = file.string();
    png.write(to_image(film));
  });
}

}  // namespace eikon
