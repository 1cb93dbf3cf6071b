// SPDX-License-Identifier: Apache-2.0
// The records of shared/records.def in lanes, one record per lane: for every part a struct
// <Name>Lanes of its fields, and
//   load_<name>(records, i)   that part of record i of each lane
//   broadcast_<name>(record)  that part of one record in all lanes
//   <name>_lanes(words)       the same of words that were loaded in another way
#ifndef EK_RECORD_LANES_H
#define EK_RECORD_LANES_H
#include "lanes/lanes.h"

#define EK_PART(T, part, Name, name) typedef struct {
#define EK_FLOAT(name) vf name;
#define EK_UINT(name) vu name;
#define EK_FLOAT3(name, x, y, z) v3 name;
#define EK_UNUSED(words) vu unused[words];
#define EK_PART_END(T, part, Name, name)                                               \
  } Name##Lanes;                                                                       \
  EK_ASSERT_SIZE(Name##Lanes, sizeof(Rec));                                            \
  EK_FN Name##Lanes name##_lanes(Rec words) {                                          \
    union { Rec words; Name##Lanes fields; } record;                                   \
    record.words = words;                                                              \
    return record.fields;                                                              \
  }                                                                                    \
  EK_FN Name##Lanes load_##name(global const T* records, vu i) {                       \
    return name##_lanes(rec16(records, i * (uint)(sizeof(T) / 64) + (uint)(part)));    \
  }
#include "shared/records.def"

#define EK_PART(T, part, Name, name) \
  EK_FN Name##Lanes broadcast_##name(global const T* record) { \
    Name##Lanes lanes;
#define EK_FLOAT(name) lanes.name = (vf)(record->name);
#define EK_UINT(name) lanes.name = (vu)(record->name);
#define EK_FLOAT3(name, a, b, c) \
  lanes.name.x = (vf)(record->a); lanes.name.y = (vf)(record->b); lanes.name.z = (vf)(record->c);
#define EK_PART_END(T, part, Name, name) \
    return lanes; \
  }
#include "shared/records.def"

// One field of record i of each lane, where the whole record would be more than is needed.
#define EK_WORD(T, field) ((uint)(__builtin_offsetof(T, field) / 4))
#define load_word_f(T, records, i, field) \
  gather_f((global const float*)(records), (i) * (uint)(sizeof(T) / 4) + EK_WORD(T, field))
#define load_word_u(T, records, i, field) \
  gather_u((global const uint*)(records), (i) * (uint)(sizeof(T) / 4) + EK_WORD(T, field))

#endif
