#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that errors are exceptions of their kind, which leave no file behind: errors_test.py EIKON [unittest arguments]"""
import os
import pathlib

import eikon
from package_case import SCENES, Package, main


class Errors(Package):
    def test_are_of_one_kind_for_each_exit_code_with_the_line_of_the_program(self):
        for kind, code, words, arguments in (
                (eikon.InputError, 3, ["nowhere.gltf"], {}),
                (eikon.UsageError, 2, [SCENES / "cornell.gltf", "--spp=0"], {"spp": 0}),
                (eikon.UsageError, 2, [SCENES / "cornell.gltf", "--colour=red"], {"colour": "red"}),
                (eikon.DeviceError, 4, [SCENES / "cornell.gltf", "--devices=nosuch"], {"devices": "nosuch"})):
            with self.assertRaises(kind) as caught:
                eikon.render(words[0], **arguments)
            self.assertEqual(caught.exception.code, code)
            self.assertIsInstance(caught.exception, eikon.Error)
            done = self.program("render", *words)
            self.assertEqual(done.returncode, code)
            self.assertEqual(done.stderr.removeprefix("eikon: ").split(";")[0].strip(), str(caught.exception).split(";")[0].strip())

    def test_of_files_leave_nothing_behind(self):
        picture = eikon.render(SCENES / "furnace.gltf", size=(4, 4), spp=2)
        for path in ("nowhere/a.exr", "nowhere/a.png"):
            with self.assertRaises(eikon.InputError):
                picture.save(self.folder / path)
        with self.assertRaises(eikon.UsageError):
            picture.save(self.folder / "a.jpg")
        with self.assertRaises(eikon.UsageError):
            picture.save(self.folder / "a.png", tonemap="nice")
        with self.assertRaises(eikon.UsageError):
            eikon.render(SCENES / "furnace.gltf", frames=(0, 3))
        with self.assertRaises(eikon.UsageError):
            eikon.render(12)
        with self.assertRaises(eikon.InputError):
            eikon.render(b"no scene")
        with self.assertRaises(eikon.InputError):
            eikon.read(SCENES / "tiles_color.png")
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_of_outputs_are_those_of_the_program_and_come_before_the_render(self):
        scene = self.folder / "own.gltf"
        scene.write_bytes((SCENES / "furnace.gltf").read_bytes())
        before = scene.read_bytes()
        a, b = self.folder / "a.exr", self.folder / "b"
        for outputs in ({"output": scene}, {"stats": scene}, {"output": a, "png": a}, {"output": a, "stats": a}, {"output": a, "report": a},
                        {"output": a, "checkpoint": a}, {"stats": b, "profile": b}, {"output": "nowhere/a.exr"},
                        {"output": a, "stats": "nowhere/a.json"}, {"output": self.folder}, {"depth_series": [1], "output": a, "png": self.folder / "a.depth1.exr"}):
            words = [f"--{key.replace('_', '-')}={','.join(map(str, value)) if isinstance(value, list) else value}" for key, value in outputs.items()]
            done = self.program("render", scene, "--size=4x4", "--spp=2", *words)
            calls = []
            with self.assertRaises(eikon.Error, msg=outputs) as caught:
                eikon.render(scene, size=(4, 4), spp=2, progress=calls.append, **outputs)
            self.assertEqual((caught.exception.code, f"eikon: {caught.exception}\n", calls), (done.returncode, done.stderr, []))
            self.assertEqual(scene.read_bytes(), before)
            self.assertEqual(list(self.folder.iterdir()), [scene])

    def test_standard_output_stays_that_of_python(self):
        part = eikon.render(SCENES / "furnace.gltf", size=(4, 4), samples=(0, 2))
        before = os.fstat(1)
        for key in ("output", "stats", "png", "report", "profile", "checkpoint"):
            for name in ("-", pathlib.Path("-")):
                with self.assertRaisesRegex(eikon.UsageError, f"{key}: standard output belongs to Python"):
                    eikon.render(SCENES / "furnace.gltf", size=(4, 4), spp=2, **{key: name})
        for flags in ({"output": "-"}, {"png": "-"}):
            with self.assertRaisesRegex(eikon.UsageError, "standard output belongs to Python"):
                eikon.merge([part], **flags)
        self.assertTrue(os.path.samestat(before, os.fstat(1)))

    def test_true_for_a_flag_that_takes_a_value_names_the_keyword(self):
        scene = SCENES / "furnace.gltf"
        before = sorted(os.listdir())
        for call in (lambda **flags: eikon.render(scene, size=(4, 4), spp=2, half=True, **flags),
                     lambda **flags: eikon.meter(scene, (0, 0, 0), facing=(0, 1, 0), **flags)):
            for key in ("seed", "max_depth", "env_scale"):
                with self.assertRaisesRegex(eikon.UsageError, f"{key}: takes a value"):
                    call(**{key: True})
        for key in ("profile", "png", "spp", "accel", "checkpoint_every"):
            with self.assertRaisesRegex(eikon.UsageError, f"{key}: takes a value"):
                eikon.render(scene, size=(4, 4), half=True, **{key: True})
        with self.assertRaisesRegex(eikon.UsageError, "png: takes a value"):
            eikon.merge([], png=True)
        with self.assertRaisesRegex(eikon.UsageError, "colour"):
            eikon.render(scene, colour=True)
        self.assertEqual(sorted(os.listdir()), before)

    def test_of_a_wrong_kind_come_before_the_render(self):
        scene = SCENES / "furnace.gltf"
        for words in ({"output": 5}, {"stats": 1.5}, {"output": ["a.exr"]}, {"progress": 5}):
            calls = []
            with self.assertRaises(eikon.UsageError, msg=words) as caught:
                eikon.render(scene, **{"size": (4, 4), "spp": 2, "progress": calls.append, **words})
            self.assertIn(next(iter(words)), str(caught.exception))
            self.assertEqual(calls, [])
        for part in ("part.exr", b"part.exr", self.folder / "part.exr"):
            with self.assertRaises(eikon.UsageError):
                eikon.merge(part)
        own = eikon.Scene()
        for wrong in ([[1j, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0], [1, 0], [0, 1]]):
            with self.assertRaises(eikon.UsageError):
                own.mesh(wrong, [[0, 1, 2]])
        with self.assertRaises(eikon.UsageError):
            own.save(self.folder / "own.txt")
        with self.assertRaises(eikon.InputError):
            own.save(self.folder / "nowhere" / "own.glb")
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_notes_say_what_was_left_out(self):
        scene = eikon.Scene()
        scene.add(scene.mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], material=scene.material(extensions={"NOBODY_knows": {}})))
        picture = eikon.render(scene, size=(8, 8), spp=2)
        self.assertTrue(any("NOBODY_knows" in note for note in picture.notes), picture.notes)


if __name__ == "__main__":
    main()
