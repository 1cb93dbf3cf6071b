// SPDX-License-Identifier: Apache-2.0
#include "job/checkpoint.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "job/report/metadata.h"
#include "job/stop_signals.h"
#include "film/exr/film_file.h"
#include "io/atomic_file.h"
#include "pack/features.h"

namespace eikon {
namespace {

std::string in_words(const Crop& crop) { return fmt::format("{},{},{},{}", crop.x0, crop.y0, crop.x1, crop.y1); }

bool encloses(const Crop& outer, const Crop& inner) {
  return inner.x0 >= outer.x0 && inner.x1 <= outer.x1 && inner.y0 >= outer.y0 && inner.y1 <= outer.y1;
}

}  // namespace

CheckpointFile::CheckpointFile(CheckpointOptions options, Log log)
    : options_(std::move(options)), log_(std::move(log)) {
  if (options_.resume && options_.file.empty())
    throw UsageError("--resume goes on from a checkpoint: name it with --checkpoint FILE");
  if (options_.file == kStandardOutput) throw UsageError("--checkpoint: takes the name of a file, not standard output");
  requests_ = checkpoint_signals();
}

void CheckpointFile::begin(const Prepared& prepared) {
  const Settings& settings = prepared.settings;
  const Features features(*prepared.scene, settings);
  const FilmLayout layout = film_layout(features, settings);
  manifests_ = features.mattes().manifests;
  settings_ = image_settings(*prepared.scene, settings, layout);
  layers_ = prepared.layers;
  asked_samples_ = settings.crop.pixel_count() * (settings.sample_end - settings.sample_begin);
  std::error_code ignored;
  if (!options_.file.empty()) {
    metadata_ = describe_image(prepared);
    if (std::filesystem::exists(options_.file, ignored)) {
      if (options_.implied)
        read_if_it_fits(prepared, options_.file);
      else if (options_.resume)
        read(prepared, options_.file);
      else
        log_(fmt::format("the first checkpoint replaces what is in {}; --resume would go on from it", options_.file));
    }
  }
  if (!options_.left.empty() && std::filesystem::exists(options_.left, ignored)) read_if_it_fits(prepared, options_.left);
  for (const std::string& part : options_.parts) take_over(prepared, part, "add");
  if (!options_.parts.empty()) count_extra_samples(settings);
}

void CheckpointFile::read(const Prepared& prepared, const std::string& file) {
  take_over(prepared, file, "resume from");
  saved_samples_ = begin_with_->sample_set.sample_count();
  there_is_one_ = file == options_.file;
  count_extra_samples(prepared.settings);
}

void CheckpointFile::take_over(const Prepared& prepared, const std::string& file, const char* where) {
  const Settings& settings = prepared.settings;
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("cannot {} \"{}\": {}", where, file, why));
  };
  SumsReader reader(file);
  FilmRecord record;
  try {
    record = parse_film_record(reader.record(), reader.layout());
  } catch (const InputError& error) {
    refuse(error.what());
  }
  if (const auto what = difference(settings_, record.settings)) refuse(*what);
  const FilmLayout layout = film_layout(Features(*prepared.scene, settings), settings);
  if (!encloses(layout.crop, reader.layout().crop))
    refuse(fmt::format("it holds the window {}, which does not lie within this render's {}: see --crop",
                       in_words(reader.layout().crop), in_words(layout.crop)));
  if (reader.layout().channels != layout.channels || reader.layout().mattes != layout.mattes ||
      reader.layout().replicates != layout.replicates)
    refuse("its sums do not have the form that its settings say: the file is damaged");

  if (!begin_with_) begin_with_.emplace(FilmState{Film(layout), {}, {}, {}});
  if (begin_with_->sample_set.overlap(record.sample_set))
    refuse("it holds samples that another file has added: leave one out");
  std::set<std::uint64_t>& light_paths = begin_with_->light_path_counts;
  if (!light_paths.empty() && !record.light_path_counts.empty() && light_paths != record.light_path_counts)
    refuse("it has another number of light paths than the other files: pilots of different devices decided otherwise");
  begin_with_->sample_set.add(record.sample_set);
  begin_with_->arithmetic.insert(record.arithmetic.begin(), record.arithmetic.end());
  light_paths.insert(record.light_path_counts.begin(), record.light_path_counts.end());
  begin_with_->guiding.insert(record.guiding.begin(), record.guiding.end());
  reader.add_to(begin_with_->film);
}

void CheckpointFile::count_extra_samples(const Settings& settings) {
  const FilmState& state = *begin_with_;
  const Crop& crop = state.film.layout().crop;
  std::uint64_t missing = 0;
  for (const WorkUnit& part : state.sample_set.missing(crop, settings.sample_begin, settings.sample_end))
    missing += part.path_count();
  extra_samples_ = state.sample_set.sample_count() - (asked_samples_ - missing);
  if (extra_samples_ > 0 && !options_.implied)
    log_(fmt::format("{} holds {} samples beyond what --spp or --samples ask for; they stay in the picture",
                     options_.parts.empty() ? options_.file : options_.parts.front(), extra_samples_));
}

/// Reads the file, or says that it will be replaced: the batch's line may have been edited since.
void CheckpointFile::read_if_it_fits(const Prepared& prepared, const std::string& file) {
  std::string why;
  try {
    read(prepared, file);
    if (extra_samples_ > 0) why = fmt::format("{} holds more samples than are asked for", file);
  } catch (const InputError& error) {
    why = error.what();
  }
  if (why.empty()) return;
  begin_with_.reset();
  saved_samples_ = extra_samples_ = 0;
  there_is_one_ = false;
  log_(fmt::format("{}; {} replaces it", why, options_.file.empty() ? "the picture" : "the first checkpoint"));
}

void CheckpointFile::attach(RenderHooks& hooks) {
  hooks.begin_with = std::exchange(begin_with_, std::nullopt);
  if (options_.file.empty()) return;
  hooks.checkpoint = [this](const FilmState& state) { write(state); };
  hooks.checkpoint_every_s = options_.every_s;
  hooks.checkpoint_now = asked_.get();
  // One signal asks all renders of the process, so each compares the count for itself.
  hooks.progress = [this, usual = std::move(hooks.progress)](const Progress& progress, const Film& film) {
    const std::uint64_t now = checkpoint_signals();
    if (std::exchange(requests_, now) != now) *asked_ = true;
    if (usual) usual(progress, film);
  };
}

FilmRecord CheckpointFile::record(const FilmState& state) const {
  return {.settings = settings_,
          .arithmetic = state.arithmetic,
          .light_path_counts = state.light_path_counts,
          .guiding = state.guiding,
          .layers = {layers_.begin(), layers_.end()},
          .manifests = manifests_,
          .sample_set = state.sample_set};
}

std::string CheckpointFile::saved() const {
  return there_is_one_ ? fmt::format("{} holds {} samples", options_.file, saved_samples_) : "there is none yet";
}

void CheckpointFile::write(const FilmState& state) {
  const ExrOptions exr{.exact_sums = true, .record = to_text(record(state)), .quick = true};
  Metadata metadata = metadata_;
  add_sample_counts(metadata, state.film, state.sample_set, state.arithmetic);
  try {
    write_exr(options_.file, state.film, metadata, exr);
  } catch (const InputError& error) {
    if (last_failure_.empty())
      log_(fmt::format("{}; the render goes on and tries again (of the checkpoint, {})", error.what(), saved()));
    last_failure_ = error.what();
    return;
  }
  saved_samples_ = state.sample_set.sample_count();
  there_is_one_ = true;
  if (!std::exchange(last_failure_, {}).empty()) log_(fmt::format("the checkpoint can be written again: {}", saved()));
}

void CheckpointFile::end(const RenderOutput& done) {
  if (options_.file.empty() || last_failure_.empty()) return;
  write(done);
  if (!last_failure_.empty()) log_(fmt::format("{}; of the checkpoint, {}", last_failure_, saved()));
}

}  // namespace eikon
