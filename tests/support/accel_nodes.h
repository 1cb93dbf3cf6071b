// SPDX-License-Identifier: Apache-2.0
// The nodes of every layout as a traversal sees them, read from the words as the kernels do.
#pragma once
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "accel/accel.h"

namespace eikon::fixtures {

struct NodeChild {
  float lo[3], hi[3];
  bool leaf = false;
  std::uint32_t node = 0;                // its index, where it is not a leaf
  std::vector<std::uint32_t> triangles;  // of a leaf
  std::vector<float> corners;            // of them, nine each, where the leaf holds them itself
};

namespace node_reader {

/// Leaves that are ranges of the list.
inline void link(const Accel& accel, std::uint32_t word, NodeChild& child) {
  child.leaf = (word & 0x80000000U) != 0;
  child.node = word;
  if (!child.leaf) return;
  const std::uint32_t first = word & 0x0fffffffU, count = (word >> 28 & 7U) + 1;
  for (std::uint32_t k = 0; k < count; ++k) child.triangles.push_back(accel.leaves.at(first + k));
}

/// Nodes of `width` boxes in planes, blocks of eight triangles.
inline std::vector<NodeChild> wide(const Accel& accel, std::uint32_t index, std::size_t width) {
  const std::uint32_t* words = accel.nodes.data() + std::size_t{index} * 8 * width;
  std::vector<NodeChild> children;
  for (std::size_t i = 0; i < width; ++i) {
    NodeChild child;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      child.lo[axis] = std::bit_cast<float>(words[2 * width * axis + i]);
      child.hi[axis] = std::bit_cast<float>(words[2 * width * axis + width + i]);
    }
    if (!(child.lo[0] <= child.hi[0])) continue;
    const std::uint32_t word = words[6 * width + i];
    child.leaf = (word & 0x80000000U) != 0;
    child.node = word;
    if (child.leaf) {
      const std::uint32_t* block = accel.leaves.data() + std::size_t{word & 0x7fffffffU} * 80;
      for (std::size_t k = 0; k < 8; ++k) {
        if (block[72 + k] == 0xffffffffU) continue;
        child.triangles.push_back(block[72 + k]);
        for (std::size_t c = 0; c < 9; ++c) child.corners.push_back(std::bit_cast<float>(block[8 * c + k]));
      }
    }
    children.push_back(child);
  }
  return children;
}

inline std::vector<NodeChild> bvh2(const Accel& accel, std::uint32_t index) {
  const std::uint32_t* words = accel.nodes.data() + std::size_t{index} * 16;
  std::vector<NodeChild> children;
  for (std::size_t i = 0; i < 2; ++i) {
    NodeChild child;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      child.lo[axis] = std::bit_cast<float>(words[6 * i + axis]);
      child.hi[axis] = std::bit_cast<float>(words[6 * i + 3 + axis]);
    }
    if (!(child.lo[0] <= child.hi[0])) continue;
    link(accel, words[12 + i], child);
    children.push_back(child);
  }
  return children;
}

/// The plane that a byte stands for: kernels/traverse/quantised.h.
inline float quantised(const std::uint32_t* frame, std::size_t axis, std::uint32_t byte) {
  const float scale = std::ldexp(1.0F, static_cast<int>(frame[3] >> 8 * axis & 255U) - 127);
  return std::bit_cast<float>(frame[axis]) + static_cast<float>(byte) * scale;
}

inline std::uint32_t byte_of(std::uint32_t word, std::size_t i) { return word >> 8 * i & 255U; }

inline std::vector<NodeChild> bvh4(const Accel& accel, std::uint32_t index) {
  const std::uint32_t* words = accel.nodes.data() + std::size_t{index} * 16;
  std::vector<NodeChild> children;
  for (std::size_t i = 0; i < 4; ++i) {
    if ((words[3] >> (24 + i) & 1U) == 0) continue;
    NodeChild child;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      child.lo[axis] = quantised(words, axis, byte_of(words[4 + 2 * axis], i));
      child.hi[axis] = quantised(words, axis, byte_of(words[5 + 2 * axis], i));
    }
    link(accel, words[12 + i], child);
    children.push_back(child);
  }
  return children;
}

inline std::vector<NodeChild> cwbvh(const Accel& accel, std::uint32_t index) {
  const std::uint32_t* words = accel.nodes.data() + std::size_t{index} * 20;
  std::vector<NodeChild> children;
  std::uint32_t next = words[4];
  for (std::size_t i = 0; i < 8; ++i) {
    const std::uint32_t kind = byte_of(words[6 + i / 4], i % 4);
    EXPECT_EQ(words[3] >> (24 + i) & 1U, (kind & 31U) >= 24 ? 1U : 0U);
    if (kind == 0) continue;
    NodeChild child;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      child.lo[axis] = quantised(words, axis, byte_of(words[8 + 2 * axis + i / 4], i % 4));
      child.hi[axis] = quantised(words, axis, byte_of(words[14 + 2 * axis + i / 4], i % 4));
    }
    child.leaf = (kind & 31U) < 24;
    if (child.leaf) {
      for (std::uint32_t ones = kind >> 5, k = 0; ones >> k != 0; ++k)
        child.triangles.push_back(accel.leaves.at(words[5] + (kind & 31U) + k));
    } else {
      EXPECT_EQ(kind, 32U + 24U + i);
      child.node = next++;
    }
    children.push_back(child);
  }
  return children;
}

}  // namespace node_reader

/// The children of node `index`, those that are there.
inline std::vector<NodeChild> node_children(const Accel& accel, std::uint32_t index) {
  if (accel.layout == "bvh16") return node_reader::wide(accel, index, 16);
  if (accel.layout == "bvh8") return node_reader::wide(accel, index, 8);
  if (accel.layout == "bvh2") return node_reader::bvh2(accel, index);
  if (accel.layout == "bvh4") return node_reader::bvh4(accel, index);
  if (accel.layout == "cwbvh") return node_reader::cwbvh(accel, index);
  throw std::logic_error("no reader for layout " + accel.layout);
}

/// Most entries that a node whose children are all met adds to a traversal's stack.
inline std::uint32_t node_entries(const Accel& accel, std::size_t children) {
  return accel.layout == "cwbvh" ? 1 : static_cast<std::uint32_t>(children) - 1;
}

}  // namespace eikon::fixtures
