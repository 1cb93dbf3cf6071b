// SPDX-License-Identifier: Apache-2.0
// The file of a program's binary, without a device: what is not whole, or of something else, is
// never taken.
#include "device/store/program_store.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <thread>
#include <vector>

#include "support/temporary_folder.h"

namespace eikon::test {
namespace {

using Found = std::optional<std::string>;

const std::string kBinary("a binary of\0zeros and lines\n", 28);

StoredProgram stored_in(const TemporaryFolder& folder, const std::string& driver = "driver 1",
                        const std::string& flags = "-w", const std::string& text = "kernel void f() {}") {
  return {folder / "eikon", driver, flags, text};
}

TEST(ProgramStore, returns_what_was_kept_last) {
  const TemporaryFolder folder;
  const StoredProgram stored = stored_in(folder);
  EXPECT_EQ(stored.find(), Found());
  stored.keep("another");
  stored.keep(kBinary);
  EXPECT_EQ(stored.find(), Found(kBinary));
  EXPECT_EQ(stored_in(folder).find(), Found(kBinary));
  const auto permissions = std::filesystem::status(folder / "eikon").permissions();
  EXPECT_EQ(permissions & (std::filesystem::perms::group_all | std::filesystem::perms::others_all),
            std::filesystem::perms::none);
}

TEST(ProgramStore, takes_nothing_of_another_driver_or_flags_or_text_even_under_the_same_name) {
  const TemporaryFolder folder;
  const StoredProgram stored = stored_in(folder);
  stored.keep(kBinary);
  for (const StoredProgram& other :
       {stored_in(folder, "driver 2"), stored_in(folder, "driver 1", "-w -Dx"),
        stored_in(folder, "driver 1", "-w", "kernel void g() {}"),
        stored_in(folder, "driver 1", "-w", "kernel void f() {}\n"), stored_in(folder, "driver 1\n-w", "")}) {
    EXPECT_NE(other.file(), stored.file());
    EXPECT_EQ(other.find(), Found());
    std::filesystem::copy_file(stored.file(), other.file());
    EXPECT_EQ(other.find(), Found());
    other.keep("other");
    EXPECT_EQ(other.find(), Found("other"));
  }
  EXPECT_EQ(stored.find(), Found(kBinary));
}

TEST(ProgramStore, takes_no_damaged_file_and_replaces_it) {
  const TemporaryFolder folder;
  const StoredProgram stored = stored_in(folder);
  stored.keep(kBinary);
  const std::string whole = read_bytes(stored.file());
  std::vector<std::string> damaged = {whole + "x", whole + whole, std::string(5000, '\0')};
  for (std::size_t i = 0; i < whole.size(); ++i) {
    damaged.push_back(whole.substr(0, i));
    damaged.push_back(whole);
    damaged.back()[i] = char(damaged.back()[i] ^ (1 << i % 8));
  }
  for (const std::string& bytes : damaged) {
    std::ofstream(stored.file(), std::ios::binary) << bytes;
    ASSERT_EQ(stored.find(), Found()) << bytes;
    stored.keep(kBinary);
    ASSERT_EQ(stored.find(), Found(kBinary));
  }
}

TEST(ProgramStore, is_silent_where_nothing_can_be_written) {
  const TemporaryFolder folder;
  const StoredProgram nowhere(folder / "missing/eikon", "", "", "");
  nowhere.keep(kBinary);
  EXPECT_EQ(nowhere.find(), Found());
  const StoredProgram in_a_file(folder.write("file", "not a folder"), "", "", "");
  in_a_file.keep(kBinary);
  EXPECT_EQ(in_a_file.find(), Found());
  EXPECT_EQ(folder.file_count(), 1U);

  const StoredProgram taken = stored_in(folder);
  std::filesystem::create_directories(taken.file());
  taken.keep(kBinary);
  EXPECT_EQ(taken.find(), Found());
}

TEST(ProgramStore, leaves_nothing_of_a_file_for_which_there_is_no_room) {
  const TemporaryFolder folder;
  const StoredProgram stored = stored_in(folder);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit little{.rlim_cur = 1000, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &little), 0);
  stored.keep(std::string(5000, 'x'));
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_EQ(stored.find(), Found());
  EXPECT_TRUE(std::filesystem::is_empty(folder / "eikon"));
}

TEST(ProgramStore, a_use_is_noted_in_the_files_date) {
  const TemporaryFolder folder;
  const StoredProgram stored = stored_in(folder);
  stored.keep(kBinary);
  const auto long_ago = std::filesystem::file_time_type::clock::now() - std::chrono::hours(48);
  std::filesystem::last_write_time(stored.file(), long_ago);
  EXPECT_EQ(stored_in(folder, "driver 2").find(), Found());
  EXPECT_EQ(std::filesystem::last_write_time(stored.file()), long_ago);
  EXPECT_EQ(stored.find(), Found(kBinary));
  EXPECT_GT(std::filesystem::last_write_time(stored.file()), long_ago + std::chrono::hours(24));
}

TEST(ProgramStore, forgets_what_was_not_used_for_the_longest_time) {
  const TemporaryFolder folder;
  const auto now = std::filesystem::file_time_type::clock::now();
  for (int i = 0; i < 10; ++i)  // the one with the last name was not used for the longest time
    std::filesystem::last_write_time(folder.write(std::to_string(i), std::string(100, 'x')),
                                     now - std::chrono::hours(i));
  std::filesystem::create_directory(folder / "folder");
  forget_oldest(folder.path(), 1000);
  EXPECT_EQ(folder.file_count(), 11U);
  forget_oldest(folder.path(), 999);
  EXPECT_EQ(folder.file_count(), 8U) << "three quarters of 999 bytes";
  for (int i = 0; i < 10; ++i) EXPECT_EQ(std::filesystem::exists(folder / std::to_string(i)), i < 7) << i;
  forget_oldest(folder / "missing", 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "folder"));
}

TEST(ProgramStore, a_folder_that_has_become_large_loses_its_oldest_file_when_another_is_kept) {
  const TemporaryFolder folder;
  const StoredProgram first = stored_in(folder), second = stored_in(folder, "driver 2");
  first.keep(kBinary);
  std::filesystem::resize_file(first.file(), std::uintmax_t{1} << 30);  // without blocks on the disk
  std::filesystem::last_write_time(first.file(),
                                   std::filesystem::file_time_type::clock::now() - std::chrono::hours(48));
  second.keep(kBinary);
  EXPECT_FALSE(std::filesystem::exists(first.file()));
  EXPECT_EQ(second.find(), Found(kBinary));
}

TEST(ProgramStore, threads_find_a_whole_binary_or_none) {
  const TemporaryFolder folder;
  std::atomic<int> found = 0, wrong = 0;
  {
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < 4; ++thread)
      threads.emplace_back([&, thread] {
        const StoredProgram stored = stored_in(folder);
        for (int round = 0; round < 50; ++round) {
          if (thread % 2 == 0) stored.keep(std::string(std::size_t(10000 + 1000 * thread), char('a' + thread)));
          const Found binary = stored.find();
          found += binary ? 1 : 0;
          wrong += binary && *binary != std::string(binary->size(), binary->front()) ? 1 : 0;
        }
      });
  }
  EXPECT_GT(found, 0);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / "eikon"), {}), 1);
}

}  // namespace
}  // namespace eikon::test
