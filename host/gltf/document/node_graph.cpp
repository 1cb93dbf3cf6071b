// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/node_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "scene/transform.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::size_t kNoParent = ~std::size_t{0};

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

std::vector<std::size_t> find_parents(const Nodes& nodes) {
  std::vector<std::size_t> parents(nodes.size(), kNoParent);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const std::size_t child : nodes[i].children) {
      if (parents[child] != kNoParent) {
        throw InputError(fmt::format("{} is a child of both {} and {}; glTF allows one parent", name_of(nodes, child),
                                     name_of(nodes, parents[child]), name_of(nodes, i)));
      }
      parents[child] = i;
    }
  }
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

std::vector<std::size_t> scene_roots(const Document& document, const std::vector<std::size_t>& parents) {
  std::vector<std::size_t> roots;
  if (!document.scene) {
    for (std::size_t i = 0; i < parents.size(); ++i)
      if (parents[i] == kNoParent) roots.push_back(i);
    return roots;
  }
  const auto refuse = [&](const std::string& what) { throw InputError(document.scene->label() + " lists " + what); };
  std::vector<bool> listed(parents.size(), false);
  for (const std::size_t node : document.scene_nodes) {
    const std::string name = name_of(document.nodes, node);
    if (parents[node] != kNoParent)
      refuse(fmt::format("{}, a child of {}; a scene lists root nodes only", name,
                         name_of(document.nodes, parents[node])));
    if (listed[node]) refuse(name + " twice");
    listed[node] = true;
    roots.push_back(node);
  }
  return roots;
}

}  // namespace

std::vector<PlacedNode> walk_nodes(const Document& document, Notes& notes) {
  refuse_loops(document.nodes);
  const std::vector<std::size_t> roots = scene_roots(document, find_parents(document.nodes));
  std::vector<PlacedNode> placed, stack;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({.node = document.nodes[*root]});
  while (!stack.empty()) {
    PlacedNode next = stack.back();  // carries its parent's transform until here
    stack.pop_back();
    next.world_from_object = next.world_from_object * local_transform(next.node, notes);
    if (!is_finite(next.world_from_object)) next.node.view.refuse("its transform and its parents' together overflow");
    for (auto child = next.node.children.rbegin(); child != next.node.children.rend(); ++child)
      stack.push_back({.node = document.nodes[*child], .world_from_object = next.world_from_object});
    placed.push_back(next);
  }
  return placed;
}

}  // namespace eikon
