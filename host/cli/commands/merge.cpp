// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "cli/commands.h"
#include "cli/flags.h"
#include "job/file_identity.h"
#include "job/log.h"
#include "job/report/metadata.h"
#include "job/report/result_lines.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "io/text.h"
#include "render/film_record.h"

namespace eikon {
namespace {

struct MergeOptions {
  std::vector<std::string> parts;
  std::string output;
  PngOptions png;
  bool half = false, quiet = false;
};

/// The header of a part.
struct Part {
  std::string file;
  std::string text;  // the record, as it stands in the file
  FilmLayout layout;
  FilmRecord record;
  Metadata metadata;
};

Part read_header(const std::string& file) {
  const SumsReader reader(file);
  Part part{file, reader.record(), reader.layout(), {}, read_metadata(file)};
  try {
    part.record = parse_film_record(part.text, part.layout);
  } catch (const InputError& error) {
    throw InputError(fmt::format("cannot read \"{}\": {}", file, error.what()));
  }
  return part;
}

std::string in_words(const WorkUnit& part) {
  const Crop& b = part.block;
  return fmt::format("samples {}:{} of the pixels {},{} to {},{}", part.sample_begin, part.sample_end, b.x0, b.y0,
                     b.x1 - 1, b.y1 - 1);
}

void refuse_difference(const Part& first, const Part& part) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("cannot merge \"{}\" with \"{}\": {}", part.file, first.file, why));
  };
  if (const auto what = difference(first.record.settings, part.record.settings)) refuse(*what);
  const std::set<std::uint64_t>&ours = first.record.light_path_counts, &its = part.record.light_path_counts;
  if (!ours.empty() && !its.empty() && ours != its)
    refuse(fmt::format(
        "it has {} light paths of each sample, not {}: pilots of different devices decided otherwise; render "
        "one of them again with the other's pilot, by --pilot",
        *its.begin(), *ours.begin()));
  const FilmLayout &a = first.layout, &b = part.layout;
  if (a.width != b.width || a.height != b.height || a.replicates != b.replicates || a.channels != b.channels ||
      a.mattes != b.mattes)
    refuse("its sums do not have the form that its settings say: the file is damaged");
}

void refuse_overlap(const std::vector<Part>& before, const Part& part) {
  for (const Part& other : before)
    if (const auto twice = other.record.sample_set.overlap(part.record.sample_set))
      throw InputError(
          fmt::format("cannot merge \"{}\" with \"{}\": both hold {}, which would count twice: leave one out",
                      part.file, other.file, in_words(*twice)));
}

/// Keeps the entries that both have. This is commutative and associative, so neither the order nor
/// the grouping of parts changes the result.
template <class Map>
void keep_common(Map& ours, const Map& theirs) {
  std::erase_if(ours, [&](const auto& entry) {
    const auto found = theirs.find(entry.first);
    return found == theirs.end() || found->second != entry.second;
  });
}

/// The header of the merged file, and its layout.
struct Whole {
  FilmLayout layout;
  FilmRecord record;
  Metadata metadata;
};

Whole join(const std::vector<Part>& parts) {
  Whole whole{parts.front().layout, {}, parts.front().metadata};
  whole.record.settings = parts.front().record.settings;
  Crop& crop = whole.layout.crop;
  for (const Part& part : parts) {
    const Crop& other = part.layout.crop;
    crop = {std::min(crop.x0, other.x0), std::min(crop.y0, other.y0), std::max(crop.x1, other.x1),
            std::max(crop.y1, other.y1)};
    whole.record.sample_set.add(part.record.sample_set);
    whole.record.arithmetic.insert(part.record.arithmetic.begin(), part.record.arithmetic.end());
    whole.record.light_path_counts.insert(part.record.light_path_counts.begin(), part.record.light_path_counts.end());
    whole.record.guiding.insert(part.record.guiding.begin(), part.record.guiding.end());
    whole.record.layers.insert(part.record.layers.begin(), part.record.layers.end());
    whole.record.manifests.insert(part.record.manifests.begin(), part.record.manifests.end());
    keep_common(whole.metadata.strings, part.metadata.strings);
    keep_common(whole.metadata.numbers, part.metadata.numbers);
    keep_common(whole.metadata.matrices, part.metadata.matrices);
  }
  return whole;
}

/// The half-open range from the first sample to the last that any pixel has.
std::pair<std::uint64_t, std::uint64_t> sample_range(const SampleSet& done) {
  std::uint64_t begin = std::numeric_limits<std::uint64_t>::max(), end = 0;
  for (const WorkUnit& part : done.parts()) {
    begin = std::min(begin, part.sample_begin);
    end = std::max(end, part.sample_end);
  }
  return {std::min(begin, end), end};
}

/// Adds up all parts, with a few rows of each in memory at a time.
Film add_up(const std::vector<Part>& parts, const FilmLayout& layout) {
  Film film(layout);
  for (const Part& part : parts) {
    SumsReader reader(part.file);
    if (reader.record() != part.text || reader.layout() != part.layout)
      throw InputError(fmt::format("\"{}\" changed while it was merged: do it again", part.file));
    reader.add_to(film);
  }
  return film;
}

/// " --crop X0,Y0,X1,Y1", or nothing if the window is the whole image.
std::string crop_flag(const Crop& window, const FilmLayout& layout) {
  if (window == Crop{0, 0, layout.width, layout.height}) return "";
  return fmt::format(" --crop {},{},{},{}", window.x0, window.y0, window.x1, window.y1);
}

/// Prints which samples are missing between those of the parts, and the flags that render them.
/// returns  true if none are missing
bool print_gaps(const Whole& whole, const std::string& output) {
  constexpr std::size_t kMaxLines = 8;
  const auto [begin, end] = sample_range(whole.record.sample_set);
  const std::vector<WorkUnit> gaps = whole.record.sample_set.missing(whole.layout.crop, begin, end);
  if (gaps.empty()) return true;
  std::uint64_t count = 0;
  for (const WorkUnit& gap : gaps) count += gap.path_count();
  print_to_stderr("eikon: {} samples are missing between those of the parts; these flags render them:\n", count);
  for (std::size_t i = 0; i < std::min(gaps.size(), kMaxLines); ++i)
    print_to_stderr("eikon:   --samples {}:{}{}\n", gaps[i].sample_begin, gaps[i].sample_end,
                    crop_flag(gaps[i].block, whole.layout));
  if (gaps.size() > kMaxLines) print_to_stderr("eikon:   and {} more\n", gaps.size() - kMaxLines);
  print_to_stderr("eikon: or all at once: --checkpoint {} --resume --samples {}:{}{}\n", printable(output), begin, end,
                  crop_flag(whole.layout.crop, whole.layout));
  return false;
}

std::string lines_of(std::uint32_t begin, std::uint32_t end) {
  return end == begin + 1 ? fmt::format("{}", begin) : fmt::format("{} to {}", begin, end - 1);
}

/// Prints which samples and pixels lie outside of all parts: other parts may hold them.
void print_outside(const Whole& whole) {
  const auto begin = sample_range(whole.record.sample_set).first;
  if (begin > 0)
    print_to_stderr("eikon: the parts begin with sample {}: samples 0 to {} are in none of them\n", begin, begin - 1);
  const FilmLayout& layout = whole.layout;
  std::vector<std::string> missing;
  if (layout.crop.y0 > 0) missing.push_back("rows " + lines_of(0, layout.crop.y0));
  if (layout.crop.y1 < layout.height) missing.push_back("rows " + lines_of(layout.crop.y1, layout.height));
  if (layout.crop.x0 > 0) missing.push_back("columns " + lines_of(0, layout.crop.x0));
  if (layout.crop.x1 < layout.width) missing.push_back("columns " + lines_of(layout.crop.x1, layout.width));
  if (!missing.empty())
    print_to_stderr("eikon: the image has {} x {} pixels: {} are in no part\n", layout.width, layout.height,
                    fmt::join(missing, ", "));
}

void write(const MergeOptions& options, const Film& film, Whole& whole, const PredictedError& error) {
  add_sample_counts(whole.metadata, film, whole.record.sample_set, whole.record.arithmetic);
  add_error(whole.metadata, error);
  const auto [begin, end] = sample_range(whole.record.sample_set);
  whole.metadata.strings["sampleRange"] = fmt::format("{}:{}", begin, end);
  write_exr(options.output, film, whole.metadata,
            {.half = options.half,
             .layers = {whole.record.layers.begin(), whole.record.layers.end()},
             .exact_sums = true,
             .manifests = whole.record.manifests,
             .record = to_text(whole.record)});
  if (!options.png.file.empty()) options.png.write(to_image(film));
}

ExitCode merge_command(const MergeOptions& options) {
  require_writable({options.output, options.png.file}, {});  // a part may be the output, which is replaced at the end
  require_writable({options.png.file}, {.files = options.parts});
  std::vector<Part> parts;
  for (const std::string& file : options.parts) {
    Part part = read_header(file);
    if (!parts.empty()) refuse_difference(parts.front(), part);
    refuse_overlap(parts, part);
    parts.push_back(std::move(part));
  }
  Whole whole = join(parts);
  const Film film = add_up(parts, whole.layout);
  const PredictedError error = film.predicted_error();
  write(options, film, whole, error);

  const Crop& crop = whole.layout.crop;
  const auto [begin, end] = sample_range(whole.record.sample_set);
  const bool complete = print_gaps(whole, options.output);
  print_outside(whole);
  if (const std::string note = note_of_guiding(whole.record.guiding); !note.empty())
    print_to_stderr("eikon: {}\n", note);
  if (whole.record.arithmetic != std::set<std::string>{"exact"} && !whole.record.arithmetic.empty())
    print_to_stderr("eikon: arithmetic {}: other devices may give other bits; see `eikon selftest`\n",
                    printable(fmt::format("{}", fmt::join(whole.record.arithmetic, ", "))));
  if (!options.quiet) {
    fmt::print("{}: {} parts, {} x {} pixels of {} x {}, samples {}:{}{}\n", printable(options.output), parts.size(), crop.width(),
               crop.height(), whole.layout.width, whole.layout.height, begin, end, complete ? "" : " with gaps");
    fmt::print("{}\n", in_words(error));
  }
  return complete ? ExitCode::done : ExitCode::not_as_asked;
}

}  // namespace

void add_merge(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<MergeOptions>();
  CommandFlags flags = root.command(
      "merge", "add up parts of one image exactly: checkpoints, and renders with --samples or --crop",
      "The order of the parts does not matter. Exit code 1: samples between those of the parts are missing; the file\n"
      "is written.\n\nExample:\n  eikon merge part0.exr part1.exr part2.exr -o whole.exr --png whole.png");
  flags.list({"PART", "...", "OpenEXR files of one image, no sample of it in two of them"},
             [&parts = options->parts](const std::string& file) { parts.push_back(file); });
  flags.group("Output (- is standard output)");
  flags.picture({"-o,--output", "FILE", "OpenEXR image, which can be merged and resumed again (required)"},
                options->output, ".exr");
  flags.require("--output");
  flags.toggle("--half", "write 16-bit channels; the sums stay exact", options->half);
  add_png_flags(flags, options->png);
  flags.group("Diagnosis");
  flags.toggle("--quiet", "print nothing on stdout", options->quiet);
  flags.run(chosen, [options] { return merge_command(*options); });
}

}  // namespace eikon
