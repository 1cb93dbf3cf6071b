// SPDX-License-Identifier: Apache-2.0
// The words of a splat, which host and kernels both read.
#ifndef EK_SHARED_SPLAT_H
#define EK_SHARED_SPLAT_H

// SPLAT_pixel: x | y << 16. SPLAT_info: EK_SPLAT_INFO | light group << 24. Then the value.
enum { SPLAT_pixel, SPLAT_info, SPLAT_r, SPLAT_g, SPLAT_b, SPLAT_WORDS };
#define EK_SPLAT_SCATTERINGS_MOST 0xffu  // more than any bound of the layers by depth
// The ratio is that of light paths' density over camera paths' (stages/shade/light_ratio.h), of
// which the exponent of the float is kept.
#define EK_SPLAT_RATIO_INFINITE 0xffu  // no camera path finds this light
#define EK_SPLAT_INFO(replicate, scatterings, ratio) ((replicate) | (scatterings) << 8 | (ratio) << 16)
#define EK_SPLAT_REPLICATE(info) ((info)&0xffu)
#define EK_SPLAT_SCATTERINGS(info) ((info) >> 8 & 0xffu)
#define EK_SPLAT_RATIO(info) ((info) >> 16 & 0xffu)
#define EK_SPLAT_GROUP(info) ((info) >> 24)

// The name of the start of the splat's light path (shared/light_target.h) stands in SPLAT_pixel if
// EK_AIM_NAMES_STARTS is set. The sides of such a picture have at most EK_SPLAT_NAMED_SIDE pixels,
// so that x and y leave seven bits each.
#define EK_SPLAT_NAMED_SIDE 512
#define EK_SPLAT_NAMED_PIXEL(pixel, start) ((pixel) | ((start)&0x7fu) << 9 | ((start) >> 7) << 25)
#define EK_SPLAT_PIXEL_OF_NAMED(word) ((word)&0x01ff01ffu)
#define EK_SPLAT_START(word) (((word) >> 9 & 0x7fu) | ((word) >> 25) << 7)

// What a unit of light paths counts.
enum { SPLATS_stored, SPLATS_path_rays, SPLATS_shadow_rays, SPLATS_COUNTS };

#endif
