// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/meshopt.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <array>
#include <utility>

#include "gltf/extensions.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxCount = 0xFFFFFFFFU;
constexpr std::array<const char*, 2> kExtensions{"KHR_meshopt_compression", "EXT_meshopt_compression"};

template <typename Value, std::size_t N>
Value named(const JsonView& extension, const char* key,
            const std::array<std::pair<std::string_view, Value>, N>& names) {
  const Json* text = member(extension.value, key);
  for (const auto& [name, value] : names) {
    if (equals(text, name)) return value;
  }
  std::string all;
  for (const auto& entry : names) all += (all.empty() ? "" : ", ") + std::string(entry.first);
  extension.fail(fmt::format("'{}' is none of {}", key, all));
}

bool stride_fits(const MeshoptView& view) {
  const std::uint32_t stride = view.stride_bytes;
  if (view.mode != MeshoptView::Mode::attributes) return stride == 2 || stride == 4;
  switch (view.filter) {
    case MeshoptView::Filter::octahedral:
      return stride == 4 || stride == 8;
    case MeshoptView::Filter::quaternion:
      return stride == 8;
    default:
      return stride != 0 && stride % 4 == 0;
  }
}

std::uint64_t least_bytes(const MeshoptView& view) {
  switch (view.mode) {
    case MeshoptView::Mode::attributes:
      return view.decoded_bytes() / kMeshoptExpansion;
    case MeshoptView::Mode::triangles:
      return view.count / 3;
    case MeshoptView::Mode::indices:
      return view.count;
  }
  return 0;
}

// A stream begins with the number of its codec and, in the lower half of the byte, of its version.
void refuse_newer_stream(const JsonView& extension, const MeshoptView& view) {
  const bool is_vertices = view.mode == MeshoptView::Mode::attributes;
  const unsigned newest = is_vertices ? 0 : 1;
  const unsigned version = view.compressed.empty() ? 0 : std::to_integer<unsigned>(view.compressed[0]) & 0xFU;
  if (version > newest) {
    extension.refuse(
        fmt::format("the data are of version {} of meshoptimizer's {} codec, at most {} is read; "
                    "damaged, or else export with EXT_meshopt_compression",
                    version, is_vertices ? "vertex" : "index", newest));
  }
}

int decode(const MeshoptView& view, void* out) {
  const auto* data = reinterpret_cast<const unsigned char*>(view.compressed.data());
  const std::size_t bytes = view.compressed.size();
  switch (view.mode) {
    case MeshoptView::Mode::attributes:
      return meshopt_decodeVertexBuffer(out, view.count, view.stride_bytes, data, bytes);
    case MeshoptView::Mode::triangles:
      return meshopt_decodeIndexBuffer(out, view.count, view.stride_bytes, data, bytes);
    case MeshoptView::Mode::indices:
      return meshopt_decodeIndexSequence(out, view.count, view.stride_bytes, data, bytes);
  }
  return -1;
}

}  // namespace

std::optional<JsonView> find_meshopt(const JsonView& buffer_view) {
  for (const char* name : kExtensions)
    if (const Json* found = extension_of(buffer_view.value, name))
      return JsonView{.value = *found, .kind = name, .parent = &buffer_view};
  return std::nullopt;
}

MeshoptView check_meshopt(const JsonView& extension, const Buffers& buffers) {
  using Mode = MeshoptView::Mode;
  using Filter = MeshoptView::Filter;
  if (!is_object(extension.value)) extension.fail("is not an object");
  const auto buffer = as_index(extension, "buffer", buffers.size(), "buffer");
  if (!buffer) extension.fail("'buffer' is missing");
  const std::uint64_t offset = as_integer(extension, "byteOffset", kMaxFileOffset).value_or(0),
                      length = required_integer(extension, "byteLength", kMaxFileOffset);
  const std::span<const std::byte> bytes = buffers[*buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    extension.fail(fmt::format("bytes {} to {} are outside buffer {} of {} bytes", offset, offset + length, *buffer,
                               bytes.size()));
  }
  MeshoptView view;
  view.compressed = bytes.subspan(offset, length);
  view.count = required_integer(extension, "count", kMaxCount);
  view.stride_bytes = static_cast<std::uint32_t>(required_integer(extension, "byteStride", 256));
  view.mode =
      named<Mode, 3>(extension, "mode",
                     {{{"ATTRIBUTES", Mode::attributes}, {"TRIANGLES", Mode::triangles}, {"INDICES", Mode::indices}}});
  if (const Json* filter = member(extension.value, "filter")) {
    if (equals(filter, "COLOR") && extension.kind == kExtensions[0])
      extension.refuse("'filter' COLOR is not read yet; export with EXT_meshopt_compression");
    view.filter = named<Filter, 4>(extension, "filter",
                                   {{{"NONE", Filter::none},
                                     {"OCTAHEDRAL", Filter::octahedral},
                                     {"QUATERNION", Filter::quaternion},
                                     {"EXPONENTIAL", Filter::exponential}}});
  }
  // meshoptimizer stops the program if these do not hold.
  if (view.filter != Filter::none && view.mode != Mode::attributes) extension.fail("'filter' is for ATTRIBUTES only");
  if (!stride_fits(view))
    extension.fail(fmt::format("'byteStride' {} does not fit its mode and filter", view.stride_bytes));
  if (view.mode == Mode::triangles && view.count % 3 != 0) {
    extension.fail(fmt::format("'count' {} is no whole number of triangles", view.count));
  }
  if (const std::uint64_t least = least_bytes(view); least > length) {
    extension.fail(fmt::format("{} elements cannot be in {} bytes; they take {} at least", view.count, length, least));
  }
  return view;
}

Bytes decode_meshopt(const JsonView& extension, const MeshoptView& view) {
  refuse_newer_stream(extension, view);
  const std::uint64_t size = view.decoded_bytes();
  Bytes out{.data = std::make_unique_for_overwrite<std::byte[]>(size), .size = size};
  if (const int code = size == 0 ? 0 : decode(view, out.data.get()); code != 0) {
    extension.refuse(
        fmt::format("the compressed data do not decode to {} elements of {} bytes (meshoptimizer says {}); "
                    "damaged, or of a newer codec? Export the file again",
                    view.count, view.stride_bytes, code));
  }
  switch (view.filter) {
    case MeshoptView::Filter::none:
      break;
    case MeshoptView::Filter::octahedral:
      meshopt_decodeFilterOct(out.data.get(), view.count, view.stride_bytes);
      break;
    case MeshoptView::Filter::quaternion:
      meshopt_decodeFilterQuat(out.data.get(), view.count, view.stride_bytes);
      break;
    case MeshoptView::Filter::exponential:
      meshopt_decodeFilterExp(out.data.get(), view.count, view.stride_bytes);
      break;
  }
  return out;
}

}  // namespace eikon
