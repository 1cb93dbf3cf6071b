// SPDX-License-Identifier: Apache-2.0
// The layers that --aov can name, the sums of the film from which each is made, and the rule. The
// flag, the film and the file share this one list.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "film/film.h"

namespace eikon {

struct LayerInfo {
  std::string_view name;
  std::vector<std::string_view> features;  // of kernels/shared/features.def: the sums that it needs
};

/// All layers, in the order in which help lists them.
[[nodiscard]] std::span<const LayerInfo> layers();
/// "albedo, normal, ..."
[[nodiscard]] std::string layer_names();
[[nodiscard]] bool is_layer(std::string_view name);

/// The rule by which a channel of the written image comes from the film.
enum class LayerRule {
  mean,  // sum of the film's channels over the number of samples
  // Sum of the first channel over the number of samples that hit something, which is the second
  // channel; infinity where none did.
  mean_of_hit,
  word,      // the channel's sum is an integer
  variance,  // variance of the mean of the channel
  samples,   // number of samples
};
struct LayerChannel {
  std::string name;  // in the written image: "albedo.R"
  LayerRule rule;
  std::vector<std::uint32_t> film;  // channels of the film
};

/// The channels of a layer that is not a matte (mattes.h).
/// throws InternalError when there is no such layer, or the film lacks its sums
[[nodiscard]] std::vector<LayerChannel> layer_channels(std::string_view layer, const FilmLayout& layout);

/// The bounds of bins that separate radiance by the number of scatterings between source and camera
/// (partial sums of the Neumann series). Each bound ends a bin; a last bin has all light that was
/// scattered more often. The bounds are those of the layers and of --depth-series, sorted.
inline constexpr std::uint32_t kMaxScatterBound = 30;
[[nodiscard]] std::vector<std::uint32_t> scatter_bounds(std::span<const std::string> layers,
                                                        std::span<const std::uint32_t> depth_series);
/// The film's channels for these bins, bin by bin: "scattered.0.R" (unscattered) to
/// "scattered.more.B".
[[nodiscard]] std::vector<std::string> scatter_channels(std::span<const std::uint32_t> bounds);
/// The film's channels for light groups: "light.NAME.R", ...
[[nodiscard]] std::vector<std::string> light_group_channels(std::span<const std::string> names);
/// Returns a film of R, G, B (and A) with only the light that was scattered at most `most` times.
/// throws InternalError unless `most` is one of the film's bounds
[[nodiscard]] Film scattered_at_most(const Film& film, std::uint32_t most);

}  // namespace eikon
