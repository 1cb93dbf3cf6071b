// SPDX-License-Identifier: Apache-2.0
#include "device/kernel_conditions.h"

#include <gtest/gtest.h>

#include "device/kernel_sources.h"
#include "support/messages.h"

namespace eikon {
namespace {

using test::contains;

const std::map<std::string, std::string> kDefines = {{"YES", "1"}, {"ALSO", "1"}, {"NO", "0"}, {"EIGHT", "8"}};

std::string left(const std::string& text) { return without_excluded(text, kDefines); }

/// What is left of "in" under a condition and of "out" under its #else.
std::string choice(const std::string& condition) { return left("#if " + condition + "\nin\n#else\nout\n#endif\n"); }

TEST(KernelConditions, leave_the_part_that_is_compiled) {
  EXPECT_EQ(choice("YES"), "in\n");
  EXPECT_EQ(choice("NO  // why"), "out\n");
  EXPECT_EQ(choice("YES & ALSO"), "in\n");
  EXPECT_EQ(choice("YES && NO"), "out\n");
  EXPECT_EQ(choice("NO | ALSO"), "in\n");
  EXPECT_EQ(choice("!NO && (NO || YES)"), "in\n");
  EXPECT_EQ(choice("!(YES | NO) | NO & UNKNOWN"), "out\n") << "as in C, & binds more tightly";
  EXPECT_EQ(choice("UNKNOWN || YES"), "in\n");
}

TEST(KernelConditions, that_are_not_known_are_left_to_the_compiler) {
  for (const char* condition : {"UNKNOWN", "YES & UNKNOWN", "EIGHT", "EIGHT == 8", "NO + YES", "defined(YES)", "2",
                                "YES YES", "YES)", "(YES", ""}) {
    const std::string text = std::string("#if ") + condition + "\nin\n#else\nout\n#endif\n";
    EXPECT_EQ(left(text), text);
  }
  EXPECT_EQ(left("#ifdef NO\na\n#endif\n#ifndef YES\nb\n#endif\n"), "#ifdef NO\na\n#endif\n#ifndef YES\nb\n#endif\n");
}

TEST(KernelConditions, may_be_nested) {
  EXPECT_EQ(left("#if NO\n#if YES\na\n#else\nb\n#endif\n#ifdef X\nc\n#endif\n#else\nd\n#endif\ne\n"), "d\ne\n");
  EXPECT_EQ(left("#if UNKNOWN\n#if YES\na\n#else\nb\n#endif\n#else\nc\n#endif\n"),
            "#if UNKNOWN\na\n#else\nc\n#endif\n");
}

TEST(KernelConditions, may_be_chained) {
  EXPECT_EQ(left("#if NO\na\n#elif YES\nb\n#elif ALSO\nc\n#else\nd\n#endif\n"), "b\n");
  EXPECT_EQ(left("#if YES\na\n#elif UNKNOWN\nb\n#else\nc\n#endif\n"), "a\n");
  EXPECT_EQ(left("#if NO\na\n#elif UNKNOWN\nb\n#elif YES\nc\n#else\nd\n#endif\n"),
            "#if UNKNOWN\nb\n#elif YES\nc\n#else\nd\n#endif\n");
  EXPECT_EQ(left("#if UNKNOWN\na\n#elif YES\nb\n#endif\n"), "#if UNKNOWN\na\n#elif YES\nb\n#endif\n");
}

TEST(KernelConditions, know_macros_of_the_text) {
  EXPECT_EQ(left("#define BOTH (YES & ALSO)\n#if BOTH\na\n#endif\n"), "#define BOTH (YES & ALSO)\na\n");
  EXPECT_EQ(left("#ifndef A_H\n#define A_H\n#define M NO\n#if M\na\n#endif\n#endif\n"),
            "#ifndef A_H\n#define A_H\n#define M NO\n#endif\n");
  for (const char* text :
       {"#define M YES\n#undef M\n#if M\na\n#endif\n", "#if UNKNOWN\n#define M YES\n#endif\n#if M\na\n#endif\n",
        "#ifndef M\n#define M 0\n#endif\n#if M\na\n#endif\n", "#define M(x) 1\n#if M\na\n#endif\n",
        "#define YES 3\n#if YES\na\n#endif\n", "#undef YES\n#if YES\na\n#endif\n",
        "#define M YES \\\n  > 2\n#if M\na\n#endif\n"})
    EXPECT_EQ(left(text), text);
}

TEST(KernelConditions, take_code_of_absent_features_out_of_kernels) {
  const std::string text = kernel_text({"stages/paths.cl"});
  const auto of = [&](const char* value) {
    return without_excluded(text, {{"EK_HAS_light_paths", value}, {"EK_HAS_merging", "0"}});
  };
  EXPECT_FALSE(contains(of("0"), "emission_density("));
  EXPECT_TRUE(contains(of("1"), "emission_density("));
}

}  // namespace
}  // namespace eikon
