// SPDX-License-Identifier: Apache-2.0
// Has the functions of libktx that eikon calls, and a picture of its own for every file: pixel i of level l is
// (i, 2 i, l, 255 - i), and levels follow each other from the smallest as in libktx. A file whose first level is empty is
// damaged, as far as it is concerned.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

struct Texture;
struct Methods {
  void (*destroy)(Texture*);
  int (*image_offset)(Texture*, std::uint32_t, std::uint32_t, std::uint32_t, std::size_t*);
};
struct Texture {
  int version;
  const Methods* methods;
  std::uint32_t width, height, levels;
  bool basis;
  std::vector<std::uint8_t> data;
};

std::size_t level_bytes(const Texture& t, std::uint32_t level) {
  return std::size_t{4} * std::max(t.width >> level, 1U) * std::max(t.height >> level, 1U);
}

int image_offset(Texture* t, std::uint32_t level, std::uint32_t, std::uint32_t, std::size_t* offset) {
  *offset = 0;
  for (std::uint32_t smaller = level + 1; smaller < t->levels; ++smaller) *offset += level_bytes(*t, smaller);
  return 0;
}

const Methods kMethods{[](Texture* t) { delete t; }, image_offset};

}  // namespace

extern "C" {

int ktxTexture2_CreateFromMemory(const std::uint8_t* bytes, std::size_t size, std::uint32_t flags, Texture** texture) {
  const auto word = [&](std::size_t at) {
    return static_cast<std::uint32_t>(bytes[at] | bytes[at + 1] << 8 | bytes[at + 2] << 16 | bytes[at + 3] << 24);
  };
  if (size < 104 || word(88) == 0 || flags != 1) return 1;
  *texture = new Texture{2, &kMethods, word(20), word(24), word(40), word(12) == 0, {}};
  return 0;
}

bool ktxTexture2_NeedsTranscoding(Texture* t) { return t->basis; }

int ktxTexture2_TranscodeBasis(Texture* t, int format, std::uint32_t) {
  if (format != 13) return 2;
  for (std::uint32_t level = t->levels; level-- > 0;) {
    for (std::size_t i = 0; i < level_bytes(*t, level) / 4; ++i)
      for (const std::size_t value : {i, 2 * i, std::size_t{level}, 255 - i})
        t->data.push_back(static_cast<std::uint8_t>(value));
  }
  return 0;
}

std::uint8_t* ktxTexture_GetData(Texture* t) { return t->data.data(); }
std::size_t ktxTexture_GetDataSize(Texture* t) { return t->data.size(); }
const char* ktxErrorString(int code) { return code == 1 ? "stand-in: no data" : "stand-in: another format"; }
}
