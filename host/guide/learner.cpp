// SPDX-License-Identifier: Apache-2.0
#include "guide/learner.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "guide/cell_index.h"

namespace eikon {
namespace {

constexpr std::uint64_t kUnitsPerLuminance = 1U << 16;         // of the usual luminance
constexpr double kMaxUnits = double(std::uint64_t{1} << 32);   // of one sample
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

/// The compiler's own conversion takes ten times as long, and few sums need it.
double to_double(uint128 value) { return (value >> 64) == 0 ? double(std::uint64_t(value)) : double(value); }

}  // namespace

/// The samples of a bin in one round.
struct BinSums {
  uint128 square;
  std::uint64_t sum;
  std::uint32_t count;

  void operator+=(const BinSums& o) {
    square += o.square;
    sum += o.sum;
    count += o.count;
  }
};

/// The samples of a cell in one round. Small cells have samples in few of their bins, so only
/// groups of bins with samples take memory.
class CellSums {
  static constexpr std::size_t kBinsOfGroup = 4;

 public:
  /// The memory of groups, of many cells together.
  using Groups = CellValues<std::array<BinSums, kBinsOfGroup>>;

  std::uint64_t sampled;  // by light sampling at vertices of this cell
  std::uint32_t sampled_count;

  void clear() {
    sampled = 0;
    sampled_count = 0;
    used_ = 0;
  }
  void add(std::size_t bin, const BinSums& sums, Groups& groups) {
    const std::size_t group = bin / kBinsOfGroup, first = group * kBinsOfGroup;
    if ((used_ >> first & ((1U << kBinsOfGroup) - 1)) == 0) {
      group_[group] = std::uint32_t(groups.size());
      groups.add();
    }
    BinSums& own = groups[group_[group]][bin - first];
    if ((used_ >> bin & 1) != 0)
      own += sums;
    else
      own = sums;
    used_ |= std::uint64_t{1} << bin;
  }
  /// groups, of_other  the memory of this cell and of the other one
  void add(const CellSums& other, Groups& groups, const Groups& of_other) {
    other.for_each_bin(of_other, [&](std::size_t bin, const BinSums& sums) { add(bin, sums, groups); });
    sampled += other.sampled;
    sampled_count += other.sampled_count;
  }
  /// Calls use(bin, sums) for the bins that have samples, in their order.
  template <class Use>
  void for_each_bin(const Groups& groups, const Use& use) const {
    for (std::uint64_t left = used_; left != 0; left &= left - 1) {
      const auto bin = std::size_t(std::countr_zero(left));
      use(bin, groups[group_[bin / kBinsOfGroup]][bin % kBinsOfGroup]);
    }
  }

 private:
  static_assert(EK_GUIDE_BINS == 64, "a bit for each bin");
  std::uint64_t used_;
  std::array<std::uint32_t, EK_GUIDE_BINS / kBinsOfGroup> group_;  // only those with samples have values
};

/// The light at a cell.
struct CellMeans {
  std::array<double, EK_GUIDE_BINS> mean, square;  // of samples in a bin, luminance and its square
  std::array<double, EK_GUIDE_BINS> target;        // the root of `square`
  double indirect, direct;

  void set(std::size_t bin, double mean_of_bin, double square_of_bin) {
    mean[bin] = mean_of_bin;
    square[bin] = square_of_bin;
    target[bin] = std::sqrt(square_of_bin);
  }
};

float PathLog::number(std::size_t path, std::uint32_t vertex, std::uint32_t which) const {
  return std::bit_cast<float>(word(path, vertex, which));
}

struct GuideLearner::Impl {
  /// Cells of one level that a round visited.
  struct Visited {
    CellIndex index;
    CellValues<CellSums> sums;
    CellSums::Groups groups;
    CellValues<CellMeans> means;  // while a round ends; not of the finest cells, which surround no others
    CellSums& of(CellId id) {
      const std::uint32_t number = index.add(id);
      if (number == sums.size()) sums.add().clear();
      return sums[number];
    }
    void clear() {
      index.clear();
      sums.clear();
      groups.clear();
      means.clear();
    }
  };

  /// A part of the cells, with all coarser cells that they lie in. Threads work on shards of their
  /// own.
  struct Shard {
    std::array<Visited, EK_GUIDE_LEVELS> levels;  // in this round; those above the finest are summed up at its end
    // The cells of all rounds so far; each list has a value for every one, by its number.
    CellIndex known;
    std::vector<double> indirect;  // CellMeans::indirect, which is looked up more often than all the rest
    CellValues<GuideCellWords> words;
  };

  /// A vertex of a path, as a sample of the light at its cell.
  struct Sample {
    static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
    CellId id;
    std::uint64_t sampled = kNone, arriving = kNone;  // in units: by light sampling, over the albedo; through the bin
    std::uint32_t bin;
  };
  using Sorted = std::array<std::vector<Sample>, kShards>;

  float scale;
  double unit;  // luminance of one count
  std::array<Shard, kShards> shards;
  std::vector<Sorted> blocks;  // room for the samples of a unit

  Impl(float of_scale, double of_unit) : scale(of_scale), unit(of_unit) {}

  [[nodiscard]] std::uint64_t units(double luminance) const {
    return luminance > 0 ? std::uint64_t(std::min(luminance / unit, kMaxUnits)) : 0;
  }

  /// The light that a cell is known to get from surfaces, by the finest level that is known; 0 if
  /// none is.
  [[nodiscard]] double known_indirect(CellId id) const {
    const Shard& shard = shards[shard_of(id)];
    for (std::uint32_t level = 0; level < EK_GUIDE_LEVELS; ++level, id = coarser(id))
      if (const std::uint32_t number = shard.known.find(id); number != CellIndex::kNone) return shard.indirect[number];
    return 0;
  }

  /// The luminance that reaches a vertex from where its path went on; negative where the log does
  /// not say.
  [[nodiscard]] double arriving(const PathLog& log, std::size_t path, std::uint32_t vertex) const {
    double sum = 0, throughput = 1;
    for (std::uint32_t v = vertex + 1; v < EK_LOG_DEPTHS; ++v) {
      const std::uint32_t info = log.word(path, v, LOG_info);
      if ((info & (LOG_HIT | LOG_MISS)) == 0) return sum;
      sum += throughput * double(log.number(path, v, LOG_emitted));
      if ((info & LOG_MISS) != 0) return sum;
      sum += throughput * double(log.number(path, v, LOG_sampled));
      if ((info & LOG_GUIDED) != 0) {
        const CellId next = cell_id(log.word(path, v, LOG_xy), log.word(path, v, LOG_zn));
        return sum + throughput * double(log.number(path, v, LOG_albedo)) * known_indirect(next);
      }
      if ((info & LOG_CONTINUES) == 0) return sum;
      throughput *= double(log.number(path, v, LOG_weight));
    }
    return -1;  // the log ends between mirrors
  }

  [[nodiscard]] Sample sample_of(const PathLog& log, std::size_t path, std::uint32_t vertex, CellId id) const {
    const std::uint32_t info = log.word(path, vertex, LOG_info);
    Sample sample{.id = id, .bin = info & LOG_BIN_MASK};
    const double albedo = log.number(path, vertex, LOG_albedo);
    if (albedo > 0) sample.sampled = units(double(log.number(path, vertex, LOG_sampled)) / albedo);
    if ((info & LOG_CONTINUES) == 0) return sample;
    const double luminance = arriving(log, path, vertex);
    if (luminance >= 0) sample.arriving = units(luminance);
    return sample;
  }

  static void add_sample(Visited& visited, const Sample& sample) {
    CellSums& cell = visited.of(sample.id);
    if (sample.sampled != Sample::kNone) {
      cell.sampled += sample.sampled;
      ++cell.sampled_count;
    }
    if (sample.arriving == Sample::kNone) return;
    cell.add(sample.bin, {.square = uint128(sample.arriving) * sample.arriving, .sum = sample.arriving, .count = 1},
             visited.groups);
  }

  void add(const PathLog& log) {
    const std::size_t count = (log.paths + kPathsPerBlock - 1) / kPathsPerBlock;
    if (blocks.size() < count) blocks.resize(count);
    oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t block) {
      Sorted& sorted = blocks[block];
      for (std::vector<Sample>& samples : sorted) samples.clear();
      const std::size_t begin = block * kPathsPerBlock, end = std::min(begin + kPathsPerBlock, log.paths);
      for (std::uint32_t v = 0; v + 1 < EK_LOG_DEPTHS; ++v)
        for (std::size_t path = begin; path < end; ++path) {
          if ((log.word(path, v, LOG_info) & LOG_GUIDED) == 0) continue;
          const CellId id = cell_id(log.word(path, v, LOG_xy), log.word(path, v, LOG_zn));
          sorted[shard_of(id)].push_back(sample_of(log, path, v, id));
        }
    });
    oneapi::tbb::parallel_for(std::size_t{0}, kShards, [&](std::size_t shard) {
      for (std::size_t block = 0; block < count; ++block)
        for (const Sample& sample : blocks[block][shard]) add_sample(shards[shard].levels[0], sample);
    });
  }

  /// The means of a cell from its samples, drawn towards those of the cell around it where there
  /// are few.
  [[nodiscard]] CellMeans means(const CellSums& sums, const CellSums::Groups& groups, const CellMeans* around) const {
    CellMeans cell;
    if (around != nullptr)
      cell = *around;
    else
      fill_with_mean_of_bins(sums, groups, cell);
    sums.for_each_bin(groups, [&](std::size_t b, const BinSums& bin) {
      cell.set(b, (double(bin.sum) * unit + kPrior * cell.mean[b]) / (bin.count + kPrior),
               (to_double(bin.square) * unit * unit + kPrior * cell.square[b]) / (bin.count + kPrior));
    });
    cell.indirect = std::accumulate(cell.mean.begin(), cell.mean.end(), 0.0) / EK_GUIDE_BINS;
    const double prior = around != nullptr ? kPrior : 0;
    cell.direct = 0;
    if (sums.sampled_count + prior > 0)
      cell.direct = (double(sums.sampled) * unit + prior * (around != nullptr ? around->direct : 0)) /
                    (sums.sampled_count + prior);
    return cell;
  }

  /// Gives each bin the mean over all of them.
  void fill_with_mean_of_bins(const CellSums& sums, const CellSums::Groups& groups, CellMeans& cell) const {
    double all = 0, all_squares = 0, count = 0;
    sums.for_each_bin(groups, [&](std::size_t, const BinSums& bin) {
      all += double(bin.sum);
      all_squares += to_double(bin.square);
      count += bin.count;
    });
    count = std::max(count, 1.0);
    cell.mean.fill(all * unit / count);
    cell.square.fill(all_squares * unit * unit / count);
    cell.target.fill(std::sqrt(cell.square[0]));
  }

  static void know(Shard& shard, CellId id, const CellMeans& means) {
    const std::uint32_t number = shard.known.add(id);
    if (number == shard.words.size()) {
      shard.indirect.push_back(0);
      shard.words.add();
    }
    shard.indirect[number] = means.indirect;
    shard.words[number] =
        words_of({.id = id, .target = means.target, .indirect = means.indirect, .direct = means.direct});
  }

  void end_round(bool keep) {
    oneapi::tbb::parallel_for(std::size_t{0}, kShards, [&](std::size_t at) {
      Shard& shard = shards[at];
      for (std::uint32_t level = 0; level + 1 < EK_GUIDE_LEVELS; ++level) {
        const Visited& fine = shard.levels[level];
        Visited& coarse = shard.levels[level + 1];
        for (std::size_t number = 0; number < fine.sums.size(); ++number)
          coarse.of(coarser(fine.index.ids()[number])).add(fine.sums[number], coarse.groups, fine.groups);
      }
      for (std::uint32_t level = EK_GUIDE_LEVELS; level-- > 0;) {
        Visited& visited = shard.levels[level];
        const Visited* const coarse = level + 1 < EK_GUIDE_LEVELS ? &shard.levels[level + 1] : nullptr;
        for (std::size_t number = 0; number < visited.sums.size(); ++number) {
          const CellId id = visited.index.ids()[number];
          const CellMeans* const around = coarse != nullptr ? &coarse->means[coarse->index.find(coarser(id))] : nullptr;
          const CellMeans cell = means(visited.sums[number], visited.groups, around);
          know(shard, id, cell);
          if (level > 0) visited.means.add() = cell;
        }
      }
      for (std::uint32_t level = keep ? 1 : 0; level < EK_GUIDE_LEVELS; ++level) shard.levels[level].clear();
    });
  }

  [[nodiscard]] GuideTable table() const {
    std::vector<std::pair<CellId, const GuideCellWords*>> known;
    for (const Shard& shard : shards)
      for (std::size_t number = 0; number < shard.words.size(); ++number)
        known.emplace_back(shard.known.ids()[number], &shard.words[number]);
    oneapi::tbb::parallel_sort(known);  // so that the order of the cells is that of their ids
    return assemble_guide_table(known, scale);
  }
};

GuideLearner::GuideLearner(float scale, double usual_luminance)
    : impl_(std::make_unique<Impl>(scale, usual_luminance / kUnitsPerLuminance)) {}
GuideLearner::~GuideLearner() = default;
void GuideLearner::add(const PathLog& log) { impl_->add(log); }
void GuideLearner::end_round(bool keep) { impl_->end_round(keep); }
GuideTable GuideLearner::table() const { return impl_->table(); }

}  // namespace eikon
