// SPDX-License-Identifier: Apache-2.0
#include "guide/learner.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

namespace eikon {
namespace {

constexpr std::uint64_t kUnitsPerLuminance = 1U << 16;         // of the usual luminance
constexpr double kMostUnits = double(std::uint64_t{1} << 32);  // of one sample
constexpr double kPrior = 4;                                   // samples that the coarser level counts for in a bin
constexpr unsigned kShardBits = 6;
constexpr std::size_t kShards = 1U << kShardBits;
constexpr std::size_t kPathsPerBlock = 1U << 13;  // that a thread sorts at a time

using uint128 = unsigned __int128;

/// The shard of a cell: that of the cell of the coarsest level around it.
std::size_t shard_of(CellId id) {
  while (level_of(id) + 1 < EK_GUIDE_LEVELS) id = coarser(id);
  return std::size_t((id * 0x9e3779b97f4a7c15ULL) >> (64 - kShardBits));
}

}  // namespace

/// The samples of a bin in one round.
struct BinSums {
  uint128 square = 0;
  std::uint64_t sum = 0;
  std::uint32_t count = 0;
};

/// The samples of a cell in one round.
struct CellSums {
  std::array<BinSums, EK_GUIDE_BINS> bins{};
  std::uint64_t sampled = 0;  // by light sampling at vertices of this cell
  std::uint32_t sampled_count = 0;

  void operator+=(const CellSums& o) {
    for (std::size_t b = 0; b < EK_GUIDE_BINS; ++b) {
      bins[b].square += o.bins[b].square;
      bins[b].sum += o.bins[b].sum;
      bins[b].count += o.bins[b].count;
    }
    sampled += o.sampled;
    sampled_count += o.sampled_count;
  }
};

/// The light at a cell by all rounds so far.
struct CellMeans {
  std::array<double, EK_GUIDE_BINS> mean{}, square{};  // of samples in a bin, luminance and its square
  double indirect = 0, direct = 0;
};

float PathLog::number(std::size_t path, std::uint32_t vertex, std::uint32_t which) const {
  return std::bit_cast<float>(word(path, vertex, which));
}

struct GuideLearner::Impl {
  using Sums = std::unordered_map<CellId, CellSums>;

  /// A part of the cells, with all coarser cells that they lie in. Threads work on shards of their own.
  struct Shard {
    Sums sums;  // of the finest level, in this round
    std::unordered_map<CellId, CellMeans> known;
  };

  float scale;
  double unit;  // luminance of one count
  std::array<Shard, kShards> shards;

  [[nodiscard]] std::uint64_t units(double luminance) const {
    return luminance > 0 ? std::uint64_t(std::min(luminance / unit, kMostUnits)) : 0;
  }

  /// The cell of the finest level that is known; null if none is.
  [[nodiscard]] const CellMeans* find(CellId id) const {
    const auto& known = shards[shard_of(id)].known;
    for (std::uint32_t level = 0; level < EK_GUIDE_LEVELS; ++level, id = coarser(id))
      if (const auto found = known.find(id); found != known.end()) return &found->second;
    return nullptr;
  }

  /// The luminance that reaches a vertex from where its path went on; negative where the log does not say.
  [[nodiscard]] double arriving(const PathLog& log, std::size_t path, std::uint32_t vertex) const {
    double sum = 0, throughput = 1;
    for (std::uint32_t v = vertex + 1; v < EK_LOG_DEPTHS; ++v) {
      const std::uint32_t info = log.word(path, v, LOG_info);
      if ((info & (LOG_HIT | LOG_MISS)) == 0) return sum;
      sum += throughput * double(log.number(path, v, LOG_emitted));
      if ((info & LOG_MISS) != 0) return sum;
      sum += throughput * double(log.number(path, v, LOG_sampled));
      if ((info & LOG_GUIDED) != 0) {
        const CellMeans* const next = find(cell_id(log.word(path, v, LOG_xy), log.word(path, v, LOG_zn)));
        if (next != nullptr) sum += throughput * double(log.number(path, v, LOG_albedo)) * next->indirect;
        return sum;
      }
      if ((info & LOG_CONTINUES) == 0) return sum;
      throughput *= double(log.number(path, v, LOG_weight));
    }
    return -1;  // the log ends between mirrors
  }

  /// A vertex of a path, as a sample of the light at its cell.
  struct Sample {
    CellId id;
    std::optional<std::uint64_t> sampled, arriving;  // in units: by light sampling, over the albedo; through the bin
    std::uint32_t bin;
  };

  [[nodiscard]] Sample sample_of(const PathLog& log, std::size_t path, std::uint32_t vertex, CellId id) const {
    const std::uint32_t info = log.word(path, vertex, LOG_info);
    Sample sample{.id = id, .sampled = {}, .arriving = {}, .bin = info & LOG_BIN_MASK};
    const double albedo = log.number(path, vertex, LOG_albedo);
    if (albedo > 0) sample.sampled = units(double(log.number(path, vertex, LOG_sampled)) / albedo);
    if ((info & LOG_CONTINUES) == 0) return sample;
    const double luminance = arriving(log, path, vertex);
    if (luminance >= 0) sample.arriving = units(luminance);
    return sample;
  }

  static void add_sample(CellSums& cell, const Sample& sample) {
    if (sample.sampled) {
      cell.sampled += *sample.sampled;
      ++cell.sampled_count;
    }
    if (!sample.arriving) return;
    BinSums& bin = cell.bins[sample.bin];
    bin.square += uint128(*sample.arriving) * *sample.arriving;
    bin.sum += *sample.arriving;
    ++bin.count;
  }

  void add(const PathLog& log) {
    using Sorted = std::array<std::vector<Sample>, kShards>;
    std::vector<Sorted> blocks((log.paths + kPathsPerBlock - 1) / kPathsPerBlock);
    oneapi::tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
      const std::size_t begin = block * kPathsPerBlock, end = std::min(begin + kPathsPerBlock, log.paths);
      for (std::uint32_t v = 0; v + 1 < EK_LOG_DEPTHS; ++v)
        for (std::size_t path = begin; path < end; ++path) {
          if ((log.word(path, v, LOG_info) & LOG_GUIDED) == 0) continue;
          const CellId id = cell_id(log.word(path, v, LOG_xy), log.word(path, v, LOG_zn));
          blocks[block][shard_of(id)].push_back(sample_of(log, path, v, id));
        }
    });
    oneapi::tbb::parallel_for(std::size_t{0}, kShards, [&](std::size_t shard) {
      for (const Sorted& block : blocks)
        for (const Sample& sample : block[shard]) add_sample(shards[shard].sums[sample.id], sample);
    });
  }

  /// The means of a cell from its samples, drawn towards those of the cell around it where there are few.
  [[nodiscard]] CellMeans means(const CellSums& sums, const CellMeans* around) const {
    double all = 0, all_squares = 0, count = 0;
    for (std::size_t b = 0; b < EK_GUIDE_BINS; ++b) {
      all += double(sums.bins[b].sum);
      all_squares += double(sums.bins[b].square);
      count += sums.bins[b].count;
    }
    count = std::max(count, 1.0);
    CellMeans cell;
    for (std::size_t b = 0; b < EK_GUIDE_BINS; ++b) {
      const double mean = around != nullptr ? around->mean[b] : all * unit / count;
      const double square = around != nullptr ? around->square[b] : all_squares * unit * unit / count;
      const BinSums& bin = sums.bins[b];
      cell.mean[b] = (double(bin.sum) * unit + kPrior * mean) / (bin.count + kPrior);
      cell.square[b] = (double(bin.square) * unit * unit + kPrior * square) / (bin.count + kPrior);
      cell.indirect += cell.mean[b] / EK_GUIDE_BINS;
    }
    const double prior = around != nullptr ? kPrior : 0;
    if (sums.sampled_count + prior > 0)
      cell.direct = (double(sums.sampled) * unit + prior * (around != nullptr ? around->direct : 0)) /
                    (sums.sampled_count + prior);
    return cell;
  }

  void end_round(bool keep) {
    oneapi::tbb::parallel_for(std::size_t{0}, kShards, [&](std::size_t at) {
      Shard& shard = shards[at];
      std::array<Sums, EK_GUIDE_LEVELS - 1> coarse;
      for (std::uint32_t level = 0; level + 1 < EK_GUIDE_LEVELS; ++level)
        for (const auto& [id, sums] : level == 0 ? shard.sums : coarse[level - 1]) coarse[level][coarser(id)] += sums;
      for (std::uint32_t level = EK_GUIDE_LEVELS; level-- > 0;)
        for (const auto& [id, sums] : level == 0 ? shard.sums : coarse[level - 1]) {
          const CellMeans* const around = level + 1 < EK_GUIDE_LEVELS ? &shard.known.at(coarser(id)) : nullptr;
          shard.known[id] = means(sums, around);
        }
      if (!keep) shard.sums.clear();
    });
  }

  [[nodiscard]] GuideTable table() const {
    std::vector<std::pair<CellId, const CellMeans*>> known;
    for (const Shard& shard : shards)
      for (const auto& [id, means] : shard.known) known.emplace_back(id, &means);
    std::ranges::sort(known);  // so that the order of the cells is that of their ids
    std::vector<GuideCellData> cells(known.size());
    oneapi::tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t i) {
      const CellMeans& means = *known[i].second;
      GuideCellData& cell = cells[i];
      cell.id = known[i].first;
      cell.indirect = means.indirect;
      cell.direct = means.direct;
      for (std::size_t b = 0; b < EK_GUIDE_BINS; ++b) cell.target[b] = std::sqrt(means.square[b]);
    });
    return make_guide_table(cells, scale);
  }
};

GuideLearner::GuideLearner(float scale, double usual_luminance)
    : impl_(std::make_unique<Impl>(Impl{.scale = scale, .unit = usual_luminance / kUnitsPerLuminance, .shards = {}})) {}
GuideLearner::~GuideLearner() = default;
void GuideLearner::add(const PathLog& log) { impl_->add(log); }
void GuideLearner::end_round(bool keep) { impl_->end_round(keep); }
GuideTable GuideLearner::table() const { return impl_->table(); }

}  // namespace eikon
