// SPDX-License-Identifier: Apache-2.0
#include "device/kernel_sources.h"

#include <gtest/gtest.h>

namespace eikon {
namespace {

TEST(KernelSources, a_bare_text_has_code_alone) {
  EXPECT_EQ(bare_text("#line 1 \"a.h\"\n// What it is.\n\n  int a = 1;  // metres\n\tint b; \n"), "int a = 1;\nint b;\n");
}

TEST(KernelSources, quoted_slashes_are_no_comment) {
  EXPECT_EQ(bare_text("#error \"see https://a.b\"  // there\nf(\"//\", \"a\"); // end\n"),
            "#error \"see https://a.b\"\nf(\"//\", \"a\");\n");
}

TEST(KernelSources, an_empty_line_ends_a_macro) {
  EXPECT_EQ(bare_text("#define F(x) \\\n  x \\\n\nint a;\n"), "#define F(x) \\\nx \\\n\nint a;\n");
}

TEST(KernelSources, comments_and_lines_of_kernels_do_not_change_what_is_compiled) {
  const std::string text = kernel_text({"stages/paths.cl"});
  std::string other = "// a first line\n" + text;
  for (std::size_t at = other.find(";\n"); at != std::string::npos; at = other.find(";\n", at + 12)) other.insert(at + 1, "  // why\n\n");
  EXPECT_EQ(bare_text(other), bare_text(text));
  EXPECT_LT(bare_text(text).size(), text.size());
}

}  // namespace
}  // namespace eikon
