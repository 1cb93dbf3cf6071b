// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/textures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/extensions.h"
#include "gltf/materials/scratch_share.h"
#include "io/text.h"
#include "scene/scene_memory.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 32U;
constexpr std::uint64_t kMaxUvSet = 0xFFFFFFFFU;
constexpr const char* kTransform = "KHR_texture_transform";

// Extensions by which a texture names an image in another format than PNG and JPEG, those that are
// read first.
constexpr std::array<const char*, 2> kReadExtensions{"EXT_texture_webp", "KHR_texture_basisu"};
constexpr std::array<const char*, 2> kOtherExtensions{"EXT_texture_avif", "MSFT_texture_dds"};

// Names a format that is not read, and what converts it.
const char* converter(PictureFormat format) {
  switch (format) {
    case PictureFormat::avif:
      return "AVIF images (convert them to PNG with `avifdec`)";
    case PictureFormat::dds:
      return "DDS images (convert them to PNG with `magick`)";
    case PictureFormat::gif:
      return "GIF images (convert them to PNG with `magick`)";
    case PictureFormat::bmp:
      return "BMP images (convert them to PNG with `magick`)";
    case PictureFormat::tiff:
      return "TIFF images (convert them to PNG with `magick`)";
    case PictureFormat::openexr:
      return "OpenEXR images (convert them to PNG with `oiiotool`)";
    case PictureFormat::radiance:
      return "Radiance images (convert them to PNG with `oiiotool`)";
    case PictureFormat::png:
    case PictureFormat::jpeg:
    case PictureFormat::webp:
    case PictureFormat::ktx2:
    case PictureFormat::unknown:
      break;
  }
  return nullptr;
}

const char* converter_of_extension(std::string_view extension) {
  return converter(extension == "EXT_texture_avif" ? PictureFormat::avif : PictureFormat::dds);
}

Wrap wrap_of(const Json& sampler, const char* key) {
  switch (const Json* value = member(sampler, key); value == nullptr ? 10497 : to_index(*value)) {
    case 33071:
      return Wrap::clamp;
    case 33648:
      return Wrap::mirror;
    default:
      return Wrap::repeat;
  }
}

// Translation x rotation x scale. The rotation is counter-clockwise as seen with v down, like the
// extension's text and its example have it; the GLSL beside them turns the other way.
void set_transform(const JsonView& view, Texture& texture) {
  const auto pair = [&](const char* key, double otherwise) {
    const Json* value = member(view.value, key);
    return value == nullptr ? glm::dvec2(otherwise) : glm::dvec2(number_at(*value, 0), number_at(*value, 1));
  };
  const glm::dvec2 offset = pair("offset", 0.0), scale = pair("scale", 1.0);
  const double angle = as_number(view, "rotation").value_or(0.0), c = std::cos(angle), s = std::sin(angle);
  texture.image_from_uv[0] = glm::vec3(scale.x * c, scale.y * s, offset.x);
  texture.image_from_uv[1] = glm::vec3(-scale.x * s, scale.y * c, offset.y);
  for (const glm::vec3& row : texture.image_from_uv) {
    if (!std::isfinite(row.x) || !std::isfinite(row.y) || !std::isfinite(row.z))
      view.refuse("goes beyond single precision; use smaller values");
  }
}

[[noreturn]] void refuse_fallback(const std::string& damage, const std::string& why) {
  throw InputError(fmt::format("{}; its PNG or JPEG cannot take its place: {}", damage, why));
}

}  // namespace

std::uint64_t texture_budget_bytes() {
  const std::uint64_t memory = usable_memory_bytes();
  return memory == 0 ? std::uint64_t{1} << 33U : memory / 2;
}

TextureReader::TextureReader(const TextureSource& source, Scene& scene, Digest& digest, Notes& notes)
    : source_(source),
      scene_(scene),
      digest_(digest),
      notes_(notes),
      of_image_(count_of(source.document, "images")) {}

std::optional<Texture> TextureReader::find(const JsonView& owner, const char* key, bool srgb) {
  const Json* info = member(owner.value, key);
  if (info == nullptr) return std::nullopt;
  const JsonView view{.value = *info, .kind = key, .parent = &owner};
  Texture result;
  result.srgb = srgb;
  result.uv_set = static_cast<std::uint32_t>(as_integer(view, "texCoord", kMaxUvSet).value_or(0));
  note_unsupported_extensions(*info, ExtensionOwner::texture_info, view.label(), notes_);
  if (const Json* extension = extension_of(*info, kTransform)) {
    const JsonView transform{.value = *extension, .kind = kTransform, .parent = &view};
    if (const auto set = as_integer(transform, "texCoord", kMaxUvSet)) result.uv_set = static_cast<std::uint32_t>(*set);
    set_transform(transform, result);
  }
  if (result.uv_set > 1) {
    notes_.unsupported(fmt::format("texture coordinates TEXCOORD_{}", result.uv_set), view.label());
    return std::nullopt;
  }
  const std::size_t index = to_index(*member(*info, "index"));
  check_part("texture", index);
  const Json& texture_json = element(items(source_.document, "textures"), index);
  const JsonView texture{.value = texture_json, .kind = "texture", .index = static_cast<std::int64_t>(index)};
  if (const Json* sampler_index = member(texture_json, "sampler")) {
    check_part("sampler", to_index(*sampler_index));
    const Json& sampler = element(items(source_.document, "samplers"), to_index(*sampler_index));
    result.wrap_u = wrap_of(sampler, "wrapS");
    result.wrap_v = wrap_of(sampler, "wrapT");
    // minFilter is not read: it asks for mip maps, which spare a rasteriser its aliasing; here the
    // samples of a pixel average texels.
    const Json* filter = member(sampler, "magFilter");
    if (filter != nullptr && to_index(*filter) == 9728) result.filter = TextureFilter::nearest;
  }
  const auto image = image_of(texture);
  if (!image) return std::nullopt;
  result.image = *image;
  return result;
}

void TextureReader::check_part(const char* kind, std::size_t index) const {
  if (source_.wrong != nullptr) source_.wrong->check(kind, index);
}

// An index into scene_.images.
std::optional<std::uint32_t> TextureReader::image_of(const JsonView& texture) {
  const Json* source = member(texture.value, "source");
  for (const char* name : kReadExtensions) {
    if (member(extension_of(texture.value, name), "source") == nullptr) continue;
    if (const auto image = image_of_extension(texture, name)) return image;
    if (source == nullptr) return std::nullopt;
  }
  for (const char* name : kOtherExtensions) {
    if (extension_of(texture.value, name) == nullptr) continue;
    if (source == nullptr) {
      notes_.unsupported(converter_of_extension(name), texture.label());
      return std::nullopt;
    }
    if (fallback_count_++ == 0) first_fallback_ = fmt::format("{}: {} is not read", texture.label(), name);
  }
  if (source == nullptr) {
    notes_.warn(texture.label() + ": left out, it has no image");
    return std::nullopt;
  }
  const std::size_t index = to_index(*source);
  const Use& use = use_image(index);
  if (!use.image) notes_.unsupported(use.missing, fmt::format("image {}", index));
  return use.image;
}

// Nothing for an image that cannot be read, which is said.
std::optional<std::uint32_t> TextureReader::image_of_extension(const JsonView& texture, const char* name) {
  const JsonView extension{.value = *extension_of(texture.value, name), .kind = name, .parent = &texture};
  const std::size_t index = *as_index(extension, "source", of_image_.size(), "image");
  const bool has_fallback = member(texture.value, "source") != nullptr;
  std::string why;
  try {
    const Use& use = use_image(index);
    if (use.image && has_fallback)
      fallbacks_.try_emplace(*use.image, Fallback{.image = to_index(*member(texture.value, "source")),
                                                  .user = fmt::format("{}: {}", texture.label(), name)});
    if (use.image) return use.image;
    why = use.missing;
  } catch (const InputError& e) {
    if (!has_fallback) throw;
    why = e.what();
  }
  if (has_fallback)
    say_fallback(fmt::format("{}: {}", texture.label(), name), why);
  else
    notes_.unsupported(why, fmt::format("image {}", index));
  return std::nullopt;
}

void TextureReader::say_fallback(const std::string& user, const std::string& why) {
  if (fallback_count_++ == 0) first_fallback_ = fmt::format("{} is not read: {}", user, why);
}

const TextureReader::Use& TextureReader::use_image(std::size_t index) {
  if (of_image_[index]) return *of_image_[index];
  check_part("image", index);
  const Json& json = element(items(source_.document, "images"), index);
  const JsonView image{.value = json, .kind = "image", .index = static_cast<std::int64_t>(index)};
  const Json *uri = member(json, "uri"), *view = member(json, "bufferView");
  if ((uri == nullptr) == (view == nullptr)) image.fail("has not exactly one of 'uri' and 'bufferView'");
  Encoded encoded;
  std::string key, name = image.label(), user = image.label();
  try {
    if (view != nullptr) {
      encoded.bytes = source_.views[to_index(*view)];
      key = fmt::format("view:{}", to_index(*view));
    } else if (const std::string& text = to_string(*uri); is_data_uri(text)) {
      encoded.owned = decode_data_uri(text);
      encoded.bytes = encoded.owned.span();
      key = fmt::format("data:{}", index);
    } else {
      const std::filesystem::path file = resolve_uri(source_.folder, text);
      name = in_quotes(text);
      user = fmt::format("image {} {}", index, in_quotes(text));
      key = "file:" + file.string();
      if (const auto found = of_file_.find(key); found == of_file_.end()) {
        encoded.owned = read_regular_file(file, kMaxFileBytes);
        encoded.bytes = encoded.owned.span();
        digest_.add(encoded.bytes);
      }
    }
    encoded.label = user;
    encoded.source = key;
    auto entry = of_file_.find(key);
    if (entry == of_file_.end()) entry = of_file_.emplace(key, add_image(std::move(name), std::move(encoded))).first;
    of_image_[index] = entry->second;
  } catch (const InputError& e) {
    throw InputError(user + ": " + e.what());
  }
  return *of_image_[index];
}

TextureReader::Use TextureReader::add_image(std::string name, Encoded encoded) {
  if (const char* what = converter(picture_format(encoded.bytes))) return {.missing = what};
  encoded.header = read_picture_header(encoded.bytes);
  const PictureHeader& header = encoded.header;
  take_memory(std::uint64_t{header.width} * header.height, header.scratch_bytes);
  if (header.deep && deep_count_++ == 0) first_deep_ = encoded.label;
  scene_.images.push_back({.name = std::move(name), .width = header.width, .height = header.height, .rgba8 = {}});
  encoded_.push_back(std::move(encoded));
  return {.image = static_cast<std::uint32_t>(scene_.images.size() - 1)};
}

void TextureReader::take_memory(std::uint64_t pixels, std::uint64_t scratch_bytes) {
  const std::uint64_t bytes = decoded_bytes_ + pixels * sizeof(std::uint32_t),
                      scratch = std::max(largest_scratch_bytes_, scratch_bytes);
  if (const std::uint64_t needed = bytes + scratch; needed > source_.budget_bytes)
    throw InputError(
        fmt::format("with its {} pixels the textures need {} MB of memory, more than the {} MB for them on this "
                    "machine; scale them down",
                    pixels, needed >> 20U, source_.budget_bytes >> 20U));
  decoded_bytes_ = bytes;
  largest_scratch_bytes_ = scratch;
}

void TextureReader::give_back_memory(const TextureImage& image) {
  decoded_bytes_ -= std::uint64_t{image.width} * image.height * sizeof(std::uint32_t);
}

Texture TextureReader::roughness_of(const Texture& glossy, float glossiness) {
  Texture result = glossy;
  result.srgb = false;
  const auto known = std::ranges::find_if(
      roughness_, [&](const Roughness& made) { return made.glossy == glossy.image && made.glossiness == glossiness; });
  if (known != roughness_.end()) {
    result.image = known->image;
    return result;
  }
  const TextureImage& from = scene_.images[glossy.image];
  take_memory(std::uint64_t{from.width} * from.height, 0);
  result.image = static_cast<std::uint32_t>(scene_.images.size());
  roughness_.push_back({.image = result.image, .glossy = glossy.image, .glossiness = glossiness});
  scene_.images.push_back(
      {.name = "the roughness of " + from.name, .width = from.width, .height = from.height, .rgba8 = {}});
  encoded_.emplace_back();
  return result;
}

void TextureReader::decode() {
  replace_damaged(decode_images(0));
  make_roughness();
  const auto others = [](std::size_t count) { return count > 1 ? fmt::format(" (and {} more)", count - 1) : ""; };
  if (fallback_count_ != 0)
    notes_.warn(fmt::format("{}, its PNG or JPEG is used{}", first_fallback_, others(fallback_count_)));
  if (deep_count_ != 0)
    notes_.warn(fmt::format("{}: 16 bits per channel reduced to 8{}", first_deep_, others(deep_count_)));
}

std::vector<std::string> TextureReader::decode_images(std::size_t first) {
  ScratchShare scratch(source_.budget_bytes - decoded_bytes_);
  std::vector<std::string> damages(encoded_.size() - first), refusals(encoded_.size() - first);
  tbb::parallel_for(first, encoded_.size(), [&](std::size_t i) {
    Encoded encoded = std::move(encoded_[i]);  // its bytes go as soon as they are decoded
    if (encoded.header.format == PictureFormat::unknown) return;
    try {
      auto texels = scene_.memory == nullptr ? std::nullopt : scene_.memory->image(encoded.source);
      if (!texels) {
        scratch.with(encoded.header.scratch_bytes,
                     [&] { texels.emplace(decode_picture(encoded.bytes, encoded.header)); });
        if (scene_.memory != nullptr) scene_.memory->keep_image(encoded.source, *texels);
      }
      scene_.images[i].rgba8 = *std::move(texels);
    } catch (const InputError& e) {
      damages[i - first] = fmt::format("{}: {}", encoded.label, e.what());
    } catch (const std::bad_alloc&) {
      refusals[i - first] = encoded.label + ": needs more memory than there is; scale it down";
    }
  });
  for (const std::string& refusal : refusals)
    if (!refusal.empty()) throw InputError(refusal);
  return damages;
}

// Textures know images by their indices, so a fallback moves to the index of the image that it
// replaces.
void TextureReader::replace_damaged(const std::vector<std::string>& damages) {
  std::map<std::uint32_t, std::uint32_t> fallback_of;  // both are indices into scene_.images
  for (std::uint32_t i = 0; i < damages.size(); ++i)
    if (!damages[i].empty()) fallback_of.emplace(i, add_fallback(i, damages[i]));
  std::vector<std::string> all = damages;
  for (std::string& damage : decode_images(damages.size())) all.push_back(std::move(damage));
  for (const auto& [damaged, fallback] : fallback_of) {
    if (!all[fallback].empty()) refuse_fallback(damages[damaged], all[fallback]);
    TextureImage image = scene_.images[fallback];
    scene_.images[damaged] = std::move(image);
  }
  scene_.images.resize(damages.size());
  encoded_.clear();
}

// Returns its index in scene_.images, where it stands behind those that textures have.
std::uint32_t TextureReader::add_fallback(std::uint32_t damaged, const std::string& damage) {
  const auto known = fallbacks_.find(damaged);
  if (known == fallbacks_.end()) throw InputError(damage);
  const auto each_roughness = [&](const auto& action) {
    for (const Roughness& made : roughness_)
      if (made.glossy == damaged) action(made);
  };
  give_back_memory(scene_.images[damaged]);
  each_roughness([&](const Roughness& made) { give_back_memory(scene_.images[made.image]); });
  Use use;
  try {
    use = use_image(known->second.image);
    if (!use.image) throw InputError(fmt::format("image {}: {} are not read", known->second.image, use.missing));
    const TextureImage& image = scene_.images[*use.image];
    each_roughness([&](const Roughness&) { take_memory(std::uint64_t{image.width} * image.height, 0); });
  } catch (const InputError& e) {
    refuse_fallback(damage, e.what());
  }
  say_fallback(known->second.user, damage);
  return *use.image;
}

void TextureReader::make_roughness() {
  for (const Roughness& made : roughness_) {
    TextureImage& image = scene_.images[made.image];
    image.width = scene_.images[made.glossy].width;
    image.height = scene_.images[made.glossy].height;
    const std::vector<std::uint32_t>& glossy = scene_.images[made.glossy].rgba8;
    std::vector<std::uint32_t>& rough = image.rgba8.edit();
    rough.resize(glossy.size());
    for (std::size_t i = 0; i < glossy.size(); ++i) {
      const float roughness = 255.0F - made.glossiness * static_cast<float>(glossy[i] >> 24U);
      rough[i] = 0xFF000000U | static_cast<std::uint32_t>(std::lround(roughness)) << 8U;
    }
  }
}

}  // namespace eikon
