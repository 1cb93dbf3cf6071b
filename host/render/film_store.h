// SPDX-License-Identifier: Apache-2.0
// The film that several devices add to at once, and the ledger that goes with it.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "film/film.h"
#include "film/sample_ledger.h"

namespace eikon {

/// Sums, the samples that they are of, and the arithmetic classes of the devices that these are from.
struct FilmState {
  Film film;
  SampleLedger done;
  std::set<std::string> arithmetic = {};
};

/// Units whose rows lie apart are added at the same time: at hundreds of millions of samples per second, one at a time would hold up
/// the devices.
class FilmStore {
 public:
  explicit FilmStore(FilmState begin) : state_(std::move(begin)) {}

  /// throws as Film::add and SampleLedger::add do; the film is then spoiled: sums may be there without their samples
  void add(const WorkUnit& unit, const UnitSums& sums, const std::string& arithmetic);
  /// Film and ledger of one moment.
  [[nodiscard]] FilmState copy();
  /// Calls look(film) while nobody adds to it.
  template <class Look>
  void look(const Look& look) {
    const Rows all(*this, 0, kBands);
    look(static_cast<const Film&>(state_.film));
  }
  [[nodiscard]] std::vector<WorkUnit> missing(const Crop& crop, std::uint64_t begin, std::uint64_t end);
  [[nodiscard]] bool spoiled() const { return spoiled_.load(); }
  /// The end: the store is empty afterwards.
  [[nodiscard]] FilmState take() { return std::move(state_); }

 private:
  static constexpr std::uint32_t kBands = 64, kBandRows = 32;
  /// Locks bands [begin, begin + count), modulo their number, in one order for all.
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
  std::array<std::mutex, kBands> bands_;  // rows y with y / kBandRows mod kBands; taken before ledger_
  std::mutex ledger_;
  std::atomic<bool> spoiled_{false};
};

}  // namespace eikon
