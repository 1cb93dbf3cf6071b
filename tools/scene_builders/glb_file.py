# SPDX-License-Identifier: Apache-2.0
"""Writes the binary form of glTF 2.0, a .glb file. Standard library only."""

import struct

MAGIC, VERSION = 0x46546C67, 2  # the first reads "glTF"
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
HEADER_BYTES, CHUNK_HEADER_BYTES = 12, 8


def pack_glb(text, binary):
    """Returns the bytes of a .glb file: `text` is its document as JSON in bytes, `binary` is its buffer.

    glTF wants the length of each chunk to be a multiple of four, so text is padded with spaces and the buffer with zeros."""
    text += b" " * (-len(text) % 4)
    binary = bytes(binary) + b"\0" * (-len(binary) % 4)
    length = HEADER_BYTES + CHUNK_HEADER_BYTES + len(text) + CHUNK_HEADER_BYTES + len(binary)
    return b"".join([struct.pack("<III", MAGIC, VERSION, length), struct.pack("<II", len(text), JSON_CHUNK), text,
                     struct.pack("<II", len(binary), BINARY_CHUNK), binary])


def field_offsets(data):
    """Returns {name: offset in bytes} of the numbers of 32 bits in the headers of a file that pack_glb() made."""
    json_length, = struct.unpack_from("<I", data, HEADER_BYTES)
    binary_chunk = HEADER_BYTES + CHUNK_HEADER_BYTES + json_length
    return {"magic": 0, "version": 4, "length": 8, "json_length": 12, "json_type": 16, "bin_length": binary_chunk,
            "bin_type": binary_chunk + 4}
