// SPDX-License-Identifier: Apache-2.0
// Stage `light_generate`.   To: all light paths of the unit, at depth 1. Starts one path per (light
// path, sample), of which light_path_index says which of the image's light paths at that sample it
// is. Its random numbers are the point of that index in the sample's block of one sequence, so the
// light paths of all samples together are spread evenly over the lights, and best if their number
// is a power of two.
#ifndef EK_STAGE_LIGHT_GENERATE_H
#define EK_STAGE_LIGHT_GENERATE_H
#include "lanes/sampler.h"
#include "lights/light_path.h"
#include "stages/generate.h"
#include "stages/wavefront.h"

#if EK_HAS_light_paths
// Sets light paths apart from the pixels of any seed.
#define EK_LIGHT_PATH_SEED 0x6c70a7b5u

/// returns the key of the random numbers of a light path
/// light_path_index  which of the sample's light paths, below frame.light_path_count
/// sample            of the unit
/// index, replicate  are set to the index of the random numbers, and to the replicate of the sample
EK_FN vu light_path_key(constant Frame* frame, vu light_path_index, vu sample, vu* index, vu* replicate) {
  // 2^shift is the least power of two that is not less than it.
  const uint shift = 32u - clz(frame->light_path_count - 1u);
  const ReplicateSample in_replicate = replicate_sample(frame, sample);
  const vu block = in_replicate.index;
  const uint high = frame->sample_high >> frame->replicate_bits;
  *replicate = in_replicate.replicate;
  // block * 2^shift + light_path_index has up to 64 bits, and the high ones belong to the key.
  *index = shift == 0u ? block : (block << shift) | light_path_index;
  const vu above = shift == 0u ? (vu)(0u) : block >> (32u - shift);
  const vu of_high = hash_bits(above + hash_bits((vu)(high)));
  return sample_key(of_high & 0xffffu, of_high >> 16, *replicate, frame->seed ^ EK_LIGHT_PATH_SEED, high);
}

/// source  instead of pixels it has light_path_index of each light path of a sample of the unit,
///         [frame.pixel_count]
/// first   path of slot 0 of the state: paths first + 0 .. first + count - 1 of the unit
EK_FN_ONCE void stage_light_generate(StageContext stage, SceneData scene, LightData lights, PathSource source, uint first,
                                     uint count) {
  constant Frame* frame = stage.frame;
  for (uint slot = 0; slot < count; slot += EK_WIDTH) {
    const vu path = (vu)(first + slot) + LANE_INDEX;
    const uint path_count = frame->pixel_count;  // of each sample
    const vu sample = sample_of_path(path, path_count);
    const vu place = path - sample * path_count;
    const vu light_path_index = gather_u(source.pixels, place < path_count ? place : (vu)(0u));
    vu index, replicate;
    const vu key = light_path_key(frame, light_path_index, sample, &index, &replicate);

    vu a, b;
    sample_2d_bits(key, index, DIM_FILTER, &a, &b);
    const AliasSample choice =
        alias_table_sample(lights.light_paths.emission_alias_table, frame->emission_light_count, a, b);
    v3 random;
    vf unused;
    sample_2d(key, index, DIM_LENS, &random.y, &random.z);
    sample_2d(key, index, DIM_TIME_DISPERSION, &random.x, &unused);  // the other one is the channel of glass with dispersion
    LightWords words = {(vu)(0u), (vu)(0u), (vu)(0u), (vu)(0u), 0u};
    if (EK_HAS_environment_map) sample_2d_bits(key, index, bounce_dimension(0, DIM_ENVIRONMENT), &words.c, &words.d);
    const EmittedPath emitted = emit_light_path(frame, scene, lights, choice, random, words);
    const PathState start = {.path = light_path_tag(replicate, emitted.start),
                             .key = key,
                             .index = index,
                             .origin = emitted.origin,
                             .dir = emitted.dir,
                             .beta = emitted.throughput,
                             .pdf = (vf)(EK_NO_DENSITY),
                             .expected = (vf)(0.0f),
                             .light_ratio = emitted.density,
                             .source_group = emitted.group,
                             .medium = (vu)(0u),
                             .null_interface_count = (vu)(0u),
                             .hit_triangle = EK_HAS_instance ? (vu)(EK_NO_HIT) : emitted.triangle};
    path_store(stage.state, slot, packing_all(), start);
  }
}
#endif

#endif
