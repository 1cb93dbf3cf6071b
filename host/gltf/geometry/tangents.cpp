// SPDX-License-Identifier: Apache-2.0
// Names of the paper: T is texture space (s, t) = (u, -v), so that t goes up in the image;
// `s_direction` is its "vOs".
#include "gltf/geometry/tangents.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/error.h"

namespace eikon {
namespace {

using Index = std::uint32_t;
constexpr Index kNone = 0xFFFFFFFFU;

bool is_not_zero(double x) { return std::abs(x) > static_cast<double>(std::numeric_limits<float>::min()); }

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return is_not_zero(length) ? v / length : glm::dvec3(0.0);
}

glm::dvec3 in_plane(const glm::dvec3& v, const glm::dvec3& normal) {
  return unit_or_zero(v - glm::dot(normal, v) * normal);
}

// Corner c belongs to triangle c / 3; these are the next and the previous corner in it.
Index next_corner(Index c) { return c % 3 == 2 ? c - 2 : c + 1; }
Index last_corner(Index c) { return c % 3 == 0 ? c + 2 : c - 1; }

/// The texture coordinates that tangents follow, by vertex.
struct TextureCoordinates {
  const SharedVector<glm::vec2>& uv;
  std::array<float, 4> image_from_uv;
};

/// The primitive as triangles with a position, a normal and a texture coordinate at each corner.
class Corners {
 public:
  Corners(const Primitive& primitive, const TriangleIndices& indices, const TextureCoordinates& texture)
      : primitive_(primitive), indices_(indices), texture_(texture), flat_(primitive.normals_object.empty()) {}

  [[nodiscard]] Index count() const { return static_cast<Index>(indices_.size()); }
  [[nodiscard]] Index vertex(Index c) const { return indices_[c]; }
  [[nodiscard]] bool flat() const { return flat_; }
  [[nodiscard]] const glm::vec3& position(Index c) const { return primitive_.positions_object[vertex(c)]; }
  [[nodiscard]] glm::vec2 uv(Index c) const {
    const glm::vec2& uv = texture_.uv[vertex(c)];
    const std::array<float, 4>& map = texture_.image_from_uv;
    return {map[0] * uv.x + map[1] * uv.y, map[2] * uv.x + map[3] * uv.y};
  }
  [[nodiscard]] glm::vec3 normal(Index c) const {
    if (!flat_) return primitive_.normals_object[vertex(c)];
    const Index first = c / 3 * 3;
    const glm::dvec3 p(position(first));
    return glm::vec3(
        unit_or_zero(glm::cross(glm::dvec3(position(first + 1)) - p, glm::dvec3(position(first + 2)) - p)));
  }

 private:
  const Primitive& primitive_;
  const TriangleIndices& indices_;
  TextureCoordinates texture_;
  bool flat_;
};

/// Gives corners of equal position, normal and texture coordinates the same number.
class Weld {
 public:
  explicit Weld(const Corners& corners) : corners_(corners) {
    // One corner stands for each vertex, unless the normals belong to the triangles.
    std::vector<Index> sample;
    if (corners.flat()) {
      sample.resize(corners.count());
      std::iota(sample.begin(), sample.end(), Index{0});
    } else {
      for (Index c = 0; c < corners.count(); ++c) {
        if (corners.vertex(c) >= sample.size()) sample.resize(corners.vertex(c) + 1, kNone);
        if (sample[corners.vertex(c)] == kNone) sample[corners.vertex(c)] = c;
      }
    }
    std::vector<Index> order(sample.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::erase_if(order, [&](Index i) { return sample[i] == kNone; });
    tbb::parallel_sort(order.begin(), order.end(), [&](Index a, Index b) {
      const Key key_a = key(sample[a]), key_b = key(sample[b]);
      return key_a != key_b ? key_a < key_b : a < b;
    });
    number_.resize(sample.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i == 0 || key(sample[order[i]]) != key(sample[order[i - 1]])) ++count_;
      number_[order[i]] = count_ - 1;
    }
  }

  [[nodiscard]] Index operator[](Index c) const { return number_[corners_.flat() ? c : corners_.vertex(c)]; }
  [[nodiscard]] Index count() const { return count_; }

 private:
  using Key = std::array<float, 8>;
  [[nodiscard]] Key key(Index c) const {
    const glm::vec3 &p = corners_.position(c), n = corners_.normal(c);
    const glm::vec2& t = corners_.uv(c);
    return {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y};
  }

  const Corners& corners_;
  std::vector<Index> number_;
  Index count_ = 0;
};

/// One run of the algorithm. Numbers of corners double as names of edges: edge c goes from corner c
/// to the next. Groups are those of the mesh at rest, and directions those of its pose.
class Tangents {
 public:
  /// posed   with the vertices at the corners that `rest` has
  /// turned  per triangle, empty if none is: its corners go the other way round in its pose
  Tangents(const Corners& rest, const Corners& posed, const std::vector<bool>& turned)
      : corners_(rest), posed_(posed), turned_(turned), weld_(rest) {
    classify();
    find_neighbours();
    find_groups();
    fill_gaps();
  }

  [[nodiscard]] const glm::vec4& operator[](Index c) const { return tangents_[group_of_corner_[c]]; }
  /// The group of a corner. The same in all poses.
  [[nodiscard]] Index group(Index c) const { return group_of_corner_[c]; }

 private:
  // A `loose` triangle has no direction of its own in the texture and joins any group. Of a
  // `collapsed` one two corners coincide.
  struct Kind {
    bool preserves_orientation = false, loose = true, collapsed = false;
  };

  void classify() {
    kinds_.resize(corners_.count() / 3);
    for (Index f = 0; f < kinds_.size(); ++f) {
      const Index c = 3 * f;
      const glm::vec3 &a = corners_.position(c), &b = corners_.position(c + 1), &d = corners_.position(c + 2);
      Kind& kind = kinds_[f];
      kind.collapsed = a == b || b == d || d == a;
      const auto [area, s, t] = derivatives(corners_, f);
      kind.preserves_orientation = area > 0;
      const bool has_area = is_not_zero(area);
      kind.loose =
          !has_area || !is_not_zero(glm::length(s) / std::abs(area)) || !is_not_zero(glm::length(t) / std::abs(area));
    }
  }

  struct Derivatives {
    double area;      // twice, signed, in the texture
    glm::dvec3 s, t;  // of the position by s and t, times `area`
  };
  [[nodiscard]] static Derivatives derivatives(const Corners& corners, Index f) {
    const Index c = 3 * f;
    const glm::dvec3 p(corners.position(c));
    const glm::dvec3 d1 = glm::dvec3(corners.position(c + 1)) - p, d2 = glm::dvec3(corners.position(c + 2)) - p;
    const glm::dvec2 uv(corners.uv(c));
    glm::dvec2 t1 = glm::dvec2(corners.uv(c + 1)) - uv, t2 = glm::dvec2(corners.uv(c + 2)) - uv;
    t1.y = -t1.y, t2.y = -t2.y;
    return {.area = t1.x * t2.y - t1.y * t2.x, .s = t2.y * d1 - t1.y * d2, .t = t1.x * d2 - t2.x * d1};
  }

  // Two triangles are neighbours over an edge that they pass in opposite directions. Where more
  // than two meet, the first in the file's order pair up.
  void find_neighbours() {
    neighbour_.assign(corners_.count(), kNone);
    std::vector<Index> start(std::size_t{weld_.count()} + 1, 0), edges;
    const auto low = [&](Index c) { return std::min(weld_[c], weld_[next_corner(c)]); };
    const auto high = [&](Index c) { return std::max(weld_[c], weld_[next_corner(c)]); };
    const auto for_each_edge = [&](auto action) {
      for (Index c = 0; c < corners_.count(); ++c) {
        if (!kinds_[c / 3].collapsed) action(c);
      }
    };
    for_each_edge([&](Index c) { ++start[low(c) + 1]; });
    std::partial_sum(start.begin(), start.end(), start.begin());
    edges.resize(start.back());
    std::vector<Index> fill(start.begin(), start.end() - 1);
    for_each_edge([&](Index c) { edges[fill[low(c)]++] = c; });
    std::vector<Index> waiting;
    for (Index v = 0; v < weld_.count(); ++v) {
      const auto begin = edges.begin() + start[v], end = edges.begin() + start[v + 1];
      std::sort(begin, end, [&](Index a, Index b) { return high(a) != high(b) ? high(a) < high(b) : a < b; });
      for (auto run = begin; run != end;) {
        const Index other = high(*run);
        std::size_t first = 0;
        waiting.clear();  // edges from `first` on have no neighbour yet; all go the same way
        for (; run != end && high(*run) == other; ++run) {
          if (first < waiting.size() && (weld_[waiting[first]] == v) != (weld_[*run] == v)) {
            neighbour_[*run] = waiting[first];
            neighbour_[waiting[first++]] = *run;
          } else {
            waiting.push_back(*run);
          }
        }
      }
    }
  }

  void find_groups() {
    group_of_corner_.assign(corners_.count(), kNone);
    for (Index c = 0; c < corners_.count(); ++c) {
      const Kind& kind = kinds_[c / 3];
      if (kind.collapsed || kind.loose || group_of_corner_[c] != kNone) continue;
      const bool orientation = kind.preserves_orientation;
      const glm::dvec3 sum = gather(c, orientation);
      add_tangent(sum, c, orientation);
    }
  }

  // Groups all corners around a vertex that can be reached over edges without a change of
  // orientation, and returns the weighted sum of their directions.
  glm::dvec3 gather(Index seed, bool orientation) {
    const auto group = static_cast<Index>(tangents_.size());
    const Index vertex = weld_[seed];
    glm::dvec3 sum(0.0);
    stack_.assign(1, seed);
    while (!stack_.empty()) {
      const Index c = stack_.back();
      stack_.pop_back();
      if (group_of_corner_[c] != kNone) continue;
      Kind& kind = kinds_[c / 3];
      if (kind.loose && is_free(c / 3)) kind.preserves_orientation = orientation;
      if (kind.preserves_orientation != orientation) continue;
      group_of_corner_[c] = group;
      if (!kind.loose) sum += weighted_direction(c);
      for (const Index edge : {neighbour_[c], neighbour_[last_corner(c)]}) {
        if (edge == kNone) continue;
        // The edge comes towards the vertex on one side and leaves it on the other.
        stack_.push_back(weld_[edge] == vertex ? edge : next_corner(edge));
      }
    }
    return sum;
  }

  // True if no group has a corner of a triangle yet.
  [[nodiscard]] bool is_free(Index f) const {
    return group_of_corner_[3 * f] == kNone && group_of_corner_[3 * f + 1] == kNone &&
           group_of_corner_[3 * f + 2] == kNone;
  }

  [[nodiscard]] glm::dvec3 weighted_direction(Index c) const {
    const Derivatives derivative = derivatives(posed_, c / 3);
    const glm::dvec3 normal(posed_.normal(c)), p(posed_.position(c));
    const glm::dvec3 s = in_plane(unit_or_zero(derivative.s) * (derivative.area > 0 ? 1.0 : -1.0), normal);
    const glm::dvec3 to_last = in_plane(glm::dvec3(posed_.position(last_corner(c))) - p, normal);
    const glm::dvec3 to_next = in_plane(glm::dvec3(posed_.position(next_corner(c))) - p, normal);
    return std::acos(std::clamp(glm::dot(to_last, to_next), -1.0, 1.0)) * s;
  }

  void add_tangent(const glm::dvec3& direction, Index corner, bool orientation) {
    const glm::dvec3 normal(posed_.normal(corner));
    if (!turned_.empty() && turned_[corner / 3]) orientation = !orientation;
    // The reference code leaves the x axis where there is no direction; a normal map needs one
    // beside the normal.
    glm::dvec3 tangent = unit_or_zero(direction);
    for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)}) {
      if (tangent == glm::dvec3(0.0) && std::abs(glm::dot(axis, normal)) < 0.999) tangent = in_plane(axis, normal);
    }
    tangents_.emplace_back(glm::vec3(tangent), orientation ? 1.0F : -1.0F);
  }

  // Gives tangents to corners that no group has reached: those of collapsed or loose triangles.
  void fill_gaps() {
    std::vector<Index> good_corner(weld_.count(), kNone);
    for (Index c = corners_.count(); c-- > 0;) {
      if (!kinds_[c / 3].collapsed) good_corner[weld_[c]] = c;
    }
    for (const bool collapsed : {false, true}) {
      for (Index c = 0; c < corners_.count(); ++c) {
        if (group_of_corner_[c] != kNone || kinds_[c / 3].collapsed != collapsed) continue;
        if (collapsed && good_corner[weld_[c]] != kNone) {
          group_of_corner_[c] = group_of_corner_[good_corner[weld_[c]]];
          continue;
        }
        group_of_corner_[c] = static_cast<Index>(tangents_.size());
        add_tangent(glm::dvec3(0.0), c, true);
      }
    }
  }

  const Corners& corners_;  // at rest
  const Corners& posed_;
  const std::vector<bool>& turned_;
  Weld weld_;
  std::vector<Kind> kinds_;       // per triangle
  std::vector<Index> neighbour_;  // per edge: the same edge of the next triangle, or kNone
  std::vector<Index> group_of_corner_;
  std::vector<glm::vec4> tangents_;
  std::vector<Index> stack_;
};

template <typename T>
void repeat(SharedVector<T>& shared, const std::vector<Index>& which) {
  if (shared.empty() || which.empty()) return;
  std::vector<T>& values = shared.edit();
  values.reserve(values.size() + which.size());
  for (const Index i : which) values.push_back(values[i]);
}

/// The triangles whose corners go the other way round than at rest; empty if none do.
std::vector<bool> turned_triangles(const TriangleIndices& at_rest, const TriangleIndices& posed) {
  std::vector<bool> turned;
  for (Index f = 0; f < at_rest.triangle_count(); ++f) {
    if (at_rest[3 * f + 1] == posed[3 * f + 1]) continue;
    turned.resize(at_rest.triangle_count());
    turned[f] = true;
  }
  return turned;
}

}  // namespace

void mark_tangents(Primitive& primitive) {
  if (primitive.indices.size() >= kNone) throw InputError("a mesh of more than 2^32 corners; split it");
  primitive.tangents_object.assign(primitive.positions_object.size(), glm::vec4(0.0F));
}

void make_tangents(Primitive& primitive, const TangentSource& source, const Primitive* at_rest) {
  if (primitive.indices.size() >= kNone) throw InputError("a mesh of more than 2^32 corners; split it");
  const Primitive& shape = at_rest != nullptr ? *at_rest : primitive;
  const TextureCoordinates texture{primitive.uv[source.uv_set], source.image_from_uv};
  const Corners corners(shape, shape.indices, texture), posed(primitive, shape.indices, texture);
  const std::vector<bool> turned = turned_triangles(shape.indices, primitive.indices);
  const Tangents tangents(corners, posed, turned);

  // Corners of a vertex in the same group stay together; the first group keeps its number.
  std::vector<Index> order(corners.count());
  std::iota(order.begin(), order.end(), Index{0});
  tbb::parallel_sort(order.begin(), order.end(), [&](Index a, Index b) {
    if (corners.vertex(a) != corners.vertex(b)) return corners.vertex(a) < corners.vertex(b);
    return tangents.group(a) != tangents.group(b) ? tangents.group(a) < tangents.group(b) : a < b;
  });
  const std::size_t vertex_count = primitive.positions_object.size();
  std::vector<Index> split, new_index(corners.count());
  std::vector<glm::vec4> result(vertex_count);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Index c = order[i], vertex = corners.vertex(c);
    if (i == 0 || vertex != corners.vertex(order[i - 1])) {
      new_index[c] = vertex;
      result[vertex] = tangents[c];
    } else if (tangents.group(c) == tangents.group(order[i - 1])) {
      new_index[c] = new_index[order[i - 1]];
    } else {
      if (vertex_count + split.size() >= kNone) throw InputError("a mesh of more than 2^32 vertices; split it");
      new_index[c] = static_cast<Index>(vertex_count + split.size());
      split.push_back(vertex);
      result.push_back(tangents[c]);
    }
  }
  for (Index f = 0; f < turned.size(); ++f)
    if (turned[f]) std::swap(new_index[3 * f + 1], new_index[3 * f + 2]);
  primitive.indices = std::move(new_index);
  repeat(primitive.positions_object, split);
  repeat(primitive.normals_object, split);
  repeat(primitive.uv[0], split);
  repeat(primitive.uv[1], split);
  repeat(primitive.colors, split);
  primitive.tangents_object = std::move(result);
}

}  // namespace eikon
