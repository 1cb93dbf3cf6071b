// SPDX-License-Identifier: Apache-2.0
// For each set of eight lanes, their numbers packed together. A processor that can permute a
// register, but not compress it, compacts by this table.
#ifndef EK_COMPRESS_TABLE_H
#define EK_COMPRESS_TABLE_H
#include "lanes/lanes.h"

// Byte k of an entry is the k-th set lane of the set. A row has all sets of the lanes 0 to 3,
// together with one of the lanes 4 to 7. The numbers are written out because PoCL expands all
// macros whenever it looks a program up: computing each entry by macros took it 0.15 s.
#define COMPRESS_ROW(high)                                                                                        \
  high, 0x00ul | high << 8, 0x01ul | high << 8, 0x0100ul | high << 16, 0x02ul | high << 8, 0x0200ul | high << 16, \
      0x0201ul | high << 16, 0x020100ul | high << 24, 0x03ul | high << 8, 0x0300ul | high << 16,                  \
      0x0301ul | high << 16, 0x030100ul | high << 24, 0x0302ul | high << 16, 0x030200ul | high << 24,             \
      0x030201ul | high << 24, 0x03020100ul | high << 32

constant ulong compress_table[256] = {
    COMPRESS_ROW(0ul),      COMPRESS_ROW(0x04ul),     COMPRESS_ROW(0x05ul),     COMPRESS_ROW(0x0504ul),
    COMPRESS_ROW(0x06ul),   COMPRESS_ROW(0x0604ul),   COMPRESS_ROW(0x0605ul),   COMPRESS_ROW(0x060504ul),
    COMPRESS_ROW(0x07ul),   COMPRESS_ROW(0x0704ul),   COMPRESS_ROW(0x0705ul),   COMPRESS_ROW(0x070504ul),
    COMPRESS_ROW(0x0706ul), COMPRESS_ROW(0x070604ul), COMPRESS_ROW(0x070605ul), COMPRESS_ROW(0x07060504ul)};

// The lanes of `bits`, then zeros.
EK_FN uchar8 compress_order(uint bits) { return as_uchar8(compress_table[bits]); }

#endif
