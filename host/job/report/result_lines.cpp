// SPDX-License-Identifier: Apache-2.0
#include "job/report/result_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/text.h"
#include "shared/records.h"

namespace eikon {

std::string in_words(const PredictedError& error) {
  if (!error.known) return "predicted relMSE unknown: it takes two samples of each pixel, one in either half";
  if (std::isfinite(error.hi))
    return fmt::format("predicted relMSE {:.3e} (95 %: {:.3e} to {:.3e})", error.relmse, error.lo, error.hi);
  return error.relmse > 0 ? fmt::format("predicted relMSE at least {:.3e}: no upper end can be stated", error.lo)
                          : "predicted relMSE unknown: no sample has found any light";
}

const char* words_of_bias(const Settings& settings) {
  return settings.merges_caustics ? "; the bias of --caustics merge is not in it" : "";
}

std::string in_words(const PilotReport& pilot, const Settings& settings) {
  const auto times = [](double gain) {
    return fmt::format("{:.2f} times less error for as many rays, it predicts", gain);
  };
  std::string text = fmt::format("pilot: {} paths{}", pilot.guiding_paths + pilot.light_trial_paths,
                                 pilot.loaded ? ", made before" : fmt::format(" in {:.2f} s", pilot.seconds));
  if (pilot.light_trial_paths > 0 && pilot.light_path_count == 0)
    text += settings.merges_caustics ? "; light paths as few as merging needs, as more would not pay"
                                     : "; no light paths, as they would not pay";
  if (pilot.light_trial_paths > 0 && pilot.light_path_count > 0)
    text += fmt::format("; {} light paths of each sample{} ({})", pilot.light_path_count,
                        pilot.light_aim_gain > 0 ? ", aimed by what it learned" : "",
                        pilot.light_path_gain > 0 ? times(pilot.light_path_gain) : "only they find some of the light");
  if (pilot.guiding_paths > 0)
    text += fmt::format("; {} ({})", pilot.roulette_depth == 0 ? "paths are not guided" : "paths are guided",
                        pilot.guiding_gain == 1 ? "it saw no gain" : times(pilot.guiding_gain));
  return text;
}

std::string rejected_line(const RenderReport& report, std::uint64_t all) {
  const std::uint64_t now = report.nonfinite + report.saturated;
  std::string line = fmt::format("{} samples were rejected ({} not finite, {} beyond the film's range", all,
                                 report.nonfinite, report.saturated);
  line += all > now ? fmt::format(", {} before this run)", all - now) : ")";
  if (!report.rejected.empty()) {
    const PixelSample& first = report.rejected.front();
    line += fmt::format("; replay the first with --pixel {},{} --sample {}", first.x, first.y, first.sample);
  }
  return line;
}

std::string search_failures_line(const Scene& scene, const RenderReport& report) {
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(scene.shapes.size(), 31); ++i)
    if ((report.search_failure_surfaces >> i & 1U) != 0)
      names += (names.empty() ? "" : ", ") + in_quotes(scene.shapes[i].name);
  if ((report.search_failure_surfaces >> 31U) != 0) names += names.empty() ? "by formula" : " and others";
  return fmt::format(
      "{} rays gave up the search for surface {} after {} steps, and went on as if it were not there; tighten its "
      "bounds, or "
      "write its formula with fewer occurrences of x, y and z",
      report.search_failures, names, EK_IMPLICIT_STEPS);
}

double per_second(double count, double seconds) { return seconds > 0 ? count / seconds : 0; }

}  // namespace eikon
