// SPDX-License-Identifier: Apache-2.0
// The counts of a film's mattes beside its sums, as a part of the file that is a table and no picture: an entry for each matte,
// pixel and id, in this order, so that the same counts give the same bytes. Channels "matte", "pixel" (of the crop, row by row),
// "id", "count.0", "count.1" (low word first); entries run along the rows, and what is behind the last one is zero.
#pragma once
#include <ImfHeader.h>
#include <ImfOutputPart.h>

#include "image/exr_file.h"
#include "film/film.h"

namespace eikon::exr {

/// seal  the checksum of the sums that these counts belong to
[[nodiscard]] Imf::Header mattes_header(const Film& film, Imf::Header like, const std::string& seal);
void write_mattes(Imf::OutputPart& part, const Film& film);

/// Adds them to a film within whose crop that of `layout` lies. throws InputError when they are damaged, are not there, or belong to
/// other sums; the film is then unusable
void read_mattes(const std::filesystem::path& path, Reader& reader, const FilmLayout& layout, const std::string& seal,
                 Film& film);

}  // namespace eikon::exr
