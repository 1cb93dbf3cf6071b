// SPDX-License-Identifier: Apache-2.0
// Manual pages, completion in shells, and the package of Debian: all made from the parser.
#include <regex>
#include <set>
#include <sstream>

#include "cli/command.h"

namespace eikon::test {
namespace {

/// The commands that `eikon --help` lists, and those below `bench`.
std::vector<std::string> commands(const Workplace& here) {
  std::vector<std::string> names;
  for (const std::string above : {"", "bench "}) {
    std::istringstream lines(here.eikon(above + "--help").out);
    bool below = false;
    for (std::string line; std::getline(lines, line);) {
      if (below && !line.starts_with("  ")) break;
      if (below) names.push_back(above + line.substr(2, line.find(' ', 2) - 2));
      below = below || line == "Subcommands:";
    }
  }
  return names;
}

/// The long flags that `--help` of a command lists in its first column, and --help.
std::set<std::string> flags_of(const Workplace& here, const std::string& command) {
  const std::string help = here.eikon(command + " --help").out;
  std::set<std::string> flags = {"--help"};
  const std::regex flag("\n  (?:-\\w,)?(--[a-z0-9-]+)");
  for (std::sregex_iterator at(help.begin(), help.end(), flag), end; at != end; ++at) flags.insert((*at)[1]);
  return flags;
}

/// The words of a text that begin with two dashes.
std::set<std::string> dashed(const std::string& text) {
  std::set<std::string> flags;
  std::istringstream words(text);
  for (std::string word; words >> word;)
    if (word.starts_with("--")) flags.insert(word);
  return flags;
}

/// Completes a line as bash does, whose last word is being written.
std::string in_bash(const Workplace& here, const std::string& words) {
  const Outcome outcome = here.shell("bash -c 'source ./eikon.bash; COMP_WORDS=(" + words +
                                     "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _eikon; echo \"${COMPREPLY[@]}\"'");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(outcome.err, "");
  return outcome.out;
}

std::string in_fish(const Workplace& here, const std::string& line) {
  const Outcome outcome =
      here.shell("fish --no-config -c 'source ./eikon.fish; complete -C \"" + line + "\"' | cut -f1");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(outcome.err, "");
  return outcome.out;
}

bool has_program(const Workplace& here, const std::string& name) { return here.shell("command -v " + name).code == 0; }

TEST(HelpPages, bash_completes_every_flag_of_every_command) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.shell(here.binary() + " completion bash > eikon.bash && bash -n eikon.bash")));
  const std::vector<std::string> all = commands(here);
  ASSERT_GT(all.size(), 12U);
  for (const std::string& command : all)
    EXPECT_EQ(dashed(in_bash(here, "eikon " + command + " --")), flags_of(here, command)) << command;
}

TEST(HelpPages, bash_completes_commands_values_lists_and_files) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.shell(here.binary() + " completion bash > eikon.bash")));
  here.write("my scene.gltf", "");
  EXPECT_EQ(in_bash(here, "eikon ren"), "render\n");
  EXPECT_EQ(in_bash(here, "eikon bench r"), "rays\n");
  EXPECT_EQ(in_bash(here, "eikon man me"), "merge meter measure\n");
  EXPECT_EQ(in_bash(here, "eikon man bench \"\""), "rays scene\n");
  EXPECT_EQ(in_bash(here, "eikon man bench rays \"\""), "\n");
  EXPECT_EQ(in_bash(here, "eikon render --energy-compensation \"\""), "off on\n");
  EXPECT_EQ(in_bash(here, "eikon render x.gltf --tonemap = a"), "aces agx\n");
  EXPECT_EQ(in_bash(here, "eikon render --aov albedo,dep"), "albedo,depth\n");
  EXPECT_EQ(in_bash(here, "eikon render my"), "my scene.gltf\n");
  EXPECT_EQ(in_bash(here, "eikon render -o my"), "my scene.gltf\n");
  EXPECT_EQ(in_bash(here, "eikon render --spp my"), "\n");
}

TEST(HelpPages, fish_completes_every_flag_of_every_command) {
  const Workplace here;
  if (!has_program(here, "fish")) GTEST_SKIP() << "fish is not installed";
  ASSERT_TRUE(succeeded(here.shell(here.binary() + " completion fish > eikon.fish && fish --no-execute eikon.fish")));
  for (const std::string& command : commands(here))
    EXPECT_EQ(dashed(in_fish(here, "eikon " + command + " --")), flags_of(here, command)) << command;
  EXPECT_EQ(in_fish(here, "eikon ren"), "render\n");
  EXPECT_EQ(in_fish(here, "eikon bench r"), "rays\n");
  EXPECT_EQ(in_fish(here, "eikon man me"), "measure\nmerge\nmeter\n");
  EXPECT_EQ(in_fish(here, "eikon man bench "), "rays\nscene\n");
  EXPECT_EQ(in_fish(here, "eikon render x.gltf --tonemap a"), "aces\nagx\n");
  EXPECT_EQ(in_fish(here, "eikon render --aov albedo,dep"), "albedo,depth\n");
}

TEST(HelpPages, zsh_knows_every_flag_of_every_command) {
  const Workplace here;
  if (!has_program(here, "zsh")) GTEST_SKIP() << "zsh is not installed";
  ASSERT_TRUE(succeeded(here.shell(here.binary() + " completion zsh > _eikon && zsh -n _eikon")));
  // Its completion needs a terminal, so that _arguments stands in here and prints what it is told.
  const Outcome outcome = here.shell(
      "zsh -fc '_describe() { :; }; _arguments() { print -l -- \"$@\"; }; words=(eikon \"\"); CURRENT=2; source "
      "./_eikon "
      ">/dev/null; for f in ${(k)functions[(I)_eikon_*]}; do print -- \"FUNCTION $f\"; $f; done; print FUNCTION'");
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(contains(outcome.out, "FUNCTION _eikon_man_bench_rays\n"));
  for (const std::string& command : commands(here)) {
    const std::string name = "FUNCTION _eikon_" + std::regex_replace(command, std::regex(" "), "_") + "\n";
    const std::size_t begin = outcome.out.find(name);
    ASSERT_NE(begin, std::string::npos) << name;
    const std::string told = outcome.out.substr(begin, outcome.out.find("\nFUNCTION", begin) - begin);
    std::set<std::string> flags;
    const std::regex flag("\\)(--[a-z0-9-]+?)(=-?)?\\[");
    for (std::sregex_iterator at(told.begin(), told.end(), flag), end; at != end; ++at) flags.insert((*at)[1]);
    EXPECT_EQ(flags, flags_of(here, command)) << command << ": " << told;
  }
}

TEST(HelpPages, every_command_has_a_manual_page_that_mandoc_accepts) {
  const Workplace here;
  std::filesystem::create_directory(here / "man1");
  ASSERT_TRUE(succeeded(here.eikon("man --folder man1")));
  const bool lint = has_program(here, "mandoc");
  std::set<std::string> pages = {"eikon.1"};
  for (const std::string& command : commands(here)) {
    const std::string name = "eikon-" + std::regex_replace(command, std::regex(" "), "-");
    pages.insert(name + ".1");
    const std::string page = read_bytes(here / ("man1/" + name + ".1"));
    EXPECT_EQ(here.eikon("man " + command).out, page) << "differs from what is installed";
    std::string plain = std::regex_replace(page, std::regex("\\\\-"), "-");
    for (const std::string& flag : flags_of(here, command)) EXPECT_TRUE(contains(plain, flag)) << name << " " << flag;
    EXPECT_TRUE(contains(page, ".SH EXAMPLES\n")) << name;
    if (lint) {
      const Outcome warnings = here.shell("mandoc -Tlint -W warning man1/" + name + ".1");
      EXPECT_EQ(warnings.out + warnings.err, "") << name;
    }
  }
  std::set<std::string> written;
  for (const auto& entry : std::filesystem::directory_iterator(here / "man1"))
    written.insert(entry.path().filename().string());
  EXPECT_EQ(written, pages);
  if (!lint) GTEST_SKIP() << "mandoc is not installed";
}

TEST(HelpPages, wrong_words_are_refused_in_one_line) {
  const Workplace here;
  EXPECT_TRUE(refused(here.eikon("man bench raus"), kUsage));
  EXPECT_TRUE(refused(here.eikon("man devices more"), kUsage));
  EXPECT_TRUE(refused(here.eikon("man render --folder ."), kUsage));
  EXPECT_TRUE(refused(here.eikon("man --folder nowhere"), kInput));
  EXPECT_TRUE(refused(here.eikon("completion tcsh"), kUsage));
  EXPECT_TRUE(refused(here.eikon("completion"), kUsage));
}

TEST(HelpPages, the_debian_package_holds_the_program_its_pages_and_what_it_depends_on) {
  const Workplace here;
  if (!has_program(here, "dpkg-shlibdeps")) GTEST_SKIP() << "dpkg-dev is not installed";
  const std::string build = std::filesystem::path(EIKON_BINARY).parent_path().string();
  ASSERT_TRUE(succeeded(here.shell("cpack -G DEB --config '" + build + "/CPackConfig.cmake' -B . >/dev/null")));
  const Outcome list = here.shell("dpkg-deb --contents eikon_*.deb | sed 's/.* [.]//'");
  ASSERT_TRUE(succeeded(list));
  for (const char* file : {"/usr/bin/eikon", "/usr/share/man/man1/eikon.1", "/usr/share/man/man1/eikon-bench-rays.1",
                           "/usr/share/bash-completion/completions/eikon", "/usr/share/zsh/vendor-completions/_eikon",
                           "/usr/share/fish/vendor_completions.d/eikon.fish", "/usr/share/doc/eikon/copyright",
                           "/usr/share/doc/eikon/examples/cornell.gltf"})
    EXPECT_TRUE(contains(list.out, std::string(file) + "\n")) << file << " is not in\n" << list.out;
  const std::string depends = here.shell("dpkg-deb --field eikon_*.deb Depends").out;
  for (const char* package : {"pocl-opencl-icd | opencl-icd", "libopenexr", "ocl-icd-libopencl1", "libtbb", "libc6"})
    EXPECT_TRUE(contains(depends, package));
  ASSERT_TRUE(succeeded(here.shell("dpkg-deb --extract eikon_*.deb root")));
  EXPECT_TRUE(succeeded(here.shell("./root/usr/bin/eikon info root/usr/share/doc/eikon/examples/cornell.gltf")));
}

}  // namespace
}  // namespace eikon::test
