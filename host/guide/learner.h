// SPDX-License-Identifier: Apache-2.0
// Learns from the logs of a pilot's paths where light comes from.
//
// At each guided vertex x with a direction in bin b, the path that goes on there is one sample of
// the radiance that arrives at the cell of x through b: what light sampling finds at the next
// guided vertex y, plus the albedo of y times the mean radiance that the round before learned for
// the cell of y, plus emission met on the way. So a sample looks one diffuse bounce ahead, and
// light spreads by one more bounce with each round [Dahm and Keller 2017, "Learning Light Transport
// the Reinforced Way"]. The target of a bin is the root of the second moment of these samples, by
// which the variance of the estimate is least [Rath et al. 2020, "Variance-Aware Path Guiding"].
//
// Samples are summed as integers, so neither the order of paths nor the number of threads changes a
// table.
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "guide/guide_table.h"

namespace eikon {

/// The log of the paths of a unit (kernels/guide/path_log.h). The memory is the wavefront's
/// (Wavefront::path_log).
struct PathLog {
  std::span<const std::uint32_t> words;     // planes of one word of each path
  std::span<const std::uint32_t> radiance;  // what each path brought to its pixel: planes of the bits of R, G and B
  std::size_t paths = 0, stride = 0;        // words in use of each plane, and from one plane to the next

  [[nodiscard]] std::uint32_t word(std::size_t path, std::uint32_t vertex, std::uint32_t which) const {
    return words[(std::size_t{vertex} * LOG_WORDS + which) * stride + path];
  }
  [[nodiscard]] float number(std::size_t path, std::uint32_t vertex, std::uint32_t which) const;
};

/// Learns round by round: add() the logs of a round, end_round(), and render the next round guided
/// by table().
class GuideLearner {
 public:
  /// scale            1 / side of the smallest cells, 1 / metres
  /// usual_luminance  of a path: samples are counted in small parts of it, and no sample counts for
  ///                  more than 2^16 of it
  GuideLearner(float scale, double usual_luminance);
  ~GuideLearner();
  /// Adds the paths of a unit to the round.
  void add(const PathLog& log);
  /// Ends a round: from now on, table() and the samples of the next round use what this one
  /// learned. Cells that it did not visit keep what they had.
  /// keep  the samples of this round count in the next one, too
  void end_round(bool keep = false);
  /// Returns the table that guides by the rounds that have ended.
  [[nodiscard]] GuideTable table() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
