// SPDX-License-Identifier: Apache-2.0
#include "render/pilot.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/clock.h"
#include "guide/learner.h"
#include "image/tonemap.h"
#include "wavefront/memory_need.h"
#include "wavefront/wavefront.h"

namespace eikon {
namespace {

// The pilot is a picture of at most so many pixels, of which each is a block of the image: gains are measured in them. There
// are so many paths for each pixel that the trial has 32 samples of it, which begin to show how samples fill gaps.
constexpr std::uint32_t kPixels = 512;
constexpr std::uint64_t kPathsPerPilotPixel = 256;
// Samples of a pixel over those of the first round: in the rounds that learn, and in each of the two ways of the trial.
constexpr std::array<std::uint64_t, 6> kRounds = {1, 2, 4, 8, 16, 16};
constexpr std::uint64_t kTrial = 8;
constexpr std::uint64_t kShares = 63;  // of all together
// At the first vertex roulette saves next to nothing, and adds noise to direct light.
constexpr std::uint32_t kRouletteDepth = 2;
constexpr std::uint64_t kLeastPaths = 1U << 15;
constexpr std::uint64_t kPathsPerPixel = 2;       // a thirty-second of the usual 64 samples
constexpr std::uint64_t kLeastPixels = 1U << 14;  // of images that have a pilot
constexpr std::uint32_t kLeastPool = 1U << 10;    // of a device with little memory
constexpr double kCellsPerHeight = 16;            // smallest cells across the picture at the usual distance
constexpr double kLeastGain = 1.25;  // a guided vertex costs about so many times another one (kernels/guide/README.md)
constexpr std::uint32_t kSeed = 0x70696c6fU;  // of no image, so that the samples differ from all images'

/// The settings of the picture that the pilot renders.
Settings pilot_settings(const Settings& settings, std::uint64_t paths) {
  Settings pilot = settings;
  const double pixels = std::clamp(double(paths / kPathsPerPilotPixel), 1.0, double(kPixels));
  const double aspect = double(settings.width) / double(settings.height);
  const auto side = [](double x) { return std::uint32_t(std::clamp(std::round(x), 1.0, double(kPixels))); };
  pilot.height = side(std::sqrt(pixels / aspect));
  pilot.width = side(pixels / pilot.height);
  pilot.crop = {0, 0, pilot.width, pilot.height};
  pilot.replicate_bits = 1;
  // What it finds is weighed against as many light paths for each pixel as the image has.
  const double scale = double(pilot.crop.pixel_count()) / (double(settings.width) * settings.height);
  if (settings.light_path_count > 0)
    pilot.light_path_count = std::max<std::uint64_t>(std::uint64_t(std::llround(double(settings.light_path_count) * scale)), 1);
  pilot.seed = kSeed;
  return pilot;
}

/// The paths of one way of sampling in the trial.
struct Trial {
  std::vector<double> count, sum, square;        // luminance of paths, by pixel
  std::array<std::vector<double>, 2> replicate;  // sums of its halves, which are scrambled apart
  double rays = 0, paths = 0;
};

/// Without guiding, and with it.
using Trials = std::array<Trial, 2>;

class PilotRun {
 public:
  PilotRun(Device& device, const PackedScene& packed, Features features, const Settings& settings,
           const Execution& execution, PilotSteps& steps)
      : settings_(pilot_settings(settings, settings.pilot_paths)),
        samples_(std::uint64_t(
            std::max(std::round(double(settings.pilot_paths) / double(settings_.crop.pixel_count() * kShares)), 1.0))),
        steps_(steps) {
    features.set_guiding(false, true);
    settings_.guide = std::make_shared<const GuideTable>(make_guide_table({}, 1));
    const Execution own = with_pool(device.info(), packed, features, execution);
    wavefront_ = std::make_unique<Wavefront>(device, packed, features, settings_, own);
  }

  Pilot run(Guiding guiding) {
    calibrate();
    GuideLearner learner(scale_, usual_luminance_);
    mean_.resize(settings_.crop.pixel_count());
    const auto learn = [&](const PathLog& log) {
      learner.add(log);
      add_to_mean(log);
    };
    for (std::size_t round = 0; round < kRounds.size(); ++round) {
      guide_with(learner.table(), round == 0 ? 0 : kRouletteDepth);
      render(samples_ * kRounds[round], learn);
      learner.freeze(round + 2 >= kRounds.size());  // the last two rounds and the trial count together
    }
    end_mean(samples_ * std::accumulate(kRounds.begin(), kRounds.end(), std::uint64_t{0}));
    const GuideTable table = learner.table();
    Trials trials;
    const std::uint64_t begin = next_;
    for (Trial& trial : trials) {
      next_ = begin;  // both ways have the same samples: what guiding does not change has the same noise in both
      guide_with(table, &trial == &trials[0] ? 0 : kRouletteDepth);
      render(samples_ * kTrial, [&](const PathLog& log) {
        learner.add(log);
        add(trial, log);
      });
    }
    learner.freeze();
    return decide(learner.table(), trials, guiding);
  }

 private:
  /// The execution with a pool for the largest unit, or as large a one as the memory allows. The size of units changes
  /// nothing of what the pilot learns. throws DeviceError when the device has not even the memory for small ones
  [[nodiscard]] Execution with_pool(const DeviceInfo& info, const PackedScene& packed, const Features& features,
                                    Execution execution) const {
    const std::uint64_t largest = samples_ * kRounds.back() * settings_.crop.pixel_count();
    const auto pool = std::uint32_t(std::min<std::uint64_t>(std::bit_ceil(largest), kMostPilotPool));
    execution.pool = execution.pool == 0 ? pool : std::min(execution.pool, pool);
    const auto need = [&] { return memory_need(packed, configure(info, execution), features); };
    const std::uint64_t limit =
        execution.memory_bytes == 0 ? info.memory_bytes : std::min(execution.memory_bytes, info.memory_bytes);
    while (execution.pool > kLeastPool && need().total() > limit) execution.pool /= 2;
    require_memory(need(), info, execution);
    return execution;
  }

  template <class Use>
  void render(std::uint64_t samples, const Use& use) {
    const std::uint32_t capacity = wavefront_->config().capacity();
    const std::uint32_t rows = std::max(1U, std::min(settings_.height, capacity / settings_.width));
    for (std::uint64_t end = next_ + samples; next_ < end;) {
      const std::uint64_t most = std::max<std::uint64_t>(capacity / (std::uint64_t{rows} * settings_.width), 1);
      const std::uint64_t until = std::min(end, next_ + most);
      for (std::uint32_t y = 0; y < settings_.height; y += rows) {
        const std::uint32_t height = std::min(rows, settings_.height - y);
        unit_pixels_ = std::size_t{height} * settings_.width;
        steps_.begin_unit(unit_pixels_ * (until - next_));
        wavefront_->begin({{0, y, settings_.width, y + height}, next_, until});
        first_pixel_ = std::size_t{y} * settings_.width;
        (void)wavefront_->finish();
        const PathLog log = wavefront_->path_log();
        steps_.end_unit();
        unit_begin_ = next_;
        use(log);
        paths_ += unit_pixels_ * (until - next_);
      }
      next_ = until;
    }
  }

  void guide_with(GuideTable table, std::uint32_t roulette_depth) {
    table.roulette_depth = roulette_depth;
    wavefront_->set_guide(std::make_shared<const GuideTable>(std::move(table)));
  }

  [[nodiscard]] static std::vector<double> luminances(const PathLog& log) {
    std::vector<double> values(log.paths);
    const auto at = [&](std::size_t plane, std::size_t i) {
      return double(std::bit_cast<float>(log.radiance[plane * log.paths + i]));
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
    render(4, [&](const PathLog& log) {
      for (const double value : luminances(log)) sum += std::abs(value);
      for (std::size_t path = 0; path < log.paths; ++path)
        if ((log.word(path, 0, LOG_info) & LOG_HIT) != 0) distances.push_back(log.number(path, 0, LOG_distance));
    });
    usual_luminance_ = sum > 0 ? sum / double(paths_) : 1;
    if (distances.empty()) return;
    const auto middle = distances.begin() + std::ptrdiff_t(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    const Camera& camera = settings_.camera;
    const double height = camera.projection == Projection::orthographic ? 2 * camera.ymag_m
                          : camera.projection == Projection::panorama
                              ? 2 * double(*middle)
                              : 2 * std::tan(0.5 * camera.yfov_rad) * double(*middle);
    if (height > 0 && std::isfinite(height)) scale_ = float(kCellsPerHeight / height);
  }

  /// Adds to the means by which errors are judged. They do not have the trial's samples: one that is bright would
  /// otherwise raise the mean of its pixel and so hide itself.
  void add_to_mean(const PathLog& log) {
    const std::vector<double> values = luminances(log);
    for (std::size_t path = 0; path < values.size(); ++path) mean_[first_pixel_ + path % unit_pixels_] += values[path];
  }

  /// Makes the sums means of so many samples, and of each pixel with its neighbours: one that is too low by chance would
  /// otherwise count for too much.
  void end_mean(std::uint64_t samples) {
    const std::vector<double> sum = mean_;
    const auto width = int(settings_.width), height = int(settings_.height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double around = 0, count = 0;
        for (int j = std::max(y - 1, 0); j < std::min(y + 2, height); ++j)
          for (int i = std::max(x - 1, 0); i < std::min(x + 2, width); ++i)
            around += sum[std::size_t(j) * settings_.width + std::size_t(i)], count += double(samples);
        mean_[std::size_t(y) * settings_.width + std::size_t(x)] = around / count;
      }
  }

  void add(Trial& trial, const PathLog& log) {
    const std::size_t pixels = std::size_t{settings_.width} * settings_.height;
    for (auto* list : {&trial.count, &trial.sum, &trial.square, &trial.replicate[0], &trial.replicate[1]})
      list->resize(pixels);
    const std::vector<double> values = luminances(log);
    trial.paths += double(values.size());
    for (std::size_t path = 0; path < values.size(); ++path) {
      const std::size_t pixel = first_pixel_ + path % unit_pixels_;
      trial.count[pixel] += 1;
      trial.sum[pixel] += values[path];
      trial.square[pixel] += values[path] * values[path];
      trial.replicate[(unit_begin_ + path / unit_pixels_) % 2][pixel] += values[path];
      for (std::uint32_t v = 0; v < EK_LOG_DEPTHS; ++v) {
        const std::uint32_t info = log.word(path, v, LOG_info);
        if ((info & (LOG_HIT | LOG_MISS)) == 0) break;
        trial.rays += (info & LOG_HIT) != 0 ? 2 : 1;  // with a shadow ray
      }
    }
  }

  /// Variance of a sample in a pixel, as of independent ones.
  [[nodiscard]] static double sample_variance(const Trial& trial, std::size_t pixel) {
    const double n = trial.count[pixel], mean = trial.sum[pixel] / n;
    return std::max(trial.square[pixel] / n - mean * mean, 0.0);
  }
  /// The same from the difference of its halves, which have less where samples fill each other's gaps.
  [[nodiscard]] static double replicate_variance(const Trial& trial, std::size_t pixel) {
    const double half = 0.5 * trial.count[pixel];
    const double difference = (trial.replicate[0][pixel] - trial.replicate[1][pixel]) / half;
    return 0.5 * half * difference * difference;
  }

  /// Error times rays without guiding over that with it, by every `step`th pixel from `first` on. The error is the
  /// sum over pixels of the variance over the squared mean.
  template <class Variance>
  [[nodiscard]] double gain(const Trials& trials, std::size_t first, std::size_t step, const Variance& variance) const {
    const double all = std::accumulate(mean_.begin(), mean_.end(), 0.0) / double(mean_.size());
    std::array<double, 2> cost{};
    for (std::size_t way = 0; way < trials.size(); ++way) {
      for (std::size_t i = first; i < mean_.size(); i += step)
        cost[way] += variance(trials[way], i) / (mean_[i] * mean_[i] + 0.01 * all * all);
      cost[way] *= trials[way].rays / trials[way].paths;
    }
    return cost[1] > 0 ? cost[0] / cost[1] : 1;
  }

  /// The least gain of the whole picture and of both its halves, since what holds for one of them alone is chance; and of
  /// the whole by the other variance, since gains where samples fill each other's gaps anyway are none.
  [[nodiscard]] double least_gain(const Trials& trials) const {
    return std::min({gain(trials, 0, 1, sample_variance), gain(trials, 0, 2, sample_variance),
                     gain(trials, 1, 2, sample_variance), gain(trials, 0, 1, replicate_variance)});
  }

  [[nodiscard]] Pilot decide(GuideTable table, const Trials& trials, Guiding guiding) const {
    Pilot pilot;
    pilot.report.paths = paths_;
    pilot.report.cells = table.cell_count();
    pilot.report.arithmetic = wavefront_->arithmetic().name();
    pilot.report.gain = least_gain(trials);
    if (guiding != Guiding::on && pilot.report.gain < kLeastGain) return pilot;
    table.roulette_depth = pilot.report.roulette_depth = kRouletteDepth;
    pilot.report.digest = table.digest();
    pilot.table = std::make_shared<const GuideTable>(std::move(table));
    return pilot;
  }

  Settings settings_;
  std::uint64_t samples_;  // of a pixel in the first round
  PilotSteps& steps_;
  std::unique_ptr<Wavefront> wavefront_;
  float scale_ = 1;
  double usual_luminance_ = 1;
  std::vector<double> mean_;  // luminance of paths, by pixel; a sum while they are rendered
  std::uint64_t next_ = 0, paths_ = 0;
  std::uint64_t unit_begin_ = 0;                   // first sample of the unit that was rendered last
  std::size_t first_pixel_ = 0, unit_pixels_ = 0;  // of it
};

}  // namespace

std::uint64_t usual_pilot_paths(const Settings& settings) {
  if (settings.guiding == Guiding::off || settings.integrator != Integrator::path || settings.roulette > 0 ||
      settings.light_samples > 1 || settings.light_sampling == LightSampling::hemisphere)
    return 0;
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  if (pixels < kLeastPixels && settings.guiding != Guiding::on) return 0;
  return std::bit_floor(std::clamp(kPathsPerPixel * pixels, kLeastPaths, kMostPilotPaths));
}

bool wants_pilot(const Features& features, const Settings& settings) {
  const bool lit = features.has(Feature::next_event) || features.has(Feature::bsdf_emission);
  const bool diffuse = features.has(Feature::diffuse) || features.has(Feature::metallic_roughness);
  if (settings.pilot_paths == 0 || settings.guide != nullptr || !lit || !diffuse) return false;
  // Caustics of small lights are rare events, which a pilot of this size does not see: its tables then lead away from
  // them, and it cannot tell what that costs. Light paths bring those that they can find.
  const bool caustics = !features.has(Feature::light_paths) && (features.has(Feature::clear_hits) || features.has(Feature::conductor)) &&
                        (features.has(Feature::area) || features.has(Feature::point) || features.has(Feature::spot));
  return !caustics || settings.guiding == Guiding::on;
}

Pilot run_pilot(Device& device, const PackedScene& packed, const Features& features, const Settings& settings,
                const Execution& execution, PilotSteps& steps) {
  const double begin = host_seconds();
  Pilot pilot = PilotRun(device, packed, features, settings, execution, steps).run(settings.guiding);
  pilot.report.seconds = host_seconds() - begin;
  return pilot;
}

}  // namespace eikon
