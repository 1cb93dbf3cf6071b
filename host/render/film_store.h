// SPDX-License-Identifier: Apache-2.0
// The film that several devices add to at once, with the set of samples that it holds.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "film/film.h"
#include "film/sample_set.h"

namespace eikon {

/// A film, the samples that it holds, the arithmetic classes of the devices that rendered them, and
/// what pilots decided for them (FilmRecord::light_path_counts and guiding).
struct FilmState {
  Film film;
  SampleSet sample_set;  // the samples that the film holds
  std::set<std::string> arithmetic = {};
  std::set<std::uint64_t> light_path_counts = {};
  std::set<std::string> guiding = {};
};

/// Adds units whose rows lie apart at the same time. At hundreds of millions of samples per second,
/// adding one after the other would hold up the devices.
class FilmStore {
 public:
  explicit FilmStore(FilmState begin) : state_(std::move(begin)) {}

  /// throws as Film::add and SampleSet::add do. The film is then spoiled: it may hold sums without
  /// their samples.
  void add(const WorkUnit& unit, const UnitSums& sums, const std::string& arithmetic);
  /// Film and samples of one moment.
  [[nodiscard]] FilmState copy();
  /// Calls reader(film) while nobody adds to it.
  template <class Reader>
  void read(const Reader& reader) {
    const Rows all(*this, 0, kBands);
    reader(static_cast<const Film&>(state_.film));
  }
  [[nodiscard]] std::vector<WorkUnit> missing(const Crop& crop, std::uint64_t begin, std::uint64_t end);
  [[nodiscard]] bool spoiled() const { return spoiled_.load(); }
  /// Moves the film out; the store is empty afterwards.
  [[nodiscard]] FilmState take() { return std::move(state_); }

 private:
  static constexpr std::uint32_t kBands = 64, kBandRows = 32;
  /// Locks bands [begin, begin + count), modulo their number. All threads lock in the same order,
  /// so there is no deadlock.
  class Rows {
   public:
    Rows(FilmStore& store, std::uint32_t begin, std::uint32_t count);
    ~Rows();
    Rows(const Rows&) = delete;
    Rows& operator=(const Rows&) = delete;

   private:
    [[nodiscard]] bool holds(std::uint32_t band) const { return (band + kBands - begin_) % kBands < count_; }
    FilmStore& store_;
    std::uint32_t begin_, count_;
  };

  FilmState state_;
  // Band b guards rows y with y / kBandRows mod kBands = b; taken before done_mutex_.
  std::array<std::mutex, kBands> bands_;
  std::mutex done_mutex_;
  std::atomic<bool> spoiled_{false};
};

}  // namespace eikon
