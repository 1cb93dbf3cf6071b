#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What the add-on for Blender does without Blender: picture_test.py EIKON [unittest arguments]"""
import os
import pathlib
import socket
import struct
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path()
SKIPPED = 77
try:
    import numpy as np
except ImportError:
    print("left out: the module numpy is missing")
    sys.exit(SKIPPED)

sys.path.insert(0, str(ROOT / "tools/blender"))
from eikon_render import picture, program  # noqa: E402


def message(operation, *parts):
    body = bytes([operation, 0]) + b"".join(parts)
    return struct.pack("<I", 4 + len(body)) + body


CREATE = message(4, b"out.exr\0", struct.pack("<iii", 3, 2, 2), b"R\0depth.Z\0")


def update(name, x, y, rows):
    values = np.asarray(rows, "<f4")
    window = struct.pack("<iiii", x, y, values.shape[1], values.shape[0])
    return message(6, b"out.exr\0", struct.pack("<i", 1), name + b"\0", window, struct.pack("<qq", 0, 1), values.tobytes())


class Receiver(unittest.TestCase):
    def after(self, *pieces):
        """The receiver after these bytes and the end of the connection."""
        receiver = picture.PictureReceiver()
        host, _, port = receiver.address.rpartition(":")
        with socket.create_connection((host, int(port))) as connection:
            for piece in pieces:
                connection.sendall(piece)
        receiver.join()
        return receiver

    def test_has_the_newest_state_of_each_pixel(self):
        receiver = self.after(CREATE, update(b"R", 0, 0, [[1, 2, 3], [4, 5, 6]]), update(b"R", 1, 1, [[7, 8]]),
                              update(b"depth.Z", 0, 0, [[np.inf, 1, 1]]))
        self.assertEqual(receiver.error, "")
        changes, channels = receiver.copy(0)
        self.assertEqual(channels["R"].tolist(), [[1, 2, 3], [4, 7, 8]])
        self.assertEqual(channels["depth.Z"].tolist(), [[np.inf, 1, 1], [0, 0, 0]])
        self.assertEqual(receiver.copy(changes), (changes, None))

    def test_says_what_did_not_arrive_and_keeps_the_rest(self):
        good = update(b"R", 0, 0, [[1, 2, 3]])
        for name, wrong in {"cut": good[:-1], "cut in its length": good[:2], "long": struct.pack("<I", 1 << 31),
                            "short": struct.pack("<I", 3), "without its values": message(6, b"out.exr\0", struct.pack("<i", 1)),
                            "outside": update(b"R", 2, 0, [[1, 2, 3]]), "without end of name": message(4, b"out.exr")}.items():
            with self.subTest(message=name):
                receiver = self.after(CREATE, good, wrong)
                self.assertIn("did not arrive as a whole", receiver.error)
                self.assertEqual(receiver.copy(0)[1]["R"][0].tolist(), [1, 2, 3])

    def test_ends_without_a_connection(self):
        receiver = picture.PictureReceiver()
        receiver.join()
        self.assertEqual((receiver.error, receiver.copy(0)), ("", (0, None)))


class Program(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def run_with(self, *flags):
        """(what was received, what ran) of a render of the Cornell box."""
        with picture.PictureReceiver() as receiver:
            with program.Eikon(str(PROGRAM), [str(ROOT / "scenes/cornell.gltf"), "-o", "a.exr", "--size", "20x16", *flags,
                                              "--tev", receiver.address], self.folder) as eikon:
                eikon.wait(None)
        return receiver, eikon

    def test_sends_its_picture_layers_and_progress(self):
        receiver, eikon = self.run_with("--spp", "4", "--aov", "depth,normal")
        self.assertEqual((eikon.failure(), receiver.error, eikon.lines), ("", "", []))
        channels = receiver.copy(0)[1]
        self.assertEqual(sorted(channels), ["B", "G", "R", "depth.Z", "normal.X", "normal.Y", "normal.Z"])
        self.assertEqual(channels["G"].shape, (16, 20))
        self.assertGreater(channels["G"].mean(), 0.05)
        self.assertGreater(channels["R"][:, :6].mean(), 2 * channels["G"][:, :6].mean())  # the red wall is on the left
        self.assertEqual((eikon.progress, eikon.status), (1, "done"))

    def test_that_refuses_says_why_in_its_own_line(self):
        receiver, eikon = self.run_with("--nonsense")
        self.assertRegex(eikon.failure(), "^eikon: .*--nonsense")
        self.assertEqual((receiver.error, eikon.process.returncode), ("", 2))

    def test_is_cancelled(self):
        with picture.PictureReceiver() as receiver:
            flags = [str(ROOT / "scenes/cornell.gltf"), "-o", "a.exr", "--size", "20x16", "--spp", "100000000",
                     "--tev", receiver.address]
            with program.Eikon(str(PROGRAM), flags, self.folder) as eikon:
                while receiver.copy(0)[1] is None and not eikon.wait(0.05):
                    pass
                eikon.cancel()
        self.assertEqual(eikon.process.returncode, 143)
        self.assertEqual(receiver.error, "")

    def test_is_found_in_path_or_by_the_preferences(self):
        self.assertEqual(program.find_eikon(str(PROGRAM)), str(PROGRAM))
        with mock.patch.dict(os.environ, {"PATH": str(PROGRAM.parent)}):
            self.assertEqual(program.find_eikon(""), str(PROGRAM))
        with mock.patch.dict(os.environ, {"PATH": self.folder}), self.assertRaisesRegex(program.EikonError, "not in PATH"):
            program.find_eikon("")
        with self.assertRaisesRegex(program.EikonError, "not there"):
            program.find_eikon(self.folder + "/missing")


if __name__ == "__main__":
    PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
