#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that pictures of other programs are read: pictures_test.py EIKON [unittest arguments]"""
import struct

import eikon
import numpy as np
from package_case import Package, main


class Pictures(Package):
    def exr(self, **channels):
        """A file of another program: scan lines of floats, not compressed."""
        (height, width), names = next(iter(channels.values())).shape, sorted(channels)

        def attribute(name, kind, value):
            return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value

        window = struct.pack("<4i", 0, 0, width - 1, height - 1)
        listed = b"".join(name.encode() + b"\0" + struct.pack("<I4x2I", 2, 1, 1) for name in names) + b"\0"
        header = struct.pack("<2I", 20000630, 2) + b"".join((
            attribute(b"channels", b"chlist", listed), attribute(b"compression", b"compression", b"\0"),
            attribute(b"dataWindow", b"box2i", window), attribute(b"displayWindow", b"box2i", window),
            attribute(b"lineOrder", b"lineOrder", b"\0"), attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
            attribute(b"screenWindowCenter", b"v2f", bytes(8)), attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)))) + b"\0"
        size = 8 + 4 * width * len(names)
        begin = len(header) + 8 * height
        rows = [struct.pack("<2i", y, size - 8) + b"".join(channels[name][y].astype("<f4").tobytes() for name in names) for y in range(height)]
        file = self.folder / f"{'_'.join(names)}.exr"
        file.write_bytes(header + b"".join(struct.pack("<Q", begin + y * size) for y in range(height)) + b"".join(rows))
        return file

    def test_without_colour_have_a_size_and_layers_and_are_not_shown(self):
        depth = np.arange(6, dtype=np.float32).reshape(2, 3)
        for channels in ({"Z": depth}, {"R": depth, "Z": depth}, {"R": depth, "G": depth}):
            picture = eikon.read(self.exr(**channels))
            self.assertEqual((picture.width, picture.height), (3, 2))
            self.assertIn("3 x 2", repr(picture))
            self.assertIsNone(picture._repr_png_())
            for call in (lambda: picture.save(self.folder / "a.png"), lambda: picture.rgb):
                with self.assertRaisesRegex(eikon.UsageError, f"has no channel {'B' if 'G' in channels else '[RG]'}"):
                    call()
            self.assertFalse((self.folder / "a.png").exists())
            picture.save(self.folder / "again.exr")
            self.assertEqual(eikon.read(self.folder / "again.exr").layers.keys(), picture.layers.keys())
        np.testing.assert_array_equal(eikon.read(self.folder / "Z.exr")["Z"], depth)
        colour = eikon.read(self.exr(R=depth, G=depth, B=depth, Z=depth))
        self.assertEqual(colour.rgb.shape, (2, 3, 3))
        self.assertTrue(colour._repr_png_().startswith(b"\x89PNG"))
        for flags in ({"exposure": float("nan")}, {"exposure": 65}, {"ev100": float("inf")}, {"exposure": 1, "ev100": 3}):
            with self.assertRaises(eikon.UsageError):
                colour.save(self.folder / "a.png", **flags)
        self.assertFalse((self.folder / "a.png").exists())


if __name__ == "__main__":
    main()
