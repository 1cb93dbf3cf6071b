// SPDX-License-Identifier: Apache-2.0
// Hashes that host and kernels share, written once for their types of 32-bit words.
#ifndef EK_SHARED_HASH_H
#define EK_SHARED_HASH_H

/// Defines with FN, for words U:
///   hash_bits   a bijection that flips every output bit with probability near 1/2 for each flipped
///               input bit [Wellons 2018, hash-prospector; constants of its low-bias table]
///   cell_hash   the word that places the key of a cell in a hash table (CellKey)
///   cell_tag    the one that recognises it there, which is never 0
#define EK_DEFINE_HASHES(FN, U)                                                    \
  FN U hash_bits(U x) {                                                            \
    x = (x ^ (x >> 16)) * 0x21f0aaadu;                                             \
    x = (x ^ (x >> 15)) * 0xd35a2d97u;                                             \
    return x ^ (x >> 15);                                                          \
  }                                                                                \
  FN U cell_hash(U xy, U zn) { return hash_bits(xy ^ hash_bits(zn + 0x9e3779b9u)); } \
  FN U cell_tag(U xy, U hash) { return hash_bits(hash + xy * 0x85ebca6bu) | 1u; }

#endif
