// SPDX-License-Identifier: Apache-2.0
// That the lanes of the kernels' text become vector registers. A compiler that takes them apart
// says nothing and renders five times slower, so this reads the machine code that PoCL keeps in its
// cache.
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>

#include "cli/command.h"

namespace eikon::test {
namespace {

struct Code {
  std::uint64_t all = 0;            // instructions
  std::uint64_t wide = 0;           // on registers of the widest kind that the lanes fill
  std::uint64_t wide_floats = 0;    // of these + - * / sqrt
  std::uint64_t scalar_floats = 0;  // + - * / sqrt of single floats
};

/// Machine code of everything in PoCL's cache folder: by name of kernel, and of each of its
/// functions as "kernel.function".
std::map<std::string, Code> code_in(const Workplace& here, const std::string& wide_register) {
  const std::regex instruction(R"(^\s+[0-9a-f]+:\s)"), float_operation(R"(\sv?(add|sub|mul|div|sqrt)(p|s)s\s)"),
      function(R"(^[0-9a-f]+ <(\w+)>:$)");
  std::map<std::string, Code> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(here / "cache")) {
    if (entry.path().extension() != ".so") continue;
    const Outcome listing = here.shell("objdump -d --no-show-raw-insn '" + entry.path().string() + "'");
    EXPECT_EQ(listing.code, 0) << listing.err;
    const std::string kernel = entry.path().stem().string();
    std::array<Code*, 2> counted{&found[kernel], &found[kernel + "."]};
    std::istringstream lines(listing.out);
    std::smatch match;
    for (std::string line; std::getline(lines, line);) {
      if (std::regex_search(line, match, function)) counted[1] = &found[kernel + "." + match[1].str()];
      if (!std::regex_search(line, instruction)) continue;
      const bool wide = line.find(wide_register) != std::string::npos,
                 floats = std::regex_search(line, match, float_operation);
      for (Code* const code : counted) {
        ++code->all;
        code->wide += wide;
        if (!floats) continue;
        code->scalar_floats += match[2] == "s";
        code->wide_floats += wide;
      }
    }
  }
  return found;
}

/// What the device's lanes should be in: "%zmm" for 16, "%ymm" for 8; empty where this test cannot
/// tell.
std::string wide_register_of(const Workplace& here) {
  const Outcome devices = here.eikon("devices");
  if (!contains(devices.out, "pthread") || here.shell("objdump --version").code != 0) return "";
  const Outcome flags = here.shell("grep -m1 ^flags /proc/cpuinfo");
  if (contains(devices.out, "runs 16 lanes")) return contains(flags.out, " avx512dq") ? "%zmm" : "";
  return contains(devices.out, "runs 8 lanes") && contains(flags.out, " avx2") ? "%ymm" : "";
}

// The scene has all that is in the way of vector code: textures, GGX, transmission, an environment
// map.
void expect_vectors(const std::string& stages, const std::map<std::string, double>& least_share) {
  const Workplace here;
  const std::string wide_register = wide_register_of(here);
  if (wide_register.empty()) GTEST_SKIP() << "needs PoCL on a processor with vectors, and objdump";
  std::filesystem::create_directory(here / "cache");
  for (const char* name : {"cornell.gltf", "rough_glass.gltf"}) {
    std::filesystem::remove_all(here / "cache");
    std::filesystem::create_directory(here / "cache");
    const Outcome outcome = here.eikon("render " + scene(name) + " --size 16x16 --spp 1 -o o.exr --quiet",
                                       "POCL_CACHE_DIR=" + (here / "cache").string() + " EIKON_STAGES=" + stages);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::map<std::string, Code> found = code_in(here, wide_register);
    for (const auto& [kernel, share] : least_share) {
      ASSERT_EQ(found.count(kernel), 1U) << "no code of " << kernel << " in the cache";
      const Code& code = found.at(kernel);
      EXPECT_GE(double(code.wide) / double(code.all), share)
          << name << ", " << kernel << ": " << code.wide << " of " << code.all << " instructions use " << wide_register;
      EXPECT_LE(code.scalar_floats * 10, code.wide_floats)
          << name << ", " << kernel << ": " << code.scalar_floats << " operations on single floats, "
          << code.wide_floats << " on " << wide_register;
    }
  }
}

// About half of what is there now.
TEST(GeneratedCode, stages_in_one_launch_fill_vector_registers) {
  expect_vectors("fused", {{"paths", 0.2},
                           {"paths.stage_generate", 0.4},
                           {"paths.stage_intersect", 0.1},
                           {"paths.stage_shade", 0.25},
                           {"paths.stage_shadow", 0.1}});
}
TEST(GeneratedCode, stages_launched_one_by_one_fill_vector_registers) {
  // The kernel "generate" is small beside PoCL's loops over work-items, which are around each
  // kernel.
  expect_vectors("unfused", {{"generate.stage_generate", 0.4}, {"intersect", 0.1}, {"shade", 0.25}, {"shadow", 0.1}});
}

}  // namespace
}  // namespace eikon::test
