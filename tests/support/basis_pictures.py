#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes KTX2 files of Basis Universal into a folder by the encoder of alktx2, and for each NAME.ktx2 its largest level as
NAME.rgba, by the decoder that comes with the encoder.

  basis_pictures.py FOLDER

Sizes are odd and even, with and without smaller levels, alpha, sRGB and Zstandard. The pictures are smooth, hard-edged, grey and
noisy, so that blocks of all kinds occur."""
import pathlib
import random
import struct
import sys

import alktx2

SIZES = ((1, 1), (3, 5), (4, 4), (17, 9), (64, 64), (101, 67))


def smooth(x, y, width, height):
    return (255 * x // width, 255 * y // height, 255 * (x + y) // (width + height), 255 - 255 * x // width)


def edges(x, y, _width, _height):
    inside = (x * 5 + y * 3) % 23 < 11
    return (220, 40, 30, 255) if inside else (20, 60 + 13 * (x // 7 % 9), 200, 60 * (y // 6 % 4))


def grey(x, y, _width, _height):
    value = (x * x + y * 7) % 256
    return (value, value, value, 255 - value)


def noise(x, y, _width, _height):
    state = random.Random(x * 7919 + y)
    return tuple(state.randrange(256) for _ in range(4))


def texels_of_tga(data, width, height):
    """The first pixels of an uncompressed TGA from the top, as RGBA. The decoder writes whole blocks, beyond the picture's edge."""
    stored_width, stored_height, bits, descriptor = struct.unpack_from("<HHBB", data, 12)
    start, channels = 18 + data[0], bits // 8
    stride = channels * stored_width
    rows = [data[start + stride * y:start + stride * (y + 1)] for y in range(stored_height)]
    if not descriptor & 0x20:
        rows.reverse()
    out = bytearray()
    for row in rows[:height]:
        for x in range(0, channels * width, channels):
            blue, green, red = row[x:x + 3]
            out += bytes((red, green, blue, row[x + 3] if channels == 4 else 255))
    return bytes(out)


def variants():
    """(name, options of the encoder)"""
    yield "etc1s", {"codec": "etc1s", "srgb": True}
    yield "etc1s_linear_levels", {"codec": "etc1s", "srgb": False, "linear": True, "quality": 90, "mipmaps": True}
    yield "uastc_zstd", {"codec": "uastc", "srgb": True, "zstd_supercompression_level": 6}
    yield "uastc_linear_levels", {"codec": "uastc", "srgb": False, "linear": True, "mipmaps": True, "effort": 8}


def main():
    folder = pathlib.Path(sys.argv[1])
    for picture in (smooth, edges, grey, noise):
        for width, height in SIZES:
            for opaque in (False, True):
                pixels = bytearray()
                for y in range(height):
                    for x in range(width):
                        color = picture(x, y, width, height)
                        pixels += bytes((*color[:3], 255 if opaque else color[3]))
                for name, options in variants():
                    data = alktx2.encode_raw_rgba_to_ktx2(bytes(pixels), width, height, not opaque, threads=1, **options)
                    stem = f"{picture.__name__}_{width}x{height}_{'opaque' if opaque else 'alpha'}_{name}"
                    (folder / f"{stem}.ktx2").write_bytes(data)
                    decoded, _ = alktx2.decode_ktx2_to_bytes(data, format="tga")
                    (folder / f"{stem}.rgba").write_bytes(texels_of_tga(decoded, width, height))


if __name__ == "__main__":
    main()
