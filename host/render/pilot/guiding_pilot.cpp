// SPDX-License-Identifier: Apache-2.0
#include "render/pilot/guiding_pilot.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "guide/learner.h"
#include "image/tonemap.h"

namespace eikon {
namespace {

// There are so many paths for each pixel that the trial has 32 samples of it, which begin to show
// how samples fill gaps.
constexpr std::uint64_t kPathsPerPilotPixel = 256;
// Samples of a pixel over those of the first round: in the rounds that learn, and in each of the
// two ways of the trial.
constexpr std::array<std::uint64_t, 6> kRounds = {1, 2, 4, 8, 16, 16};
constexpr std::uint64_t kTrial = 8;
constexpr std::uint64_t kAllRoundsAndTrial = std::accumulate(kRounds.begin(), kRounds.end(), 2 * kTrial);
// At the first vertex roulette saves next to nothing, and adds noise to direct light.
constexpr std::uint32_t kRouletteDepth = 2;
constexpr double kCellsPerHeight = 16;  // smallest cells across the picture at the usual distance
constexpr double kMinGain = 1.25;  // a guided vertex costs about so many times another one (kernels/guide/README.md)
// The pilot gives up after a round, if the gains that its samples and those of the round before
// show are less than this. They are noisy, and grow from round to round (kernels/guide/README.md).
constexpr std::array<double, kRounds.size()> kMinHopeOfRound = {0, 0, 0, 1, 1.1, 0};
constexpr std::uint64_t kMinPathsToGiveUp = 1U << 17;  // smaller pilots show too little in their rounds
// After this round the pilot also gives up if lamps light the surfaces, and these light no others.
constexpr std::size_t kRoundOfDirectLight = 1;

/// Sums over the paths of one way of sampling, in a round or in the trial.
struct PathStatistics {
  std::vector<double> count, sum, square;        // luminance of paths, by pixel
  std::array<std::vector<double>, 2> replicate;  // sums of its halves, which are scrambled apart
  double rays = 0, paths = 0;
  bool has_indirect_light = false;  // a path that was scattered met more than lamps that nothing else lights
};

/// Without guiding, and with it.
struct BothWays {
  PathStatistics without, with;
};

class GuidingPilot {
 public:
  /// picture  with the settings of guiding_picture_settings(), and a program with feature path_log
  GuidingPilot(PilotPicture& picture, std::uint64_t paths)
      : picture_(picture), wanted_paths_(paths), samples_(first_round(picture.settings(), paths)) {}

  /// Samples of a pixel in the first round.
  static std::uint64_t first_round(const Settings& picture, std::uint64_t paths) {
    const double each = double(paths) / double(picture.crop.pixel_count() * kAllRoundsAndTrial);
    return std::uint64_t(std::max(std::round(each), 1.0));
  }

  void run(Guiding guiding, Pilot& pilot) {
    calibrate();
    GuideLearner learner(scale_, usual_luminance_);
    sums_.resize(picture_.pixel_count());
    for (std::size_t round = 0; round < kRounds.size(); ++round) {
      guide_with(learner.table(), round == 0 ? 0 : kRouletteDepth);
      if (round > 0) rounds_.with = {};
      PathStatistics& way = round == 0 ? rounds_.without : rounds_.with;
      render(samples_ * kRounds[round], [&](const PilotUnit& unit) {
        learner.add(unit.log);
        add(way, unit);
      });
      add_to_means(way);
      if (guiding != Guiding::on && gives_up_after(round, learner, pilot)) return;
      learner.end_round(round + 2 >= kRounds.size());  // the last two rounds and the trial count together
    }
    const GuideTable table = learner.table();
    BothWays trial;
    const std::uint64_t begin = next_;
    for (PathStatistics* way : {&trial.without, &trial.with}) {
      next_ = begin;  // both ways have the same samples: what guiding does not change has the same noise in both
      guide_with(table, way == &trial.without ? 0 : kRouletteDepth);
      render(samples_ * kTrial, [&](const PilotUnit& unit) {
        learner.add(unit.log);
        add(*way, unit);
      });
    }
    learner.end_round();
    decide(learner.table(), trial, guiding, pilot);
  }

 private:
  template <class Use>
  void render(std::uint64_t samples, const Use& use) {
    picture_.render(next_, next_ + samples, true, [&](const PilotUnit& unit) {
      use(unit);
      paths_ += unit.log.paths;
    });
    next_ += samples;
  }

  void guide_with(GuideTable table, std::uint32_t roulette_depth) {
    table.roulette_depth = roulette_depth;
    picture_.wavefront().set_guide(std::make_shared<const GuideTable>(std::move(table)));
  }

  [[nodiscard]] static std::vector<double> luminances(const PathLog& log) {
    std::vector<double> values(log.paths);
    const auto at = [&](std::size_t plane, std::size_t i) {
      return double(std::bit_cast<float>(log.radiance[plane * log.stride + i]));
    };
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double value = luminance({at(0, i), at(1, i), at(2, i)});
      values[i] = std::isfinite(value) ? value : 0;
    }
    return values;
  }

  /// Finds how large cells should be, and what a path usually brings.
  void calibrate() {
    std::vector<float> distances;
    double sum = 0;
    render(4, [&](const PilotUnit& unit) {
      const PathLog& log = unit.log;
      add(rounds_.without, unit);
      for (const double value : luminances(log)) sum += std::abs(value);
      for (std::size_t path = 0; path < log.paths; ++path)
        if ((log.word(path, 0, LOG_info) & LOG_HIT) != 0) distances.push_back(log.number(path, 0, LOG_distance));
    });
    usual_luminance_ = sum > 0 ? sum / double(paths_) : 1;
    if (distances.empty()) return;
    const auto middle = distances.begin() + std::ptrdiff_t(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    const Camera& camera = picture_.settings().camera;
    const double height = camera.projection == Projection::orthographic ? 2 * camera.ymag_m
                          : camera.projection == Projection::panorama
                              ? 2 * double(*middle)
                              : 2 * std::tan(0.5 * camera.yfov_rad) * double(*middle);
    if (height > 0 && std::isfinite(height)) scale_ = float(kCellsPerHeight / height);
  }

  /// Adds a round to the means by which errors are judged. They do not have the trial's samples:
  /// one that is bright would otherwise raise the mean of its pixel and so hide itself.
  void add_to_means(const PathStatistics& round) {
    for (std::size_t pixel = 0; pixel < sums_.size(); ++pixel) sums_[pixel] += round.sum[pixel];
    means_ = sums_;
    for (double& value : means_) value /= double(next_);
    means_ = smoothed(means_, picture_.settings().width);
  }

  /// True if all that a vertex adds is its own emission: light sampling found nothing there.
  [[nodiscard]] static bool only_emits(const PathLog& log, std::size_t path, std::uint32_t vertex) {
    return (log.word(path, vertex, LOG_info) & LOG_HIT) != 0 && log.number(path, vertex, LOG_emitted) > 0 &&
           log.number(path, vertex, LOG_sampled) == 0;
  }

  void add(PathStatistics& way, const PilotUnit& unit) const {
    for (auto* list : {&way.count, &way.sum, &way.square, &way.replicate[0], &way.replicate[1]})
      list->resize(picture_.pixel_count());
    const PathLog& log = unit.log;
    const std::vector<double> values = luminances(log);
    way.paths += double(values.size());
    for (std::size_t path = 0; path < values.size(); ++path) {
      const std::size_t pixel = unit.first_pixel + path % unit.pixels;
      way.count[pixel] += 1;
      way.sum[pixel] += values[path];
      way.square[pixel] += values[path] * values[path];
      way.replicate[(unit.sample_begin + path / unit.pixels) % 2][pixel] += values[path];
      for (std::uint32_t v = 0; v < EK_LOG_DEPTHS; ++v) {
        const std::uint32_t info = log.word(path, v, LOG_info);
        if ((info & (LOG_HIT | LOG_MISS)) == 0) break;
        way.rays += (info & LOG_HIT) != 0 ? 2 : 1;  // with a shadow ray
        if (v > 0 && !only_emits(log, path, v)) way.has_indirect_light = true;
      }
    }
  }

  /// Variance of a sample in a pixel, as of independent ones.
  [[nodiscard]] static double sample_variance(const PathStatistics& way, std::size_t pixel) {
    const double n = way.count[pixel], mean = way.sum[pixel] / n;
    return std::max(way.square[pixel] / n - mean * mean, 0.0);
  }
  /// The same from the difference of its halves, which have less where samples fill each other's
  /// gaps.
  [[nodiscard]] static double replicate_variance(const PathStatistics& way, std::size_t pixel) {
    const double half = 0.5 * way.count[pixel];
    const double difference = (way.replicate[0][pixel] - way.replicate[1][pixel]) / half;
    return 0.5 * half * difference * difference;
  }

  /// Error times rays without guiding over that with it, by every `step`th pixel from `first` on.
  /// The error is the sum over pixels of the variance over the squared mean.
  template <class Variance>
  [[nodiscard]] double gain(const BothWays& both, std::size_t first, std::size_t step, const Variance& variance) const {
    const double all = std::accumulate(means_.begin(), means_.end(), 0.0) / double(means_.size());
    const auto cost = [&](const PathStatistics& way) {
      double error = 0;
      for (std::size_t i = first; i < means_.size(); i += step)
        error += variance(way, i) / pilot_error_scale(means_[i], all);
      return error * way.rays / way.paths;
    };
    const double with = cost(both.with);
    return with > 0 ? cost(both.without) / with : 1;
  }

  /// The least gain of the whole picture and of both its halves, since what holds for one of them
  /// alone is chance; and of the whole by the other variance, since gains where samples fill each
  /// other's gaps anyway are none.
  [[nodiscard]] double least_gain(const BothWays& both) const {
    return std::min({gain(both, 0, 1, sample_variance), gain(both, 0, 2, sample_variance),
                     gain(both, 1, 2, sample_variance), gain(both, 0, 1, replicate_variance)});
  }

  /// True if the rest of the pilot can be spared, because there is nothing to learn, or because
  /// this round and the one before did so badly beside unguided paths; then this is in the report.
  bool gives_up_after(std::size_t round, const GuideLearner& learner, Pilot& pilot) {
    if (round == 0) return false;
    if (round == kRoundOfDirectLight && !rounds_.without.has_indirect_light && !rounds_.with.has_indirect_light) {
      report(learner.table(), 1, pilot);
      return true;
    }
    const double before = std::exchange(gain_of_round_, gain(rounds_, 0, 1, sample_variance));
    const double hope = std::max(before, gain_of_round_);
    if (wanted_paths_ < kMinPathsToGiveUp || hope >= kMinHopeOfRound[round]) return false;
    report(learner.table(), hope, pilot);
    return true;
  }

  void report(const GuideTable& table, double gain, Pilot& pilot) const {
    pilot.report.guiding_paths = paths_;
    pilot.report.guiding_cells = table.cell_count();
    pilot.report.guiding_gain = gain;
  }

  void decide(GuideTable table, const BothWays& both, Guiding guiding, Pilot& pilot) const {
    report(table, least_gain(both), pilot);
    if (guiding != Guiding::on && pilot.report.guiding_gain < kMinGain) return;
    table.roulette_depth = pilot.report.roulette_depth = kRouletteDepth;
    pilot.report.guiding_digest = table.digest();
    pilot.table = std::make_shared<const GuideTable>(std::move(table));
  }

  PilotPicture& picture_;
  std::uint64_t wanted_paths_;
  std::uint64_t samples_;  // of a pixel in the first round
  float scale_ = 1;
  double usual_luminance_ = 1;
  std::vector<double> sums_, means_;  // luminance of the paths of all rounds, by pixel; means are smoothed
  double gain_of_round_ = 0;          // the last one
  BothWays rounds_;                   // paths without a table, and those of the last round with one
  std::uint64_t next_ = 0, paths_ = 0;
};

}  // namespace

Settings guiding_picture_settings(const Settings& settings) {
  return pilot_picture_settings(settings, double(settings.pilot_paths / kPathsPerPilotPixel));
}

std::uint64_t largest_guiding_round(const Settings& settings) {
  const Settings picture = guiding_picture_settings(settings);
  return GuidingPilot::first_round(picture, settings.pilot_paths) * kRounds.back() * picture.crop.pixel_count();
}

void run_guiding_pilot(PilotPicture& picture, const Settings& settings, Pilot& pilot) {
  picture.restart(guiding_picture_settings(settings));
  picture.wavefront().trace_light_paths(false);  // what it finds is weighed against them all the same
  GuidingPilot(picture, settings.pilot_paths).run(settings.guiding, pilot);
}

}  // namespace eikon
