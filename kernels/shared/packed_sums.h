// SPDX-License-Identifier: Apache-2.0
// The packed form of a unit's film sums, which a device with memory of its own hands to the host. A
// sum has 128 bits, but those that are not zero nearly always lie within 63 places and a sign. So
// each has two words, and a byte that says how far these are to be shifted to the left.
//   [0]                                                                          number of sums
//                                                                                that do not fit
//   [EK_PACKED_HEAD + ((replicate * channels + channel) * 2 + word) * pixel_stride + pixel]   low
//                                                                                             word,
//                                                                                             high
//                                                                                             word
//   behind them, planes of bytes: byte k % 4 of plane k / 4, k = replicate * channels + channel
#ifndef EK_SHARED_PACKED_SUMS_H
#define EK_SHARED_PACKED_SUMS_H

#define EK_PACKED_HEAD 16

#endif
