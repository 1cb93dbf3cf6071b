// SPDX-License-Identifier: Apache-2.0
#include "job/batch/ledger.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/json_dump.h"
#include "io/source_file.h"
#include "io/text.h"
#include "io/xxhash64.h"

namespace eikon {
namespace {

using nlohmann::json;

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw InputError(fmt::format("{}: {}", path.string(), what));
}

/// True for the beginning of a ledger's first line, as a power failure leaves it: the line is not
/// on the disk as a whole, or its place is filled with zeros.
bool is_begun(std::string_view text) {
  constexpr std::string_view kBegin = "{\"eikon\":";
  const std::size_t known = std::min(text.size(), kBegin.size());
  return text.substr(0, known) == kBegin.substr(0, known) || text.find_first_not_of('\0') == std::string_view::npos;
}

}  // namespace

std::string to_json(const LedgerEntry& entry) {
  json line = {{"eikon", EIKON_VERSION},         {"time", entry.time},
               {"state", entry.state},           {"line", entry.line},
               {"job", name_to_utf8(entry.job)}, {"key", entry.key},
               {"exit_code", entry.exit_code},   {"message", entry.message},
               {"seconds", entry.seconds},       {"render_seconds", entry.render_seconds},
               {"samples", entry.samples}};
  line["relmse_predicted"] = entry.relmse ? json(*entry.relmse) : json(nullptr);
  line["outputs"] = json::array();
  for (const LedgerOutput& output : entry.outputs)
    line["outputs"].push_back({{"path", name_to_utf8(output.path)}, {"bytes", output.bytes}, {"hash", output.hash}});
  return dump_json(line);
}

std::optional<LedgerEntry> parse_entry(const std::string& text) {
  const json line = json::parse(text, nullptr, false);
  if (!line.is_object()) return std::nullopt;
  try {
    LedgerEntry entry;
    entry.state = line.at("state");
    entry.key = line.at("key");
    entry.time = line.value("time", "");
    entry.job = name_from_utf8(line.value("job", ""));
    entry.message = line.value("message", "");
    entry.line = line.value("line", std::size_t{0});
    entry.exit_code = line.value("exit_code", 0);
    entry.seconds = line.value("seconds", 0.0);
    entry.render_seconds = line.value("render_seconds", 0.0);
    entry.samples = line.value("samples", std::uint64_t{0});
    if (line.contains("relmse_predicted") && line["relmse_predicted"].is_number())
      entry.relmse = line["relmse_predicted"].get<double>();
    for (const json& output : line.at("outputs"))
      entry.outputs.push_back({.path = name_from_utf8(output.at("path").get<std::string>()),
                               .bytes = output.value("bytes", std::uint64_t{0}),
                               .hash = output.value("hash", "")});
    return entry;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

LedgerOutput describe_output(const std::filesystem::path& path) {
  const Bytes bytes = read_regular_file(path, usable_memory_bytes());
  return {.bytes = bytes.size, .hash = fmt::format("{:016x}", xxhash64(bytes.span(), 0))};
}

Ledger::Ledger(std::filesystem::path path, std::string advice) : path_(std::move(path)), advice_(std::move(advice)) {
  if (path_.empty()) return;
  descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0666);
  if (descriptor_ < 0) fail(path_, fmt::format("cannot open the ledger: {}; {}", std::strerror(errno), advice_));
  try {
    struct stat found {};
    if (fstat(descriptor_, &found) != 0 || !S_ISREG(found.st_mode))
      fail(path_, "the ledger is not a regular file; " + advice_);
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
      fail(path_, "another batch is at work with this ledger; wait for it, or " + advice_);
    read();
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

Ledger::~Ledger() {
  if (descriptor_ >= 0) close(descriptor_);
}

void Ledger::read() {
  std::string text;
  std::vector<char> piece(1 << 16);
  for (;;) {
    const ssize_t got = pread(descriptor_, piece.data(), piece.size(), off_t(text.size()));
    if (got < 0) fail(path_, fmt::format("cannot read the ledger: {}", std::strerror(errno)));
    if (got == 0) break;
    text.append(piece.data(), std::size_t(got));
  }
  torn_ = !text.empty() && text.back() != '\n';
  for (const std::string& line : split(text, '\n')) {
    if (line.empty()) continue;
    if (const std::optional<LedgerEntry> entry = parse_entry(line))
      remember(*entry);
    else
      ++unreadable_;
  }
  if (unreadable_ > 0 && last_.empty() && !(torn_ && is_begun(text)))
    fail(path_, "this is no ledger of a batch, and nothing was added to it; " + advice_);
}

void Ledger::remember(const LedgerEntry& entry) {
  for (const LedgerOutput& output : entry.outputs) last_[output.path] = entry;
}

const LedgerEntry* Ledger::last(const std::string& output) const {
  const auto found = last_.find(output);
  return found == last_.end() ? nullptr : &found->second;
}

void Ledger::add(const LedgerEntry& entry, bool sync) {
  remember(entry);
  if (descriptor_ < 0) return;
  // One write: lines of two processes would not mix either.
  const std::string line = (torn_ ? "\n" : "") + to_json(entry) + "\n";
  const ssize_t wrote = write(descriptor_, line.data(), line.size());
  if (wrote != ssize_t(line.size())) {
    torn_ = torn_ || wrote > 0;
    fail(path_, fmt::format("cannot write the ledger: {}", wrote < 0 ? std::strerror(errno) : "the disk is full"));
  }
  torn_ = false;
  if (sync && fsync(descriptor_) != 0 && errno != EINVAL)
    fail(path_, fmt::format("cannot write the ledger: {}", std::strerror(errno)));
}

}  // namespace eikon
