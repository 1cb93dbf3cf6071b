#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The denoised layer of `eikon view`, with the real library.

  tests/view/denoise_test.py EIKON [unittest arguments]

Exit code 77, skipped, unless EIKON_OIDN names Open Image Denoise's library."""
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile
import time
import unittest

from viewer import CORNELL, LIMIT_S, Viewer, floats_of_exr, rgbe_of

EIKON = ""
TURNED = {"--look-at": "0.1,0.4,-0.6:0.3,0.25,0.3"}


class Denoised(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="eikon_denoise_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def denoised(self, viewer, look, samples):
        """Asks for such a look. Returns news, what is known of each frame that is seen until there is one without noise of so many
        samples, and its pixels."""
        before = viewer.news()[0]["frame"]
        frame, seen, begin = before["number"] if before else 0, [], time.monotonic()
        viewer.look({"--size": "160x120", **look}, layer="denoised")
        while time.monotonic() - begin < LIMIT_S:
            news, pixels = viewer.news(frame=frame)
            if news["frame"]:
                frame = news["frame"]["number"]
                seen.append(news["frame"]["about"])
                if (seen[-1]["layer"], seen[-1]["samples"]) == ("denoised", samples):
                    return news, seen, pixels
            time.sleep(0.01)
        self.fail(f"never denoised: {seen[-3:]}, {viewer.news()[0]['status']}")

    def test_the_last_picture_has_the_bits_of_render_denoise(self):
        with Viewer(EIKON, self.folder, CORNELL, "--size", "160x120", "--spp", "8") as viewer:
            _, noisy = viewer.wait_for("done")
            self.assertEqual(viewer.news()[0]["status"]["denoiser"], "")
            for look in ({}, TURNED):
                news, _, pixels = self.denoised(viewer, look, 8)
                command = shlex.split(news["status"]["command"])
                run = subprocess.run([EIKON, *command[1:], "--denoise", "--quiet"], cwd=self.folder, capture_output=True, text=True, check=False)
                self.assertEqual(run.returncode, 0, run.stderr)
                planes = floats_of_exr(self.folder / "picture.exr")
                self.assertEqual(rgbe_of({c: planes[f"denoised.{c}"] for c in "RGB"}), pixels)
                self.assertNotEqual(pixels, noisy)

    def test_a_picture_is_denoised_again_only_where_that_pays_and_no_noisy_one_follows(self):
        with Viewer(EIKON, self.folder, CORNELL, "--size", "160x120", "--spp", "256") as viewer:
            _, seen, _ = self.denoised(viewer, {}, 256)
            layers = [about["layer"] for about in seen]
            first = layers.index("denoised")
            self.assertEqual(set(layers[first:]), {"denoised"})
            counts = [about["samples"] for about in seen[first:]]
            for before, after in zip(counts, counts[1:]):
                self.assertTrue(after >= 1.5 * before or after == 256, counts)
            # The next picture begins noisy.
            _, seen, _ = self.denoised(viewer, TURNED, 256)
            self.assertIn("picture", [about["layer"] for about in seen])

    def test_a_signal_ends_it_while_it_denoises(self):
        with Viewer(EIKON, self.folder, CORNELL, "--size", "1024x1024", "--spp", "2") as viewer:
            viewer.look({"--size": "1024x1024"}, layer="denoised")
            viewer.wait_for("done")
            self.assertEqual(viewer.end(), (0, "", ""))


if __name__ == "__main__":
    if not os.path.exists(os.environ.get("EIKON_OIDN", "")):
        print("EIKON_OIDN does not name Open Image Denoise's library")
        sys.exit(77)
    EIKON = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
