// SPDX-License-Identifier: Apache-2.0
// The words of a splat, which host and kernels both read.
#ifndef EK_SHARED_SPLAT_H
#define EK_SHARED_SPLAT_H

// SPLAT_pixel: x | y << 16. SPLAT_info: replicate | number of scatterings << 8 | ratio << 16 | light group << 24. Then the
// value.
enum { SPLAT_pixel, SPLAT_info, SPLAT_r, SPLAT_g, SPLAT_b, SPLAT_WORDS };
#define EK_SPLAT_SCATTERINGS_MOST 0xffu  // more than any bound of the layers by depth
// The ratio is that of light paths' density over camera paths' (stages/shade/light_ratio.h), of which the exponent of the
// float is kept.
#define EK_SPLAT_RATIO_SHIFT 16
#define EK_SPLAT_RATIO_INFINITE 0xffu  // no camera path finds this light

// What a unit of light paths counts.
enum { SPLATS_stored, SPLATS_path_rays, SPLATS_shadow_rays, SPLATS_COUNTS };

#endif
