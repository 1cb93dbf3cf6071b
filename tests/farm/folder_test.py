#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the farm's folder keeps, and what the commands make of it when it was damaged, moved, or is in use: without a cluster,
and without eikon. The argument, the real one, is not used."""
import pathlib
import sys
import unittest
import unittest.mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from farm import jobs  # noqa: E402


class Names(unittest.TestCase):
    """Of the images' files in the folder."""

    def names(self, *outputs):
        said = [{"error": None, "line": 1, "words": [], "part": [], "samples": [0, 1], "output": output, "key": "", "scene": "",
                 "size": None, "open_ended": False, "results": [output]} for output in outputs]
        with unittest.mock.patch.object(jobs, "list_lines", return_value=said):
            return [job.name for job in jobs.read_jobs("eikon", "", "/", "jobs.txt")]

    def test_no_two_images_have_one_name(self):
        self.assertEqual(self.names("x/a.exr", "y/a.exr", "a-2.exr"), ["a", "a-2", "a-2-2"])
        self.assertEqual(self.names("a-2.exr", "x/a.exr", "y/a.exr", "z/a.exr"), ["a-2", "a", "a-3", "a-4"])

    def test_a_name_of_dots_is_no_folder(self):
        self.assertEqual(self.names("..exr", "...exr", "out/..exr"), ["image", "image-2", "image-3"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
