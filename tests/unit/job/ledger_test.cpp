// SPDX-License-Identifier: Apache-2.0
#include "job/batch/ledger.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace eikon::test {
namespace {

std::string read_all(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

LedgerEntry entry(const std::string& state, const std::string& key, const std::string& output) {
  LedgerEntry made;
  made.state = state;
  made.time = "2026-01-31T12:00:00Z";
  made.job = "render 'a b.gltf'";
  made.key = key;
  made.line = 7;
  made.exit_code = 3;
  made.message = "no \"such\" file\n\xff";
  made.seconds = 1.5;
  made.render_seconds = 0.25;
  made.samples = std::uint64_t{1} << 60;
  made.relmse = 1e-3;
  made.outputs = {{.path = output, .bytes = 12, .hash = "0123456789abcdef"}};
  return made;
}

TEST(Ledger, a_line_says_all_of_an_entry) {
  const LedgerEntry made = entry("done", "k", "out.exr");
  const std::string line = to_json(made);
  EXPECT_FALSE(contains(line, "\n"));
  const std::optional<LedgerEntry> read = parse_entry(line);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->state, made.state);
  EXPECT_EQ(read->time, made.time);
  EXPECT_EQ(read->job, made.job);
  EXPECT_EQ(read->key, made.key);
  EXPECT_EQ(read->line, made.line);
  EXPECT_EQ(read->exit_code, made.exit_code);
  EXPECT_EQ(read->seconds, made.seconds);
  EXPECT_EQ(read->render_seconds, made.render_seconds);
  EXPECT_EQ(read->samples, made.samples);
  EXPECT_EQ(read->relmse, made.relmse);
  ASSERT_EQ(read->outputs.size(), 1U);
  EXPECT_EQ(read->outputs[0].path, "out.exr");
  EXPECT_EQ(read->outputs[0].bytes, 12U);
  EXPECT_EQ(read->outputs[0].hash, "0123456789abcdef");
  for (std::size_t cut = 0; cut < line.size(); ++cut) EXPECT_FALSE(parse_entry(line.substr(0, cut))) << cut;
  for (const char* none : {"", "{}", "[]", "3", R"({"state": 1, "key": "", "outputs": []})",
                           R"({"state": "", "key": "", "outputs": [3]})", R"({"state": "", "key": "", "outputs": 3})"})
    EXPECT_FALSE(parse_entry(none)) << none;
}

TEST(Ledger, the_last_entry_of_an_output_counts_also_in_the_next_process) {
  const TemporaryFolder folder;
  {
    Ledger ledger(folder / "l");
    EXPECT_EQ(ledger.last("a"), nullptr);
    ledger.add(entry("started", "1", "a"));
    ledger.add(entry("done", "1", "a"));
    ledger.add(entry("failed", "2", "b"), false);
    EXPECT_EQ(ledger.last("a")->state, "done");
  }
  Ledger ledger(folder / "l");
  ASSERT_NE(ledger.last("a"), nullptr);
  EXPECT_EQ(ledger.last("a")->state, "done");
  EXPECT_EQ(ledger.last("b")->key, "2");
  EXPECT_EQ(ledger.unreadable(), 0U);
}

TEST(Ledger, names_that_are_not_utf_8_are_kept_apart) {
  const TemporaryFolder folder;
  {
    Ledger ledger(folder / "l");
    ledger.add(entry("done", "1", "a\xff.exr"));
    ledger.add(entry("done", "2", "a\xfe.exr"));
  }
  const Ledger ledger(folder / "l");
  ASSERT_NE(ledger.last("a\xff.exr"), nullptr);
  EXPECT_EQ(ledger.last("a\xff.exr")->key, "1");
  EXPECT_EQ(ledger.last("a\xfe.exr")->key, "2");
}

TEST(Ledger, a_torn_last_line_costs_that_line_alone) {
  const TemporaryFolder folder;
  Ledger(folder / "whole").add(entry("done", "1", "a"));
  const std::string line = read_all(folder / "whole");
  for (std::size_t cut = 1; cut < line.size() - 1; cut += 13) {
    const std::filesystem::path path = folder / "torn";
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary) << line << line.substr(0, cut);
    {
      Ledger ledger(path);
      EXPECT_EQ(ledger.unreadable(), 1U);
      EXPECT_EQ(ledger.last("a")->state, "done");
      ledger.add(entry("done", "2", "b"));
    }
    Ledger again(path);
    EXPECT_EQ(again.unreadable(), 1U);
    EXPECT_EQ(again.last("a")->key, "1");
    EXPECT_EQ(again.last("b")->key, "2");
  }
}

TEST(Ledger, a_torn_first_line_is_one_that_was_begun) {
  const TemporaryFolder folder;
  for (const std::string& text : {std::string("{\"eikon\":\"0.1"), std::string("{\"ei"), std::string(300, '\0')}) {
    std::ofstream(folder / "l") << text;
    EXPECT_NO_THROW(Ledger(folder / "l")) << text;
  }
  for (const char* text : {"{\"name\":", "{\"eikon\":\n", "d"}) {
    std::ofstream(folder / "l") << text;
    EXPECT_THROW(Ledger(folder / "l"), InputError) << text;
  }
}

TEST(Ledger, what_is_none_is_refused_and_left_alone) {
  const TemporaryFolder folder;
  std::ofstream(folder / "notes.txt") << "dear diary\n";
  EXPECT_THROW(Ledger(folder / "notes.txt"), InputError);
  EXPECT_EQ(read_all(folder / "notes.txt"), "dear diary\n");
  EXPECT_THROW(Ledger(folder.path()), InputError);
  EXPECT_THROW(Ledger(folder / "no" / "folder"), InputError);
  const Ledger first(folder / "l");
  EXPECT_THROW(Ledger(folder / "l"), InputError) << "one batch at a time";
}

TEST(Ledger, outputs_are_known_by_their_bytes) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "picture";
  std::ofstream(folder / "b") << "picturf";
  const LedgerOutput a = describe_output(folder / "a"), b = describe_output(folder / "b");
  EXPECT_EQ(a.bytes, 7U);
  EXPECT_EQ(a.hash.size(), 16U);
  EXPECT_NE(a.hash, b.hash);
  EXPECT_THROW((void)describe_output(folder / "c"), InputError);
}

}  // namespace
}  // namespace eikon::test
