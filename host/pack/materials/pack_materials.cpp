// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <span>
#include <type_traits>

#include "core/error.h"
#include "image/srgb.h"
#include "pack/lights/pack_light_paths.h"
#include "pack/materials/material_parameters.h"
#include "pack/pack_parts.h"
#include "scene/measured_table.h"
#include "shared/light_target.h"

namespace eikon {
namespace {

// Stands for log2 of a transmittance of 0. It absorbs everything within any distance, but nothing
// at distance 0, where minus infinity would give 0 * infinity.
constexpr double kOpaque = -0x1p100;

std::span<const std::uint32_t> texel_table() {
  static const auto table = [] {
    std::array<std::uint32_t, EK_TEXEL_TABLE> words{};
    for (int code = 0; code < int(EK_TEXEL_TABLE); ++code)
      words[std::size_t(code)] = std::bit_cast<std::uint32_t>(float(linear_from_srgb(code / 255.0)));
    return words;
  }();
  return table;
}

std::uint32_t texture_flags(const Texture& texture) {
  std::uint32_t flags = 0;
  if (texture.srgb) flags |= EK_TEXTURE_SRGB;
  if (texture.filter == TextureFilter::nearest) flags |= EK_TEXTURE_NEAREST;
  if (texture.uv_set == 1) flags |= EK_TEXTURE_UV1;
  if (texture.wrap_u != Wrap::repeat) flags |= texture.wrap_u == Wrap::clamp ? EK_TEXTURE_CLAMP_U : EK_TEXTURE_MIRROR_U;
  if (texture.wrap_v != Wrap::repeat) flags |= texture.wrap_v == Wrap::clamp ? EK_TEXTURE_CLAMP_V : EK_TEXTURE_MIRROR_V;
  return flags;
}

class MaterialPacker {
 public:
  MaterialPacker(const Scene& scene, const Features& features, PackedScene& packed)
      : scene_(scene), features_(features), packed_(packed) {}

  void pack() {
    for (const Material& material : scene_.materials) {
      packed_.materials.push_back(record(material));
      if (features_.has(Feature::material_extension)) packed_.material_extensions.push_back(extension(material));
      if (features_.has(Feature::material_detail)) packed_.material_details.push_back(detail(material));
    }
    if (packed_.materials.empty()) packed_.materials.emplace_back();
    if (features_.has(Feature::nested_media)) {
      const std::vector<std::uint32_t> ranks = medium_ranks(scene_);
      for (std::uint32_t i = 0; i < ranks.size(); ++i) {
        packed_.material_extensions[i].medium_rank = ranks[i];
        if (ranks[i] != 0) packed_.material_extensions[ranks[i] - 1].medium_of_rank = i;
      }
    }
  }

 private:
  MaterialRecord record(const Material& m) {
    auto r = parameters_of<MaterialRecord>(m);
    if (!m.unlit) r.emission_r = m.emission.x, r.emission_g = m.emission.y, r.emission_b = m.emission.z;
    r.flags = 1U << std::uint32_t(lobe_of(m)) | (m.double_sided ? EK_MATERIAL_DOUBLE_SIDED : 0) |
              (m.unlit ? EK_MATERIAL_UNLIT : 0) | (m.alpha_mode == AlphaMode::mask ? EK_MATERIAL_MASK : 0) |
              (m.alpha_mode == AlphaMode::blend ? EK_MATERIAL_BLEND : 0) | (is_solid(m) ? EK_MATERIAL_SOLID : 0) |
              (is_light_target(m) ? EK_MATERIAL_LIGHT_TARGET : 0) |
              (is_glossy_light_target(m) ? EK_MATERIAL_GLOSSY_TARGET : 0);
    return r;
  }

  MaterialExtension extension(const Material& m) {
    auto e = parameters_of<MaterialExtension>(m);
    if (m.solid && m.attenuation_distance > 0 && std::isfinite(m.attenuation_distance)) {
      const auto absorption = [&](float color) {
        return float(std::max(kOpaque, std::log2(double(color)) / double(m.attenuation_distance)));
      };
      e.absorption_r = absorption(m.attenuation_color.x);
      e.absorption_g = absorption(m.attenuation_color.y);
      e.absorption_b = absorption(m.attenuation_color.z);
    }
    if (m.measured) e.measured_table = first_word(*m.measured);
    return e;
  }

  MaterialDetail detail(const Material& m) {
    auto d = parameters_of<MaterialDetail>(m);
    d.thin_film_least_nm = m.thin_film_thickness_nm[0], d.thin_film_most_nm = m.thin_film_thickness_nm[1];
    d.anisotropy_cos = float(std::cos(m.anisotropy_rotation_rad));
    d.anisotropy_sin = float(std::sin(m.anisotropy_rotation_rad));
    // [KHR_materials_dispersion]: half the difference of the index between the Fraunhofer lines F
    // and C.
    d.spread = m.ior > 1 ? float(0.025 * double(m.dispersion) * (double(m.ior) - 1)) : 0.0F;
    return d;
  }

  /// A record with the parameters that the scene has, and otherwise 0.
  template <class Record>
  Record parameters_of(const Material& m) {
    std::array<std::uint32_t, sizeof(Record) / 4> words{};
    ParametersOf<Record>::visit([&](auto parameter, std::size_t word) {
      if constexpr (std::is_same_v<decltype(parameter), MaterialTexture>) {
        words[word] = texture(m.*parameter.of, parameter.scale == nullptr ? 1.0F : m.*parameter.scale);
      } else {
        const auto& value = m.*parameter;
        std::memcpy(&words[word], &value, sizeof value);
      }
    });
    return std::bit_cast<Record>(words);
  }

  std::uint32_t texture(const std::optional<Texture>& use, float scale) {
    if (!use) return EK_NO_TEXTURE;
    const TextureImage& image = scene_.images.at(use->image);
    TextureRecord r{};
    r.first_texel = first_texel(use->image);
    r.width = image.width;
    r.height = image.height;
    r.flags = texture_flags(*use);
    const glm::vec3 &u = use->image_from_uv[0], &v = use->image_from_uv[1];
    r.u_u = u.x, r.u_v = u.y, r.u_1 = u.z;
    r.v_u = v.x, r.v_v = v.y, r.v_1 = v.z;
    r.scale = scale;
    packed_.textures.push_back(r);
    return std::uint32_t(packed_.textures.size() - 1);
  }

  std::uint32_t first_texel(std::uint32_t image) {
    const auto known = first_texel_of_.find(image);
    if (known != first_texel_of_.end()) return known->second;
    return first_texel_of_[image] = append(scene_.images[image].rgba8);
  }

  std::uint32_t first_word(const MeasuredTable& table) {
    const auto known = first_word_of_.find(&table);
    if (known != first_word_of_.end()) return known->second;
    return first_word_of_[&table] = append(table.words);
  }

  std::uint32_t append(const std::vector<std::uint32_t>& words) {
    if (packed_.texels.empty()) packed_.texels.push_back(texel_table());
    const std::uint64_t first = packed_.texel_count();
    if (first + words.size() > std::uint64_t{0xffffffff})
      throw InputError(fmt::format("{}: the textures and tables are more than 2^32 texels; use smaller images",
                                   scene_.path.string()));
    packed_.texels.emplace_back(words);
    return std::uint32_t(first);
  }

  const Scene& scene_;
  const Features& features_;
  PackedScene& packed_;
  std::map<std::uint32_t, std::uint32_t> first_texel_of_;  // by image
  std::map<const MeasuredTable*, std::uint32_t> first_word_of_;
};

}  // namespace

void pack_materials(const Scene& scene, const Features& features, PackedScene& packed) {
  MaterialPacker(scene, features, packed).pack();
}

}  // namespace eikon
