// SPDX-License-Identifier: Apache-2.0
// Lines that tell people what a render found.
#pragma once
#include <cstdint>
#include <string>

#include "film/film.h"
#include "render/render.h"
#include "scene/scene.h"

namespace eikon {

/// "predicted relMSE 1e-3 (95 %: 9e-4 to 1.1e-3)", or what can be said instead.
[[nodiscard]] std::string in_words(const PredictedError& error);
/// Says behind it which bias the error leaves out; empty if there is none.
[[nodiscard]] const char* words_of_bias(const Settings& settings);
/// "pilot: 65536 paths in 0.52 s; paths are guided (1.80 times less error for as many rays, it
/// predicts)"
[[nodiscard]] std::string in_words(const PilotReport& pilot, const Settings& settings);
/// "3 samples were rejected (2 not finite, 1 beyond the film's range); replay the first with
/// --pixel 4,7 --sample 12"
/// all  the rejected samples of this run and of the runs before it, by the film's counts
[[nodiscard]] std::string rejected_line(const RenderReport& report, std::uint64_t all);
/// "12 rays gave up the search for surface 'gyroid' after 4096 steps, ..."
[[nodiscard]] std::string search_failures_line(const Scene& scene, const RenderReport& report);

/// count / seconds, or 0 when no time has passed.
[[nodiscard]] double per_second(double count, double seconds);

}  // namespace eikon
