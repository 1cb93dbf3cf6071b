// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/draco_mesh.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "core/error.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr int kTriangleList = 4, kTriangleStrip = 5;
// The most triangles and numbers that a stream is believed to hold: some, however small it is, and
// more for each byte. The library allocates what a header claims. Scanned and modelled meshes have
// about one triangle per byte; flat regular grids have some hundreds, and two million of these are
// free.
constexpr std::uint64_t kFreeTriangles = std::uint64_t{1} << 21U, kTrianglesPerByte = 64;
constexpr std::uint64_t kFreeNumbers = std::uint64_t{1} << 26U, kNumbersPerByte = 256;
constexpr int kMaxStreamAttributes = 32;
constexpr std::uint64_t kMaxId = 0xFFFFFFFFU;

/// Reads the head of a stream [Draco bitstream 2.2, sections 3 to 6] as far as the number of
/// triangles.
class Head {
 public:
  explicit Head(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::uint64_t triangle_count() {
    constexpr std::string_view kMagic = "DRACO";
    for (const char c : kMagic) {
      if (byte() != static_cast<unsigned char>(c)) throw InputError("are no Draco stream; export the file again");
    }
    const unsigned major = byte(), minor = byte(), type = byte(), method = byte();
    const unsigned flags = byte() | byte() << 8U;
    if (major != 2 || minor != 2) {
      throw InputError(
          fmt::format("are a Draco stream of version {}.{}; glTF has 2.2, export the file again", major, minor));
    }
    if (type != 1 || method > 1) throw InputError("are a Draco stream without triangles; export the file again");
    if ((flags & 0x8000U) != 0) skip_metadata();
    if (method == 0) return varint();  // sequential: triangles, points
    byte();                            // edgebreaker: kind of traversal, vertices, triangles
    varint();
    return varint();
  }

 private:
  unsigned byte() {
    if (at_ == bytes_.size()) throw InputError("are a truncated Draco stream; copy the file again");
    return std::to_integer<unsigned>(bytes_[at_++]);
  }
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      const unsigned next = byte();
      value |= static_cast<std::uint64_t>(next & 0x7FU) << shift;
      if (next < 0x80U) return value;
    }
    throw InputError("are a damaged Draco stream: a number that does not end; export the file again");
  }
  void skip(std::uint64_t count) {
    if (count > bytes_.size() - at_) throw InputError("are a truncated Draco stream; copy the file again");
    at_ += count;
  }
  // Metadata are names and values in a tree, parents first, so a walk has to know only how many
  // nodes are left to read.
  void skip_metadata() {
    const std::uint64_t attributes = varint();
    for (std::uint64_t i = 0; i <= attributes; ++i) {  // the last one is of the whole mesh
      if (i < attributes) varint();
      for (std::uint64_t nodes = 1, first = 1; nodes != 0; first = 0) {
        --nodes;
        if (first == 0) skip(byte());
        for (std::uint64_t entries = varint(); entries != 0; --entries) {
          skip(byte());
          skip(varint());
        }
        nodes += varint();
      }
    }
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

std::optional<ComponentType> component_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return ComponentType::i8;
    case draco::DT_UINT8:
      return ComponentType::u8;
    case draco::DT_INT16:
      return ComponentType::i16;
    case draco::DT_UINT16:
      return ComponentType::u16;
    case draco::DT_UINT32:
      return ComponentType::u32;
    case draco::DT_FLOAT32:
      return ComponentType::f32;
    default:
      return std::nullopt;
  }
}

/// A mesh that looks at each attribute before the library gives it memory.
class GuardedMesh : public draco::Mesh {
 public:
  GuardedMesh(std::uint64_t position_count, std::uint64_t max_numbers)
      : position_count_(position_count), max_numbers_(max_numbers) {}

  void SetAttribute(int id, std::unique_ptr<draco::PointAttribute> attribute) override {
    if (num_points() != position_count_) {
      throw InputError(fmt::format("hold {} vertices where the accessor of POSITION says {}; export the file again",
                                   num_points(), position_count_));
    }
    numbers_ += static_cast<std::uint64_t>(attribute->num_components()) * position_count_;
    if (id >= kMaxStreamAttributes || numbers_ > max_numbers_) {
      throw InputError(
          fmt::format("claim {} numbers in {} attributes, more than so few bytes hold; export the file "
                      "again",
                      numbers_, id + 1));
    }
    Mesh::SetAttribute(id, std::move(attribute));
  }

 private:
  std::uint64_t position_count_, max_numbers_, numbers_ = 0;
};

// Whatever Draco's own code and the checks inside it throw becomes one line about the extension.
void decode_stream(const JsonView& view, std::span<const std::byte> bytes, std::uint64_t triangles, draco::Mesh& mesh) {
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const draco::Status status = draco::Decoder().DecodeBufferToGeometry(&buffer, &mesh);
    if (!status.ok()) {
      throw InputError("do not decode (Draco says: " + one_line(status.error_msg_string()) +
                       "); damaged? Export the file again");
    }
    if (mesh.num_faces() != triangles) throw InputError("hold other triangles than they announce; damaged?");
  } catch (const InputError& e) {
    view.refuse(std::string("its data ") + e.what());
  } catch (const std::bad_alloc&) {
    view.refuse("its data need more memory than there is; split the mesh");
  } catch (const std::exception& e) {
    view.refuse("its data do not decode (" + one_line(e.what()) + "); damaged? Export the file again");
  }
}

std::uint64_t announced_triangles(const JsonView& view, std::span<const std::byte> bytes) {
  try {
    return Head(bytes).triangle_count();
  } catch (const InputError& e) {
    view.refuse(std::string("its data ") + e.what());
  }
}

// A copy of an attribute of the stream, one element per point, in the form that the file's accessor
// announces.
Accessor copy_attribute(const JsonView& view, const draco::Mesh& mesh, std::uint32_t id, const Accessor& announced,
                        Bytes& storage) {
  const draco::PointAttribute* source = mesh.GetAttributeByUniqueId(id);
  if (source == nullptr) view.fail(fmt::format("the stream holds no attribute {} for {}", id, announced.label));
  if (announced.sparse_count != 0) view.fail(announced.label + " is sparse, which the extension forbids");
  if (announced.count != mesh.num_points()) {
    view.fail(fmt::format("{} has {} elements, the stream {}", announced.label, announced.count, mesh.num_points()));
  }
  const bool same_type = component_of(source->data_type()) == announced.component && !announced.is_matrix;
  if (!same_type || static_cast<std::uint32_t>(source->num_components()) != announced.component_count) {
    view.fail(fmt::format("the stream holds {} components of another type than {} says",
                          static_cast<int>(source->num_components()), announced.label));
  }
  Accessor copy = announced;
  const std::uint64_t bytes = announced.element_bytes();
  storage.size = bytes * mesh.num_points();
  storage.data = std::make_unique_for_overwrite<std::byte[]>(storage.size);
  for (std::uint32_t point = 0; point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex value = source->mapped_index(draco::PointIndex(point));
    if (value.value() >= source->size()) view.fail("the stream names a value that it does not hold");
    std::memcpy(storage.data.get() + point * bytes, source->GetAddress(value), bytes);
  }
  copy.data = storage.data.get();
  copy.stride_bytes = static_cast<std::uint32_t>(bytes);
  return copy;
}

}  // namespace

double draco_decoder_bytes(std::uint64_t triangles, std::uint64_t vertices, std::size_t attributes,
                           std::uint64_t numbers) {
  const auto of_attributes = static_cast<double>(attributes);
  return static_cast<double>(triangles) * (44 + 12 * of_attributes) +
         static_cast<double>(vertices) * (8 * of_attributes + 8 * static_cast<double>(numbers));
}

DracoMesh DracoDecoder::decode(const JsonView& view, const GltfPrimitive& primitive) {
  if (!is_object(view.value)) view.fail("is not an object");
  const auto buffer_view = as_index(view, "bufferView", views_.size(), "bufferView");
  const Json* attributes = as_object(view, "attributes");
  if (!buffer_view || attributes == nullptr) view.fail("'bufferView' or 'attributes' is missing");
  const auto positions = primitive.attributes.find("POSITION");
  if (positions == primitive.attributes.end() || !primitive.indices || member(attributes, "POSITION") == nullptr) {
    view.fail("needs 'indices', and POSITION in the attributes of the primitive and of the extension");
  }
  const int mode = primitive.mode;
  if (mode != kTriangleList && mode != kTriangleStrip) view.fail("compresses triangles and triangle strips only");
  const std::uint64_t position_count = accessors_[positions->second].count,
                      index_count = accessors_[*primitive.indices].count;

  const std::span<const std::byte> bytes = views_[*buffer_view];
  const std::uint64_t triangles = announced_triangles(view, bytes);
  // A strip of n corners has n - 2 triangles; a list has to be of the length that it says.
  if (mode == kTriangleList ? triangles != index_count / 3 || index_count % 3 != 0 : triangles > index_count) {
    view.fail(fmt::format("the stream holds {} triangles where the accessor of the indices has {} elements", triangles,
                          index_count));
  }
  triangles_claimed_ += triangles;
  decoded_.file_bytes += bytes.size();
  if (triangles_claimed_ > kFreeTriangles + kTrianglesPerByte * decoded_.file_bytes) {
    view.refuse(
        fmt::format("the stream claims {} triangles in {} bytes, more than so few are believed to hold; damaged, or "
                    "else export the mesh without Draco",
                    triangles, bytes.size()));
  }
  GuardedMesh mesh(position_count, kFreeNumbers + kNumbersPerByte * bytes.size());
  decode_stream(view, bytes, triangles, mesh);
  if (mesh.num_points() != position_count) view.fail("the stream holds no vertices");

  DracoMesh result;
  result.indices.reserve(3 * triangles);
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(f))) {
      if (corner.value() >= position_count) view.fail("the stream names a vertex that it does not hold");
      result.indices.push_back(corner.value());
    }
  }
  for (const JsonMember& entry : members(attributes)) {
    const auto announced = primitive.attributes.find(entry.key);
    if (announced == primitive.attributes.end()) continue;  // of no attribute of the primitive
    if (!is_index(entry.value, kMaxId + 1)) view.fail(in_quotes(entry.key) + " is no attribute of a stream");
    result.storage.emplace_back();
    result.attributes[entry.key] = copy_attribute(view, mesh, static_cast<std::uint32_t>(to_index(entry.value)),
                                                  accessors_[announced->second], result.storage.back());
    decoded_.unpacked_bytes += result.storage.back().size;
  }
  decoded_.unpacked_bytes += result.indices.size() * sizeof(std::uint32_t);
  const auto decoder_bytes = static_cast<std::uint64_t>(expected_bytes(view.value, primitive));
  decoded_.decoder_bytes = std::max(decoded_.decoder_bytes, decoder_bytes);
  return result;
}

double DracoDecoder::expected_bytes(const Json& extension, const GltfPrimitive& primitive) const {
  const auto positions = primitive.attributes.find("POSITION");
  const Json* view = member(extension, "bufferView");
  if (positions == primitive.attributes.end() || !primitive.indices || view == nullptr ||
      !is_index(*view, views_.size()))
    return 0;
  const std::uint64_t bytes = views_[to_index(*view)].size(), vertices = accessors_[positions->second].count,
                      triangles = accessors_[*primitive.indices].count / 3;
  std::uint64_t numbers = 0;
  for (const auto& entry : primitive.attributes) numbers += accessors_[entry.second].component_count;
  return draco_decoder_bytes(std::min(triangles, kFreeTriangles + kTrianglesPerByte * bytes),
                             std::min(vertices, kFreeNumbers + kNumbersPerByte * bytes), primitive.attributes.size(),
                             numbers);
}

}  // namespace eikon
