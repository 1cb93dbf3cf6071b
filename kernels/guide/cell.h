// SPDX-License-Identifier: Apache-2.0
// Cells of the guide: cubes of space, split by the direction of the surface in them. A point is
// looked up in the cell of the finest level that the pilot has visited (host/guide/guide_table.h
// builds the hash table). [Binder et al. 2018, "Fast Path Space Filtering by Jittered Spatial
// Hashing"]
#ifndef EK_GUIDE_CELL_H
#define EK_GUIDE_CELL_H
#include "lanes/sampler.h"
#include "shared/guide.h"

// True if the program has tables; that of a pilot has them too.
#define EK_USES_GUIDE (EK_HAS_guiding | EK_HAS_path_log)

#define EK_NO_CELL 0xffffffffu

/// The cell of level 0 of a point: its coordinates, 16 bits each, and the code of its normal.
typedef struct {
  vu xy;  // x | y << 16
  vu zn;  // z | code << 16
} CellKey;

// The coordinate of a cell on one axis, [0, 2^16); points far outside share the outermost cells.
EK_FN vu cell_coordinate(vf x) {
  const vf bounded = min_f(max_f(x, (vf)(-32768.0f)), (vf)(32767.0f));
  const vi truncated = TO_I(bounded);
  const vi above = TO_F(truncated) > bounded;
  return AS_U(above ? truncated - 1 : truncated) + 32768u;
}

// The face of a cube around the origin that the normal goes through, and which quarter of that
// face; normals along an axis have one code, so that rounding does not tear a wall apart.
#define EK_ALONG_AXIS 0.999f  // least cosine with the axis, 2.6 degrees
EK_FN vu normal_code(v3 n) {
  const vf ax = abs_f(n.x), ay = abs_f(n.y), az = abs_f(n.z);
  const vi along_x = (ax >= ay) & (ax >= az), along_y = !along_x & (ay >= az);
  const vf major = along_x ? n.x : along_y ? n.y : n.z;
  const vf first = along_x ? n.y : n.x, second = (along_x | along_y) ? n.z : n.y;
  const vu face = (along_x ? (vu)(0u) : along_y ? (vu)(2u) : (vu)(4u)) + (major > 0.0f ? (vu)(1u) : (vu)(0u));
  const vu quarter = (first > 0.0f ? (vu)(2u) : (vu)(0u)) + (second > 0.0f ? (vu)(1u) : (vu)(0u));
  return face * 4u + (abs_f(major) > EK_ALONG_AXIS ? (vu)(0u) : quarter);
}

/// p, n  world, metres; n unit
EK_FN CellKey cell_key(constant Frame* frame, v3 p, v3 n) {
  const float scale = frame->guide_scale;
  const CellKey key = {cell_coordinate(p.x * scale) | (cell_coordinate(p.y * scale) << 16),
                       cell_coordinate(p.z * scale) | (normal_code(n) << 16)};
  return key;
}

/// The cell of a coarser level that contains this one. Each level doubles the side of the cubes.
EK_FN CellKey cell_key_at_level(CellKey key, uint level) {
  const uint low = 0xffffu >> level;
  const CellKey coarse = {((key.xy >> level) & (low | (low << 16))),
                          ((key.zn & 0xffffu) >> level) | (key.zn & 0xffff0000u) | (vu)(level << 24)};
  return coarse;
}

/// Finds the cell of the finest level; EK_NO_CELL where there is none, or where `wanted` is not
/// set. Two keys with the same tag share a cell, which costs variance and nothing else.
/// slots  pairs of a tag and the index of a cell; a tag of 0 ends a search
EK_FN vu cell_find(constant Frame* frame, global const uint* slots, CellKey key, vi wanted) {
  const uint mask = frame->guide_slot_mask;
  vu cell = (vu)(EK_NO_CELL);
  for (uint level = 0; level < EK_GUIDE_LEVELS; ++level) {
    vi open = wanted & (cell == EK_NO_CELL);
    if (!ANY(open)) break;
    const CellKey at_level = cell_key_at_level(key, level);
    vu slot = cell_hash(at_level.xy, at_level.zn);
    const vu tag = cell_tag(at_level.xy, slot);
    while (ANY(open)) {
      slot = slot & mask;
      const vu found = gather_u(slots, 2u * slot);
      const vi is_it = open & (found == tag);
      cell = is_it ? gather_u(slots, 2u * slot + 1u) : cell;
      open = open & !is_it & (found != 0u);
      slot = slot + 1u;
    }
  }
  return cell;
}

#endif
