// SPDX-License-Identifier: Apache-2.0
// Random numbers: Sobol points with hash-based Owen scrambling [Burley 2020, "Practical Hash-based
// Owen Scrambling", JCGT 9(4)]. A number is a pure function of (pixel, replicate, sample index,
// dimension, seed): no state, and nothing depends on the order of work. A dimension is a PAIR of
// numbers: the first two Sobol dimensions, a (0,2)-sequence in base 2, of which every pixel,
// replicate and dimension has a scramble of its own; pairs are padded, the index shuffled in each
// (Burley's section 5).
#ifndef EK_SAMPLER_H
#define EK_SAMPLER_H
#include "lanes/math.h"
#include "shared/hash.h"

// The pairs of each decision. Lens and time have pairs in every scene, so that scenes without them
// keep their numbers.
enum {
  DIM_FILTER,  // place in the pixel
  DIM_LENS,
  DIM_TIME_DISPERSION,  // x: time; y: the colour channel of paths that meet glass with dispersion
  DIM_BOUNCE,  // the first of DIM_PER_BOUNCE pairs of each bounce
  DIM_PER_BOUNCE = 4
};
// Pairs of a bounce (bounce_dimension).
enum {
  DIM_SCATTER,     // direction of the BSDF sample
  DIM_LIGHT,       // choice of a light and the point on it
  DIM_CHOICE,      // x: lobe; y: roulette
  DIM_ENVIRONMENT  // texel of the environment's map and the place in it
};

// Light paths use the same pairs, some of them for other decisions. In stage light_generate
// DIM_FILTER chooses the light and the point on it, x of DIM_TIME_DISPERSION the target, DIM_LENS
// the direction within the target's cone or the place on its disc, and DIM_ENVIRONMENT of depth 0
// the texel. At a vertex DIM_LIGHT chooses the point on the lens (camera_view), and DIM_ENVIRONMENT
// the pixel among those whose filter reaches the splat (splat_place).

/// Dimension of decision `which` (DIM_SCATTER ...) at the vertex of that depth. No depth is the
/// last.
EK_FN uint bounce_dimension(uint depth, uint which) { return DIM_BOUNCE + depth * DIM_PER_BOUNCE + which; }

EK_DEFINE_HASHES(EK_FN, vu)

// By hand, since built-ins for it are missing on some devices.
EK_FN vu reverse_bits(vu x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  return (x >> 16) | (x << 16);
}

// Laine-Karras permutation: bit k of the result depends on bits 0..k alone, which on reversed words
// is an Owen scramble [Laine and Karras 2011]; the constants are those of Vegdahl ["Building a
// better LK hash", 2021].
EK_FN vu laine_karras(vu x, vu seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// The second Sobol dimension's generator matrix is the Pascal triangle mod 2, bits reversed: column
// i holds (1 + z)^i over GF(2). So reverse_bits(sobol_1(k)) are the coefficients of k(1 + z), which
// five halving steps compose.
EK_FN vu sobol_1_reversed(vu k) {
  k ^= k >> 16;
  k ^= (k >> 8) & 0x00ff00ffu;
  k ^= (k >> 4) & 0x0f0f0f0fu;
  k ^= (k >> 2) & 0x33333333u;
  k ^= (k >> 1) & 0x55555555u;
  return k;
}

/// Key of all numbers of one pixel in one replicate, for sample_2d.
/// pixel_x, pixel_y  < 2^16 in the full image: within a replicate no two pixels then share a key
/// index_high        high word of the sample's index; the low word is given to sample_2d
EK_FN vu sample_key(vu pixel_x, vu pixel_y, vu replicate, uint seed, uint index_high) {
  const vu seed_bits = hash_bits((vu)(seed) + 0x9e3779b9u);
  // The seed is hashed once more than for the pixel. Otherwise both hashes would be the same for
  // pixel (0, 0) and index_high 0, and cancel out, so that the keys of replicate 0 would not depend
  // on the seed.
  const vu high_bits = hash_bits(hash_bits(seed_bits) + index_high);
  const vu pixel = hash_bits((pixel_x ^ ((pixel_y << 16) | (pixel_y >> 16))) ^ seed_bits);
  return hash_bits((pixel + replicate * 0x85ebca6bu) ^ high_bits);
}

/// Pair of 32-bit words, uniform; over any aligned 2^m indices they form a (0,m,2)-net.
/// index      of the sample in its replicate, low word
/// dimension  DIM_* or bounce_dimension()
EK_FN void sample_2d_bits(vu key, vu index, uint dimension, vu* a, vu* b) {
  const vu seed_index = hash_bits(key + dimension * 0x9e3779b9u);
  vu seed_a = (seed_index ^ 0x6a09e667u) * 0x2c1b3c6du;
  seed_a ^= seed_a >> 15;
  vu seed_b = (seed_a ^ 0xbb67ae85u) * 0x297a2d39u;
  seed_b ^= seed_b >> 15;
  // Dimension 0 of Sobol's sequence is the reversed index, so scrambling it starts from the index
  // itself.
  const vu shuffled = reverse_bits(laine_karras(reverse_bits(index), seed_index));
  *a = reverse_bits(laine_karras(shuffled, seed_a));
  *b = reverse_bits(laine_karras(sobol_1_reversed(shuffled), seed_b));
}

/// [0, 1): at most 1 - 2^-24, where a plain conversion of the word would round up to 1.
EK_FN vf to_unit_float(vu x) { return TO_F(AS_I(x >> 8)) * 0x1p-24f; }

/// Pair in [0, 1)^2; see sample_2d_bits.
EK_FN void sample_2d(vu key, vu index, uint dimension, vf* x, vf* y) {
  vu a, b;
  sample_2d_bits(key, index, dimension, &a, &b);
  *x = to_unit_float(a);
  *y = to_unit_float(b);
}

#endif
