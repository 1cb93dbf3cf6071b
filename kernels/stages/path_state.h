// SPDX-License-Identifier: Apache-2.0
// The words of path_state.def in memory, and the records of paths and shadow rays that are made of
// them.
#ifndef EK_PATH_STATE_H
#define EK_PATH_STATE_H
#include "lanes/compact.h"
#include "lanes/math.h"
#include "lights/light_samples.h"

// Words of state per path; a field that this program does not need has no place. Each word of a
// shadow ray has room for EK_LIGHT_SAMPLES rays of every path: on chunks they are packed from the
// first on; else ray k of the path in a slot lies k * EK_CHUNK slots behind it.
enum {
#define EK_FIELD(type, name, needed) FIELD_##name, FIELD_LAST_##name = FIELD_##name + EK_WORDS_##type * (needed) - 1,
#include "shared/path_state.def"
  PATH_WORDS, PATH_LAST_WORD = PATH_WORDS - 1,
#define EK_SHADOW(type, name, needed) \
  SHADOW_##name, SHADOW_LAST_##name = SHADOW_##name + EK_WORDS_##type * (needed) * EK_LIGHT_SAMPLES - 1,
#include "shared/path_state.def"
  STATE_WORDS
};

// Slots between two words: a power of two would put all words of a path into one cache set.
#define EK_STRIDE (EK_CHUNK + EK_PAD)

/// Number of the sample of a pixel that each path of a unit has: path / pixel_count, rounded down.
/// Several lanes divide as floats: their units have less than 2^23 paths, for which the error is
/// less than half a step.
EK_FN vu sample_of_path(vu path, uint pixel_count) {
#if EK_WIDTH == 1
  return path / pixel_count;
#else
  return AS_U(TO_I(div_f(TO_F(AS_I(path)) + 0.5f, (vf)((float)pixel_count))));
#endif
}

/// A sample by its replicate and its index in there.
typedef struct {
  vu replicate;
  vu index;  // low word; the high word is the same for the whole unit (Frame.sample_high >> Frame.replicate_bits)
} ReplicateSample;

/// sample  of the unit, as from sample_of_path
EK_FN ReplicateSample replicate_sample(constant Frame* frame, vu sample) {
  const uint bits = frame->replicate_bits, high = frame->sample_high;
  const vu low = (vu)(frame->sample_begin) + sample;
  const ReplicateSample s = {low & ((1u << bits) - 1u), bits == 0 ? low : (low >> bits) | (high << (32u - bits))};
  return s;
}

// state_<type>, state_set_<type>: of the paths of a vector, from slot `slot` on.
EK_FN vf state_vf(global const uint* state, uint word, uint slot) {
  return load_f((global const float*)(state + word * EK_STRIDE + slot));
}
EK_FN vu state_vu(global const uint* state, uint word, uint slot) { return load_u(state + word * EK_STRIDE + slot); }
EK_FN v3 state_v3(global const uint* state, uint word, uint slot) {
  return V3(state_vf(state, word, slot), state_vf(state, word + 1, slot), state_vf(state, word + 2, slot));
}
EK_FN void state_set_vu(global uint* state, uint word, uint slot, vu x) { store_u(state + word * EK_STRIDE + slot, x); }
EK_FN void state_set_vf(global uint* state, uint word, uint slot, vf x) {
  store_f((global float*)(state + word * EK_STRIDE + slot), x);
}

// state_pack_<type>: the same of the lanes of a packing, moved together.
EK_FN void state_pack_vu(global uint* state, uint word, uint slot, Packing keep, vu x) {
  state_set_vu(state, word, slot, packed(keep, x));
}
EK_FN void state_pack_vf(global uint* state, uint word, uint slot, Packing keep, vf x) {
  state_set_vu(state, word, slot, packed(keep, AS_U(x)));
}
EK_FN void state_pack_v3(global uint* state, uint word, uint slot, Packing keep, v3 a) {
  state_pack_vf(state, word, slot, keep, a.x);
  state_pack_vf(state, word + 1, slot, keep, a.y);
  state_pack_vf(state, word + 2, slot, keep, a.z);
}

/// The state that a path carries from one depth to the next; fields that this program does not need
/// are neither loaded nor stored.
typedef struct {
#define EK_FIELD(type, name, needed) type name;
#define EK_DEPTH_FIELD(type, name, needed)
#include "shared/path_state.def"
} PathState;

/// The paths in `slot` and those behind it. Fields that the caller does not use cost nothing.
EK_FN PathState path_load(global const uint* state, uint slot) {
  PathState path;
#define EK_FIELD(type, name, needed) \
  if (needed) path.name = state_##type(state, FIELD_##name, slot);
#define EK_DEPTH_FIELD(type, name, needed)
#include "shared/path_state.def"
  return path;
}

/// Puts the paths of the lanes of `keep` into `slot` and those behind it; a whole vector is
/// written.
EK_FN void path_store(global uint* state, uint slot, Packing keep, PathState path) {
#define EK_FIELD(type, name, needed) \
  if (needed) state_pack_##type(state, FIELD_##name, slot, keep, path.name);
#define EK_DEPTH_FIELD(type, name, needed)
#include "shared/path_state.def"
}

/// As path_store, of paths that go on. On queues a path keeps its slot, and there is all that it
/// keeps from its start.
EK_FN void path_store_next(global uint* state, uint slot, Packing keep, PathState path) {
#if !EK_CHUNKED
#define EK_START_FIELD(type, name, needed)
#endif
#define EK_FIELD(type, name, needed) \
  if (needed) state_pack_##type(state, FIELD_##name, slot, keep, path.name);
#define EK_DEPTH_FIELD(type, name, needed)
#include "shared/path_state.def"
}

/// A shadow ray that waits for stage `shadow`.
typedef struct {
#define EK_FIELD(type, name, needed)
#define EK_SHADOW(type, name, needed) type name;
#include "shared/path_state.def"
} ShadowRay;

// shadow_<type>, shadow_pack_<type>: as state_<type>, with the words of a vector EK_LIGHT_SAMPLES
// apart.
#define shadow_vu state_vu
#define shadow_vf state_vf
#define shadow_pack_vu state_pack_vu
#define shadow_pack_vf state_pack_vf
EK_FN v3 shadow_v3(global const uint* state, uint word, uint slot) {
  return V3(state_vf(state, word, slot), state_vf(state, word + EK_LIGHT_SAMPLES, slot),
            state_vf(state, word + 2 * EK_LIGHT_SAMPLES, slot));
}
EK_FN void shadow_pack_v3(global uint* state, uint word, uint slot, Packing keep, v3 a) {
  state_pack_vf(state, word, slot, keep, a.x);
  state_pack_vf(state, word + EK_LIGHT_SAMPLES, slot, keep, a.y);
  state_pack_vf(state, word + 2 * EK_LIGHT_SAMPLES, slot, keep, a.z);
}

/// As path_load, of shadow rays.
EK_FN ShadowRay shadow_load(global const uint* state, uint slot) {
  ShadowRay ray = {.destination = (vu)(0u)};
#define EK_SHADOW(type, name, needed) \
  if (needed) ray.name = shadow_##type(state, SHADOW_##name, slot);
#include "shared/path_state.def"
  return ray;
}

/// As path_store, of shadow rays.
EK_FN void shadow_store(global uint* state, uint slot, Packing keep, ShadowRay ray) {
#define EK_SHADOW(type, name, needed) \
  if (needed) shadow_pack_##type(state, SHADOW_##name, slot, keep, ray.name);
#include "shared/path_state.def"
}

#endif
