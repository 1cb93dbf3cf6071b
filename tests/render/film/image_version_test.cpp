// SPDX-License-Identifier: Apache-2.0
// Sums of versions whose images differ must not be added: kImageVersion tells them apart, and this
// test says when to raise it.
#include "render/film_record.h"

#include "cli/command.h"
#include "film/exr/layout.h"
#include "film/exr/film_file.h"

namespace eikon::test {
namespace {

std::string hash_of(const std::string& scene_name, const std::string& flags) {
  const Workplace here;
  const Outcome outcome =
      here.eikon("render " + scene(scene_name) + " -o a.exr --size 24x16 --samples 0:8 --quiet " + flags);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  if (outcome.code != 0) return "";
  const Film film = read_film(here / "a.exr");
  exr::SumsHash hash(film.layout(), "", exr::light_paths_text(film.light_paths()));
  for (std::uint32_t y = 0; y < film.layout().height; ++y) hash.add_row(film.row_sums(y), film.row_counts(y));
  return hash.text();
}

struct Known {
  std::string scene, flags, hash;
};

TEST(ImageVersion, is_raised_when_the_bits_of_images_change) {
  ASSERT_EQ(kImageVersion, 19) << "put the new version here, and the new hashes below";
  const Known known[] = {
      {"cornell.gltf", "", "115744e94bd74a85"},
      {"cornell_spheres.gltf", "--filter gaussian --light-paths off", "e847c508f37c3d19"},
      {"cornell_spheres.gltf", "", "ce82d4db0a261611"},
      {"sun_room.gltf", "--filter gaussian", "29eddea8e2e8dbef"},
      {"textured.gltf", "--aov albedo,normal", "92b4e8ea5caf2209"},
      {"window_room.gltf", "--transparent", "5342349e53af1914"},
      {"veach_plates.gltf", "", "e6ed7b07a1ab46a0"},
      {"sun_room.gltf", "--light-sampling cosine", "d2e591ebbf4dc513"},
      {"veach_plates.gltf", "--light-paths 0.0625", "9cff4fabc79ad026"},
      {"roughness_metal.gltf", "--guiding 4096", "9cd1217a1c95cbe4"},
  };
  for (const Known& image : known)
    EXPECT_EQ(hash_of(image.scene, image.flags), image.hash)
        << image.scene
        << ": the bits of images have changed: raise kImageVersion in render/film_record.h, and keep the "
        << "new hashes here";
}

}  // namespace
}  // namespace eikon::test
