// SPDX-License-Identifier: Apache-2.0
// Binaries in PoCL's format, without PoCL: what is left out, what is kept, and that other bytes are
// never taken for one.
#include "device/store/pocl_binary.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "support/temporary_folder.h"

namespace eikon::test {
namespace {

template <class Number>
std::string bytes_of(Number number) {
  return {reinterpret_cast<const char*>(&number), sizeof number};
}

std::string text_of(const std::string& text) { return bytes_of(std::uint32_t(text.size())) + text; }

std::string kernel_of(const std::string& name, const std::string& code) {
  const std::string about = bytes_of(std::uint32_t{7}) + text_of(name) + "arguments";
  const std::string files = text_of("/" + name + "/0-0-0/" + name + ".so") + text_of(code);
  return bytes_of(std::uint64_t(16 + about.size() + files.size())) + bytes_of(std::uint64_t(files.size())) + about +
         files;
}

const std::string kProgramName = "AB/CDEFGHIJKLMNOPABCDEFGHIJKLMNOPABCDEFG";
const std::string kBitcode = "BC\xC0\xDE and the rest of a program";

std::string header(std::uint32_t format, std::uint32_t kernels) {
  return std::string("poclbin\0 device ", 16) + bytes_of(format) + bytes_of(kernels) + "twelve flags" + kProgramName +
         '\0';
}

std::string program(const std::string& bitcode) {
  const std::string file = text_of("/program.bc") + text_of(bitcode);
  return bytes_of(std::uint64_t(file.size())) + file;
}

std::string binary_of(std::uint32_t format, const std::string& bitcode, const std::string& kernels) {
  return header(format, 2) + program(bitcode) + kernels;
}

const std::string kKernels = kernel_of("first", "code of the first") + kernel_of("second", "more code");
const std::string kWholeBinary = binary_of(9, kBitcode, kKernels);

TEST(PoclBinary, loses_its_bitcode_and_keeps_everything_else) {
  const auto without = without_bitcode(kWholeBinary);
  ASSERT_TRUE(without);
  std::string expected = header(9, 2);
  expected[expected.size() - 2] = 'Z';
  EXPECT_EQ(*without, expected + program(std::string("BC\xC0\xDE\x21\x08\0\0\x01\0\0\0\0\0\0\0", 16)) + kKernels);
  EXPECT_EQ(without_bitcode(*without), without);
}

TEST(PoclBinary, of_another_format_stays_as_it_is) {
  EXPECT_FALSE(without_bitcode(binary_of(8, kBitcode, kKernels)));
  EXPECT_FALSE(without_bitcode(binary_of(10, kBitcode, kKernels)));
  EXPECT_FALSE(without_bitcode(binary_of(9, "text", kKernels)));
  EXPECT_FALSE(without_bitcode(binary_of(9, kBitcode, kernel_of("first", "code"))));
  EXPECT_FALSE(without_bitcode(kWholeBinary + "x"));
  for (std::size_t size = 0; size < kWholeBinary.size(); ++size)
    EXPECT_FALSE(without_bitcode(kWholeBinary.substr(0, size))) << size;
  for (std::size_t byte = 0; byte < kWholeBinary.size(); ++byte)
    for (const char value : {'\0', '\x7f', '\xff'}) {  // lengths among them that reach far beyond the end
      std::string changed = kWholeBinary;
      changed[byte] = value;
      const auto without = without_bitcode(changed);
      EXPECT_TRUE(!without || without->size() < kWholeBinary.size()) << byte;
      (void)is_unpacked(changed, "nowhere");
    }
}

TEST(PoclBinary, without_machine_code_of_a_kernel_stays_as_it_is) {
  const std::string nothing = bytes_of(std::uint64_t{24}) + bytes_of(std::uint64_t{0}) + "argument";
  EXPECT_FALSE(without_bitcode(binary_of(9, kBitcode, kernel_of("first", "code") + nothing)));
}

TEST(PoclBinary, is_unpacked_when_all_its_machine_code_is_there) {
  const TemporaryFolder folder;
  const std::string binary = without_bitcode(kWholeBinary).value_or("");
  const std::filesystem::path unpacked = folder / (kProgramName.substr(0, 39) + "Z");
  EXPECT_FALSE(is_unpacked(binary, folder.path()));
  for (const std::string name : {"first", "second"}) {
    std::filesystem::create_directories(unpacked / name / "0-0-0");
    EXPECT_FALSE(is_unpacked(binary, folder.path()));
    std::ofstream(unpacked / name / "0-0-0" / (name + ".so")) << (name == "first" ? "code of the first" : "more code");
  }
  EXPECT_TRUE(is_unpacked(binary, folder.path()));
  EXPECT_FALSE(is_unpacked(kWholeBinary, folder.path())) << "of the whole binary, which has a folder of its own";
  std::filesystem::resize_file(unpacked / "second/0-0-0/second.so", 3);
  EXPECT_FALSE(is_unpacked(binary, folder.path()));
  EXPECT_TRUE(is_unpacked(binary_of(8, kBitcode, kKernels), folder.path())) << "another format has its bitcode";
}

}  // namespace
}  // namespace eikon::test
