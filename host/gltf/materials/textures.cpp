// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/textures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/extensions.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 32U;
constexpr std::uint64_t kMaxUvSet = 0xFFFFFFFFU;
constexpr const char* kTransform = "KHR_texture_transform";

// Extensions by which a texture names an image in another format than PNG and JPEG.
constexpr std::array<const char*, 4> kFormatExtensions{"KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif",
                                                       "MSFT_texture_dds"};

// Names a format that is not read, and what converts it.
const char* converter(PictureFormat format) {
  switch (format) {
    case PictureFormat::ktx2:
      return "KTX2 images (convert them to PNG with `ktx extract`)";
    case PictureFormat::webp:
      return "WebP images (convert them to PNG with `dwebp`)";
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
    case PictureFormat::unknown:
      break;
  }
  return nullptr;
}

const char* converter_of_extension(std::string_view extension) {
  if (extension == "KHR_texture_basisu") return converter(PictureFormat::ktx2);
  if (extension == "EXT_texture_webp") return converter(PictureFormat::webp);
  if (extension == "EXT_texture_avif") return converter(PictureFormat::avif);
  return converter(PictureFormat::dds);
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

}  // namespace

std::uint64_t texture_budget_bytes() {
  const std::uint64_t memory = physical_memory_bytes();
  return memory == 0 ? std::uint64_t{1} << 33U : memory / 2;
}

TextureReader::TextureReader(const TextureSource& source, Scene& scene, Digest& digest, Notes& notes)
    : source_(source), scene_(scene), digest_(digest), notes_(notes), of_image_(count_of(source.document, "images")) {}

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
  const Json& texture_json = element(items(source_.document, "textures"), index);
  const JsonView texture{.value = texture_json, .kind = "texture", .index = static_cast<std::int64_t>(index)};
  if (const Json* sampler_index = member(texture_json, "sampler")) {
    const Json& sampler = element(items(source_.document, "samplers"), to_index(*sampler_index));
    result.wrap_u = wrap_of(sampler, "wrapS");
    result.wrap_v = wrap_of(sampler, "wrapT");
    // minFilter is not read: it asks for mip maps, which spare a rasteriser its aliasing; here the
    // samples of a pixel average texels.
    const Json* filter = member(sampler, "magFilter");
    if (filter != nullptr && to_index(*filter) == 9728) result.filter = TextureFilter::nearest;
  }
  const auto image_index = image_of(texture);
  const auto image = image_index ? use_image(*image_index) : std::nullopt;
  if (!image) return std::nullopt;
  result.image = *image;
  return result;
}

// The PNG or JPEG of a texture, as an index into the document's images.
std::optional<std::size_t> TextureReader::image_of(const JsonView& texture) {
  const Json* source = member(texture.value, "source");
  for (const char* name : kFormatExtensions) {
    if (extension_of(texture.value, name) == nullptr) continue;
    if (source == nullptr) {
      notes_.unsupported(converter_of_extension(name), texture.label());
      return std::nullopt;
    }
    if (fallback_count_++ == 0) first_fallback_ = fmt::format("{}: {} is not read", texture.label(), name);
    break;
  }
  if (source == nullptr) {
    notes_.warn(texture.label() + ": left out, it has no image");
    return std::nullopt;
  }
  return to_index(*source);
}

std::optional<std::uint32_t> TextureReader::use_image(std::size_t index) {
  if (of_image_[index]) return *of_image_[index];
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
    const auto [entry, is_new] = of_file_.try_emplace(key);
    encoded.label = user;
    if (is_new) entry->second = add_image(image, std::move(name), std::move(encoded));
    of_image_[index] = entry->second;
  } catch (const InputError& e) {
    throw InputError(user + ": " + e.what());
  }
  return *of_image_[index];
}

std::optional<std::uint32_t> TextureReader::add_image(const JsonView& image, std::string name, Encoded encoded) {
  if (const char* what = converter(picture_format(encoded.bytes))) {
    notes_.unsupported(what, image.label());
    return std::nullopt;
  }
  encoded.header = read_picture_header(encoded.bytes);
  const PictureHeader& header = encoded.header;
  decoded_bytes_ += std::uint64_t{header.width} * header.height * sizeof(std::uint32_t);
  if (decoded_bytes_ > source_.budget_bytes)
    throw InputError(fmt::format(
        "with its {} x {} pixels the textures need {} MB of memory, more than the {} MB for them on this machine; "
        "scale them down",
        header.width, header.height, decoded_bytes_ >> 20U, source_.budget_bytes >> 20U));
  if (header.deep && deep_count_++ == 0) first_deep_ = encoded.label;
  scene_.images.push_back({.name = std::move(name), .width = header.width, .height = header.height, .rgba8 = {}});
  encoded_.push_back(std::move(encoded));
  return static_cast<std::uint32_t>(scene_.images.size() - 1);
}

void TextureReader::decode() {
  std::vector<std::string> errors(encoded_.size());
  tbb::parallel_for(std::size_t{0}, encoded_.size(), [&](std::size_t i) {
    Encoded encoded = std::move(encoded_[i]);  // its bytes go as soon as they are decoded
    try {
      scene_.images[i].rgba8 = decode_picture(encoded.bytes, encoded.header);
    } catch (const InputError& e) {
      errors[i] = fmt::format("{}: {}", encoded.label, e.what());
    } catch (const std::bad_alloc&) {
      errors[i] = encoded.label + ": needs more memory than there is; scale it down";
    }
  });
  encoded_.clear();
  for (const std::string& error : errors) {
    if (!error.empty()) throw InputError(error);
  }
  const auto others = [](std::size_t count) { return count > 1 ? fmt::format(" (and {} more)", count - 1) : ""; };
  if (fallback_count_ != 0)
    notes_.warn(fmt::format("{}, its PNG or JPEG is used{}", first_fallback_, others(fallback_count_)));
  if (deep_count_ != 0)
    notes_.warn(fmt::format("{}: 16 bits per channel reduced to 8{}", first_deep_, others(deep_count_)));
}

}  // namespace eikon
