// SPDX-License-Identifier: Apache-2.0
// What became of the jobs of a batch: a file of JSON lines, one per event, only ever added to.
//
//   {"eikon": "0.1.0", "time": "2026-01-31T12:00:00Z", "state": "started" | "done" | "failed" | "interrupted",
//    "line": n, "job": "render ..", "key": "16 hex digits", "exit_code": n, "message": "..",
//    "seconds": x, "render_seconds": x, "samples": n, "relmse_predicted": x | null,
//    "outputs": [{"path": "absolute", "bytes": n, "hash": "16 hex digits"}]}
//
// line and job say where the job stood and what it was; key is the hash of all that decides its outputs (job_key.h);
// outputs are the files as they were written, with the XXH64 of their bytes; they stand in lines of state "done" alone, and in
// others just by name. The last line of an output counts. "started" without a line after it: the process was killed.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace eikon {

struct LedgerOutput {
  std::string path{};  // absolute
  std::uint64_t bytes = 0;
  std::string hash{};
};

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
/// nullopt for what is no such line.
[[nodiscard]] std::optional<LedgerEntry> parse_entry(const std::string& line);

/// The file as it is now. throws InputError when it is absent or cannot be read
[[nodiscard]] LedgerOutput describe_output(const std::filesystem::path& path);

class Ledger {
 public:
  /// Reads what there is, and locks the file; an empty path: a ledger that remembers nothing after the process.
  /// throws InputError when it cannot be read or written, or another process has it
  explicit Ledger(std::filesystem::path path);
  ~Ledger();
  Ledger(const Ledger&) = delete;
  Ledger& operator=(const Ledger&) = delete;

  /// The last entry about a file, by its absolute path; nullptr: there is none.
  [[nodiscard]] const LedgerEntry* last(const std::string& output) const;
  /// Lines that are none of a ledger, such as one that was being written when the power went.
  [[nodiscard]] std::size_t unreadable() const { return unreadable_; }

  /// Adds a line; it is on the disk when this returns, unless `sync` is false. One thread at a time. throws InputError
  void add(const LedgerEntry& entry, bool sync = true);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  bool torn_ = false;  // the file does not end with a whole line
  std::size_t unreadable_ = 0;
  std::map<std::string, LedgerEntry> last_;

  void remember(const LedgerEntry& entry);
  void read();
};

}  // namespace eikon
