// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/buffer_views.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/extensions.h"
#include "gltf/geometry/meshopt.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxStride = 252;

std::vector<bool> views_of_accessors(const Json& document) {
  std::vector<bool> used(items(document, "bufferViews").size(), false);
  const auto use = [&](const Json* owner) {
    const Json* view = owner == nullptr ? nullptr : member(*owner, "bufferView");
    if (view == nullptr || !view->is_number_unsigned()) return;
    if (const auto index = view->get<std::uint64_t>(); index < used.size()) used[index] = true;
  };
  for (const Json& accessor : items(document, "accessors")) {
    use(&accessor);
    const Json* sparse = member(accessor, "sparse");
    if (sparse == nullptr) continue;
    use(member(*sparse, "indices"));
    use(member(*sparse, "values"));
  }
  return used;
}

void check_fits(const JsonView& compression, const MeshoptView& source, std::uint64_t length, std::uint64_t stride) {
  if (source.decoded_bytes() != length) {
    compression.fail(fmt::format("{} elements of {} bytes are not the {} bytes of the bufferView", source.count,
                                 source.stride_bytes, length));
  }
  if (stride != 0 && stride != source.stride_bytes) {
    compression.fail(fmt::format("'byteStride' {} is not the {} of the bufferView", source.stride_bytes, stride));
  }
}

}  // namespace

Buffers::Buffers(Json& document, const Container& container, const std::filesystem::path& folder) {
  if (items(document, "buffers").empty()) return;
  const std::uint64_t memory = usable_memory_bytes();
  std::uint64_t total = 0;
  Json& list = document["buffers"];
  for (std::size_t i = 0; i < list.size(); ++i) {
    const JsonView place{.value = list[i], .kind = "buffer", .index = static_cast<std::int64_t>(i)};
    std::uint64_t length = required_integer(place, "byteLength", kMaxFileOffset);
    std::span<const std::byte> bytes;
    try {
      if (auto uri = list[i].find("uri"); uri == list[i].end()) {
        if (i == 0 && container.has_binary)
          bytes = container.binary;
        else
          length = 0;
      } else if (auto& text = uri->get_ref<std::string&>(); is_data_uri(text)) {
        decoded_.push_back(decode_data_uri(text));
        std::string().swap(text);  // an assignment would keep its memory
        bytes = decoded_.back().span();
      } else {
        const std::filesystem::path file = resolve_uri(folder, text);
        try {
          files_.push_back(read_regular_file(file, kMaxFileOffset));
        } catch (const InputError& e) {
          throw InputError(fmt::format("file {} {}", in_quotes(text), e.what()));
        }
        bytes = files_.back().span();
        total += bytes.size();
        if (memory != 0 && total > memory)
          throw InputError(fmt::format("the files add up to more than the memory, {} bytes", memory));
      }
    } catch (const InputError& e) {
      place.refuse(e.what());
    }
    if (length > bytes.size()) {
      place.refuse(fmt::format("'byteLength' is {}, but there are only {} bytes; truncated? Copy the file again",
                               length, bytes.size()));
    }
    views_.push_back(bytes.first(length));
  }
}

// Honest files compress each piece of data once; views that share a piece may not multiply it
// without end.
std::span<const std::byte> BufferViews::decompress(const JsonView& compression, const MeshoptView& source) {
  const std::uint64_t memory = usable_memory_bytes();
  compressed_bytes_ += source.compressed.size();
  decompressed_bytes_ += source.decoded_bytes();
  if (decompressed_bytes_ / kMeshoptExpansion > file_bytes_ || (memory != 0 && decompressed_bytes_ > memory)) {
    compression.refuse(
        fmt::format("the bufferViews decompress to {} bytes, more than the memory or {} times the "
                    "file; split the scene",
                    decompressed_bytes_, kMeshoptExpansion));
  }
  decompressed_.push_back(decode_meshopt(compression, source));
  return decompressed_.back().span();
}

BufferViews::BufferViews(const Json& document, const Buffers& buffers, WrongParts& wrong, Notes& notes)
    : wrong_(wrong) {
  const Json& list = items(document, "bufferViews");
  const std::vector<bool> used = views_of_accessors(document);
  for (std::size_t i = 0; i < buffers.size(); ++i) file_bytes_ += buffers[i].size();
  views_.reserve(list.size());
  std::string odd_stride;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const JsonView place{.value = list[i], .kind = "bufferView", .index = static_cast<std::int64_t>(i)};
    const auto buffer = required_integer(place, "buffer", buffers.size() - 1);
    const std::uint64_t offset = as_integer(place, "byteOffset", kMaxFileOffset).value_or(0),
                        length = required_integer(place, "byteLength", kMaxFileOffset),
                        stride = as_integer(place, "byteStride", kMaxStride).value_or(0);
    if (stride % 4 != 0 && odd_stride.empty())
      odd_stride = fmt::format("{}: 'byteStride' {} is not a multiple of 4; read as it is", place.label(), stride);
    View view{.bytes = {}, .stride_bytes = static_cast<std::uint32_t>(stride)};
    if (const auto compression = find_meshopt(place)) {
      const MeshoptView source = check_meshopt(*compression, buffers);
      check_fits(*compression, source, length, stride);
      if (used[i]) view.bytes = decompress(*compression, source);
    } else if (!buffers.has_bytes(buffer)) {
      wrong.add(place, fmt::format("{}: buffer {} has neither a URI nor the binary chunk of a .glb; export the file "
                                   "again",
                                   place.label(), buffer));
    } else {
      const std::span<const std::byte> bytes = buffers[buffer];
      if (offset > bytes.size() || length > bytes.size() - offset) {
        place.fail(fmt::format("bytes {} to {} are outside buffer {} of {} bytes", offset, offset + length, buffer,
                               bytes.size()));
      }
      view.bytes = bytes.subspan(offset, length);
    }
    views_.push_back(view);
  }
  if (!odd_stride.empty()) notes.mended(odd_stride);
}

}  // namespace eikon
