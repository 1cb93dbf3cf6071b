// SPDX-License-Identifier: Apache-2.0
// Runs production kernel functions on arrays. A probe is a kernel of probes.cl, or of a file
// *_probes.cl beside its test, that includes the production headers and applies their functions to
// every item of its inputs.
#pragma once
#include <bit>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "device/device.h"
#include "shared/records.h"

namespace eikon::test {

using Words = std::vector<std::uint32_t>;

inline float as_float(std::uint32_t word) { return std::bit_cast<float>(word); }
inline std::uint32_t as_word(float x) { return std::bit_cast<std::uint32_t>(x); }
Words as_words(const std::vector<float>& values);

/// Appends the components of a vector, rounded, to inputs first to first + 2.
inline void append(std::vector<Words>& in, std::size_t first, const glm::dvec3& a) {
  for (int k = 0; k < 3; ++k) in[first + std::size_t(k)].push_back(as_word(float(a[k])));
}
/// The vector of which words first to first + 2 of an item are the components.
inline glm::dvec3 vector_at(const std::vector<Words>& words, std::size_t first, std::size_t item) {
  return {as_float(words[first][item]), as_float(words[first + 1][item]), as_float(words[first + 2][item])};
}

/// Every device that can be used, opened once for the process.
std::vector<std::unique_ptr<Device>>& devices();

/// A program's text, of which a hash is computed once: it has most of a megabyte.
struct HashedText {
  HashedText(std::string of) : text(std::move(of)), hash(std::hash<std::string>()(text)) {}
  std::string text;
  std::size_t hash;
};

/// The program of `text` on one of devices(), built when it is first asked for: a driver that has
/// it compiled already takes half a second to find that out.
const Program& program_of(Device& device, const HashedText& text, const ProgramOptions& options);

/// What one probe is given: buffers and values by the names of its kernel's arguments, and defines
/// of the program.
class Probe {
 public:
  /// subject  which part of probes.cl is compiled: EK_PROBE_<subject>
  explicit Probe(std::string subject) : subject_(std::move(subject)) {}

  Probe& define(const std::string& name, const std::string& value);
  Probe& value(const std::string& name, std::uint32_t word);
  /// So many items, evenly among all, are asked of every device and lane width; the others, which
  /// statistics need but the comparison of bits does not, of the first alone.
  Probe& compare(std::size_t items);
  /// Text behind that of probes.cl: functions that are written at run time.
  Probe& append(std::string text);
  /// The same for a file of tests/kernels. throws std::runtime_error if it cannot be read
  Probe& append_file(const std::string& path);
  template <class T, class Allocator>
  Probe& buffer(const std::string& name, const std::vector<T, Allocator>& records) {
    const auto* words = reinterpret_cast<const std::uint32_t*>(records.data());
    buffers_[name] = Words(words, words + records.size() * sizeof(T) / 4);
    return *this;
  }

  /// Provides what kernels of lights name and no light path needs.
  Probe& without_light_paths() {
    return buffer("emission_alias_table", std::vector<AliasEntry>(1))
        .buffer("emission_pdf", std::vector<float>(1))
        .buffer("emission_aim", std::vector<float>(1))
        .buffer("light_targets", std::vector<float4>(1))
        .buffer("light_aim", Words(1));
  }

  /// Runs kernel `name` over all items on the first device, and over those of compare() on every
  /// usable one at lane widths 1, 8 and 16, with and without the processor's own instructions, and
  /// expects the same bits from all of them.
  /// inputs   arrays of one length; item i of input k is word i of array k
  /// outputs  how many words the probe writes per item
  /// returns  the outputs of the first device, in the same form
  std::vector<Words> run(const std::string& name, const std::vector<Words>& inputs, unsigned outputs) const;

 private:
  std::string subject_, appended_;
  std::size_t compared_ = 65536;
  std::map<std::string, std::string> defines_;
  std::map<std::string, Words> buffers_;
  std::map<std::string, std::uint32_t> values_;
};

}  // namespace eikon::test
