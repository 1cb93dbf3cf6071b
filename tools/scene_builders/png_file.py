# SPDX-License-Identifier: Apache-2.0
"""Writes PNG files from rows of pixels that are packed already. Standard library only."""

import struct
import zlib

SIGNATURE = b"\x89PNG\r\n\x1a\n"
GREY, RGB, RGBA = 0, 2, 6  # the colour types of a header


def pack_chunk(kind, data, good_checksum=True):
    """Returns the bytes of a chunk: its length, its kind (4 bytes), its data and their checksum, which is wrong on demand."""
    checksum = zlib.crc32(kind + data) ^ (0 if good_checksum else 1)
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", checksum)


def pack_png(size, packed_rows, color_type=RGB, depth=8, interlace=0, good_checksums=True):
    """Returns the bytes of a PNG file of `size` (width, height) pixels with `depth` bits in each channel.

    packed_rows is a zlib stream of the rows from the top down, each with the byte of its filter in front. Nothing is
    checked, since files that lie about themselves are made here too."""
    header = struct.pack(">IIBBBBB", *size, depth, color_type, 0, 0, interlace)
    chunks = ((b"IHDR", header), (b"IDAT", packed_rows), (b"IEND", b""))
    return SIGNATURE + b"".join(pack_chunk(kind, data, good_checksums) for kind, data in chunks)
