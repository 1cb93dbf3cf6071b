#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that renders from Python are those of the program: render_test.py EIKON [unittest arguments]"""
import json
import os
import signal
import threading

import eikon
import numpy as np
from package_case import SCENES, Package, main


class Render(Package):
    def test_has_the_bits_of_the_command_line_in_every_layer_and_in_the_png(self):
        scene = SCENES / "window_room.gltf"
        done = self.program("render", scene, "-o", "a.exr", "--png", "a.png", "--size", "24x16", "--spp", "8", "--aov",
                            "albedo,normal,depth,id,variance,samples,direct,cryptomatte_object", "--exposure", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        picture = eikon.render(scene, size=(24, 16), spp=8,
                               aov=["albedo", "normal", "depth", "id", "variance", "samples", "direct", "cryptomatte_object"])
        self.assert_same_picture(picture, eikon.read(self.folder / "a.exr"))
        self.assertEqual(picture["normal"].shape, (16, 24, 3))
        self.assertEqual(picture["cryptomatte_object00"].shape, (16, 24, 4))
        picture.save(self.folder / "b.png", exposure=1)
        self.assertEqual((self.folder / "a.png").read_bytes(), (self.folder / "b.png").read_bytes())
        picture.save(self.folder / "b.exr")
        self.assertEqual(self.program("compare", "a.exr", "b.exr", "--fail-above", "0").returncode, 0)

    def test_other_flags_are_keywords(self):
        picture = eikon.render(SCENES / "sphere_in_sky.gltf", size=(16, 9), spp=4, env=(1, 2, 3), transparent=True, filter="gaussian",
                               seed=7, energy_compensation=True, output=self.folder / "kept.exr", stats=self.folder / "kept.json")
        done = self.program("render", SCENES / "sphere_in_sky.gltf", "-o", "a.exr", "--size", "16x9", "--spp", "4", "--env", "1,2,3",
                            "--transparent", "--filter", "gaussian", "--seed", "7", "--energy-compensation", "on")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same_picture(picture, eikon.read(self.folder / "a.exr"))
        self.assert_same_picture(picture, eikon.read(self.folder / "kept.exr"))
        self.assertIn("alpha", picture.layers)
        self.assertEqual(json.loads((self.folder / "kept.json").read_text())["seed"], 7)

    def test_leaves_every_file_that_the_program_leaves(self):
        flags = {"size": (8, 8), "spp": 2, "depth_series": [1, 2]}
        picture = eikon.render(SCENES / "cornell.gltf", output=self.folder / "ds.exr", png=self.folder / "ds.png", **flags)
        done = self.program("render", SCENES / "cornell.gltf", "--output=cli.exr", "--png=cli.png", "--size=8x8", "--spp=2", "--depth-series=1,2")
        self.assertEqual(done.returncode, 0, done.stderr)
        files = {file.name for file in self.folder.iterdir()}
        self.assertEqual({name.replace("ds", "cli") for name in files if name.startswith("ds")}, {name for name in files if name.startswith("cli")})
        for part in ("ds.depth1.exr", "ds.depth2.exr", "ds.exr"):
            self.assert_same_picture(eikon.read(self.folder / part), eikon.read(self.folder / part.replace("ds", "cli")))
        # The picture is that of the render, whatever its file holds later.
        eikon.render(SCENES / "furnace.gltf", output=self.folder / "ds.exr", size=(8, 8), spp=2)
        picture.save(self.folder / "again.exr")
        self.assert_same_picture(eikon.read(self.folder / "again.exr"), eikon.read(self.folder / "cli.exr"))

    def test_leaves_out_empty_lists_and_gives_each_part_of_its_own(self):
        flags = {"size": (8, 8), "spp": 6}
        whole = eikon.render(SCENES / "cornell.gltf", **flags)
        self.assert_same_picture(eikon.render(SCENES / "cornell.gltf", aov=[], depth_series=(), add=np.array([]), **flags), whole)
        parts = [self.folder / "a,b.exr", self.folder / "c.exr"]
        for part, begin in zip(parts, (0, 2)):
            eikon.render(SCENES / "cornell.gltf", size=(8, 8), samples=(begin, begin + 2), output=part)
        added = eikon.render(SCENES / "cornell.gltf", add=parts, **flags)
        self.assertEqual((added.rgb.tobytes(), added.stats["samples"]), (whole.rgb.tobytes(), 2 * 64))
        added = eikon.render(SCENES / "cornell.gltf", add=parts[0], **flags)
        self.assertEqual(added.stats["samples"], 4 * 64)
        for key in ("aov", "output", "env"):
            with self.assertRaisesRegex(eikon.UsageError, f"^{key}: the text is empty; give a value, or leave {key} out$"):
                eikon.render(SCENES / "cornell.gltf", **{key: ""})

    def test_that_ends_before_its_first_sample_is_no_older_picture(self):
        older = eikon.render(SCENES / "furnace.gltf", output=self.folder / "a.exr", size=(8, 8), spp=2)
        with self.assertRaisesRegex(eikon.UsageError, "before the first sample"):
            eikon.render(SCENES / "furnace.gltf", output=self.folder / "a.exr", size=(8, 8), time=0.01)
        self.assert_same_picture(eikon.read(self.folder / "a.exr"), older)

    def test_states_its_error_with_an_interval_and_its_statistics(self):
        picture = eikon.render(SCENES / "cornell.gltf", size=(16, 16), spp=16)
        self.assertTrue(0 < picture.error.low < picture.error.relmse < picture.error.high)
        self.assertEqual(picture.error.relmse, picture.stats["relmse_predicted"])
        self.assertEqual([picture.error.low, picture.error.high], picture.stats["relmse_interval"])
        self.assertEqual(picture.stats["samples"], 16 ** 3)
        self.assertTrue(picture.as_asked)
        self.assertTrue(picture._repr_png_().startswith(b"\x89PNG"))
        self.assertIn("16 x 16", repr(picture))

    def test_takes_a_camera_by_matrix_with_any_roll(self):
        # Rolled by 90 degrees: world from camera has the camera's x along -y.
        matrix = np.array([[0, 1, 0, 0.278], [-1, 0, 0, 0.273], [0, 0, 1, 1.2], [0, 0, 0, 1]])
        rolled = eikon.render(SCENES / "cornell.gltf", camera=matrix, fov=40, size=(12, 12), spp=4)
        named = eikon.render(SCENES / "cornell.gltf", look_at=((0.278, 0.273, 1.2), (0.278, 0.273, 0.2), (1, 0, 0)), fov=40,
                             size=(12, 12), spp=4)
        self.assertEqual(rolled.rgb.tobytes(), named.rgb.tobytes())
        with self.assertRaisesRegex(eikon.UsageError, "without a scale"):
            eikon.render(SCENES / "cornell.gltf", camera=2 * np.eye(4))
        with self.assertRaisesRegex(eikon.UsageError, "shape"):
            eikon.render(SCENES / "cornell.gltf", camera=np.eye(3))
        by_index = eikon.render(SCENES / "cornell.gltf", camera=np.int64(0), size=(12, 12), spp=1)
        self.assertEqual(by_index.rgb.shape, (12, 12, 3))

    def test_tells_progress_and_ends_by_it_with_what_is_done(self):
        calls = []

        def progress(now):
            calls.append(now)
            return len(calls) < 2

        picture = eikon.render(SCENES / "cornell.gltf", size=(128, 128), spp=1 << 24, progress=progress)
        self.assertTrue(picture.interrupted)
        self.assertFalse(picture.as_asked)
        self.assertTrue(0 < calls[-1].share < 1 and calls[-1].samples > 0)
        self.assertGreater(picture.stats["samples"], 0)

    def test_ends_by_a_false_of_numpy_too(self):
        calls = []

        def progress(now):
            calls.append(now)
            if len(calls) > 20:
                raise LookupError("the render goes on")
            return np.less(now.samples, 0)

        picture = eikon.render(SCENES / "cornell.gltf", size=(128, 128), spp=1 << 24, progress=progress)
        self.assertTrue(picture.interrupted)
        for answer in (np.True_, None, 0, "", np.array([])):  # nothing else ends it
            self.assertFalse(eikon.render(SCENES / "furnace.gltf", size=(8, 8), spp=2, progress=lambda _, a=answer: a).interrupted)

    def test_raises_what_progress_raises(self):
        def progress(_):
            raise LookupError("enough")

        with self.assertRaisesRegex(LookupError, "enough"):
            eikon.render(SCENES / "cornell.gltf", size=(64, 64), spp=1 << 24, progress=progress)

    def test_ctrl_c_ends_it_and_other_threads_run_meanwhile(self):
        # The signal comes once the render is under way, which another thread of Python sees.
        begun = threading.Event()

        def interrupt():
            begun.wait()
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=interrupt)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            eikon.render(SCENES / "cornell.gltf", size=(128, 128), spp=1 << 24, progress=lambda _: begun.set())
        thread.join()
        self.assertIs(signal.getsignal(signal.SIGINT), signal.default_int_handler)
        # The driver's handlers are gone, so that Ctrl-C still is an exception.
        with self.assertRaises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            threading.Event().wait(60)

    def test_may_run_on_any_thread(self):
        pictures = {}

        def work(seed):
            pictures[seed] = eikon.render(SCENES / "furnace.gltf", size=(8, 8), spp=2, seed=seed)

        threads = [threading.Thread(target=work, args=(seed,)) for seed in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        alone = eikon.render(SCENES / "furnace.gltf", size=(8, 8), spp=2, seed=1)
        self.assertEqual(pictures[1].rgb.tobytes(), alone.rgb.tobytes())


if __name__ == "__main__":
    main()
