# SPDX-License-Identifier: Apache-2.0
"""The base of the tests of the package for Python, which compare it with the program."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"


class Package(unittest.TestCase):
    binary = pathlib.Path()  # of the program

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program(self, *words):
        return subprocess.run([self.binary, *map(str, words)], cwd=self.folder, capture_output=True, text=True, check=False)

    def assert_same_picture(self, picture, other):
        self.assertEqual(sorted(picture.layers), sorted(other.layers))
        for layer in picture:
            self.assertEqual(picture[layer].tobytes(), other[layer].tobytes(), layer)


def main():
    """Runs the tests of a script that is started as SCRIPT EIKON [unittest arguments]."""
    Package.binary = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
