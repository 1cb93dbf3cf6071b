#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that names of files may hold bytes that are no text: names_test.py EIKON [unittest arguments]"""
import json
import os

import eikon
from package_case import SCENES, Package, main

NAME = os.fsdecode(b"caf\xe9")  # in Latin-1, which is not UTF-8


class Names(Package):
    def test_that_are_no_text_are_those_of_the_files(self):
        scene, files = self.folder / f"{NAME}.gltf", {key: self.folder / f"{NAME}.{key}" for key in ("exr", "json", "png")}
        scene.write_bytes((SCENES / "furnace.gltf").read_bytes())
        part = eikon.render(os.fspath(scene), size=(8, 8), samples=(0, 2), output=os.fspath(files["exr"]), stats=files["json"],
                            png=files["png"])
        self.assert_same_picture(part, eikon.render(SCENES / "furnace.gltf", size=(8, 8), samples=(0, 2)))
        self.assertEqual(sorted(os.listdir(os.fsencode(self.folder))), [b"caf\xe9.exr", b"caf\xe9.gltf", b"caf\xe9.json", b"caf\xe9.png"])
        self.assertEqual(part.metadata["scene"], r"caf\xe9.gltf")
        self.assertEqual(json.loads(files["json"].read_text()), part.stats)
        self.assert_same_picture(eikon.read(files["exr"]), part)
        for ending in ("exr", "png"):
            part.save(self.folder / f"{NAME} saved.{ending}")
        self.assertEqual((self.folder / f"{NAME} saved.png").read_bytes(), files["png"].read_bytes())
        merged = eikon.merge([os.fspath(files["exr"])], self.folder / f"{NAME} merged.exr", png=self.folder / f"{NAME} merged.png")
        self.assertEqual(merged.rgb.tobytes(), part.rgb.tobytes())
        self.assertEqual(eikon.compare(os.fspath(files["exr"]), self.folder / f"{NAME} saved.exr").mse, 0)
        self.assertEqual(eikon.meter(scene, (0, 0, 0), facing=(0, 1, 0), spp=1).quantity, "irradiance")

    def test_may_be_given_as_bytes(self):
        files = {key: os.fsencode(self.folder / f"a.{key}") for key in ("output", "stats", "png", "checkpoint")}
        part = eikon.render(SCENES / "furnace.gltf", size=(8, 8), samples=(0, 2), **files)
        merged = eikon.merge([files["output"]], os.fsencode(self.folder / "m.exr"), png=os.fsencode(self.folder / "m.png"))
        for ending in (b"exr", b"png"):
            merged.save(os.fsencode(self.folder) + b"/saved." + ending)
        names = ["a.checkpoint", "a.output", "a.png", "a.stats", "m.exr", "m.png", "saved.exr", "saved.png"]
        self.assertEqual(sorted(os.listdir(self.folder)), names)
        self.assertEqual(eikon.compare(files["output"], part).mse, 0)

    def test_that_are_no_text_are_escaped_in_errors_as_the_program_does(self):
        missing = self.folder / f"{NAME}.gltf"
        with self.assertRaises(eikon.InputError) as caught:
            eikon.render(missing)
        done = self.program("render", missing)
        self.assertEqual((done.returncode, done.stderr), (3, f"eikon: {caught.exception}\n"))
        self.assertIn(r"caf\xe9.gltf", str(caught.exception))
        picture = eikon.render(SCENES / "furnace.gltf", size=(4, 4), spp=2)
        for call, kind in ((lambda: eikon.read(missing), eikon.InputError), (lambda: eikon.merge([missing]), eikon.InputError),
                           (lambda: picture.save(self.folder / NAME / "a.png"), eikon.InputError),
                           (lambda: picture.save(self.folder / NAME / "a.exr"), eikon.InputError),
                           (lambda: picture.save(missing), eikon.UsageError)):
            with self.assertRaisesRegex(kind, r"caf\\xe9"):
                call()

    def test_that_no_file_can_have_are_refused(self):
        for name in ("a\0b.gltf", "\ud800.gltf"):
            for call in (eikon.render, eikon.read, lambda name: eikon.render(SCENES / "furnace.gltf", output=name)):
                with self.assertRaisesRegex(eikon.UsageError, "no name of a file has such characters$"):
                    call(name)


if __name__ == "__main__":
    main()
