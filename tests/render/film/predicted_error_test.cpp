// SPDX-License-Identifier: Apache-2.0
// What a film states of its own error, against the truth of a room that is lit mostly by indirect
// light. tools/measure/coverage.py measures the same on any scene.
#include <algorithm>
#include <array>
#include <vector>

#include "film/exr/film_file.h"
#include "image/image.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

constexpr std::uint32_t kWidth = 48, kHeight = 32;
constexpr int kSeeds = 24;

/// What films of `kSeeds` seeds say, and what is true of them.
struct Statements {
  std::vector<double> predicted_over_true;
  int held = 0, means_held = 0;
  double variance_over_error = 0;
};

/// settings: of the films, with any seed
Statements statements_of(const Scene& scene, Settings settings, const Film& reference) {
  const Image truth = to_image(reference);
  std::vector<Film> films;
  double relmse = 0, variance = 0, error = 0;
  // Variance over error has a standard deviation of .075 for 24 seeds of 4 samples, so it takes
  // more of them.
  const int seeds = std::max(kSeeds, int(960 / settings.sample_end));
  for (int seed = 1; seed <= seeds; ++seed) {
    settings.seed = static_cast<std::uint32_t>(seed);
    const Film film = film_of(scene, settings);
    if (seed <= kSeeds) films.push_back(film), relmse += compare_images(to_image(film), truth).relmse / kSeeds;
    for (std::uint32_t y = 0; y < kHeight; ++y)
      for (std::uint32_t x = 0; x < kWidth; ++x) {
        const double off = film.mean(x, y, 1) - reference.mean(x, y, 1);
        variance += film.variance_of_mean(x, y, 1);
        error += off * off;
      }
  }
  Statements found;
  found.variance_over_error = variance / error;
  const MeanRadiance true_mean = reference.mean_radiance();
  for (const Film& film : films) {
    const PredictedError predicted = film.predicted_error();
    found.predicted_over_true.push_back(predicted.relmse / relmse);
    found.held += predicted.lo <= relmse && relmse <= predicted.hi ? 1 : 0;
    const MeanRadiance mean = film.mean_radiance();
    found.means_held += std::abs(mean.value[1] - true_mean.value[1]) <= 1.96 * (*mean.standard_error)[1] ? 1 : 0;
  }
  std::ranges::sort(found.predicted_over_true);
  return found;
}

/// Compares what images of 4, 16 and 64 samples per pixel state with their difference to the
/// reference.
void expect_true_statements(const Scene& scene, Settings settings, const Film& reference) {
  for (const auto& [spp, allowed] : {std::pair{4U, 0.15}, {16U, 0.1}, {64U, 0.06}}) {
    SCOPED_TRACE(spp);
    settings.sample_end = spp;
    const Statements found = statements_of(scene, settings, reference);
    EXPECT_NEAR(found.predicted_over_true[kSeeds / 2], 1, allowed);
    EXPECT_GE(found.held, 19);
    EXPECT_GE(found.means_held, 19);
    EXPECT_NEAR(found.variance_over_error, 1, 0.08);
  }
}

// Of 24 intervals of 95 %, fewer than 19 hold with a probability of 0.1 %.
TEST(PredictedErrorOfRoom, is_true_at_few_and_at_many_samples) {
  auto [scene, settings] = room(kWidth, kHeight, 4096);
  settings.seed = 1000;
  const Film reference = film_of(scene, settings);
  expect_true_statements(scene, settings, reference);
}

// The truth is that of a render without guiding, so this also holds the means of both together.
TEST(PredictedErrorOfRoom, is_true_where_paths_are_guided) {
  auto [scene, settings] = room(kWidth, kHeight, 8192);
  settings.seed = 1000;
  const Film reference = film_of(scene, settings);
  settings.guiding = Guiding::on;
  settings.pilot_paths = 1U << 15;
  settings.sample_end = 1;
  RenderHooks hooks{.devices = &open_devices->pool};
  const std::atomic<bool> never{false};
  hooks.pilot_done = [&settings = settings](const Pilot& pilot) { settings.guide = pilot.table; };
  (void)render(scene, Settings(settings), as_tested({}), never, hooks);
  ASSERT_NE(settings.guide, nullptr);
  expect_true_statements(scene, settings, reference);
}

}  // namespace
}  // namespace eikon::test
