// SPDX-License-Identifier: Apache-2.0
#include "guide/learner.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <unordered_map>

namespace eikon {
namespace {

constexpr std::uint64_t kUnitsPerLuminance = 1U << 16;         // of the usual luminance
constexpr double kMostUnits = double(std::uint64_t{1} << 32);  // of one sample
constexpr double kPrior = 4;                                   // samples that the coarser level counts for in a bin
constexpr std::size_t kShards = 32;

using uint128 = unsigned __int128;

std::size_t shard_of(CellId id) { return std::size_t((id * 0x9e3779b97f4a7c15ULL) >> 59) % kShards; }

}  // namespace

/// The samples of a cell in one round.
struct CellSums {
  std::array<std::uint64_t, EK_GUIDE_BINS> sum{};
  std::array<uint128, EK_GUIDE_BINS> square{};
  std::array<std::uint32_t, EK_GUIDE_BINS> count{};
  std::uint64_t sampled = 0;  // by light sampling at vertices of this cell
  std::uint32_t sampled_count = 0;

  void operator+=(const CellSums& o) {
    for (std::size_t b = 0; b < EK_GUIDE_BINS; ++b)
      sum[b] += o.sum[b], square[b] += o.square[b], count[b] += o.count[b];
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

  float scale;
  double unit;  // luminance of one count
  std::array<Sums, kShards> shards;
  std::unordered_map<CellId, CellMeans> known;

  [[nodiscard]] std::uint64_t units(double luminance) const {
    return luminance > 0 ? std::uint64_t(std::min(luminance / unit, kMostUnits)) : 0;
  }

  /// The cell of the finest level that is known; null if none is.
  [[nodiscard]] const CellMeans* find(CellId id) const {
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

  void add_vertex(Sums& sums, CellId id, const PathLog& log, std::size_t path, std::uint32_t vertex) const {
    CellSums& cell = sums[id];
    const std::uint32_t info = log.word(path, vertex, LOG_info);
    const double albedo = log.number(path, vertex, LOG_albedo);
    if (albedo > 0) {
      cell.sampled += units(double(log.number(path, vertex, LOG_sampled)) / albedo);
      ++cell.sampled_count;
    }
    if ((info & LOG_CONTINUES) == 0) return;
    const double luminance = arriving(log, path, vertex);
    if (!(luminance >= 0)) return;
    const std::uint64_t q = units(luminance);
    const std::uint32_t bin = info & LOG_BIN_MASK;
    cell.sum[bin] += q;
    cell.square[bin] += uint128(q) * q;
    ++cell.count[bin];
  }

  void add(const PathLog& log) {
    // The cells are dealt out to shards, so that no two threads touch one cell.
    struct Vertex {
      CellId id;
      std::uint32_t path, vertex;
    };
    std::array<std::vector<Vertex>, kShards> dealt;
    for (std::uint32_t v = 0; v + 1 < EK_LOG_DEPTHS; ++v)
      for (std::size_t path = 0; path < log.paths; ++path) {
        if ((log.word(path, v, LOG_info) & LOG_GUIDED) == 0) continue;
        const CellId id = cell_id(log.word(path, v, LOG_xy), log.word(path, v, LOG_zn));
        dealt[shard_of(id)].push_back({id, std::uint32_t(path), v});
      }
    oneapi::tbb::parallel_for(std::size_t{0}, kShards, [&](std::size_t shard) {
      for (const Vertex& at : dealt[shard]) add_vertex(shards[shard], at.id, log, at.path, at.vertex);
    });
  }

  /// The means of a cell from its samples, drawn towards those of the cell around it where there are few.
  [[nodiscard]] CellMeans means(const CellSums& sums, const CellMeans* around) const {
    double all = 0, all_squares = 0, count = 0;
    for (std::size_t b = 0; b < EK_GUIDE_BINS; ++b) {
      all += double(sums.sum[b]);
      all_squares += double(sums.square[b]);
      count += sums.count[b];
    }
    count = std::max(count, 1.0);
    CellMeans cell;
    for (std::size_t b = 0; b < EK_GUIDE_BINS; ++b) {
      const double mean = around != nullptr ? around->mean[b] : all * unit / count;
      const double square = around != nullptr ? around->square[b] : all_squares * unit * unit / count;
      cell.mean[b] = (double(sums.sum[b]) * unit + kPrior * mean) / (sums.count[b] + kPrior);
      cell.square[b] = (double(sums.square[b]) * unit * unit + kPrior * square) / (sums.count[b] + kPrior);
      cell.indirect += cell.mean[b] / EK_GUIDE_BINS;
    }
    const double prior = around != nullptr ? kPrior : 0;
    if (sums.sampled_count + prior > 0)
      cell.direct = (double(sums.sampled) * unit + prior * (around != nullptr ? around->direct : 0)) /
                    (sums.sampled_count + prior);
    return cell;
  }

  void end_round(bool keep) {
    std::array<Sums, EK_GUIDE_LEVELS> levels;
    for (Sums& shard : shards) {
      levels[0].insert(shard.begin(), shard.end());
      if (!keep) shard.clear();
    }
    for (std::uint32_t level = 0; level + 1 < EK_GUIDE_LEVELS; ++level)
      for (const auto& [id, sums] : levels[level]) levels[level + 1][coarser(id)] += sums;
    for (std::uint32_t level = EK_GUIDE_LEVELS; level-- > 0;)
      for (const auto& [id, sums] : levels[level]) {
        const CellMeans* const around = level + 1 < EK_GUIDE_LEVELS ? &known.at(coarser(id)) : nullptr;
        known[id] = means(sums, around);
      }
  }

  [[nodiscard]] GuideTable table() const {
    std::vector<GuideCellData> cells;
    cells.reserve(known.size());
    for (const auto& [id, means] : known) {
      GuideCellData& cell = cells.emplace_back();
      cell.id = id;
      cell.indirect = means.indirect;
      cell.direct = means.direct;
      for (std::size_t b = 0; b < EK_GUIDE_BINS; ++b) cell.target[b] = std::sqrt(means.square[b]);
    }
    std::ranges::sort(cells, {}, &GuideCellData::id);
    return make_guide_table(cells, scale);
  }
};

GuideLearner::GuideLearner(float scale, double usual_luminance)
    : impl_(std::make_unique<Impl>(
          Impl{.scale = scale, .unit = usual_luminance / kUnitsPerLuminance, .shards = {}, .known = {}})) {}
GuideLearner::~GuideLearner() = default;
void GuideLearner::add(const PathLog& log) { impl_->add(log); }
void GuideLearner::end_round(bool keep) { impl_->end_round(keep); }
GuideTable GuideLearner::table() const { return impl_->table(); }

}  // namespace eikon
