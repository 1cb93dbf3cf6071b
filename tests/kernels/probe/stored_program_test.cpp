// SPDX-License-Identifier: Apache-2.0
// Programs that PoCL opens from a binary: the same kernels, arguments and results as from the text.
#include "device/store/program_store.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "device/cl.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace eikon::test {
namespace {

/// Sets a variable of the environment until the end of the block.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* const before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~EnvironmentVariable() {
    if (before_)
      setenv(name_, before_->c_str(), 1);
    else
      unsetenv(name_);
  }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

const char* const kStoredText = R"(
  #pragma OPENCL FP_CONTRACT OFF
  kernel void roots(global const float* stored_in, global float* stored_out, uint stored_count) {
    const uint i = get_global_id(0);
    if (i < stored_count) stored_out[i] = sqrt(stored_in[i]) / 3.0f + STORED_OFFSET;
  }
  kernel void count(global uint* stored_counts, uint stored_step) {
    local uint most[2];
    most[get_local_id(0) % 2] = stored_step;
    barrier(CLK_LOCAL_MEM_FENCE);
    stored_counts[get_global_id(0)] = most[0] * (uint)get_global_id(0);
  })";
const ProgramOptions kStoredOptions{.defines = {{"STORED_OFFSET", "0.25f"}}};
constexpr std::uint32_t kStoredCount = 100;

/// Keeps the binaries of this test in a folder of its own. PoCL's cache stays where it was when
/// PoCL started.
class StoredPrograms : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const DeviceInfo& info : select_devices("all"))
      if (is_pocl(info)) info_ = info;
    if (info_.name.empty()) GTEST_SKIP() << "needs PoCL; other drivers keep their own";
    cache_.emplace("POCL_CACHE_DIR", folder_.path().string());
  }

  /// The words that both kernels write.
  static std::vector<std::uint32_t> run(Device& device, const Program& program) {
    std::vector<float> in(kStoredCount);
    for (std::uint32_t i = 0; i < kStoredCount; ++i) in[i] = float(i) * 0.7f;
    const Buffer out = device.allocate(4 * kStoredCount), counts = device.allocate(4 * kStoredCount);
    Arguments arguments;
    arguments.set("stored_in", device.upload(in));
    arguments.set("stored_out", out);
    arguments.set("stored_counts", counts);
    arguments.set("stored_count", kStoredCount);
    arguments.set("stored_step", 3);
    for (const char* const name : {"roots", "count"}) {
      Kernel kernel = program.kernel(name);
      kernel.bind(arguments);
      device.run(kernel, name == std::string("roots") ? kStoredCount : kStoredCount / 4,
                 name == std::string("roots") ? 1 : 4);
      device.finish();
    }
    std::vector<std::uint32_t> words = device.read_all<std::uint32_t>(out);
    const std::vector<std::uint32_t> more = device.read_all<std::uint32_t>(counts);
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  std::vector<std::uint32_t> run(const ProgramOptions& options = kStoredOptions) const {
    Device device(info_);
    return run(device, device.build(kStoredText, options));
  }

  /// Whether the program is opened from its text, and not from a binary.
  [[nodiscard]] bool is_compiled(const ProgramOptions& options = kStoredOptions) const {
    const ClDevice device = open_device(info_);
    cl_device_id id = device.get();
    cl_int code = CL_SUCCESS;
    const ClContext context(clCreateContext(nullptr, 1, &id, nullptr, nullptr, &code));
    const auto program = build_program(context.get(), id, info_, kStoredText, options);
    std::size_t size = 0;
    clGetProgramInfo(program->program.get(), CL_PROGRAM_SOURCE, 0, nullptr, &size);
    return size > 1;
  }

  [[nodiscard]] std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> found;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "eikon", none))
      found.push_back(entry.path());
    return found;
  }

  DeviceInfo info_;
  TemporaryFolder folder_;
  std::optional<EnvironmentVariable> cache_;
};

TEST_F(StoredPrograms, a_binary_gives_the_results_of_the_text) {
  EXPECT_TRUE(is_compiled());
  EXPECT_EQ(files().size(), 0U) << "kept before its kernels have run";
  const auto words = run();
  ASSERT_EQ(files().size(), 1U);
  EXPECT_FALSE(is_compiled());
  EXPECT_EQ(run(), words);
  EXPECT_EQ(files().size(), 1U);
  EXPECT_FALSE(contains(read_bytes(files()[0]), "FP_CONTRACT"));
  EXPECT_FALSE(contains(read_bytes(files()[0]), "llvm")) << "the program's bitcode is still there";
}

TEST_F(StoredPrograms, a_program_is_kept_when_its_last_kernel_has_run) {
  Device device(info_);
  const Program program = device.build(kStoredText, kStoredOptions);
  Arguments arguments;
  arguments.set("stored_counts", device.allocate(4 * kStoredCount));
  arguments.set("stored_step", 1);
  Kernel kernel = program.kernel("count");
  kernel.bind(arguments);
  device.run(kernel, kStoredCount / 4, 4);
  device.finish();
  EXPECT_EQ(files().size(), 0U);
  run(device, program);
  EXPECT_EQ(files().size(), 1U);
}

TEST_F(StoredPrograms, an_argument_of_a_binary_that_nobody_provides_is_named) {
  run();
  ASSERT_FALSE(is_compiled());
  Device device(info_);
  Kernel kernel = device.build(kStoredText, kStoredOptions).kernel("roots");
  Arguments arguments;
  arguments.set("stored_in", device.allocate(4 * kStoredCount));
  EXPECT_EQ(message_of<InternalError>([&] { kernel.bind(arguments); }),
            "kernel 'roots' wants a buffer 'stored_out' that nobody provides");
  arguments.set("stored_out", device.allocate(4 * kStoredCount));
  EXPECT_EQ(message_of<InternalError>([&] { kernel.bind(arguments); }),
            "kernel 'roots' wants a value 'stored_count' that nobody provides");
  EXPECT_THROW((void)device.build(kStoredText, kStoredOptions).kernel("other"), InternalError);
}

TEST_F(StoredPrograms, other_defines_variables_and_devices_without_optimisation_have_no_part_in_it) {
  const auto words = run();
  const ProgramOptions other{.defines = {{"STORED_OFFSET", "0.5f"}}};
  EXPECT_TRUE(is_compiled(other));
  EXPECT_NE(run(other), words);
  EXPECT_EQ(files().size(), 2U);
  EXPECT_TRUE(is_compiled({.defines = kStoredOptions.defines, .optimise = false}));
  {
    const EnvironmentVariable method("POCL_WORK_GROUP_METHOD", "loopvec");
    EXPECT_TRUE(is_compiled());
  }
  EXPECT_FALSE(is_compiled());
}

TEST_F(StoredPrograms, the_text_is_compiled_where_the_file_is_damaged_or_of_another_driver) {
  const auto words = run();
  ASSERT_EQ(files().size(), 1U);
  const std::string whole = read_bytes(files()[0]);
  std::string other_driver = whole;
  other_driver[whole.find("PoCL") + 5] = '9';
  std::string other_binary = whole;
  other_binary[whole.size() - 100] ^= 1;
  for (const std::string& damaged : {std::string(), whole.substr(0, whole.size() / 2), other_driver, other_binary}) {
    std::ofstream(files()[0], std::ios::binary) << damaged;
    EXPECT_TRUE(is_compiled());
    EXPECT_EQ(run(), words);
    EXPECT_EQ(read_bytes(files()[0]).size(), whole.size()) << "not replaced";
    EXPECT_FALSE(is_compiled());
  }
}

TEST_F(StoredPrograms, a_binary_that_the_driver_refuses_is_replaced) {
  const auto words = run();
  const StoredProgram wrong = [&] {
    const ClDevice device = open_device(info_);
    cl_device_id id = device.get();
    cl_int code = CL_SUCCESS;
    const ClContext context(clCreateContext(nullptr, 1, &id, nullptr, nullptr, &code));
    std::filesystem::remove(files()[0]);
    return *build_program(context.get(), id, info_, kStoredText, kStoredOptions)->stored;
  }();
  wrong.keep(std::string(4000, 'x'));
  EXPECT_TRUE(is_compiled());
  EXPECT_EQ(run(), words);
  EXPECT_FALSE(is_compiled());
}

TEST_F(StoredPrograms, the_text_is_compiled_where_the_machine_code_of_a_binary_was_not_unpacked) {
  const auto words = run();
  EXPECT_EQ(run(), words);
  const std::string kept = read_bytes(files().at(0));
  const std::string name = kept.substr(kept.find("poclbin") + 36, 40);  // of the folder, behind 36 bytes of header
  ASSERT_TRUE(name.ends_with('Z')) << name;
  const std::filesystem::path library = *folder_of_running_pocl() / name / "roots/0-0-0/roots.so";
  ASSERT_TRUE(std::filesystem::remove(library));  // and not made shorter, because this process has it in its memory
  std::ofstream(library, std::ios::binary).flush();
  EXPECT_TRUE(is_compiled());
  EXPECT_EQ(run(), words);
  std::filesystem::remove(library);
  EXPECT_FALSE(is_compiled()) << "PoCL did not unpack it again";
  EXPECT_EQ(run(), words);
}

TEST_F(StoredPrograms, nothing_is_kept_where_PoCL_keeps_nothing_or_compiles_more_variants) {
  {
    const EnvironmentVariable no_cache("POCL_KERNEL_CACHE", "0");
    run();
    EXPECT_EQ(files().size(), 0U);
  }
  {
    const EnvironmentVariable variants("POCL_WORK_GROUP_SPECIALIZATION", "1");
    run();
    EXPECT_EQ(files().size(), 0U);
  }
}

TEST_F(StoredPrograms, programs_are_built_where_the_folder_cannot_be_written) {
  const auto words = run();
  const EnvironmentVariable cache("POCL_CACHE_DIR", folder_.write("file", "not a folder").string());
  EXPECT_TRUE(is_compiled());
  EXPECT_EQ(run(), words);
}

TEST_F(StoredPrograms, a_part_of_a_device_opens_the_binary_of_the_whole) {
  if (!info_.divisible || info_.whole_units < 2) GTEST_SKIP() << info_.name << " cannot be divided";
  const auto words = run();
  info_.compute_units = 1;
  EXPECT_FALSE(is_compiled());
  EXPECT_EQ(run(), words);
  std::filesystem::remove(files()[0]);
  EXPECT_EQ(run(), words);
  EXPECT_FALSE(is_compiled());
}

}  // namespace
}  // namespace eikon::test
