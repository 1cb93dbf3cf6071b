// SPDX-License-Identifier: Apache-2.0
// The ledger of a batch says what became of its jobs: a file of JSON lines, one per event, to which
// lines are only added.
//
//   {"eikon": "0.1.0", "time": "2026-01-31T12:00:00Z",
//    "state": "started" | "done" | "failed" | "interrupted",
//    "line": n, "job": "render ..", "key": "16 hex digits", "exit_code": n, "message": "..",
//    "seconds": x, "render_seconds": x, "samples": n, "relmse_predicted": x | null,
//    "outputs": [{"path": "..", "bytes": n, "hash": "16 hex digits"}]}
//
// `line` and `job` say where the job stood and what it was. `key` is the hash of everything that
// decides its outputs (job_key.h). `outputs` are the files as they were written, with the XXH64 of
// their bytes; lines whose state is not "done" have their names only. A path is relative if the
// file lies below the folder in which the batch runs, which is that of the jobs file, and else
// absolute. `path` and `job` have "\u0000ff" for a byte FF that is not UTF-8 (name_to_utf8()). The
// last line about an output counts. "started" without a line after it means that the process was
// killed.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace eikon {

/// A file that a job wrote.
struct LedgerOutput {
  std::string path{};  // as ledger_name() gives it
  std::uint64_t bytes = 0;
  std::string hash{};
};

/// A line of the ledger; the members have the names of its fields.
struct LedgerEntry {
  std::string state{}, time{}, job{}, key{}, message{};
  std::size_t line = 0;
  int exit_code = 0;
  double seconds = 0, render_seconds = 0;
  std::uint64_t samples = 0;
  std::optional<double> relmse{};
  std::vector<LedgerOutput> outputs{};
};

/// One line, without its end.
[[nodiscard]] std::string to_json(const LedgerEntry& entry);
/// Returns nothing if the text is no such line.
[[nodiscard]] std::optional<LedgerEntry> parse_entry(const std::string& line);

/// Describes the file as it is now, but for its path. throws InputError if it is absent or cannot
/// be read
[[nodiscard]] LedgerOutput describe_output(const std::filesystem::path& path);

/// The ledger of one batch, which no other process can use meanwhile.
class Ledger {
 public:
  /// Reads and locks the file. With an empty path, the ledger lasts only as long as the process.
  /// advice  what to do where this file cannot be the ledger, for messages
  /// throws InputError when it cannot be read or written, or another process has it
  explicit Ledger(std::filesystem::path path, std::string advice = "choose another with --ledger");
  ~Ledger();
  Ledger(const Ledger&) = delete;
  Ledger& operator=(const Ledger&) = delete;

  /// The last entry about a file, by its name in the ledger, or nullptr.
  [[nodiscard]] const LedgerEntry* last(const std::string& output) const;
  /// The number of lines that are not of a ledger, such as one that a power failure cut off.
  [[nodiscard]] std::size_t unreadable() const { return unreadable_; }

  /// Adds a line, which is on the disk when this returns unless `sync` is false. One thread at a
  /// time.
  /// throws InputError
  void add(const LedgerEntry& entry, bool sync = true);

 private:
  std::filesystem::path path_;
  std::string advice_;
  int descriptor_ = -1;
  bool torn_ = false;  // the file does not end with a whole line
  std::size_t unreadable_ = 0;
  std::map<std::string, LedgerEntry> last_;

  void remember(const LedgerEntry& entry);
  void read();
};

}  // namespace eikon
