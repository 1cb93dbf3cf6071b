// SPDX-License-Identifier: Apache-2.0
// Renders that open the programs of earlier ones from their binaries, in a cache folder of their
// own.
#include "cli/render/checkpoint_files.h"

namespace eikon::test {
namespace {

constexpr const char* kOwnCache = "POCL_CACHE_DIR=$PWD/cache";

bool runs_on_pocl(const Workplace& here) { return bool(contains(here.eikon("devices").out, "pthread")); }

/// Removes PoCL's own folders, or only eikon's.
void remove_from_cache(const Workplace& here, bool of_eikon) {
  std::vector<std::filesystem::path> removed;
  for (const auto& entry : std::filesystem::directory_iterator(here / "cache"))
    if ((entry.path().filename() == "eikon") == of_eikon) removed.push_back(entry.path());
  ASSERT_FALSE(removed.empty());
  for (const auto& path : removed) std::filesystem::remove_all(path);
}

TEST(StoredPrograms, an_image_is_the_same_whatever_is_left_of_the_cache) {
  const Workplace here;
  if (!runs_on_pocl(here)) GTEST_SKIP() << "needs PoCL; other drivers keep their own binaries";
  ASSERT_TRUE(succeeded(here.eikon(cornell(), kOwnCache)));
  const auto planes = read_exr(here / "out.exr").planes;
  const auto files = std::distance(std::filesystem::directory_iterator(here / "cache/eikon"), {});
  EXPECT_GT(files, 0);
  const auto again = [&] {
    ASSERT_TRUE(succeeded(here.eikon(cornell(), kOwnCache)));
    EXPECT_EQ(read_exr(here / "out.exr").planes, planes);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(here / "cache/eikon"), {}), files);
  };
  again();
  remove_from_cache(here, false);
  again();
  remove_from_cache(here, true);
  again();
  again();
}

TEST(StoredPrograms, processes_fill_one_cache_at_once) {
  const Workplace here;
  if (!runs_on_pocl(here)) GTEST_SKIP() << "needs PoCL; other drivers keep their own binaries";
  const std::string render =
      Workplace::binary() + " render " + scene("cornell.gltf") + " --size 16x12 --spp 4 --quiet -o ";
  const std::string cache = std::string(kOwnCache) + " ";
  const std::string both = "(" + cache + render + "a.exr & " + cache + render + "b.exr & wait)";
  ASSERT_TRUE(succeeded(here.shell(both + " && " + both + " && " + cache + render + "c.exr")));
  const auto planes = read_exr(here / "c.exr").planes;
  EXPECT_EQ(read_exr(here / "a.exr").planes, planes);
  EXPECT_EQ(read_exr(here / "b.exr").planes, planes);
  for (const auto& entry : std::filesystem::directory_iterator(here / "cache/eikon"))
    EXPECT_FALSE(entry.path().filename().string().starts_with(".")) << entry.path() << " was left behind";
}

TEST(StoredPrograms, nothing_is_kept_where_PoCL_keeps_nothing) {
  const Workplace here;
  if (!runs_on_pocl(here)) GTEST_SKIP() << "needs PoCL; other drivers keep their own binaries";
  ASSERT_TRUE(succeeded(here.eikon(cornell(), std::string(kOwnCache) + " POCL_KERNEL_CACHE=0")));
  EXPECT_FALSE(std::filesystem::exists(here / "cache/eikon"));
}

}  // namespace
}  // namespace eikon::test
