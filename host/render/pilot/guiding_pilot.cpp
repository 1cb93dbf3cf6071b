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
// Each round has so many parts of the pilot's samples. The first one has no table to follow.
constexpr std::array<std::uint64_t, 6> kPartsOfRound = {8, 2, 4, 8, 16, 16};
// After the rounds a trial renders the samples of the first one with the last table.
constexpr std::uint64_t kAllParts =
    std::accumulate(kPartsOfRound.begin(), kPartsOfRound.end(), std::uint64_t{kPartsOfRound[0]});
// A table that is used learns from so many parts more, which pilots of other scenes do not have.
constexpr std::uint64_t kMoreParts = 32;
// At the first vertex roulette saves next to nothing, and adds noise to direct light.
constexpr std::uint32_t kRouletteDepth = 2;
constexpr double kCellsPerHeight = 16;  // smallest cells across the picture at the usual distance
// A guided vertex costs 1.25 times another one (kernels/guide/README.md), and gains are noisy.
constexpr double kMinGain = 1.3;
// The pilot gives up after a round whose samples show a smaller gain than this. The gain grows from
// round to round (kernels/guide/README.md).
constexpr std::array<double, kPartsOfRound.size()> kMinHopeOfRound = {0, 0, 1.03, 1.1, 1.15, 1.2};
// Gains are judged without this share of the pixels, since a few bright samples would decide; and
// not at all if these pixels have more than that share of the error (kernels/guide/README.md).
constexpr double kOutliers = 0.01, kMaxErrorOfOutliers = 0.6;
constexpr std::uint64_t kMinPathsToGiveUp = 1U << 17;  // smaller pilots show too little in their rounds

/// Sums over the paths of a round, or of the trial.
struct PathStatistics {
  std::vector<double> count, sum, square;        // luminance of paths, by pixel
  std::array<std::vector<double>, 2> replicate;  // sums of its halves, which are scrambled apart
  double rays = 0, paths = 0;
  bool has_indirect_light = false;  // a path that was scattered met more than lamps that nothing else lights
};

class GuidingPilot {
 public:
  /// picture  with the settings of guiding_picture_settings(), and a program with feature path_log
  GuidingPilot(PilotPicture& picture, std::uint64_t paths)
      : picture_(picture), wanted_paths_(paths), samples_of_part_(samples_of_part(picture.settings(), paths)) {}

  /// The samples of a pixel in one part of the pilot.
  static std::uint64_t samples_of_part(const Settings& picture, std::uint64_t paths) {
    const double each = double(paths) / double(picture.crop.pixel_count() * kAllParts);
    return std::uint64_t(std::max(std::round(each), 1.0));
  }

  void run(Guiding guiding, Pilot& pilot) {
    const bool may_give_up = guiding != Guiding::on;
    calibrate();
    GuideLearner learner(scale_, usual_luminance_);
    const std::uint64_t begin = next_;
    guide_with(learner.table(), 0);
    render_parts(1, learner, without_);
    // The pilot ends here where lamps light surfaces that light no others.
    if (may_give_up && !without_.has_indirect_light) return report(learner.table(), 1, pilot);
    render_parts(kPartsOfRound[0] - 1, learner, without_);
    learner.end_round();
    for (std::size_t round = 1; round < kPartsOfRound.size(); ++round) {
      render_guided(kPartsOfRound[round], learner);
      if (may_give_up && gives_up_after(round, learner, pilot)) return;
      add_to_sums(with_);
      learner.end_round(round + 3 >= kPartsOfRound.size());  // the last three rounds and the trial count together
    }
    // Both ways have the same samples: what guiding does not change has the same noise in both.
    const std::uint64_t end = std::exchange(next_, begin);
    render_guided(kPartsOfRound[0], learner);
    const double gain = least_gain();
    const bool guides = guiding == Guiding::on || gain >= kMinGain;
    if (guides) {
      learner.end_round(true);
      next_ = end;
      render_guided(kMoreParts, learner);
      learner.end_round();
      use(learner.table(), pilot);
    }
    report(learner.table(), gain, pilot);
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

  /// Renders so many parts of the pilot, and learns from them.
  void render_parts(std::uint64_t parts, GuideLearner& learner, PathStatistics& way) {
    render(parts * samples_of_part_, [&](const PilotUnit& unit) {
      learner.add(unit.log);
      add(way, unit);
    });
  }

  /// The same for paths that are guided by what is learned so far.
  void render_guided(std::uint64_t parts, GuideLearner& learner) {
    guide_with(learner.table(), kRouletteDepth);
    with_ = {};
    render_parts(parts, learner, with_);
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
    PathStatistics statistics;
    render(4, [&](const PilotUnit& unit) {
      const PathLog& log = unit.log;
      add(statistics, unit);
      for (const double value : luminances(log)) sum += std::abs(value);
      for (std::size_t path = 0; path < log.paths; ++path)
        if ((log.word(path, 0, LOG_info) & LOG_HIT) != 0) distances.push_back(log.number(path, 0, LOG_distance));
    });
    add_to_sums(statistics);
    without_.has_indirect_light = statistics.has_indirect_light;
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

  void add_to_sums(const PathStatistics& round) {
    sums_.resize(picture_.pixel_count());
    for (std::size_t pixel = 0; pixel < sums_.size(); ++pixel) sums_[pixel] += round.sum[pixel];
    summed_paths_ += round.paths;
  }

  /// The means of pixels by which errors are judged, each smoothed with its neighbours.
  /// sums, paths  luminance of the paths of each pixel, and the number of paths of all
  [[nodiscard]] std::vector<double> means(std::vector<double> sums, double paths) const {
    for (double& value : sums) value *= double(sums.size()) / paths;
    return smoothed(sums, picture_.settings().width);
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
    return std::max(way.square[pixel] / n - mean * mean, 0.0) * n / std::max(n - 1, 1.0);
  }
  /// The same from the difference of its halves, which have less where samples fill each other's
  /// gaps.
  [[nodiscard]] static double replicate_variance(const PathStatistics& way, std::size_t pixel) {
    const double half = 0.5 * way.count[pixel];
    const double difference = (way.replicate[0][pixel] - way.replicate[1][pixel]) / half;
    return 0.5 * half * difference * difference;
  }

  /// The error of a way of sampling: the sum over pixels of the variance over the squared mean.
  /// left_out  this share of the pixels is left out: those that have most of the error
  template <class Variance>
  [[nodiscard]] static double error(const PathStatistics& way, const std::vector<double>& means,
                                    const Variance& variance, double left_out) {
    const double all = std::accumulate(means.begin(), means.end(), 0.0) / double(means.size());
    std::vector<double> errors(means.size());
    for (std::size_t i = 0; i < errors.size(); ++i) errors[i] = variance(way, i) / pilot_error_scale(means[i], all);
    std::ranges::sort(errors);  // the whole order, so that sums have the same bits by any library
    return std::accumulate(errors.begin(), errors.end() - std::ptrdiff_t(left_out * double(errors.size())), 0.0);
  }

  /// Error times rays without guiding over that with it.
  template <class Variance>
  [[nodiscard]] double gain(const std::vector<double>& means, const Variance& variance, double left_out) const {
    const auto cost = [&](const PathStatistics& way) {
      return error(way, means, variance, left_out) * way.rays / way.paths;
    };
    const double gain = cost(without_) / cost(with_);
    return std::isfinite(gain) ? gain : 1;  // both may be 0
  }

  /// True if a few pixels have most of the error without guiding: then no gain can be told.
  [[nodiscard]] bool outliers_decide(const std::vector<double>& means) const {
    return error(without_, means, sample_variance, kOutliers) <
           (1 - kMaxErrorOfOutliers) * error(without_, means, sample_variance, 0);
  }

  /// The gain that the last round shows beside the first one.
  [[nodiscard]] double gain_of_round() const {
    std::vector<double> sums = sums_;
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += without_.sum[i] + with_.sum[i];
    const std::vector<double> all = means(std::move(sums), summed_paths_ + without_.paths + with_.paths);
    return outliers_decide(all) ? 1 : gain(all, sample_variance, kOutliers);
  }

  /// The least gain that the trial shows: with and without outliers, since what a few samples
  /// decide is chance; and by the other variance, since gains where samples fill each other's gaps
  /// anyway are none. The means do not have the trial's samples: one that is bright would otherwise
  /// raise the mean of its pixel and so hide itself.
  [[nodiscard]] double least_gain() const {
    const std::vector<double> unseen = means(sums_, summed_paths_);
    if (outliers_decide(unseen)) return 1;
    return std::min({gain(unseen, sample_variance, 0), gain(unseen, sample_variance, kOutliers),
                     gain(unseen, replicate_variance, kOutliers)});
  }

  /// True if the rest of the pilot can be spared, because guided paths did so badly in this round;
  /// then this is in the report.
  bool gives_up_after(std::size_t round, const GuideLearner& learner, Pilot& pilot) {
    if (wanted_paths_ < kMinPathsToGiveUp) return false;
    const double hope = gain_of_round();
    if (hope >= kMinHopeOfRound[round]) return false;
    report(learner.table(), hope, pilot);
    return true;
  }

  void report(const GuideTable& table, double gain, Pilot& pilot) const {
    pilot.report.guiding_paths = paths_;
    pilot.report.guiding_cells = table.cell_count();
    pilot.report.guiding_gain = gain;
  }

  static void use(GuideTable table, Pilot& pilot) {
    table.roulette_depth = pilot.report.roulette_depth = kRouletteDepth;
    pilot.report.guiding_digest = table.digest();
    pilot.table = std::make_shared<const GuideTable>(std::move(table));
  }

  PilotPicture& picture_;
  std::uint64_t wanted_paths_;
  std::uint64_t samples_of_part_;
  float scale_ = 1;
  double usual_luminance_ = 1;
  std::vector<double> sums_;  // luminance of all paths but those of the first round and of the trial, by pixel
  double summed_paths_ = 0;
  PathStatistics without_, with_;  // of the first round; of the last one, or of the trial
  std::uint64_t next_ = 0, paths_ = 0;
};

}  // namespace

Settings guiding_picture_settings(const Settings& settings) {
  return pilot_picture_settings(settings, double(settings.pilot_paths / kPathsPerPilotPixel));
}

std::uint64_t largest_guiding_round(const Settings& settings) {
  const Settings picture = guiding_picture_settings(settings);
  return GuidingPilot::samples_of_part(picture, settings.pilot_paths) * std::ranges::max(kPartsOfRound) *
         picture.crop.pixel_count();
}

void run_guiding_pilot(PilotPicture& picture, const Settings& settings, Pilot& pilot) {
  picture.restart(guiding_picture_settings(settings));
  picture.wavefront().trace_light_paths(false);  // what it finds is weighed against them all the same
  GuidingPilot(picture, settings.pilot_paths).run(settings.guiding, pilot);
}

}  // namespace eikon
