// SPDX-License-Identifier: Apache-2.0
// What host and kernels agree on about path guiding: the table that guides (kernels/guide/guide.h),
// and the log from which it is learned (kernels/guide/path_log.h).
#ifndef EK_SHARED_GUIDE_H
#define EK_SHARED_GUIDE_H
#include "shared/abi.h"
EK_BEGIN

#define EK_GUIDE_LEVELS 3        // sizes of cells: each level's are twice as large
#define EK_GUIDE_BINS 64         // of a cell's table: 8 rows of 8 columns
#define EK_GUIDE_TOTAL 65536     // sum of the weights of a table
#define EK_GUIDE_LEAST 0.25f     // least weight of a bin over the mean of all
#define EK_GUIDE_ROWS 8u         // of as many bins each
#define EK_LOG_DEPTHS 8          // vertices of a path that are logged

// Words of a cell. Weights have 16 bits each and a sum of EK_GUIDE_TOTAL.
enum {
  GUIDE_bounds = 0,                                  // sum of the weights before each row, 16 bits
  GUIDE_weights = GUIDE_bounds + EK_GUIDE_ROWS / 2,  // of the bins, row by row
  // Floats, luminance in W / (sr m^2): irradiance / pi from surfaces and from lights that scattered
  // rays meet, and from lights that are sampled. Times the albedo it is what leaves.
  GUIDE_indirect = GUIDE_weights + EK_GUIDE_BINS / 2,
  GUIDE_direct,
  EK_GUIDE_CELL_WORDS = 40                           // padded
};

// Words of a logged vertex. Light is counted as it arrives at the vertex before: without what a
// medium absorbs on the way there. Luminances of light are in W / (sr m^2).
enum {
  LOG_info,      // LOG_HIT ... and the bin of the direction in which the path goes on
  LOG_xy,        // key of its cell (CellKey)
  LOG_zn,
  LOG_distance,  // float, metres: from the vertex before
  // Float: what is left of the luminance of the path's throughput, from the vertex before to where
  // the path goes on from this one.
  LOG_weight,
  // Float: luminance of the base colour, times the share that the medium on the way to the vertex
  // before leaves.
  LOG_albedo,
  LOG_sampled,   // float: luminance that leaves towards the vertex before, from light sampling here
  LOG_emitted,   // float: luminance that the path met here, weighted as if directions were not guided
  LOG_WORDS
};

#define LOG_BIN_MASK 63u
#define LOG_HIT 64u        // the path met a surface
#define LOG_MISS 128u      // it left the scene
// The guide's tables apply to this vertex: its surface is diffuse, at least in part, or glossy.
#define LOG_GUIDED 256u
#define LOG_CONTINUES 512u // the path goes on

EK_END
#endif
