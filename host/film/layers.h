// SPDX-License-Identifier: Apache-2.0
// What --aov may ask for: of which sums of the film a layer is made, and how. One list for the flag, the film and the file.
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
  std::vector<std::string_view> features;  // of kernels/shared/features.def: sums that it is made of
};

/// All layers there are, in the order in which they are told.
[[nodiscard]] std::span<const LayerInfo> layers();
/// "albedo, normal, ..."
[[nodiscard]] std::string layer_names();
[[nodiscard]] bool is_layer(std::string_view name);

/// How a channel of the written image comes from the film.
enum class LayerRule {
  mean,  // sum of the film's channels over the number of samples
  mean_of_hit,  // of the first channel, over the samples that hit something, whose number the second has; infinity where none did
  word,      // the channel's sum is an integer
  variance,  // of the mean of the channel
  samples,   // their number
};
struct LayerChannel {
  std::string name;  // in the written image: "albedo.R"
  LayerRule rule;
  std::vector<std::uint32_t> film;  // channels of the film
};

/// The channels of a layer that is no matte (mattes.h). throws InternalError when the film lacks what it is made of, or there is no such layer
[[nodiscard]] std::vector<LayerChannel> layer_channels(std::string_view layer, const FilmLayout& layout);

/// Radiance apart by how often light was scattered between its source and the camera: partial sums of the Neumann series.
/// Each bound ends a bin; a last bin has what was scattered more often. What layers and a --depth-series ask for, sorted.
inline constexpr std::uint32_t kMaxScatterBound = 30;
[[nodiscard]] std::vector<std::uint32_t> scatter_bounds(std::span<const std::string> layers,
                                                        std::span<const std::uint32_t> depth_series);
/// The film's channels for such bins, bin by bin: "scattered.0.R" up to 0 times, ... "scattered.more.B".
[[nodiscard]] std::vector<std::string> scatter_channels(std::span<const std::uint32_t> bounds);
/// The film's channels for light apart by light groups: "light.NAME.R", ...
[[nodiscard]] std::vector<std::string> light_group_channels(std::span<const std::string> names);
/// A film of R, G, B, and A where there is one, of the light alone that was scattered at most `most` times, one of the bounds.
/// throws InternalError when the film does not have that apart
[[nodiscard]] Film scattered_at_most(const Film& film, std::uint32_t most);

}  // namespace eikon
