// SPDX-License-Identifier: Apache-2.0
// The layers that --aov may ask for. One table says for the flag, the film and the file what each
// is made of, and how.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "film/film.h"

namespace eikon {

/// The sums that the film keeps beside R, G and B: EK_AOV of kernels/shared/features.def, and the
/// two mattes, which are counted instead of summed (mattes.h).
enum class FilmSum {
#define EK_AOV(name, channels) name,
#include "shared/features.def"
  matte_object,
  matte_material,
};

/// How a channel of the written image comes from the film.
enum class LayerRule {
  mean,         // sum of the film's channels over the number of samples
  mean_of_hit,  // of the first channel, over the hits that the second channel counts; infinity if there are none
  word,         // the channel's sum is an integer
  variance,     // of the mean of the channel
  samples,      // their number
};

struct LayerInfo {
  std::string_view name;
  std::optional<FilmSum> sum;  // that it is made of; mean_of_hit takes hit_count besides
  LayerRule rule;
  std::string_view letters;  // of its channels, as in normal.X, normal.Y, normal.Z; none: the only channel has its name
  std::uint64_t least_bounces = 0, most_bounces = 0;  // of light in a layer made of bounce_bins
};

/// All layers, in the order in which help lists them.
[[nodiscard]] std::span<const LayerInfo> layers();
/// "albedo, normal, ..."
[[nodiscard]] std::string layer_names();
[[nodiscard]] bool is_layer(std::string_view name);
/// True if one of the layers is made of that sum.
[[nodiscard]] bool needs_sum(std::span<const std::string> layers, FilmSum sum);

struct LayerChannel {
  std::string name;  // in the written image: "albedo.R"
  LayerRule rule;
  std::vector<std::uint32_t> film;  // channels of the film
};

/// The channels of a layer that is no matte.
/// throws InternalError when the film lacks what the layer is made of, or there is no such layer
[[nodiscard]] std::vector<LayerChannel> layer_channels(std::string_view layer, const FilmLayout& layout);

/// The bounds of the bins that layers and a --depth-series ask for, sorted. Radiance is kept apart
/// by how often light was scattered between its source and the camera (partial sums of the Neumann
/// series); each bound ends a bin, and a last bin has what was scattered more often.
inline constexpr std::uint32_t kMaxScatterBound = 30;
[[nodiscard]] std::vector<std::uint32_t> scatter_bounds(std::span<const std::string> layers,
                                                        std::span<const std::uint32_t> depth_series);
/// The film's channels of a sum that is no matte: "albedo.R", ... bounce_bins are "scattered.0.R"
/// for light scattered at most 0 times, ... "scattered.more.B"; light_group "light.NAME.R", ...
[[nodiscard]] std::vector<std::string> film_channels_of(FilmSum sum, std::span<const std::uint32_t> scatter_bounds,
                                                        std::span<const std::string> light_groups);
/// The most times that the light of a channel "scattered.N.R" was scattered; nothing for other
/// channels.
[[nodiscard]] std::optional<std::uint64_t> bound_of(std::string_view channel);
/// The channels for what light paths bring to those of a film that hold radiance.
[[nodiscard]] std::vector<std::string> splat_channels_of(std::span<const std::string> channels);
/// A film of R, G, B (and A if `film` has it) that has only the light scattered at most `most`
/// times, which is one of the bounds. throws InternalError when the film does not keep that light
/// apart
[[nodiscard]] Film scattered_at_most(const Film& film, std::uint32_t most);

}  // namespace eikon
