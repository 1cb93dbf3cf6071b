#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The package for Python against the program: package_test.py EIKON [unittest arguments]"""
import base64
import json
import os
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
from unittest import mock

import eikon
import numpy as np
from eikon import _driver

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
PROGRAM = pathlib.Path()


class Package(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program(self, *words):
        return subprocess.run([PROGRAM, *map(str, words)], cwd=self.folder, capture_output=True, text=True, check=False)

    def assert_same_picture(self, picture, other):
        self.assertEqual(sorted(picture.layers), sorted(other.layers))
        for layer in picture:
            self.assertEqual(picture[layer].tobytes(), other[layer].tobytes(), layer)


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


class OtherThreads(Package):
    def run_apart(self, code):
        """What a new process prints, whose driver compiles anew and with that sets handlers of signals."""
        begin = """if True:
            import eikon, os, pathlib, re, signal, threading
            scene = os.environ["SCENE"]
            def caught():
                return int(re.search(r"SigCgt:\\s*(\\w+)", pathlib.Path("/proc/self/status").read_text())[1], 16)
            def on_thread(work):
                thread = threading.Thread(target=work)
                thread.start()
                return thread
            """
        done = subprocess.run([sys.executable, "-c", begin + code], capture_output=True, text=True, check=False,
                              env={**os.environ, "SCENE": os.fspath(SCENES / "furnace.gltf"), "POCL_CACHE_DIR": os.fspath(self.folder)})
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_leave_the_handlers_of_signals_as_they_were(self):
        self.assertEqual(self.run_apart("""
            eikon.devices()
            before = caught()
            for thread in [on_thread(lambda: eikon.render(scene, size=(8, 8), spp=4)) for _ in range(2)]:
                thread.join()
            print(caught() == before)
            try:
                os.kill(os.getpid(), signal.SIGINT)
                threading.Event().wait(60)
            except KeyboardInterrupt:
                print("interrupted")
            """), "True\ninterrupted\n")

    def test_keep_a_handler_that_was_set_meanwhile(self):
        self.assertEqual(self.run_apart("""
            begun, may_end = threading.Event(), threading.Event()
            def progress(_):
                begun.set()
                return not may_end.is_set()
            thread = on_thread(lambda: eikon.render(scene, size=(64, 64), spp=1 << 24, progress=progress))
            begun.wait()
            signal.signal(signal.SIGTERM, lambda *_: print("mine"))
            may_end.set()
            thread.join()
            os.kill(os.getpid(), signal.SIGTERM)
            """), "mine\n")


class Exit(Package):
    def test_is_not_held_up_by_a_driver_that_hangs_and_has_its_code(self):
        code = """if True:
            import atexit, eikon, sys
            atexit.register(print, "at exit")
            try:
                eikon.render(sys.argv[1], size=(8, 8), spp=2)
            except eikon.DeviceError as error:
                print("refused")
            sys.exit(9)"""
        done = subprocess.run([sys.executable, "-c", code, SCENES / "furnace.gltf"], capture_output=True, text=True, check=False, timeout=120,
                              env={**os.environ, "EIKON_FAULT": "device:0:hang", "EIKON_WATCHDOG": "1"})
        self.assertEqual((done.returncode, done.stdout, done.stderr), (9, "refused\nat exit\n", ""))


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

    def test_notes_say_what_was_left_out(self):
        scene = eikon.Scene()
        scene.add(scene.mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], material=scene.material(extensions={"NOBODY_knows": {}})))
        picture = eikon.render(scene, size=(8, 8), spp=2)
        self.assertTrue(any("NOBODY_knows" in note for note in picture.notes), picture.notes)


def arrays_of(document, accessor):
    """The values of an accessor of a .gltf file whose buffers are in it."""
    accessor = document["accessors"][accessor]
    view = document["bufferViews"][accessor["bufferView"]]
    data = base64.b64decode(document["buffers"][view["buffer"]]["uri"].split(",")[1])
    kind = {5126: "<f4", 5125: "<u4", 5123: "<u2", 5121: "u1"}[accessor["componentType"]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return np.frombuffer(data, kind, accessor["count"] * width, begin).reshape(accessor["count"], width)


class Scenes(Package):
    def rebuilt(self, name):
        """A shipped scene, made of arrays."""
        document = json.loads((SCENES / name).read_text())
        scene = eikon.Scene()
        materials = [scene.material(**fields) for fields in document["materials"]]
        meshes = []
        for mesh in document["meshes"]:
            (primitive,) = mesh["primitives"]
            attributes = primitive["attributes"]
            optional = {"normals": "NORMAL", "texcoords": "TEXCOORD_0"}
            more = {key: arrays_of(document, attributes[a]) for key, a in optional.items() if a in attributes}
            meshes.append(scene.mesh(arrays_of(document, attributes["POSITION"]), arrays_of(document, primitive["indices"]),
                                     material=materials[primitive["material"]], **more))
        for node in document["nodes"]:
            fields = {k: v for k, v in node.items() if k not in ("mesh", "camera")}
            if "camera" in node:
                camera = document["cameras"][node["camera"]]["perspective"]
                self.assertNotIn("matrix", fields)
                matrix = np.eye(4)
                x, y, z, w = fields.get("rotation", (0, 0, 0, 1))
                matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                                  [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                                  [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
                matrix[:3, 3] = fields.get("translation", (0, 0, 0))
                scene.camera(fov=np.degrees(camera["yfov"]), aspect=camera.get("aspectRatio"), matrix=matrix)
            else:
                scene.add(meshes[node["mesh"]] if "mesh" in node else None, **fields)
        return scene

    def test_of_arrays_has_the_bits_of_the_same_scene_as_a_file(self):
        scene = self.rebuilt("cornell.gltf")
        view = {"look_at": ((0.278, 0.273, 1.0), (0.278, 0.273, 0.0)), "fov": 40, "size": (24, 24), "spp": 8, "aov": ["normal"]}
        built, file = eikon.render(scene, **view), eikon.render(SCENES / "cornell.gltf", **view)
        self.assertGreater(file.rgb.mean(), 0.01)
        self.assert_same_picture(built, file)
        scene.save(self.folder / "cornell.glb")
        self.assert_same_picture(built, eikon.render((self.folder / "cornell.glb").read_bytes(), **view))
        self.assert_same_picture(built, eikon.render((SCENES / "cornell.gltf").read_bytes(), **view))

    def test_shows_images_from_arrays_bytes_and_files(self):
        pixels = np.zeros((2, 2, 3), np.uint8)
        pixels[0, 1] = 255
        file = self.folder / "pixels.png"
        file.write_bytes(eikon._scene.png_of(pixels))
        pictures = []
        for image in (pixels, file.read_bytes(), file, {"image": pixels, "texCoord": 0, "magFilter": 9728}):
            scene = eikon.Scene()
            unlit = scene.material(pbrMetallicRoughness={"baseColorTexture": image}, extensions={"KHR_materials_unlit": {}})
            square = scene.mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [0, 1, 2, 0, 2, 3], material=unlit,
                                texcoords=[[0, 1], [1, 1], [1, 0], [0, 0]])
            scene.add(square)
            scene.camera(height=2, aspect=1, matrix=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]])
            pictures.append(eikon.render(scene, size=(8, 8), spp=2).rgb)
        for other in pictures[1:3]:
            np.testing.assert_array_equal(pictures[0], other)
        nearest = pictures[3]
        np.testing.assert_allclose(nearest[:4, 4:], 1)  # the white pixel is at the top right
        np.testing.assert_allclose(nearest[4:], 0)
        np.testing.assert_allclose(nearest[:, :4], 0)

    def test_places_a_mesh_by_matrix_translation_and_light(self):
        def render(**place):
            scene = eikon.Scene()
            triangle = scene.mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], colors=np.eye(3),
                                  material=scene.material(pbrMetallicRoughness={"metallicFactor": 0}))
            scene.add(triangle, **place)
            scene.add(triangle, translation=(-1.5, 0, 0))
            scene.light("spot", intensity=100, outerConeAngle=0.6, matrix=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]])
            return eikon.render(scene, look_at=((0, 0, 4), (0, 0, 0)), size=(16, 16), spp=4, aov=["id"])

        by_matrix = render(matrix=[[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        self.assert_same_picture(by_matrix, render(translation=(0.5, 0, 0)))
        self.assertEqual(len(np.unique(by_matrix["id"])), 3)
        self.assertGreater(by_matrix.rgb.max(), 0.1)

    def test_refuses_arrays_of_another_shape(self):
        scene = eikon.Scene()
        corners = np.zeros((3, 3))
        for arguments in ({"positions": np.zeros((3, 2))}, {"positions": corners, "normals": np.zeros((2, 3))},
                          {"positions": corners, "indices": [0.0, 1.0, 2.0]}, {"positions": corners, "indices": [0, 1]},
                          {"positions": corners, "indices": [0, 1, -1]}, {"positions": corners, "indices": [0, 1, 2 ** 32 + 2]},
                          {"positions": corners, "texcoords": corners}):
            with self.assertRaises(eikon.UsageError):
                scene.mesh(**arguments)
        with self.assertRaises(eikon.UsageError):
            scene.add(0, matrix=np.eye(3))
        with self.assertRaises(eikon.UsageError):
            scene.material(pbrMetallicRoughness={"baseColorTexture": np.zeros((2, 2, 3))})
        with self.assertRaises(eikon.UsageError):
            scene.camera()
        scene.add(scene.mesh(corners, [0, 1, 7]))  # what the reader refuses in a file
        with self.assertRaises(eikon.InputError):
            eikon.render(scene)


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
    PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
