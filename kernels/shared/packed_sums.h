// SPDX-License-Identifier: Apache-2.0
// The packed form of a unit's film sums, which a device with memory of its own hands to the host. A
// sum has 128 bits, but those that are not zero nearly always lie within 63 places and a sign. So
// each has two words, and a byte that says how far these are to be shifted to the left.
// A pixel has n = replicates * channels sums; one has the index k = replicate * channels + channel.
// Words:
//   [0]                                    number of sums that do not fit
//   [EK_PACKED_HEAD + plane * pixel_stride + pixel]
//     plane 2 k, 2 k + 1                   low and high word of the signed number of sum k
//     plane 2 n + k / 4                    its byte k % 4 is the shift of sum k
#ifndef EK_SHARED_PACKED_SUMS_H
#define EK_SHARED_PACKED_SUMS_H

#define EK_PACKED_HEAD 16

#endif
