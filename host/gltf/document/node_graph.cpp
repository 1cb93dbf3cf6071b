// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/node_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gltf/extensions.h"
#include "scene/limits.h"
#include "scene/transform.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::size_t kNoParent = ~std::size_t{0};
// Nodes that share children can multiply without end.
constexpr std::size_t kMaxRepeatedNodes = std::size_t{1} << 16U;

using Nodes = std::vector<GltfNode>;

std::string name_of(const Nodes& nodes, std::size_t node) { return nodes[node].view.label(); }

// The search is depth first with an explicit stack. An edge to a node that is still open closes a
// loop.
void refuse_loops(const Nodes& nodes) {
  enum class State : unsigned char { unseen, open, done };
  struct Entry {
    std::size_t node, next_child;
  };
  std::vector<State> state(nodes.size(), State::unseen);
  std::vector<Entry> stack;
  for (std::size_t start = 0; start < nodes.size(); ++start) {
    if (state[start] != State::unseen) continue;
    stack.push_back({.node = start, .next_child = 0});
    state[start] = State::open;
    while (!stack.empty()) {
      Entry& top = stack.back();
      const GltfNode& node = nodes[top.node];
      if (top.next_child == node.children.size()) {
        state[top.node] = State::done;
        stack.pop_back();
        continue;
      }
      const std::size_t child = node.children[top.next_child++];
      if (state[child] == State::unseen) {
        state[child] = State::open;
        stack.push_back({.node = child, .next_child = 0});
      } else if (state[child] == State::open) {
        auto entry = std::find_if(stack.begin(), stack.end(), [&](const Entry& e) { return e.node == child; });
        std::string names;
        for (int shown = 0; entry != stack.end() && shown < 8; ++entry, ++shown) {
          names += name_of(nodes, entry->node) + " -> ";
        }
        if (entry != stack.end()) names += "... -> ";
        throw InputError("NODE_LOOP: " + names + name_of(nodes, child) +
                         ": a node cannot be its own ancestor; remove one of these children");
      }
    }
  }
}

/// Returns the first parent of each node.
std::vector<std::size_t> find_parents(const Nodes& nodes, Notes& notes) {
  std::vector<std::size_t> parents(nodes.size(), kNoParent);
  std::string shared;
  std::size_t shared_count = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const std::size_t child : nodes[i].children) {
      const std::size_t other = parents[child];
      if (other == i) throw InputError(name_of(nodes, i) + " lists " + name_of(nodes, child) + " twice as its child");
      parents[child] = i;
      if (other == kNoParent || shared_count++ != 0) continue;
      shared = fmt::format("{} is a child of both {} and {}, where glTF allows one parent; it stands under each",
                           name_of(nodes, child), name_of(nodes, other), name_of(nodes, i));
    }
  }
  if (shared_count > 1) shared += fmt::format(" ({} of them)", shared_count);
  if (shared_count != 0) notes.mended(shared);
  return parents;
}

glm::dvec4 rotation_of(const GltfNode& node, Notes& notes) {
  const std::vector<double>& xyzw = node.rotation_xyzw;
  if (xyzw.empty()) return {0, 0, 0, 1};
  const double largest = std::max({std::abs(xyzw[0]), std::abs(xyzw[1]), std::abs(xyzw[2]), std::abs(xyzw[3])});
  if (largest == 0) node.view.refuse("rotation (0, 0, 0, 0) is no rotation; none at all is (0, 0, 0, 1)");
  const glm::dvec4 rotation(xyzw[0], xyzw[1], xyzw[2], xyzw[3]);
  const double length = glm::length(rotation / largest) * largest;
  if (std::abs(length - 1) > 1e-2)
    notes.warn(fmt::format("{}: rotation of length {:.3g} normalised", node.view.label(), length));
  return rotation;
}

glm::dvec3 three(const std::vector<double>& values, double otherwise) {
  return values.empty() ? glm::dvec3(otherwise) : glm::dvec3(values[0], values[1], values[2]);
}

glm::dmat4 local_transform(const GltfNode& node, Notes& notes) {
  if (node.matrix.empty())
    return transform_matrix(three(node.translation, 0), rotation_of(node, notes), three(node.scale, 1));
  glm::dmat4 matrix{1.0};
  for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
  if (matrix[0][3] != 0 || matrix[1][3] != 0 || matrix[2][3] != 0 || matrix[3][3] != 1)
    node.view.refuse("the last row of its matrix is not 0 0 0 1; glTF stores columns first");
  return matrix;
}

/// Marks the nodes that some listed node has below it.
std::vector<bool> below(const Nodes& nodes, std::vector<std::size_t> stack) {
  std::vector<bool> marked(nodes.size(), false);
  while (!stack.empty()) {
    const std::size_t node = stack.back();
    stack.pop_back();
    for (const std::size_t child : nodes[node].children) {
      if (!marked[child]) stack.push_back(child);
      marked[child] = true;
    }
  }
  return marked;
}

/// The nodes that the scene lists, without those that others of them have below them anyway.
std::vector<std::size_t> listed_roots(const Document& document, const std::vector<std::size_t>& parents, Notes& notes) {
  const Nodes& nodes = document.nodes;
  std::vector<std::size_t> roots;
  std::vector<bool> listed(nodes.size(), false);
  const std::vector<bool> is_below = below(nodes, document.scene_nodes);
  std::string first;
  std::size_t count = 0;
  for (const std::size_t node : document.scene_nodes) {
    if (listed[node]) throw InputError(document.scene->label() + " lists " + name_of(nodes, node) + " twice");
    listed[node] = true;
    if (!is_below[node]) roots.push_back(node);
    if (parents[node] == kNoParent || count++ != 0) continue;
    first = fmt::format("{} lists {}, a child of {}; it stands {}", document.scene->label(), name_of(nodes, node),
                        name_of(nodes, parents[node]),
                        is_below[node] ? "where its parent puts it" : "without its parent, which the scene lacks");
  }
  if (count > 1) first += fmt::format(" ({} such nodes)", count);
  if (count != 0) notes.mended(first);
  return roots;
}

std::vector<std::size_t> without_parents(const std::vector<std::size_t>& parents) {
  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < parents.size(); ++i)
    if (parents[i] == kNoParent) roots.push_back(i);
  return roots;
}

std::vector<std::size_t> scene_roots(const Document& document, Notes& notes) {
  const std::vector<std::size_t> parents = find_parents(document.nodes, notes);
  return document.scene ? listed_roots(document, parents, notes) : without_parents(parents);
}

/// Returns for each node the parent under which a walk from all roots, in the order of the file,
/// comes to it first.
std::vector<std::size_t> first_parents(const Nodes& nodes) {
  struct Entry {
    std::size_t node, parent;
  };
  Notes said_before;
  std::vector<std::size_t> parents(nodes.size(), kNoParent);
  std::vector<bool> seen(nodes.size(), false);
  std::vector<Entry> stack;
  for (const std::size_t root : without_parents(find_parents(nodes, said_before))) {
    stack.push_back({.node = root, .parent = kNoParent});
    while (!stack.empty()) {
      const Entry entry = stack.back();
      stack.pop_back();
      if (seen[entry.node]) continue;
      seen[entry.node] = true;
      parents[entry.node] = entry.parent;
      const std::vector<std::size_t>& children = nodes[entry.node].children;
      for (auto child = children.rbegin(); child != children.rend(); ++child)
        if (!seen[*child]) stack.push_back({.node = *child, .parent = entry.node});
    }
  }
  return parents;
}

bool says_invisible(const GltfNode& node) {
  const Json* visible = member(extension_of(node.view.value, kVisibilityExtension), "visible");
  return visible != nullptr && !to_boolean(*visible);
}

glm::dmat4 place_below(const glm::dmat4& parent, const GltfNode& node, Notes& notes) {
  const glm::dmat4 world_from_object = parent * local_transform(node, notes);
  if (!is_finite(world_from_object)) node.view.refuse("its transform and its parents' together overflow");
  return world_from_object;
}

std::vector<PlacedNode> walk_from(const std::vector<std::size_t>& roots, const Document& document, Notes& notes) {
  std::vector<PlacedNode> placed, stack;  // those in the stack carry what their parent has
  placed.reserve(document.nodes.size());
  const auto push = [&](std::size_t node, const PlacedNode* parent) {
    document.wrong.check("node", node);
    stack.push_back({.node = document.nodes[node],
                     .world_from_object = parent == nullptr ? glm::dmat4(1.0) : parent->world_from_object,
                     .visible = parent == nullptr || parent->visible});
  };
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) push(*root, nullptr);
  while (!stack.empty()) {
    PlacedNode next = stack.back();
    stack.pop_back();
    next.world_from_object = place_below(next.world_from_object, next.node, notes);
    next.visible = next.visible && !says_invisible(next.node);
    for (auto child = next.node.children.rbegin(); child != next.node.children.rend(); ++child) push(*child, &next);
    placed.push_back(next);
    if (placed.size() > document.nodes.size() + kMaxRepeatedNodes)
      next.node.view.refuse("children of several parents make too many nodes; give each node one parent");
  }
  return placed;
}

}  // namespace

std::vector<PlacedNode> walk_nodes(const Document& document, Notes& notes) {
  refuse_loops(document.nodes);
  return walk_from(scene_roots(document, notes), document, notes);
}

OwnPlaces::OwnPlaces(const Document& document, Notes& notes)
    : document_(document), notes_(notes), parents_(first_parents(document.nodes)) {}

const glm::dmat4& OwnPlaces::operator[](std::size_t node) {
  std::vector<std::size_t> way;  // from the node up, until one is known
  for (std::size_t at = node; at != kNoParent && !known_.contains(at); at = parents_[at]) way.push_back(at);
  for (; !way.empty(); way.pop_back()) {
    const std::size_t at = way.back(), parent = parents_[at];
    document_.wrong.check("node", at);
    known_[at] = place_below(parent == kNoParent ? glm::dmat4(1.0) : known_.at(parent), document_.nodes[at], notes_);
  }
  return known_.at(node);
}

void check_position(const JsonView& of, const PlacedNode& placed) {
  for (int axis = 0; axis < 3; ++axis) {
    const double position = placed.world_from_object[3][axis];
    if (!(std::abs(position) <= kMaxCoordinate))
      of.refuse(fmt::format("lies at {} = {:g}, beyond 2^40 m, the largest coordinate; scale the scene down",
                            "xyz"[axis], position));
  }
}

}  // namespace eikon
