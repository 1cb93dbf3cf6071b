// SPDX-License-Identifier: Apache-2.0
// Animations on the command line: stills at a time, and sequences.
#include <fmt/format.h>

#include <csignal>
#include <fstream>
#include <set>

#include "cli/batch/batch_outcome.h"
#include "film/exr/film_file.h"

namespace eikon::test {
namespace {

std::string arm(const std::string& flags, int spp = 2) {
  return fmt::format("render {} --size 24x16 --spp {} {}", scene("bending_arm.gltf"), spp, flags);
}

TEST(Sequence, a_frame_has_the_samples_that_it_has_alone) {
  const Workplace here;
  const Outcome outcome =
      here.eikon(arm("-o arm_%04d.exr --png arm_%04d.png --stats s%d.json --frames 0:12:4 --fps 12"));
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(outcome.err.empty()) << outcome.err;
  EXPECT_EQ(states(outcome), (States{{0, "done"}, {4, "done"}, {8, "done"}, {12, "done"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "frame  state") && contains(outcome.out, "4 frames in ")) << outcome.out;
  std::set<std::string> pictures;
  for (const int frame : {0, 4, 8, 12}) {
    EXPECT_TRUE(
        succeeded(here.eikon(arm(fmt::format("-o one_%d.exr --png one.png --frame {} --fps 12 --quiet", frame)))));
    EXPECT_TRUE(same_picture(here / fmt::format("one_{}.exr", frame), here / fmt::format("arm_{:04}.exr", frame)));
    EXPECT_EQ(read_bytes(here / "one.png"), read_bytes(here / fmt::format("arm_{:04}.png", frame)));
    pictures.insert(read_bytes(here / "one.png"));
    EXPECT_TRUE(succeeded(here.eikon(arm(fmt::format("-o time.exr --scene-time {} --quiet", frame / 12.0)))));
    EXPECT_TRUE(same_picture(here / "time.exr", here / fmt::format("arm_{:04}.exr", frame)));
    EXPECT_TRUE(std::filesystem::exists(here / fmt::format("s{}.json", frame)));
  }
  EXPECT_EQ(pictures.size(), 4U) << "the frames differ";
}

TEST(Sequence, what_is_done_is_skipped_and_a_lost_frame_rendered_again) {
  const Workplace here;
  const std::string command = arm("-o arm.%02d.exr --frames 0:2");
  EXPECT_EQ(states(here.eikon(command)), (States{{0, "done"}, {1, "done"}, {2, "done"}}));
  EXPECT_TRUE(std::filesystem::exists(here / "arm.frames.ledger"));
  EXPECT_EQ(states(here.eikon(command)), (States{{0, "skipped"}, {1, "skipped"}, {2, "skipped"}}));
  std::filesystem::remove(here / "arm.01.exr");
  EXPECT_EQ(states(here.eikon(command)), (States{{0, "skipped"}, {1, "done"}, {2, "skipped"}}));
  EXPECT_EQ(states(here.eikon(command + " --fps 30")), (States{{0, "done"}, {1, "done"}, {2, "done"}}))
      << "another time is another image";
}

TEST(Sequence, force_renders_what_is_done_again) {
  const Workplace here;
  const std::string command = arm("-o arm.%02d.exr --frames 0:1");
  EXPECT_EQ(states(here.eikon(command)), (States{{0, "done"}, {1, "done"}}));
  EXPECT_EQ(states(here.eikon(command + " --force")), (States{{0, "done"}, {1, "done"}}));
  EXPECT_EQ(states(here.eikon(command)), (States{{0, "skipped"}, {1, "skipped"}})) << "the key is the same";
  const Outcome alone = here.eikon(arm("-o a.exr --frame 1 --force"));
  EXPECT_EQ(alone.code, kUsage);
  EXPECT_TRUE(contains(alone.err, "--force: goes with --frames"));
}

TEST(Sequence, frames_have_the_same_bits_whatever_tree_is_refitted_to_them) {
  const Workplace here;
  for (const char* layout : {"bvh8", "bvh16", "bvh2", "cwbvh"}) {
    const std::string flags = fmt::format("--layout {} --quiet", layout);
    EXPECT_TRUE(succeeded(here.eikon(arm(fmt::format("-o {}_%02d.exr --frames 0:30:6 {}", layout, flags)))));
    for (int frame = 0; frame <= 30; frame += 6) {
      EXPECT_TRUE(succeeded(here.eikon(arm(fmt::format("-o one.exr --frame {} {}", frame, flags)))));
      EXPECT_TRUE(same_picture(here / "one.exr", here / fmt::format("{}_{:02}.exr", layout, frame))) << layout << frame;
    }
  }
}

TEST(Sequence, a_folder_for_each_frame_has_the_ledger_beside_the_folders) {
  const Workplace here;
  for (const char* folder : {"shots/0/a", "shots/1/a"}) std::filesystem::create_directories(here / folder);
  const std::string command = arm("-o shots/%d/a/still.exr --frames 0:1");
  EXPECT_EQ(states(here.eikon(command)), (States{{0, "done"}, {1, "done"}}));
  EXPECT_TRUE(std::filesystem::exists(here / "shots/still_frames.ledger"));
  EXPECT_EQ(states(here.eikon(command)), (States{{0, "skipped"}, {1, "skipped"}}));
  const Outcome nowhere = here.eikon(arm("-o none/%d.exr --frames 0:1"));
  EXPECT_TRUE(refused(nowhere, kInput));
  EXPECT_TRUE(contains(nowhere.err, "-o") && !contains(nowhere.err, "--ledger")) << nowhere.err;
}

TEST(Sequence, goes_on_after_a_kill) {
  const Workplace here;
  const std::string command = arm("-o arm_%04d.exr --frames 0:15", 8192);
  const pid_t child = here.start(command);
  wait_for_lines(here / "arm_frames.ledger", 3);  // two have begun, and the first one is done
  kill(child, SIGKILL);
  EXPECT_EQ(here.wait(child).code, 1000 + SIGKILL);
  const Outcome outcome = here.eikon(command);
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(states(outcome).at(0), "skipped") << outcome.out;
  EXPECT_EQ(states(outcome).at(15), "done") << outcome.out;
}

TEST(Sequence, a_frame_that_fails_does_not_stop_the_others) {
  const Workplace here;
  std::filesystem::create_directories(here / "arm_1.exr");  // cannot be replaced by a file
  const Outcome outcome = here.eikon(arm("-o arm_%d.exr --frames 0:2"));
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(states(outcome), (States{{0, "done"}, {1, "failed"}, {2, "done"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.err, "frame 1: "));
}

TEST(Sequence, is_refused_in_one_line_where_nothing_can_come_of_it) {
  const Workplace here;
  for (const char* flags :
       {"-o a%d.exr --frames 5:1", "-o a%d.exr --frames 3", "-o a%d.exr --frames 0:x", "-o a%d.exr --frames 0:9:0",
        "-o a%d.exr --frames 0:9:1:1", "-o a.exr --frames 0:1", "-o a%d.exr --png a.png --frames 0:1",
        "-o - --frames 0:1", "-o a%d.exr --pilot p.pilot --frames 0:1", "-o a%d.exr --frames 0:9999999",
        "-o a%d.exr --frames -1:3", "-o a%d.exr --png a%d.exr --frames 0:1", "-o a%d.exr --frames 0:1 --frame 3",
        "-o a%d.exr --frames 0:1 --scene-time 3", "-o a%d.exr --frame 3 --scene-time 3",
        "-o a%d.exr --frames 0:1 --fps 0", "-o a%d.exr --frame 1.5", "-o a%d.exr --frames 0:1 --pixel 1,1 --sample 0"})
    EXPECT_TRUE(refused(here.eikon(arm(flags)), kUsage)) << flags;
  EXPECT_TRUE(refused(here.eikon(arm("-o a.exr --animation dance")), kInput));
  EXPECT_TRUE(here.files().empty());
  const Outcome nothing = here.eikon("render none.gltf -o a%d.exr --frames 0:2");
  EXPECT_EQ(nothing.code, kInput) << "what is wrong with every frame has its own code";
  EXPECT_EQ(std::count(nothing.err.begin(), nothing.err.end(), '\n'), 1) << nothing.err;
}

TEST(Sequence, a_line_of_a_batch_may_be_one) {
  const Workplace here;
  copy_scene(here, "spinning_wheel.gltf");
  here.write("jobs", fmt::format("render spinning_wheel.gltf {0} -o w%d.exr --frames 1:2\n"
                                 "render spinning_wheel.gltf {0} -o still.exr\n",
                                 kSmall));
  const Outcome outcome = here.eikon("batch jobs");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "   1:1  done") && contains(outcome.out, "   1:2  done") &&
              contains(outcome.out, "     2  done"))
      << outcome.out;
  EXPECT_FALSE(same_picture(here / "w1.exr", here / "w2.exr"));
}

TEST(Sequence, parts_of_different_times_are_not_merged) {
  const Workplace here;
  EXPECT_TRUE(succeeded(here.eikon(arm("-o a.exr --samples 0:1 --frame 3 --quiet"))));
  EXPECT_TRUE(succeeded(here.eikon(arm("-o b.exr --samples 1:2 --frame 4 --quiet"))));
  EXPECT_TRUE(succeeded(here.eikon(arm("-o c.exr --samples 1:2 --scene-time 0.125 --quiet"))));
  EXPECT_TRUE(refused(here.eikon("merge a.exr b.exr -o whole.exr"), kInput));
  EXPECT_TRUE(succeeded(here.eikon("merge a.exr c.exr -o whole.exr"))) << "3 / 24 s";
}

TEST(Sequence, the_camera_of_a_file_without_one_stands_still) {
  const Workplace here;
  nlohmann::json file = read_json(scene("bending_arm.gltf"));
  file.erase("cameras");
  for (nlohmann::json& node : file["nodes"]) node.erase("camera");
  here.write("arm.gltf", file.dump());
  for (const char* time : {"0", "0.9"})
    EXPECT_TRUE(
        succeeded(here.eikon(fmt::format("render arm.gltf --size 24x16 --spp 1 -o {0}.exr --scene-time {0}", time))));
  const Metadata begin = read_metadata(here / "0.exr"), later = read_metadata(here / "0.9.exr");
  EXPECT_EQ(begin.matrices.at("worldToCamera"), later.matrices.at("worldToCamera"));
  EXPECT_EQ(later.numbers.at("sceneTime"), 0.9);
  EXPECT_EQ(later.strings.at("animations"), "'wave'");
}

TEST(Sequence, light_that_goes_out_does_not_bring_the_studio) {
  const Workplace here;
  here.write("lamp.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "materials": [{"emissiveFactor": [1, 1, 1]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "buffers": [{"byteLength": 68, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAIA/AACAPwAAgD8AAAAAAAAAAAAAAAA="}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
                    {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR"},
                  {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "animations": [{"samplers": [{"input": 1, "output": 2}], "channels": [{"sampler": 0, "target": {"path": "pointer",
      "extensions": {"KHR_animation_pointer": {"pointer": "/materials/0/emissiveFactor"}}}}]}]})");
  for (const char* time : {"0", "1"}) {
    const Outcome outcome = here.eikon(fmt::format(
        "render lamp.gltf --size 8x8 --spp 1 -o {0}.exr --look-at 0.2,0.2,2:0.2,0.2,0 --scene-time {0}", time));
    EXPECT_TRUE(succeeded(outcome));
    EXPECT_FALSE(contains(outcome.err, "studio"));
  }
  EXPECT_TRUE(contains(here.eikon("render lamp.gltf --size 8x8 --spp 1 -o 2.exr --scene-time 1").err, "black"));
}

TEST(Info, animations_skins_and_morph_targets_are_listed) {
  const Workplace here;
  const Outcome arm = here.eikon("info " + scene("bending_arm.gltf"));
  EXPECT_TRUE(contains(arm.out, "animation 'wave': 0 to 2 s, 3 channels\n"));
  EXPECT_TRUE(contains(arm.out, "skin 'arm': 3 joints\n"));
  const Outcome blob = here.eikon("info " + scene("morphing_blob.gltf") + " --animation none");
  EXPECT_TRUE(contains(blob.out, "animation 'breathe': 0 to 3 s, 1 channels, not in force\n"));
  EXPECT_TRUE(contains(blob.out, "mesh 'blob': 2: 'star', 'cushion'\n"));
  EXPECT_FALSE(contains(here.eikon("info " + scene("cornell.gltf")).out, "animation"));
}

}  // namespace
}  // namespace eikon::test
