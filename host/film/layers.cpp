// SPDX-License-Identifier: Apache-2.0
#include "film/layers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.h"
#include "film/mattes.h"

namespace eikon {
namespace {

constexpr std::uint64_t kAnyTimes = std::numeric_limits<std::uint64_t>::max();
constexpr std::string_view kScattered = "scattered.", kLightGroup = "light.", kHitCount = "hits";
constexpr std::array<const char*, 3> kColours = {"R", "G", "B"};

std::uint32_t need_channel(const FilmLayout& layout, std::string_view name) {
  const auto found = std::ranges::find(layout.channels, name);
  if (found == layout.channels.end())
    throw InternalError(fmt::format("a layer needs the channel {}, which the film does not have", name));
  return static_cast<std::uint32_t>(found - layout.channels.begin());
}

/// The first layer that is made of a sum, which names the film's channels of the sum.
const LayerInfo& row_of(FilmSum sum) {
  const auto layer = std::ranges::find(layers(), sum, &LayerInfo::sum);
  if (layer == layers().end()) throw InternalError("a sum of the film that no layer is made of");
  return *layer;
}

std::vector<std::string> channels_of(const LayerInfo& layer) {
  if (layer.letters.empty()) return {std::string(layer.name)};
  std::vector<std::string> channels;
  for (const char letter : layer.letters) channels.push_back(fmt::format("{}.{}", layer.name, letter));
  return channels;
}

/// Channels of light that was scattered [least, most] times. The film's bounds must include least -
/// 1 and most.
std::vector<LayerChannel> scattered_between(std::string_view prefix, std::uint64_t least, std::uint64_t most,
                                            const FilmLayout& layout) {
  std::vector<LayerChannel> channels;
  for (const char* colour : kColours) {
    LayerChannel channel{fmt::format("{}{}", prefix, colour), LayerRule::mean, {}};
    for (std::uint32_t c = 0; c < layout.channels.size(); ++c) {
      const std::optional<std::uint64_t> bound = bound_of(layout.channels[c]);
      if (bound && *bound >= least && *bound <= most && layout.channels[c].ends_with(colour)) channel.film.push_back(c);
    }
    if (channel.film.empty())
      throw InternalError(
          fmt::format("the film does not have light apart that was scattered {} to {} times", least, most));
    channels.push_back(std::move(channel));
  }
  return channels;
}

}  // namespace

std::optional<std::uint64_t> bound_of(std::string_view channel) {
  if (!channel.starts_with(kScattered)) return std::nullopt;
  const std::string_view text = channel.substr(kScattered.size());
  std::uint32_t bound = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), bound);
  return code == std::errc() ? bound : kAnyTimes;
}

std::vector<std::string> splat_channels_of(std::span<const std::string> channels) {
  std::vector<std::string> splats;
  for (const std::string& name : channels)
    if (std::ranges::find(kColours, name) != kColours.end() || name.starts_with(kScattered) || name.starts_with(kLightGroup))
      splats.push_back(fmt::format("{}{}", kSplats, name));
  return splats;
}

std::span<const LayerInfo> layers() {
  using enum LayerRule;
  static constexpr LayerInfo kLayers[] = {
      {"albedo", FilmSum::albedo, mean, "RGB"},
      {"normal", FilmSum::normal, mean, "XYZ"},
      {"geometric_normal", FilmSum::geometric_normal, mean, "XYZ"},
      {"depth", FilmSum::depth, mean_of_hit, "Z"},
      {"position", FilmSum::position, mean_of_hit, "XYZ"},
      {"uv", FilmSum::texcoord, mean_of_hit, "UV"},
      {"motion", FilmSum::motion, mean, "XY"},
      {"id", FilmSum::id, word, ""},
      {"object_id", FilmSum::id, word, ""},
      {"material_id", FilmSum::material_id, word, ""},
      {"cryptomatte_object", FilmSum::matte_object, word, ""},
      {"cryptomatte_material", FilmSum::matte_material, word, ""},
      {"emission", FilmSum::bounce_bins, mean, "RGB", 0, 0},
      {"direct", FilmSum::bounce_bins, mean, "RGB", 1, 1},
      {"indirect", FilmSum::bounce_bins, mean, "RGB", 2, kAnyTimes},
      {"light_groups", FilmSum::light_group, mean, "RGB"},
      {"variance", std::nullopt, variance, "RGB"},
      {"samples", std::nullopt, samples, ""},
  };
  return kLayers;
}

std::string layer_names() {
  std::vector<std::string_view> names;
  for (const LayerInfo& layer : layers()) names.push_back(layer.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

bool is_layer(std::string_view name) { return std::ranges::find(layers(), name, &LayerInfo::name) != layers().end(); }

bool needs_sum(std::span<const std::string> asked, FilmSum sum) {
  return std::ranges::any_of(layers(), [&](const LayerInfo& layer) {
    const bool made_of_it = layer.sum == sum || (sum == FilmSum::hit_count && layer.rule == LayerRule::mean_of_hit);
    return made_of_it && std::ranges::find(asked, layer.name) != asked.end();
  });
}

std::vector<LayerChannel> layer_channels(std::string_view name, const FilmLayout& layout) {
  const auto layer = std::ranges::find(layers(), name, &LayerInfo::name);
  if (layer == layers().end() || is_matte(name))
    throw InternalError(fmt::format("unknown layer {}", name));
  if (layer->sum == FilmSum::bounce_bins)
    return scattered_between(fmt::format("{}.", name), layer->least_bounces, layer->most_bounces, layout);
  std::vector<LayerChannel> channels;
  if (layer->sum == FilmSum::light_group) {
    for (std::uint32_t c = 0; c < layout.channels.size(); ++c)
      if (layout.channels[c].starts_with(kLightGroup)) channels.push_back({layout.channels[c], layer->rule, {c}});
    return channels;
  }
  const std::vector<std::string> names = channels_of(*layer);
  const std::vector<std::string> sums = layer->sum ? channels_of(row_of(*layer->sum)) : names;
  for (std::uint32_t c = 0; c < names.size(); ++c) {
    LayerChannel& channel = channels.emplace_back(LayerChannel{names[c], layer->rule, {}});
    if (layer->rule == LayerRule::variance) channel.film.push_back(c);
    if (layer->sum) channel.film.push_back(need_channel(layout, sums[c]));
    if (layer->rule == LayerRule::mean_of_hit) channel.film.push_back(need_channel(layout, kHitCount));
  }
  return channels;
}

std::vector<std::uint32_t> scatter_bounds(std::span<const std::string> layers,
                                          std::span<const std::uint32_t> depth_series) {
  std::set<std::uint32_t> bounds(depth_series.begin(), depth_series.end());
  for (const std::string& layer : layers)
    if (layer == "emission" || layer == "direct" || layer == "indirect") bounds.insert({0, 1});
  return {bounds.begin(), bounds.end()};
}

std::vector<std::string> film_channels_of(FilmSum sum, std::span<const std::uint32_t> bounds,
                                          std::span<const std::string> light_groups) {
  if (sum == FilmSum::hit_count) return {std::string(kHitCount)};
  if (sum == FilmSum::coverage) return {"A"};
  std::vector<std::string> channels;
  const auto add = [&](std::string_view prefix, std::string_view bin) {
    for (const char* colour : kColours) channels.push_back(fmt::format("{}{}.{}", prefix, bin, colour));
  };
  if (sum == FilmSum::bounce_bins) {
    for (const std::uint32_t bound : bounds) add(kScattered, std::to_string(bound));
    add(kScattered, "more");
    return channels;
  }
  if (sum == FilmSum::light_group) {
    for (const std::string& name : light_groups) add(kLightGroup, name);
    return channels;
  }
  return channels_of(row_of(sum));
}

Film scattered_at_most(const Film& film, std::uint32_t most) {
  const FilmLayout& from = film.layout();
  FilmLayout layout = from;
  layout.channels = {"R", "G", "B"};
  layout.mattes.clear();
  std::vector<LayerChannel> parts = scattered_between("", 0, most, from);
  if (const auto alpha = film.channel_index("A")) {
    layout.channels.emplace_back("A");
    parts.push_back({"A", LayerRule::mean, {*alpha}});
  }
  // Each of these has a channel of splats, too, if the film has them.
  for (std::size_t c = 0, count = parts.size(); c < count; ++c) {
    LayerChannel splats{fmt::format("{}{}", kSplats, parts[c].name), LayerRule::mean, {}};
    for (const std::uint32_t channel : parts[c].film)
      if (const auto of = film.channel_index(fmt::format("{}{}", kSplats, from.channels[channel])))
        splats.film.push_back(*of);
    if (splats.film.empty()) continue;
    layout.channels.push_back(splats.name);
    parts.push_back(std::move(splats));
  }
  Film partial(layout);
  for (const LightPathCount& count : film.light_paths()) partial.add_light_paths(count);
  const Crop& crop = from.crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      for (std::uint32_t r = 0; r < from.replicates; ++r) {
        partial.set_count(x, y, r, film.count(x, y, r));
        for (std::uint32_t c = 0; c < parts.size(); ++c) {
          int128 sum = 0;
          for (const std::uint32_t channel : parts[c].film)
            if (__builtin_add_overflow(sum, film.sum(x, y, r, channel), &sum))
              throw InputError(fmt::format("film: the partial sums of pixel {},{} are beyond 2^63", x, y));
          partial.set(x, y, r, c, sum);
        }
      }
  return partial;
}

}  // namespace eikon
