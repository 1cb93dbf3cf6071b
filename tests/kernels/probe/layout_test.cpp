// SPDX-License-Identifier: Apache-2.0
// Host and device must agree on every field of every shared record, in memory and in lanes.
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "device/device.h"
#include "device/kernel_sources.h"
#include "shared/records.h"

namespace eikon {
namespace {

struct Expected {
  std::string name;
  std::uint32_t value;
};

// Builds `body` into a kernel on each device, and compares the words that it writes.
void expect_words(const std::string& body, const std::vector<Expected>& expected) {
  const std::string text = expand_includes(
      "#include \"lanes/record_lanes.h\"\nkernel void layout(global uint* out, global const uint* words) {\n" + body + "}\n",
      "layout.cl");
  std::vector<std::uint32_t> counted(48);
  for (std::uint32_t i = 0; i < counted.size(); ++i) counted[i] = i;
  for (const DeviceInfo& info : list_devices()) {
    if (!info.unusable.empty()) continue;
    Device device(info);
    const Buffer out = device.allocate(expected.size() * 4), words = device.upload(counted);
    device.fill_zero(out);
    Arguments arguments;
    arguments.set("out", out);
    arguments.set("words", words);
    Kernel kernel = device.build(text, {.defines = {{"EK_WIDTH", "16"}}, .optimise = false}).kernel("layout");
    kernel.bind(arguments);
    device.run(kernel, 1, 1, 1);
    const auto found = device.read_all<std::uint32_t>(out);
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_EQ(found[i], expected[i].value) << expected[i].name << " on " << info.name;
  }
}

TEST(Layout, every_field_of_every_shared_record_lies_where_the_host_has_it) {
  std::vector<Expected> expected;
  std::string body;
  const auto field = [&](const std::string& record, const std::string& name, std::size_t offset) {
    expected.push_back({record + "." + name, std::uint32_t(offset)});
    body += "  *out++ = (uint)((private char*)&x." + name + " - (private char*)&x);\n";
  };
#define EK_RECORD(T)                                             \
  {                                                              \
    using Record = T;                                            \
    const std::string record = #T;                               \
    expected.push_back({"sizeof " #T, std::uint32_t(sizeof(T))}); \
    body += "  { " #T " x; *out++ = (uint)sizeof(x);\n";
#define EK_MEMBER(type, name) field(record, #name, offsetof(Record, name));
#define EK_ARRAY(type, name, count) EK_MEMBER(type, name)
#define EK_FLOAT(name) EK_MEMBER(float, name)
#define EK_UINT(name) EK_MEMBER(uint, name)
#define EK_FLOAT3(name, x, y, z) EK_MEMBER(float, x) EK_MEMBER(float, y) EK_MEMBER(float, z)
#define EK_RECORD_END(T, bytes) \
  body += "  }\n";              \
  }
#include "shared/records.def"
  expect_words(body, expected);
}

TEST(Layout, records_in_lanes_have_the_words_that_the_host_has_in_memory) {
  std::vector<Expected> expected;
  std::string body;
  const auto field = [&](const std::string& record, const std::string& lanes, std::size_t offset) {
    expected.push_back({record + " " + lanes, std::uint32_t(offset / 4)});
    body += "  *out++ = as_uint(x." + lanes + ".s0);\n";
  };
#define EK_PART(T, part, Name, name)                                                     \
  {                                                                                      \
    using Record = T;                                                                    \
    const std::string record = #Name;                                                    \
    body += "  { " #Name "Lanes x = load_" #name "((global const " #T "*)words, (vu)(0u));\n";
#define EK_FLOAT(name) field(record, #name, offsetof(Record, name));
#define EK_UINT(name) EK_FLOAT(name)
#define EK_FLOAT3(name, a, b, c)                \
  field(record, #name ".x", offsetof(Record, a)); \
  field(record, #name ".y", offsetof(Record, b)); \
  field(record, #name ".z", offsetof(Record, c));
#define EK_PART_END(T, part, Name, name) \
  body += "  }\n";                       \
  }
#include "shared/records.def"
  expect_words(body, expected);
}

}  // namespace
}  // namespace eikon
