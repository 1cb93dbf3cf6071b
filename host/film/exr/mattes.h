// SPDX-License-Identifier: Apache-2.0
// Stores the counts of a film's mattes beside its sums. The part of the file is a table, not a
// picture: it has an entry for each matte, pixel and id, in this order, so that the same counts
// give the same bytes. Its channels are "matte", "pixel" (of the crop, row by row), "id", "count.0"
// and "count.1" (low word first). Entries run along the rows, and zeros follow the last one.
#pragma once
#include <ImfHeader.h>
#include <ImfOutputPart.h>

#include "image/exr_file.h"
#include "film/film.h"

namespace eikon::exr {

/// seal  the checksum of the sums that these counts belong to
[[nodiscard]] Imf::Header mattes_header(const Film& film, Imf::Header like, const std::string& seal);
void write_mattes(Imf::OutputPart& part, const Film& film);

/// Adds the counts to a film whose crop contains that of `layout`. throws InputError when they are
/// damaged or missing, or belong to other sums; the film is then unusable
void read_mattes(const std::filesystem::path& path, Reader& reader, const FilmLayout& layout, const std::string& seal,
                 Film& film);

}  // namespace eikon::exr
