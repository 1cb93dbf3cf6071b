// SPDX-License-Identifier: Apache-2.0
#include "film/layers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.h"

namespace eikon {
namespace {

constexpr std::uint64_t kAnyTimes = std::numeric_limits<std::uint64_t>::max();
constexpr std::string_view kScattered = "scattered.", kLightGroup = "light.";
constexpr std::array<const char*, 3> kColours = {"R", "G", "B"};

std::uint32_t need_channel(const FilmLayout& layout, std::string_view name) {
  const auto found = std::ranges::find(layout.channels, name);
  if (found == layout.channels.end())
    throw InternalError(fmt::format("a layer needs the channel {}, which the film does not have", name));
  return static_cast<std::uint32_t>(found - layout.channels.begin());
}

std::vector<LayerChannel> each(std::string_view layer, std::string_view parts, LayerRule rule,
                               const FilmLayout& layout) {
  std::vector<LayerChannel> channels;
  for (const char part : parts) {
    const std::string name = fmt::format("{}.{}", layer, part);
    channels.push_back({name, rule, {need_channel(layout, name)}});
    if (rule == LayerRule::mean_of_hit) channels.back().film.push_back(need_channel(layout, "hits"));
  }
  return channels;
}

/// Returns the bound N of a channel "scattered.N.R", or nothing for other channels.
std::optional<std::uint64_t> bound_of(std::string_view channel) {
  if (!channel.starts_with(kScattered)) return std::nullopt;
  const std::string_view text = channel.substr(kScattered.size());
  std::uint32_t bound = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), bound);
  return code == std::errc() ? bound : kAnyTimes;
}

/// Sums the light that was scattered [least, most] times; least - 1 and most must be bounds of the
/// film.
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

std::span<const LayerInfo> layers() {
  static const std::vector<LayerInfo> all = {
      {"albedo", {"albedo"}},
      {"normal", {"normal"}},
      {"geometric_normal", {"geometric_normal"}},
      {"depth", {"depth", "hits"}},
      {"position", {"position", "hits"}},
      {"uv", {"texture_place", "hits"}},
      {"id", {"id"}},
      {"object_id", {"id"}},
      {"material_id", {"material_id"}},
      {"cryptomatte_object", {"matte_object"}},
      {"cryptomatte_material", {"matte_material"}},
      {"emission", {"scattered"}},
      {"direct", {"scattered"}},
      {"indirect", {"scattered"}},
      {"light_groups", {"light_group"}},
      {"variance", {}},
      {"samples", {}},
  };
  return all;
}

std::string layer_names() {
  std::vector<std::string_view> names;
  for (const LayerInfo& layer : layers()) names.push_back(layer.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

bool is_layer(std::string_view name) { return std::ranges::find(layers(), name, &LayerInfo::name) != layers().end(); }

std::vector<LayerChannel> layer_channels(std::string_view layer, const FilmLayout& layout) {
  if (layer == "albedo") return each(layer, "RGB", LayerRule::mean, layout);
  if (layer == "normal" || layer == "geometric_normal") return each(layer, "XYZ", LayerRule::mean, layout);
  if (layer == "depth") return each(layer, "Z", LayerRule::mean_of_hit, layout);
  if (layer == "position") return each(layer, "XYZ", LayerRule::mean_of_hit, layout);
  if (layer == "uv") return each(layer, "UV", LayerRule::mean_of_hit, layout);
  if (layer == "id" || layer == "material_id")
    return {{std::string(layer), LayerRule::word, {need_channel(layout, layer)}}};
  if (layer == "object_id") return {{"object_id", LayerRule::word, {need_channel(layout, "id")}}};
  if (layer == "emission") return scattered_between("emission.", 0, 0, layout);
  if (layer == "direct") return scattered_between("direct.", 1, 1, layout);
  if (layer == "indirect") return scattered_between("indirect.", 2, kAnyTimes, layout);
  if (layer == "light_groups") {
    std::vector<LayerChannel> channels;
    for (std::uint32_t c = 0; c < layout.channels.size(); ++c)
      if (layout.channels[c].starts_with(kLightGroup)) channels.push_back({layout.channels[c], LayerRule::mean, {c}});
    return channels;
  }
  if (layer == "samples") return {{"samples", LayerRule::samples, {}}};
  if (layer != "variance") throw InternalError(fmt::format("unknown layer {}", layer));
  std::vector<LayerChannel> channels;
  for (std::uint32_t c = 0; c < kColours.size(); ++c)
    channels.push_back({fmt::format("variance.{}", kColours[c]), LayerRule::variance, {c}});
  return channels;
}

std::vector<std::uint32_t> scatter_bounds(std::span<const std::string> layers,
                                          std::span<const std::uint32_t> depth_series) {
  std::set<std::uint32_t> bounds(depth_series.begin(), depth_series.end());
  for (const std::string& layer : layers)
    if (layer == "emission" || layer == "direct" || layer == "indirect") bounds.insert({0, 1});
  return {bounds.begin(), bounds.end()};
}

std::vector<std::string> scatter_channels(std::span<const std::uint32_t> bounds) {
  std::vector<std::string> channels;
  const auto add = [&](const std::string& bin) {
    for (const char* colour : kColours) channels.push_back(fmt::format("{}{}.{}", kScattered, bin, colour));
  };
  for (const std::uint32_t bound : bounds) add(std::to_string(bound));
  add("more");
  return channels;
}

std::vector<std::string> light_group_channels(std::span<const std::string> names) {
  std::vector<std::string> channels;
  for (const std::string& name : names)
    for (const char* colour : kColours) channels.push_back(fmt::format("{}{}.{}", kLightGroup, name, colour));
  return channels;
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
  Film partial(layout);
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
