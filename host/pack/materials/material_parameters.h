// SPDX-License-Identifier: Apache-2.0
// The rows of records.def that hold a parameter of a material as the scene has it.
#pragma once
#include <cstddef>
#include <optional>

#include "pack/features.h"
#include "scene/scene.h"
#include "shared/records.h"

namespace eikon {

struct MaterialTexture {
  std::optional<Texture> Material::*of;
  Feature feature;                   // of the programs that look it up
  float Material::*scale = nullptr;  // of normal maps
};

/// ParametersOf<Record>::visit(use) calls use(parameter, word) for each such row of the record: a
/// pointer to a float or a colour of Material, or a MaterialTexture, and its first word.
template <class Record>
struct ParametersOf;
#define EK_RECORD(T)                                     \
  template <>                                            \
  struct ParametersOf<T> {                               \
    using Record = T;                                    \
    template <class Use>                                 \
    static void visit([[maybe_unused]] const Use& use) {
#define EK_FACTOR(name) use(&Material::name, offsetof(Record, name) / 4);
#define EK_COLOR(name) use(&Material::name, offsetof(Record, name##_r) / 4);
#define EK_TEXTURE(name, feature) use(MaterialTexture{&Material::name, Feature::feature}, offsetof(Record, name) / 4);
#define EK_NORMAL_TEXTURE(name, scale) \
  use(MaterialTexture{&Material::name, Feature::normal_texture, &Material::scale}, offsetof(Record, name) / 4);
#define EK_RECORD_END(T, bytes) \
    }                           \
  };
#include "shared/records.def"

}  // namespace eikon
