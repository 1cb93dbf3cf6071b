// SPDX-License-Identifier: Apache-2.0
// The arithmetic probe alone, and how a device lays out the shared records.
#include "probe/arithmetic.h"

kernel void arithmetic(global uint* arithmetic_out, global const uint* arithmetic_records) {
  arithmetic_run(arithmetic_out, arithmetic_records);
}

// Sizes of the shared records and the offset of each one's last field, as this device lays them
// out.
kernel void record_layout(global uint* layout_out) {
  // Differences of addresses: a null pointer need not have the address 0.
#define EK_LAYOUT(i, T, field)                                                   \
  {                                                                              \
    T record;                                                                    \
    layout_out[i] = (uint)sizeof(T);                                             \
    layout_out[i + 1] = (uint)((uchar*)&record.field - (uchar*)&record);         \
  }
  EK_LAYOUT(0, Frame, environment_cos)
  EK_LAYOUT(2, Triangle, n_z)
  EK_LAYOUT(4, TriangleNormals, v2)
  EK_LAYOUT(6, MaterialRecord, emissive_texture)
  EK_LAYOUT(8, Light, triangle)
  EK_LAYOUT(10, AliasEntry, alias)
  EK_LAYOUT(12, Diagnostics, report)
}
