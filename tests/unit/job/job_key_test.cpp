// SPDX-License-Identifier: Apache-2.0
#include "job/batch/job_key.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace eikon::test {
namespace {

class JobKey : public ::testing::Test {
 protected:
  TemporaryFolder folder;
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
  }
  [[nodiscard]] std::uint64_t digest() const { return digest_scene_files(folder / "scene.gltf").hash; }
};

TEST_F(JobKey, every_file_that_a_scene_names_counts_and_its_date_does_not) {
  write("scene.gltf", R"({"buffers": [{"uri": "a%20b.bin"}], "images": [{"uri": "i.png"}, {"uri": "data:,x"}],
                         "extras": {"environment": {"uri": "sky.exr"}}, "extensions": {"x": [{"uri": "../out"}]}})");
  for (const char* name : {"a b.bin", "i.png", "sky.exr"}) write(name, "1");
  std::uint64_t last = digest();
  const Digest first = digest_scene_files(folder / "scene.gltf");
  EXPECT_EQ(first.bytes > 3, true);
  for (const char* name : {"a b.bin", "i.png", "sky.exr"}) {
    std::filesystem::last_write_time(folder / name, std::filesystem::file_time_type::clock::now());
    EXPECT_EQ(digest(), last) << name;
    write(name, "2");
    EXPECT_NE(digest(), last) << name;
    last = digest();
    std::filesystem::remove(folder / name);
    EXPECT_NE(digest(), last) << name << " is missing";
    write(name, "2");
    EXPECT_EQ(digest(), last);
  }
  write("other.txt", "1");
  EXPECT_EQ(digest(), last);
  write("a b.bin", "3");
  write("i.png", "2");
  const std::uint64_t swapped = digest();
  write("a b.bin", "2");
  write("i.png", "3");
  EXPECT_NE(digest(), swapped) << "which file has what counts";
}

TEST_F(JobKey, broken_scenes_are_the_loader_s_to_refuse) {
  for (const std::string& text :
       {std::string("{"), std::string("nonsense"), std::string("glTF\2\0\0\0\xff\xff\xff\xff", 12),
        std::string(100000, '['), std::string(R"({"uri": 3, "a": {"uri": ""}})")}) {
    write("scene.gltf", text);
    write("scene.glb", text);
    EXPECT_NO_THROW((void)digest_scene_files(folder / "scene.gltf"));
    EXPECT_NO_THROW((void)digest_scene_files(folder / "scene.glb"));
  }
  EXPECT_THROW((void)digest_scene_files(folder / "absent.gltf"), InputError);
  EXPECT_THROW((void)digest_scene_files(folder.path()), InputError);
}

TEST_F(JobKey, keys_differ_with_each_part) {
  const Digest a{1, 10}, b{2, 10};
  const std::string key = job_key(a, b, "spp=4");
  EXPECT_EQ(key.size(), 16U);
  EXPECT_EQ(key, job_key(a, b, "spp=4"));
  EXPECT_NE(key, job_key(b, a, "spp=4"));
  EXPECT_NE(key, job_key(a, a, "spp=4"));
  EXPECT_NE(key, job_key(a, b, "spp=5"));
}

}  // namespace
}  // namespace eikon::test
