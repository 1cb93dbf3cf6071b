// SPDX-License-Identifier: Apache-2.0
// The other commands, help, and an installed binary.
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/command.h"
#include "device/kernel_sources.h"
#include "support/paths.h"

namespace eikon::test {
namespace {

using nlohmann::json;

TEST(Commands, names_of_files_cannot_rewrite_the_terminal) {
  const Workplace here;
  std::filesystem::copy_file(scene("furnace.gltf"), here / "evil\x1b[2J.gltf");
  const std::string render = "render 'evil\x1b[2J.gltf' --devices cpu --size 4x4 --spp 2 --quiet ";
  here.write("jobs.txt", "render nothing.gltf -o 'evil\x1b[2J.exr'\nrender 'evil\x1b[2J.gltf' --no-such-flag\n");
  const std::string info = "info 'evil\x1b[2J.gltf'", merge = "merge 'part\x1b[2J.exr' -o 'all\x1b[2J.exr'";
  for (const std::string& command :
       {info, render + "-o 'out\x1b[2J.exr'", render + "--samples 0:1 -o 'part\x1b[2J.exr'", merge,
        render + "--camera nowhere", std::string("batch jobs.txt")}) {
    const Outcome outcome = here.eikon(command);
    EXPECT_TRUE(contains(outcome.out + outcome.err, "[2J.")) << command << ": " << outcome.out << outcome.err;
    EXPECT_FALSE(contains(outcome.out + outcome.err, "\x1b")) << command;
  }
}

TEST(Commands, one_that_is_missing_or_not_there_is_named_with_those_that_are) {
  const Workplace here;
  const std::pair<const char*, const char*> cases[] = {
      {"rendr a.gltf -o a.exr", "eikon: there is no command 'rendr'; there is render, batch"},
      {"bench frames", "eikon: there is no command 'frames'; there is rays, scene; try `eikon bench --help`"},
      {"bench", "eikon: a command is missing; there is rays, scene; try `eikon bench --help`"},
      {"", "eikon: a command is missing; there is render, batch"}};
  for (const auto& [words, said] : cases) {
    const Outcome outcome = here.eikon(words);
    EXPECT_TRUE(refused(outcome, kUsage)) << words;
    EXPECT_TRUE(contains(outcome.err, said));
  }
}

TEST(Commands, words_that_are_wrong_are_named_with_what_to_do) {
  const Workplace here;
  const std::pair<const char*, const char*> cases[] = {
      {"--vers", "eikon: there is no flag '--vers', but there is --version; try `eikon --help`"},
      {"render a.gltf --width 480", "eikon: there is no flag '--width'; try `eikon render --help`"},
      {"render a.gltf --thredas=3", "eikon: there is no flag '--thredas', but there is --threads; try"},
      {"render --sp", "eikon: there is no flag '--sp', but there is --spp; try"},
      {"render a.gltf b.gltf", "eikon: 'b.gltf' is one word too many; try"},
      {"render a.gltf --spp", "eikon: --spp needs a value; try"},
      {"render a.gltf --half --png", "eikon: --png needs a value; try"},
      {"render a.gltf --quiet --half=3", "eikon: --half takes no value; try"},
      {"render a.gltf --spp 1 --spp 2", "eikon: --spp is given 2 times, but takes one value; try"},
      {"render a.gltf --quiet=3", "eikon: --quiet takes no value; try"},
      {"render a.gltf --frame 1 --scene-time 2", "eikon: --scene-time and --frame do not go together; try"},
      {"bench rays", "eikon: SCENE is required; try `eikon bench rays --help`"}};
  for (const auto& [words, said] : cases) {
    const Outcome outcome = here.eikon(words);
    EXPECT_TRUE(refused(outcome, kUsage)) << words;
    EXPECT_TRUE(contains(outcome.err, said));
  }
}

TEST(Commands, a_flag_is_no_value_of_the_one_before_it_unless_it_is_joined) {
  const Workplace here;
  const std::pair<const char*, const char*> cases[] = {
      {"--stats --half", "--stats needs a value, but --half follows; write --stats=--half if you mean that"},
      {"--png --spp=4", "--png needs a value, but --spp=4 follows"},
      {"--stats -o b.exr", "--stats needs a value, but -o follows"},
      {"-o --quiet", "-o needs a value, but --quiet follows; write --output=--quiet"}};
  for (const auto& [flags, said] : cases) {
    const Outcome outcome = here.eikon("render " + scene("furnace.gltf") + " --size 4x4 --spp 1 " + flags);
    EXPECT_TRUE(refused(outcome, kUsage)) << flags;
    EXPECT_TRUE(contains(outcome.err, said));
  }
  here.write("jobs", "render a.gltf --stats --half\n");
  EXPECT_TRUE(contains(here.eikon("batch jobs").err, "--stats needs a value, but --half follows"));
  EXPECT_EQ(here.files(), (std::vector<std::string>{"jobs", "jobs.ledger"}));
  EXPECT_TRUE(succeeded(here.eikon(cornell("--size 4x4 --spp 1 --quiet --stats=--half --exposure -1 --png -.png"))));
  EXPECT_TRUE(std::filesystem::exists(here / "--half"));
}

TEST(Commands, help_of_each_shows_an_example) {
  const Workplace here;
  const Outcome all = here.eikon("--help");
  EXPECT_TRUE(succeeded(all));
  EXPECT_TRUE(contains(all.out, "Example") && contains(all.out, "Exit codes"));
  for (const char* command : {"render", "batch", "merge", "info", "devices", "compare", "selftest", "meter", "measure",
                              "bench", "bench rays", "bench scene"}) {
    EXPECT_TRUE(contains(all.out, std::string(command).substr(0, 5))) << command;
    const Outcome outcome = here.eikon(std::string(command) + " --help");
    EXPECT_TRUE(succeeded(outcome)) << command;
    EXPECT_TRUE(contains(outcome.out, "Example") && contains(outcome.out, std::string("eikon ") + command))
        << outcome.out;
    EXPECT_TRUE(outcome.err.empty()) << outcome.err;
  }
  EXPECT_TRUE(contains(here.eikon("--version").out, "eikon "));
}

TEST(Commands, help_shows_flags_in_groups_each_in_one_line_and_the_environment_last) {
  const Workplace here;
  const std::string help = here.eikon("render --help").out;
  std::size_t at = 0;
  for (const char* group : {"\nScene:", "\nImage:", "\nLight:", "\nDevices", "\nOutput", "\nDiagnosis", "\nExample",
                            "\nEnvironment variables:", "\nFor developers:"}) {
    const std::size_t next = help.find(group);
    ASSERT_NE(next, std::string::npos) << group;
    EXPECT_GT(next, at) << group;
    at = next;
  }
  for (const char* name :
       {"EIKON_OIDN", "EIKON_WATCHDOG", "EIKON_KERNEL_DIR", "EIKON_LANES", "EIKON_STAGES", "EIKON_UNIT_PATHS",
        "EIKON_UNIT_BLOCK", "EIKON_NO_OPTIMISE", "EIKON_DUMP_PROGRAMS", "EIKON_DIVISION", "EIKON_TICKS", "EIKON_FAULT"})
    EXPECT_TRUE(contains(help, name)) << name;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);)
    EXPECT_FALSE(line.starts_with("          ")) << "continues the line before it: " << line;
  EXPECT_FALSE(contains(here.eikon("devices --help").out, "--spp"));
}

TEST(Commands, help_needs_no_device) {
  const Workplace here;
  EXPECT_TRUE(succeeded(here.eikon("render --help", "OCL_ICD_VENDORS=/nonexistent")));
}

TEST(Commands, devices_lists_what_there_is) {
  const Workplace here;
  const Outcome outcome = here.eikon("devices");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "0: ") && contains(outcome.out, "compute units") && contains(outcome.out, "driver"))
      << outcome.out;
  const Outcome two = here.eikon("devices", "POCL_DEVICES='pthread pthread'");
  EXPECT_TRUE(contains(two.out, "1: "));
  EXPECT_TRUE(contains(two.out, "is the hardware of device 0"));  // the processor, once more
  EXPECT_TRUE(contains(two.out, "host: "));
}

TEST(Commands, selftest_trusts_this_driver) {
  const Workplace here;
  const Outcome outcome = here.eikon("selftest");
  EXPECT_TRUE(succeeded(outcome)) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "arithmetic") && contains(outcome.out, "furnace")) << outcome.out;
  EXPECT_FALSE(contains(outcome.out, "FAIL"));
}

TEST(Commands, selftest_tells_a_driver_that_is_wrong) {
  const Workplace here;
  // The kernels of this binary, not of the source tree: that may be newer, or change while it is
  // copied.
  for (const auto& [name, text] : embedded_kernels()) {
    std::filesystem::create_directories((here / "kernels" / name).parent_path());
    here.write("kernels/" + name, text);
  }
  std::string film = read_bytes(here / "kernels/film/fixed_point.h");
  const std::string exact = "- 86;";  // the film's unit
  ASSERT_TRUE(contains(film, exact));
  std::ofstream(here / "kernels/film/fixed_point.h") << film.replace(film.find(exact), exact.size(), "- 85;");
  const Outcome outcome = here.eikon("selftest", "EIKON_KERNEL_DIR=" + (here / "kernels").string());
  EXPECT_EQ(outcome.code, 4);
  EXPECT_TRUE(contains(outcome.out, "FAIL"));
  EXPECT_EQ(outcome.err.rfind("eikon: ", 0), 0U) << outcome.err;
}

TEST(Commands, info_prints_the_ledger) {
  const Workplace here;
  const Outcome outcome = here.eikon("info " + scene("cornell.gltf"));
  EXPECT_TRUE(succeeded(outcome));
  for (const char* line :
       {"triangles", "diffuse", "area", "environment", "vertex_normal", "next_event", "in ", "out ",
        "'light': ", "memory", "bvh8", "bvh2", "W (lm)", "material 'white': diffuse", "emits (", "textures\n  none"})
    EXPECT_TRUE(contains(outcome.out, line)) << line << " in\n" << outcome.out;
  // Who needs it, or why it is out.
  EXPECT_TRUE(contains(outcome.out, "environment      out"));
  EXPECT_TRUE(contains(here.eikon("info " + scene("sphere_in_sky.gltf")).out, "environment      in"));
}

TEST(Commands, compare_measures_and_judges) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("cornell.gltf") + " -o a.exr --size 16x16 --spp 16 --quiet")));
  ASSERT_TRUE(
      succeeded(here.eikon("render " + scene("cornell.gltf") + " -o b.exr --size 16x16 --spp 16 --seed 7 --quiet")));
  const Outcome same = here.eikon("compare a.exr a.exr --json --fail-above 0");
  EXPECT_TRUE(succeeded(same));
  EXPECT_EQ(json::parse(same.out).at("relmse").get<double>(), 0);
  EXPECT_EQ(json::parse(same.out).at("ratio_of_means").get<double>(), 1);
  const Outcome other = here.eikon("compare a.exr b.exr --json --png difference.png");
  EXPECT_TRUE(succeeded(other));
  const json found = json::parse(other.out);
  for (const char* metric : {"mse", "relmse", "mape"}) EXPECT_GT(found.at(metric).get<double>(), 0) << metric;
  EXPECT_EQ(read_bytes(here / "difference.png").substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(here.eikon("compare a.exr b.exr --fail-above 1e-9").code, 1);
  EXPECT_EQ(here.eikon("compare a.exr b.exr --fail-above 1e9").code, 0);
  EXPECT_TRUE(contains(here.eikon("compare a.exr b.exr").out, "relMSE"));
  EXPECT_TRUE(refused(here.eikon("compare a.exr b.exr --png nowhere/x.png"), 3));
}

TEST(Commands, an_installed_eikon_needs_nothing_of_the_source_tree) {
  const Workplace here;
  const std::string prefix = (here / "prefix").string();
  const std::string build = std::filesystem::path(EIKON_BINARY).parent_path().string();
  ASSERT_EQ(std::system(("cmake --install '" + build + "' --prefix '" + prefix + "' >/dev/null").c_str()), 0);
  std::filesystem::copy(scene("furnace.gltf"), here / "furnace.gltf");
  // No name of the source tree or the build may be in it; the kernels are inside.
  const std::string binary = read_bytes(prefix + "/bin/eikon");
  EXPECT_FALSE(contains(binary, std::string(EIKON_SOURCE_DIR) + "/"));
  EXPECT_TRUE(contains(binary, "Stage `intersect`"));
  EXPECT_TRUE(succeeded(here.shell(
      "env -i PATH=/usr/bin:/bin HOME=\"$PWD\" ./prefix/bin/eikon render furnace.gltf --size 8x8 --spp 4 --quiet")));
  EXPECT_TRUE(std::filesystem::exists(here / "furnace.exr"));
}

}  // namespace
}  // namespace eikon::test
