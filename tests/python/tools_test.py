#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests merge, compare and meter against the program, and the choice of a driver: tools_test.py EIKON [unittest arguments]"""
import json
import os
import pathlib
import subprocess
import sys
from unittest import mock

import eikon
import numpy as np
from eikon import _driver
from package_case import SCENES, Package, main


class Tools(Package):
    def test_merge_is_exact_and_refuses_as_the_program_does(self):
        parts = [eikon.render(SCENES / "cornell.gltf", size=(12, 12), samples=part) for part in ((0, 4), (4, 8))]
        whole = eikon.render(SCENES / "cornell.gltf", size=(12, 12), spp=8)
        merged = eikon.merge(parts, self.folder / "merged.exr", png=self.folder / "merged.png")
        self.assertEqual(merged.rgb.tobytes(), whole.rgb.tobytes())
        self.assertEqual(merged.error, whole.error)
        self.assertTrue((self.folder / "merged.png").exists())
        late = eikon.render(SCENES / "cornell.gltf", size=(12, 12), samples=(12, 16))
        with self.assertWarnsRegex(UserWarning, "missing"):
            eikon.merge([parts[0], late])
        with self.assertRaisesRegex(eikon.InputError, "twice"):
            eikon.merge([parts[0], parts[0]])
        with self.assertRaises(eikon.InputError):
            eikon.merge([whole, parts[0]])  # a plain picture has no sums

    def test_compare_takes_pictures_files_and_arrays(self):
        picture = eikon.render(SCENES / "cornell.gltf", size=(8, 8), spp=2)
        picture.save(self.folder / "a.exr")
        brighter = picture.rgb * np.float32(2)
        for test in (picture, self.folder / "a.exr", picture.rgb):
            self.assertEqual(eikon.compare(test, picture).mse, 0)
            self.assertAlmostEqual(eikon.compare(brighter, test).ratio_of_means, 2, places=6)
        with self.assertRaises(eikon.InputError):
            eikon.compare(picture, picture.rgb[1:])
        with self.assertRaises(eikon.UsageError):
            eikon.compare(picture, picture.rgb[..., 0])
        for shape in ((0, 0, 3), (0, 8, 3), (8, 0, 3)):
            with self.assertRaisesRegex(eikon.UsageError, rf"with pixels, not \({shape[0]}, {shape[1]}, 3\)$"):
                eikon.compare(np.zeros(shape), np.zeros(shape))

    def test_meter_reads_what_the_program_reads(self):
        reading = eikon.meter(SCENES / "cornell.gltf", (0.278, 0.001, 0.28), facing=(0, 1, 0), spp=4)
        done = self.program("meter", SCENES / "cornell.gltf", "--at", "0.278,0.001,0.28", "--facing", "0,1,0", "--spp", "4", "--json")
        printed = json.loads(done.stdout)
        self.assertEqual(reading.value.tolist(), printed["value"])
        self.assertEqual(reading.standard_error.tolist(), printed["standard_error"])
        self.assertEqual(reading.notes, [])
        self.assertEqual((reading.quantity, reading.unit, reading.paths), ("irradiance", "W/m^2", printed["paths"]))
        with self.assertRaises(eikon.UsageError):
            eikon.meter(SCENES / "cornell.gltf", (0, 0, 0))

    def test_devices_are_those_of_the_program(self):
        printed = self.program("devices").stdout
        for device in eikon.devices():
            self.assertIn(f"{device.index}: {device.name}\n", printed)

    def test_the_import_loads_neither_numpy_nor_a_driver(self):
        done = subprocess.run([sys.executable, "-c", "import eikon, sys; print('numpy' in sys.modules); print(open('/proc/self/maps').read())"],
                              capture_output=True, text=True, check=True)
        self.assertTrue(done.stdout.startswith("False\n"))
        self.assertNotIn("libpocl", done.stdout)

    def test_uses_a_driver_of_pypi_only_where_the_system_has_none(self):
        driver, vendors = self.folder / "lib/libintelocl.so", self.folder / "vendors"
        driver.parent.mkdir()
        vendors.mkdir()
        (self.folder / "lib/libsystem.so").touch()
        environment = {"LD_LIBRARY_PATH": os.fspath(self.folder / "lib"), "PATH": ""}
        with mock.patch.object(_driver, "SYSTEM", vendors), mock.patch.object(sys, "prefix", os.fspath(self.folder)), \
                mock.patch.dict(os.environ, environment, clear=True):
            self.assertIsNone(_driver.choose_driver())  # there is none
            driver.touch()
            self.assertEqual(_driver.choose_driver(), driver)
            (vendors / "removed.icd").write_text("libnosuch.so.1\n")
            self.assertEqual(_driver.choose_driver(), driver)
            (vendors / "system.icd").write_text("libsystem.so\n")
            self.assertIsNone(_driver.choose_driver())
            (vendors / "system.icd").write_text(f"{self.folder}/lib/gone.so\n")
            self.assertEqual(_driver.choose_driver(), driver)
            os.environ["OCL_ICD_VENDORS"] = "mine.icd"
            self.assertIsNone(_driver.choose_driver())

    def test_the_stub_has_what_the_module_has(self):
        stub = (pathlib.Path(eikon.__file__).parent / "_eikon.pyi").read_text()
        for name in dir(eikon._eikon):
            if not name.startswith("_"):
                self.assertRegex(stub, rf"\b{name}\b")


if __name__ == "__main__":
    main()
