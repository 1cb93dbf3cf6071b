// SPDX-License-Identifier: Apache-2.0
// For each set of eight lanes, their numbers packed together. A processor that can permute a
// register, but not compress it, compacts by this table.
#ifndef EK_COMPRESS_TABLE_H
#define EK_COMPRESS_TABLE_H
#include "lanes/lanes.h"

// Byte k of an entry is the k-th set lane of the set m.
#define COMPRESS_BIT(m, lane) ((ulong)((m) >> (lane)) & 1ul)
#define COMPRESS_BELOW_2(m) (COMPRESS_BIT(m, 0) + COMPRESS_BIT(m, 1))
#define COMPRESS_BELOW_4(m) (COMPRESS_BELOW_2(m) + COMPRESS_BELOW_2((m) >> 2))
#define COMPRESS_LANE(m, lane, below) (COMPRESS_BIT(m, lane) * ((lane##ul) << 8u * (below)))
#define COMPRESS_ENTRY(m)                                                                                     \
  COMPRESS_LANE(m, 1, COMPRESS_BIT(m, 0)) | COMPRESS_LANE(m, 2, COMPRESS_BELOW_2(m)) |                        \
      COMPRESS_LANE(m, 3, COMPRESS_BELOW_2(m) + COMPRESS_BIT(m, 2)) | COMPRESS_LANE(m, 4, COMPRESS_BELOW_4(m)) | \
      COMPRESS_LANE(m, 5, COMPRESS_BELOW_4(m) + COMPRESS_BIT(m, 4)) |                                         \
      COMPRESS_LANE(m, 6, COMPRESS_BELOW_4(m) + COMPRESS_BELOW_2((m) >> 4)) |                                 \
      COMPRESS_LANE(m, 7, COMPRESS_BELOW_4(m) + COMPRESS_BELOW_2((m) >> 4) + COMPRESS_BIT(m, 6))
#define COMPRESS_4(m) COMPRESS_ENTRY(m), COMPRESS_ENTRY(m + 1), COMPRESS_ENTRY(m + 2), COMPRESS_ENTRY(m + 3)
#define COMPRESS_16(m) COMPRESS_4(m), COMPRESS_4(m + 4), COMPRESS_4(m + 8), COMPRESS_4(m + 12)
#define COMPRESS_64(m) COMPRESS_16(m), COMPRESS_16(m + 16), COMPRESS_16(m + 32), COMPRESS_16(m + 48)

constant ulong compress_table[256] = {COMPRESS_64(0), COMPRESS_64(64), COMPRESS_64(128), COMPRESS_64(192)};

// The lanes of `bits`, then zeros.
EK_FN uchar8 compress_order(uint bits) { return as_uchar8(compress_table[bits]); }

#endif
