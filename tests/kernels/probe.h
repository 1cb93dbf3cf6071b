// SPDX-License-Identifier: Apache-2.0
// Runs production kernel functions on arrays. A probe is a kernel of probes.cl that includes the production headers and
// applies their functions to every item of its inputs.
#pragma once
#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace eikon::test {

using Words = std::vector<std::uint32_t>;

inline float as_float(std::uint32_t word) { return std::bit_cast<float>(word); }
inline std::uint32_t as_word(float x) { return std::bit_cast<std::uint32_t>(x); }
Words as_words(const std::vector<float>& values);

/// What one probe is given: buffers and values by the names of its kernel's arguments, and defines of the program.
class Probe {
 public:
  /// subject  which part of probes.cl is compiled: EK_PROBE_<subject>
  explicit Probe(std::string subject) : subject_(std::move(subject)) {}

  Probe& define(const std::string& name, const std::string& value);
  Probe& value(const std::string& name, std::uint32_t word);
  /// Text behind that of probes.cl: functions that are written at run time.
  Probe& append(std::string text);
  template <class T, class Allocator>
  Probe& buffer(const std::string& name, const std::vector<T, Allocator>& records) {
    const auto* words = reinterpret_cast<const std::uint32_t*>(records.data());
    buffers_[name] = Words(words, words + records.size() * sizeof(T) / 4);
    return *this;
  }

  /// Runs kernel `name` over all items on every usable device, at lane widths 1, 8 and 16, with and without the
  /// processor's own instructions, and expects the same bits from all of them.
  /// inputs   arrays of one length; item i of input k is word i of array k
  /// outputs  how many words the probe writes per item
  /// returns  the outputs of the first device, in the same form
  std::vector<Words> run(const std::string& name, const std::vector<Words>& inputs, unsigned outputs) const;

 private:
  std::string subject_, appended_;
  std::map<std::string, std::string> defines_;
  std::map<std::string, Words> buffers_;
  std::map<std::string, std::uint32_t> values_;
};

}  // namespace eikon::test
