// SPDX-License-Identifier: Apache-2.0
// The words of a splat, which host and kernels both read.
#ifndef EK_SHARED_SPLAT_H
#define EK_SHARED_SPLAT_H

// SPLAT_pixel: x | y << 16. SPLAT_info: replicate | number of scatterings << 8 | light group << 24. Then the value.
enum { SPLAT_pixel, SPLAT_info, SPLAT_r, SPLAT_g, SPLAT_b, SPLAT_WORDS };
#define EK_SPLAT_SCATTERINGS_MOST 0xffffu

// What a unit of light paths counts.
enum { SPLATS_stored, SPLATS_path_rays, SPLATS_shadow_rays, SPLATS_COUNTS };

#endif
