# SPDX-License-Identifier: Apache-2.0
"""The pictures of the shipped scenes: PNG textures and the sky as Radiance HDR. Standard library only.

The PNGs are stored, not deflated: zlib's output differs between its versions, and these files are always the same bytes.
"""

import math
import struct
import zlib

from .png_file import RGB, RGBA, pack_png


def png(width, height, pixel):
    """8-bit PNG; pixel(x, y) is a tuple of 3 (RGB) or 4 (RGBA) numbers in [0, 255], y down from the top; rounded."""
    channels = len(pixel(0, 0))
    rows = b"".join(b"\0" + bytes(int(c + 0.5) for x in range(width) for c in pixel(x, y)) for y in range(height))
    pieces = [rows[i:i + 65535] for i in range(0, len(rows), 65535)]
    stored = b"".join(struct.pack("<BHH", i == len(pieces) - 1, len(piece), len(piece) ^ 0xFFFF) + piece
                      for i, piece in enumerate(pieces))
    packed = b"\x78\x01" + stored + struct.pack(">I", zlib.adler32(rows))
    return pack_png((width, height), packed, {3: RGB, 4: RGBA}[channels])


def hdr(width, height, radiance):
    """Radiance RGBE with run-length scanlines (all literal); radiance(x, y) is linear RGB, y down from the top."""
    def rgbe(color):
        mantissa, exponent = math.frexp(max(color))
        if mantissa == 0:
            return (0, 0, 0, 0)
        return (*(min(255, int(c * 256 / 2.0 ** exponent)) for c in color), exponent + 128)

    data = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode()
    for y in range(height):
        pixels = [rgbe(radiance(x, y)) for x in range(width)]
        data += struct.pack(">BBH", 2, 2, width)
        for channel in range(4):
            plane = bytes(p[channel] for p in pixels)
            for start in range(0, width, 128):
                piece = plane[start:start + 128]
                data += bytes([len(piece)]) + piece
    return data


def sky(width=128, height=64):
    """Bytes of sky.hdr: a clear sky that grows brighter and paler towards the horizon and towards the sun's place
    (azimuth 40 degrees from -Z towards +X, 35 degrees high; the disc itself is a light of the scene), over dim ground."""
    elevation, azimuth = math.radians(35), math.radians(40)
    sun = (math.cos(elevation) * math.sin(azimuth), math.sin(elevation), -math.cos(elevation) * math.cos(azimuth))

    def radiance(x, y):
        phi, theta = 2 * math.pi * ((x + 0.5) / width - 0.5), math.pi * (y + 0.5) / height
        direction = (math.sin(theta) * math.sin(phi), math.cos(theta), -math.sin(theta) * math.cos(phi))
        if direction[1] < 0:
            return (0.35, 0.3, 0.24)
        haze = (1 - direction[1]) ** 4
        glow = max(0.0, sum(a * b for a, b in zip(direction, sun))) ** 24
        clear, pale, warm = (0.6, 1.3, 3.0), (2.6, 2.9, 3.2), (14.0, 11.0, 7.0)
        return tuple(c + haze * (p - c) + glow * w for c, p, w in zip(clear, pale, warm))

    return hdr(width, height, radiance)


# --- Patterns of a wall of glazed tiles with metal rivets, tileable; u and v in [0, 1).

TILES = 4  # in a row; every other row is shifted by half a tile
SIDE = 128


def _tile(u, v):
    """(height in [0, 1], is rivet, tile number) of the tiles' surface."""
    row = int(v * TILES)
    shifted = u * TILES + (row % 2) / 2
    x, y = shifted % 1 - 0.5, v * TILES - row - 0.5
    edge = min(0.5 - abs(x), 0.5 - abs(y))
    rivet = math.hypot(x, y)
    if rivet < 0.18:
        return 0.8 + 0.5 * math.sqrt(max(0.0, 0.18 ** 2 - rivet ** 2)) / 0.18, True, 0
    number = (int(shifted) % TILES) * 31 + row * 17
    return 0.8 * min(1.0, max(0.0, (edge - 0.04) / 0.1)), False, number


def tiles_color():
    """sRGB base colour: glazed tiles in four colours, grey mortar, brass rivets."""
    glazes = ((178, 58, 44), (36, 96, 140), (214, 170, 70), (60, 130, 92))

    def pixel(x, y):
        height, rivet, number = _tile((x + 0.5) / SIDE, (y + 0.5) / SIDE)
        if rivet:
            return (230, 190, 120)
        return glazes[number % 4] if height > 0.2 else (120, 116, 110)

    return png(SIDE, SIDE, pixel)


def tiles_metallic_roughness():
    """G roughness, B metallic: glossy tiles, rough mortar, brushed metal rivets."""
    def pixel(x, y):
        height, rivet, _ = _tile((x + 0.5) / SIDE, (y + 0.5) / SIDE)
        return (0, 90, 255) if rivet else (0, 70, 0) if height > 0.2 else (0, 230, 0)

    return png(SIDE, SIDE, pixel)


def tiles_normal():
    """Tangent-space normals, +Y up against v, of the same surface."""
    def pixel(x, y):
        def height(dx, dy):
            return _tile(((x + 0.5 + dx) / SIDE) % 1, ((y + 0.5 + dy) / SIDE) % 1)[0]

        slope = 2.2  # height of 1 in texels
        n = (slope * (height(-1, 0) - height(1, 0)) / 2, slope * (height(0, 1) - height(0, -1)) / 2, 1.0)
        length = math.sqrt(sum(c * c for c in n))
        return tuple(127.5 + 127.5 * c / length for c in n)

    return png(SIDE, SIDE, pixel)


def checker():
    """sRGB: 2 x 2 squares, light and dark, in 16 x 16 texels."""
    return png(16, 16, lambda x, y: (225, 220, 210) if (x < 8) == (y < 8) else (70, 72, 78))


def leaf():
    """sRGB and opacity: a pointed leaf with a pale rib, upright in its square; transparent around it."""
    def pixel(x, y):
        u, v = (x + 0.5) / 64 - 0.5, 1 - (y + 0.5) / 64
        half = 0.42 * math.sin(math.pi * min(1.0, v ** 0.8)) * (1 + 0.12 * math.sin(40 * v))
        rib = abs(u) < 0.02 or abs((v * 10 - 6 * abs(u)) % 1 - 0.5) < 0.07
        # The opacity falls off over a few texels, so that the cutoff finds a smooth outline between
        # them.
        opacity = min(1.0, max(0.0, 0.5 + 10 * (half - abs(u))))
        if opacity == 0:
            return (0, 0, 0, 0)  # black, so that the picture also serves as a light
        return (*((150, 190, 90) if rib else (58, 122, 40)), 255 * opacity)

    return png(64, 64, pixel)
