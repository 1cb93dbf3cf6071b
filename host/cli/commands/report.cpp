// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "io/source_file.h"
#include "io/text.h"
#include "job/file_identity.h"
#include "io/atomic_file.h"
#include "job/report/stats.h"
#include "page/page_picture.h"
#include "page/report_page.h"
#include "page/timeline.h"

namespace eikon {
namespace {

struct ReportOptions {
  std::string stats, profile, image, output;
};

constexpr std::uint64_t kMaxBytes = std::uint64_t{256} << 20;

Json read_json_file(const std::string& file) {
  try {
    const Bytes bytes = read_regular_file(file, kMaxBytes);
    return parse_json({reinterpret_cast<const char*>(bytes.data.get()), bytes.size});
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
}

Json read_stats(const std::string& file) {
  Json stats = read_json_file(file);
  const Json* const version = member(stats, "schema_version");
  if (version == nullptr)
    throw InputError(fmt::format("{}: it has no schema_version; name a file that `eikon render --stats` wrote", file));
  if (*version != kStatsSchemaVersion)
    throw InputError(fmt::format("{}: its schema_version is {}, and this eikon reads {}", file, excerpt(*version),
                                 kStatsSchemaVersion));
  return stats;
}

Json read_timeline(const std::string& file) {
  if (file.empty()) return nullptr;
  const Json trace = read_json_file(file);
  const Json* const events = member(trace, "traceEvents");
  try {
    return page_timeline(events == nullptr ? Json(nullptr) : *events);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}; name a file that `eikon render --profile` wrote", file, error.what()));
  }
}

ExitCode report_command(const ReportOptions& options) {
  require_writable({options.output}, {.files = {options.stats, options.profile, options.image}});
  const Json stats = read_stats(options.stats), timeline = read_timeline(options.profile);
  const Json picture = options.image.empty() ? Json(nullptr) : page_picture(read_exr(options.image));
  const Json display = {{"exposure", 0}, {"tone", name_of(ToneMap::none)}};
  write_text(options.output,
             report_page({.stats = stats, .picture = picture, .timeline = timeline, .display = display}));
  return ExitCode::done;
}

}  // namespace

void add_report(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<ReportOptions>();
  CommandFlags flags =
      root.command("report", "write a page about a render that is over, from its --stats and --profile files",
                   "The page needs no other file and no network. `eikon render --report` writes it at once.\n\n"
                   "Example:\n  eikon report stats.json --profile profile.json --image cornell.exr -o report.html");
  flags.text({"STATS", "", "JSON file of `eikon render --stats`"}, options->stats);
  flags.text({"--profile", "FILE", "timeline of `eikon render --profile`, with the error over time"}, options->profile);
  flags.text({"--image", "FILE", "the OpenEXR image; with `--aov variance` its error map is shown too"},
             options->image);
  flags.group("Output (- is standard output)");
  flags.text({"-o,--output", "FILE.html", "the page"}, options->output);
  flags.require("--output");
  flags.run(chosen, [options] { return report_command(*options); });
}

}  // namespace eikon
