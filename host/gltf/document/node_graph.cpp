// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/node_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "scene/transform.h"

namespace eikon {
namespace {

constexpr std::size_t kNoParent = ~std::size_t{0};

std::size_t child_at(const tinygltf::Node& node, std::size_t i) { return static_cast<std::size_t>(node.children[i]); }

// Depth first with an explicit stack; an edge to a node that is still open closes a loop.
void refuse_loops(const tinygltf::Model& model) {
  enum class State : unsigned char { unseen, open, done };
  struct Entry {
    std::size_t node, next_child;
  };
  std::vector<State> state(model.nodes.size(), State::unseen);
  std::vector<Entry> stack;
  for (std::size_t start = 0; start < model.nodes.size(); ++start) {
    if (state[start] != State::unseen) continue;
    stack.push_back({.node = start, .next_child = 0});
    state[start] = State::open;
    while (!stack.empty()) {
      Entry& top = stack.back();
      const tinygltf::Node& node = model.nodes[top.node];
      if (top.next_child == node.children.size()) {
        state[top.node] = State::done;
        stack.pop_back();
        continue;
      }
      const std::size_t child = child_at(node, top.next_child++);
      if (state[child] == State::unseen) {
        state[child] = State::open;
        stack.push_back({.node = child, .next_child = 0});
      } else if (state[child] == State::open) {
        auto entry = std::find_if(stack.begin(), stack.end(), [&](const Entry& e) { return e.node == child; });
        std::string names;
        for (int shown = 0; entry != stack.end() && shown < 8; ++entry, ++shown) {
          names += node_label(model, entry->node) + " -> ";
        }
        if (entry != stack.end()) names += "... -> ";
        throw InputError("NODE_LOOP: " + names + node_label(model, child) +
                         ": a node cannot be its own ancestor; remove one of these children");
      }
    }
  }
}

std::vector<std::size_t> find_parents(const tinygltf::Model& model) {
  std::vector<std::size_t> parents(model.nodes.size(), kNoParent);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    for (std::size_t c = 0; c < model.nodes[i].children.size(); ++c) {
      const std::size_t child = child_at(model.nodes[i], c);
      if (parents[child] != kNoParent) {
        throw InputError(fmt::format("{} is a child of both {} and {}; glTF allows one parent",
                                     node_label(model, child), node_label(model, parents[child]),
                                     node_label(model, i)));
      }
      parents[child] = i;
    }
  }
  return parents;
}

glm::dvec4 rotation_of(const tinygltf::Model& model, std::size_t index, Notes& notes) {
  const std::vector<double>& xyzw = model.nodes[index].rotation;
  if (xyzw.empty()) return {0, 0, 0, 1};
  const double largest = std::max({std::abs(xyzw[0]), std::abs(xyzw[1]), std::abs(xyzw[2]), std::abs(xyzw[3])});
  if (largest == 0) {
    throw InputError(node_label(model, index) + ": rotation (0, 0, 0, 0) is no rotation; none at all is (0, 0, 0, 1)");
  }
  const glm::dvec4 rotation(xyzw[0], xyzw[1], xyzw[2], xyzw[3]);
  const double length = glm::length(rotation / largest) * largest;
  if (std::abs(length - 1) > 1e-2) {
    notes.warn(fmt::format("{}: rotation of length {:.3g} normalised", node_label(model, index), length));
  }
  return rotation;
}

glm::dvec3 three(const std::vector<double>& values, double otherwise) {
  return values.empty() ? glm::dvec3(otherwise) : glm::dvec3(values[0], values[1], values[2]);
}

glm::dmat4 local_transform(const tinygltf::Model& model, std::size_t index, Notes& notes) {
  const tinygltf::Node& node = model.nodes[index];
  if (!node.matrix.empty()) {
    glm::dmat4 matrix{1.0};
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
    if (matrix[0][3] != 0 || matrix[1][3] != 0 || matrix[2][3] != 0 || matrix[3][3] != 1) {
      throw InputError(node_label(model, index) +
                       ": the last row of its matrix is not 0 0 0 1; glTF stores columns first");
    }
    return matrix;
  }
  return transform_matrix(three(node.translation, 0), rotation_of(model, index, notes), three(node.scale, 1));
}

std::vector<std::size_t> scene_roots(const tinygltf::Model& model, const std::vector<std::size_t>& parents) {
  std::vector<std::size_t> roots;
  if (model.scenes.empty()) {
    for (std::size_t i = 0; i < parents.size(); ++i) {
      if (parents[i] == kNoParent) roots.push_back(i);
    }
    return roots;
  }
  const std::size_t chosen = model.defaultScene >= 0 ? static_cast<std::size_t>(model.defaultScene) : 0;
  const tinygltf::Scene& scene = model.scenes[chosen];
  std::vector<bool> listed(parents.size(), false);
  for (const int entry : scene.nodes) {
    const auto node = static_cast<std::size_t>(entry);
    if (parents[node] != kNoParent) {
      throw InputError(fmt::format("{} lists {}, a child of {}; a scene lists root nodes only",
                                   label("scene", chosen, scene.name), node_label(model, node),
                                   node_label(model, parents[node])));
    }
    if (listed[node]) {
      throw InputError(label("scene", chosen, scene.name) + " lists " + node_label(model, node) + " twice");
    }
    listed[node] = true;
    roots.push_back(node);
  }
  return roots;
}

}  // namespace

std::string node_label(const tinygltf::Model& model, std::size_t node) {
  return label("node", node, model.nodes[node].name);
}

std::vector<PlacedNode> walk_nodes(const tinygltf::Model& model, Notes& notes) {
  refuse_loops(model);
  const std::vector<std::size_t> parents = find_parents(model);
  std::vector<std::size_t> roots = scene_roots(model, parents);

  std::vector<PlacedNode> placed, stack;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root)
    stack.push_back({.node = *root, .world_from_object = glm::dmat4{1.0}});
  while (!stack.empty()) {
    PlacedNode next = stack.back();  // carries its parent's transform until here
    stack.pop_back();
    next.world_from_object = next.world_from_object * local_transform(model, next.node, notes);
    if (!is_finite(next.world_from_object)) {
      throw InputError(node_label(model, next.node) + ": its transform and its parents' together overflow");
    }
    const tinygltf::Node& node = model.nodes[next.node];
    for (std::size_t c = node.children.size(); c-- > 0;) {
      stack.push_back({.node = child_at(node, c), .world_from_object = next.world_from_object});
    }
    placed.push_back(next);
  }
  return placed;
}

}  // namespace eikon
