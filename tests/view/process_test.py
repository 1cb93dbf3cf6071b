#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The process of `eikon view`: how it begins and ends, which scenes it shows, and the bits of its pictures.

  tests/view/process_test.py EIKON [unittest arguments]

A build with EIKON_SANITIZE=address,undefined passes, too, with ASAN_OPTIONS=use_sigaltstack=0: LLVM in PoCL sets signal stacks."""
import base64
import json
import pathlib
import random
import re
import shlex
import signal
import socket
import stat
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from viewer import CORNELL, LIMIT_S, ROOT, SMALL, StandInBrowser, Viewer, floats_of_exr, rgbe_of, run_side_by_side

EIKON = ""


class Process(unittest.TestCase):
    """One server for each test."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="eikon_view_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def eikon(self, *words):
        return subprocess.run([EIKON, *map(str, words)], cwd=self.folder, capture_output=True, text=True, check=False, timeout=LIMIT_S)

    def assert_refused(self, run, code, *parts):
        self.assertEqual((run.returncode, run.stdout, run.stderr.count("\n")), (code, "", 1), run)
        for part in parts:
            self.assertIn(part, run.stderr)

    def test_a_port_that_is_taken_is_one_line(self):
        with Viewer(EIKON, self.folder, CORNELL, *SMALL) as viewer:
            self.assert_refused(self.eikon("view", CORNELL, "--port", viewer.port), 3, f"--port {viewer.port}: ", "another program")
        with Viewer(EIKON, self.folder, CORNELL, *SMALL, "--port", str(viewer.port)) as again:
            self.assertEqual(again.port, viewer.port)
            self.assertNotEqual(again.token, viewer.token)

    def test_wrong_flags_and_missing_scenes_are_one_line(self):
        self.assert_refused(self.eikon("view", "nothing.gltf"), 3, "nothing.gltf: ")
        self.assert_refused(self.eikon("view", CORNELL, "--port", "0"), 2, "--port")
        self.assert_refused(self.eikon("view", CORNELL, "--fov", "wide"), 2, "--fov")
        self.assert_refused(self.eikon("view"), 2, "SCENE")

    def test_signals_end_it_whatever_it_does(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            for size in ("64x48", "2048x2048"):
                with Viewer(EIKON, self.folder, CORNELL, "--size", size, "--spp", "100000") as viewer:
                    viewer.wait_for("rendering")
                    idle = [socket.create_connection(("127.0.0.1", viewer.port)) for _ in range(50)]
                    self.assertEqual(viewer.end(number), (0, "", ""))
                    for one in idle:
                        one.close()
        with Viewer(EIKON, self.folder, CORNELL, *SMALL) as viewer:  # before anything is loaded
            self.assertEqual(viewer.end(), (0, "", ""))

    def undisturbed(self, attempt, most_s, what):
        """Repeats an attempt, which returns seconds, until one took at most so long: others may keep the processors busy."""
        took = []
        while len(took) < 5:
            took.append(attempt())
            if took[-1] <= most_s:
                return
        self.fail(f"{what} took {took} s")

    def busy_viewer(self):
        """One that is busy for long: its small file stands for two million triangles that lie across each other."""
        points, count, parts = random.Random(27), 50000, 40
        data = b"".join(struct.pack("<3f", points.random(), points.random(), points.random()) for _ in range(count))
        scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                 "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
                 "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
                 "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": count, "min": [0, 0, 0], "max": [1, 1, 1]}],
                 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}] * parts}]}
        (self.folder / "strips.gltf").write_text(json.dumps(scene))
        viewer = Viewer(EIKON, self.folder, "strips.gltf", *SMALL)
        self.wait_until_building(viewer)
        return viewer

    def wait_until_building(self, viewer):
        begin = time.monotonic()
        while viewer.news()[0]["status"]["state"] != "building":
            self.assertLess(time.monotonic() - begin, LIMIT_S)

    def test_a_signal_ends_it_within_a_second_while_it_builds_a_tree(self):
        def attempt():
            with self.busy_viewer() as viewer:
                begin = time.monotonic()
                self.assertEqual(viewer.end(signal.SIGTERM), (0, "", ""))
                return time.monotonic() - begin
        self.undisturbed(attempt, 1, "the end")

    def test_a_signal_ends_it_within_a_second_while_it_compiles(self):
        def attempt():
            with tempfile.TemporaryDirectory(dir=self.folder) as cache, \
                    Viewer(EIKON, self.folder, ROOT / "scenes/cornell_spheres.gltf", *SMALL, variables={"POCL_CACHE_DIR": cache}) as viewer:
                viewer.wait_for("compiling")
                begin = time.monotonic()
                self.assertEqual(viewer.end(), (0, "", ""))
                return time.monotonic() - begin
        self.undisturbed(attempt, 1, "the end")

    def test_another_scene_is_opened_while_a_large_one_is_prepared(self):
        def attempt():
            with self.busy_viewer() as viewer:
                begin = time.monotonic()
                self.assertEqual(viewer.ask("POST", "/api/drop?name=paper.gltf", (ROOT / "scenes/paper.gltf").read_bytes())[0], 200)
                while (news := viewer.news()[0])["status"]["state"] == "building" or not news["status"]["scene"]:
                    self.assertLess(time.monotonic() - begin, LIMIT_S)
                self.assertEqual(news["status"]["scene"]["name"], "paper.gltf")
                took = time.monotonic() - begin
                # What nobody wants any more does not come back once it is loaded, and what is there
                # can be turned.
                viewer.wait_for("done")
                viewer.wait_until_idle()
                self.assertEqual(viewer.news()[0]["status"]["scene"]["name"], "paper.gltf")
                news, _ = viewer.wait_for("done", viewer.look({"--spp": "8", "--fov": "30"}))
                self.assertEqual(news["status"]["scene"]["name"], "paper.gltf")
                for number in range(12):  # and threads that load for nobody are few
                    status, _, answer = viewer.ask("POST", "/api/drop?name=strips.gltf", (self.folder / "strips.gltf").read_bytes())
                    if status != 200:
                        break
                    self.wait_until_building(viewer)
                self.assertEqual((status, b"try again" in answer), (400, True), number)
                self.assertEqual(viewer.end(), (0, "", ""))
                return took
        self.undisturbed(attempt, 1.5, "opening the other scene")

    def test_no_denoiser_is_said_and_the_picture_is_shown_all_the_same(self):
        with Viewer(EIKON, self.folder, CORNELL, *SMALL, variables={"EIKON_OIDN": "/nowhere/libOpenImageDenoise.so.2"}) as viewer:
            line = self.eikon("render", CORNELL, "-o", "x.exr", "--denoise", "--quiet")
            news, _ = viewer.wait_for("done", viewer.look({"--spp": "8"}, layer="denoised"))
            self.assertIn("/nowhere/libOpenImageDenoise.so.2", news["status"]["denoiser"])
            self.assertTrue(news["status"]["denoiser"].startswith("--denoise: cannot load"), line)
            self.assertEqual(news["frame"]["about"]["layer"], "picture")

    def test_open_without_a_program_for_it_is_one_line_and_the_view_goes_on(self):
        with Viewer(EIKON, self.folder, CORNELL, *SMALL, "--open", variables={"PATH": "/nowhere"}) as viewer:
            viewer.wait_for("done")
            code, out, err = viewer.end()
            self.assertEqual((code, out, err.count("\n")), (0, "", 1))
            self.assertIn("open the address yourself", err)

    def test_open_starts_a_browser_with_a_file_that_only_its_user_can_read(self):
        browser = StandInBrowser(self.folder)
        with Viewer(EIKON, self.folder, CORNELL, *SMALL, "--open", variables=browser.variables) as viewer:
            (word,) = browser.words()
            self.assertNotIn(viewer.token, word)
            page = pathlib.Path(word)
            self.assertEqual([stat.S_IMODE(part.stat().st_mode) for part in (page, page.parent)], [0o600, 0o700])
            self.assertIn(f"url={viewer.address}\"", page.read_text())
            self.assertEqual(viewer.end(), (0, "", ""))
            self.assertFalse(page.parent.exists())

    def test_a_broken_scene_shows_the_line_of_render_until_it_is_repaired(self):
        scene = self.folder / "scene.gltf"
        whole = CORNELL.read_text()
        for broken in (whole[:400], "{}", whole.replace('"2.0"', '"1.0"')):
            scene.write_text(broken)
            line = self.eikon("render", "scene.gltf", "-o", "x.exr", "--quiet").stderr
            self.assertTrue(line.startswith("eikon: "), line)
            with Viewer(EIKON, self.folder, "scene.gltf", *SMALL) as viewer:
                try:
                    viewer.wait_for("done")
                    self.fail("a broken scene was rendered")
                except AssertionError as error:
                    self.assertEqual(f"eikon: {error}\n", line)
                scene.write_text(whole)
                begin = time.monotonic()
                while viewer.news()[0]["status"]["state"] != "done" and time.monotonic() - begin < LIMIT_S:
                    time.sleep(0.1)
                self.assertEqual(viewer.news()[0]["status"]["error"], "")
                self.assertEqual(viewer.news()[0]["frame"]["about"]["samples"], 8)

    def test_a_scene_that_changes_is_shown_anew(self):
        scene = self.folder / "scene.gltf"
        scene.write_text(CORNELL.read_text())
        with Viewer(EIKON, self.folder, "scene.gltf", *SMALL) as viewer:
            first, pixels = viewer.wait_for("done")
            changed = json.loads(scene.read_text())
            for material in changed["materials"]:
                material.get("pbrMetallicRoughness", {})["baseColorFactor"] = [0.1, 0.2, 0.9, 1]
            scene.write_text(json.dumps(changed))
            begin = time.monotonic()
            news, now = first, pixels
            while (now == pixels or news["status"]["state"] != "done") and time.monotonic() - begin < LIMIT_S:
                news, now = viewer.news()
                time.sleep(0.1)
            self.assertNotEqual(now, pixels)

    def test_a_given_environment_is_shown_anew_when_its_file_changes(self):
        scene, sky = self.folder / "scene.gltf", self.folder / "sky.hdr"
        scene.write_text((ROOT / "scenes/sphere_in_sky.gltf").read_text())

        def paint(*rgbe):
            sky.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + bytes(rgbe) * 8)

        def wait_for_change(viewer, before):
            begin = time.monotonic()
            while time.monotonic() - begin < 20:
                news, pixels = viewer.news()
                if news["status"]["state"] == "done" and pixels != before:
                    return pixels
                time.sleep(0.1)
            raise AssertionError("the picture stays as it was")

        paint(128, 10, 10, 129)
        with Viewer(EIKON, self.folder, "scene.gltf", *SMALL, "--env", "sky.hdr") as viewer:
            _, given = viewer.wait_for("done")
            _, neutral = viewer.wait_for("done", viewer.look({"--spp": "8", "--env": "neutral"}))
            changed = json.loads(scene.read_text())
            changed["materials"] = [{"emissiveFactor": [1, 1, 1]} for _ in changed["materials"]]
            scene.write_text(json.dumps(changed))
            wait_for_change(viewer, neutral)  # loaded again under another environment than the given one
            _, again = viewer.wait_for("done", viewer.look({"--spp": "8"}))
            self.assertNotIn(again, (given, neutral))
            paint(10, 128, 10, 129)
            wait_for_change(viewer, again)
            self.assertEqual(viewer.end(), (0, "", ""))

    def test_a_dropped_scene_is_shown_and_leaves_nothing(self):
        (self.folder / "tmp").mkdir()
        with Viewer(EIKON, self.folder, CORNELL, *SMALL, "--camera", "camera", "--fov", "20",
                    variables={"TMPDIR": str(self.folder / "tmp")}) as viewer:
            _, before = viewer.wait_for("done")
            for number, name in enumerate(("paper.gltf", "sphere_in_sky.gltf")):
                body = (ROOT / "scenes" / name).read_bytes()
                self.assertEqual(viewer.ask("POST", f"/api/drop?name={name}", body)[0], 200)
                news, pixels = viewer.wait_for("done", number + 2)
                self.assertEqual(news["status"]["scene"]["name"], name)
                self.assertNotIn("--camera", news["status"]["command"])
                self.assertIn("dropped", news["status"]["notes"][0])
                self.assertNotEqual(pixels, before)
                self.assertEqual([file.name for file in (self.folder / "tmp").glob("eikon_view_*/*/*")], [name])
            for name in ("", "x.exr", "..gltf", "../x.gltf", "%2Ftmp%2Fx.gltf", "-o.gltf", "a%0Ab.gltf", "a" * 200 + ".gltf"):
                status, _, answer = viewer.ask("POST", f"/api/drop?name={name}", b"{}")
                self.assertEqual((status, b"view: " in answer), (400, True), name)
            self.assertEqual(viewer.ask("POST", "/api/drop?name=x.glb", b"", {"X-Eikon-Token": "0" * 32})[0], 403)
            with socket.create_connection(("127.0.0.1", viewer.port), timeout=LIMIT_S) as connection:
                connection.sendall(f"POST /api/drop?name=x.glb HTTP/1.1\r\nHost: localhost\r\nX-Eikon-Token: {viewer.token}\r\n"
                                   f"Content-Length: {1 << 40}\r\n\r\n".encode())
                self.assertIn(b" 400 ", connection.recv(100))
            viewer.ask("POST", "/api/drop?name=broken.gltf", b"{")
            begin = time.monotonic()
            while viewer.news()[0]["status"]["state"] != "failed" and time.monotonic() - begin < LIMIT_S:
                time.sleep(0.05)
            self.assertIn("broken.gltf", viewer.news()[0]["status"]["error"])
            self.assertEqual(viewer.end(), (0, "", ""))
        self.assertEqual(list((self.folder / "tmp").glob("eikon_view_*")), [])

    def test_memory_stays_flat_while_somebody_orbits(self):
        with Viewer(EIKON, self.folder, ROOT / "scenes/cornell_spheres.gltf", "--size", "320x240") as viewer:
            def orbit(steps):
                for step in range(steps):
                    eye = f"{0.278 + 0.001 * (step % 100)},0.273,-0.8"
                    viewer.look({"--size": "320x240", "--look-at": f"{eye}:0.278,0.273,0.28"}, moving=step % 10 != 0)
                    viewer.news()
                return int(re.search(r"VmRSS:\s+(\d+) kB", pathlib.Path(f"/proc/{viewer.process.pid}/status").read_text())[1])
            viewer.wait_for("rendering")
            first = orbit(200)
            self.assertLess(orbit(600), first + 16000, "kB")

    def test_the_settled_picture_has_the_bits_of_the_printed_command(self):
        looks = ({"--size": "160x120"}, {"--look-at": "0.1,0.4,-0.6:0.3,0.25,0.3", "--fov": "55", "--f-number": "1.4", "--focus-distance": "0.9"},
                 {"--env": "neutral", "--env-rotate": "40", "--env-scale": "0.5", "--size": "50x31"})
        scenes = ROOT / "scenes"
        for scene, words in ((CORNELL, ()), (scenes / "cornell_spheres.gltf", ("--light-paths", "auto", "--spp", "2")),
                             (scenes / "shelf_lamp_room.gltf", ("--guiding", "on", "--spp", "6"))):
            with Viewer(EIKON, self.folder, scene, "--size", "64x48", *(words or ("--spp", "6"))) as viewer:
                for flags, layer in zip(looks, ("picture", "albedo", "picture")):
                    viewer.wait_for("done", viewer.look(flags, layer=layer))
                    news, pixels = viewer.wait_for("done", viewer.look(flags, layer="picture"))
                    command = shlex.split(news["status"]["command"])
                    self.assertEqual(command[:2], ["eikon", "render"])
                    run = self.eikon(*command[1:], "--quiet")
                    self.assertEqual(run.returncode, 0, run.stderr)
                    shown = rgbe_of(floats_of_exr(self.folder / "picture.exr"))
                    self.assertEqual(shown, pixels, news["status"]["command"])
                self.assertNotEqual(shown[:400], pixels[400:800], "the comparison sees nothing")

    def test_a_shutter_blurs_the_picture_as_that_of_the_printed_command(self):
        blurred = ("--shutter", "2", "--shutter-at", "centre", "--motion-steps", "3")
        pictures = []
        for words in ((), blurred):
            with Viewer(EIKON, self.folder, ROOT / "scenes/spinning_wheel.gltf", *SMALL, "--frame", "12", *words) as viewer:
                news, pixels = viewer.wait_for("done")
                later, _ = viewer.wait_for("done", viewer.look({"--spp": "8", "--scene-time": "0.7"}))
                news, pixels = viewer.wait_for("done", viewer.look({"--spp": "8", "--scene-time": "0.5"}))
                command = shlex.split(news["status"]["command"])
                self.assertEqual("--shutter=2" in command, bool(words), later["status"]["command"])
                run = self.eikon(*command[1:], "--quiet")
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(rgbe_of(floats_of_exr(self.folder / "picture.exr")), pixels)
                pictures.append(pixels)
        self.assertNotEqual(*pictures)

    def test_help_states_one_size(self):
        text = self.eikon("view", "--help").stdout
        size = next(line for line in text.splitlines() if line.split()[:1] == ["--size"])
        self.assertTrue(size.endswith("[640x480]"), size)
        self.assertEqual(text.count("640x480"), 1)
        with Viewer(EIKON, self.folder, CORNELL, "--spp", "1") as viewer:
            news, _ = viewer.wait_for("done")
            self.assertIn("--size=640x480", shlex.split(news["status"]["command"]))

    def test_a_final_render_writes_the_picture_of_the_command(self):
        with Viewer(EIKON, self.folder, CORNELL, *SMALL) as viewer:
            viewer.look({"--spp": "8", "--exposure": "1.5", "--tonemap": "agx"})
            news, _ = viewer.wait_for("done")
            self.assertEqual(self.eikon(*shlex.split(news["status"]["command"])[1:], "--quiet").returncode, 0)
            for name in ("cornell-view-1", "cornell-view-2"):  # no file is replaced
                self.assertEqual(viewer.ask("POST", "/api/render", b"{}")[0], 200)
                begin = time.monotonic()
                while (final := viewer.news()[0]["final"])["state"] == "running" and time.monotonic() - begin < LIMIT_S:
                    time.sleep(0.05)
                self.assertEqual((final["state"], final["image"], final["png"]), ("done", name + ".exr", name + ".png"))
                compared = self.eikon("compare", name + ".exr", "picture.exr", "--fail-above", "0")
                self.assertEqual(compared.returncode, 0, compared.stdout)
                self.assertEqual((self.folder / (name + ".png")).read_bytes(), (self.folder / "picture.png").read_bytes())

    def test_a_final_render_can_be_stopped_and_ends_with_the_view(self):
        with Viewer(EIKON, self.folder, CORNELL, "--size", "64x48", "--spp", "100000000") as viewer:
            viewer.wait_for("rendering")
            viewer.ask("POST", "/api/render", b"{}")
            self.assertEqual(viewer.ask("POST", "/api/render", b"{}")[0], 400)  # one at a time
            viewer.ask("POST", "/api/stop", b"{}")
            begin = time.monotonic()
            while (final := viewer.news()[0]["final"])["state"] == "running" and time.monotonic() - begin < LIMIT_S:
                time.sleep(0.05)
            self.assertEqual(final["state"], "stopped")
            viewer.ask("POST", "/api/render", b"{}")
            self.assertEqual(viewer.news()[0]["final"]["state"], "running")
            self.assertEqual(viewer.end(), (0, "", ""))


if __name__ == "__main__":
    EIKON = str(pathlib.Path(sys.argv.pop(1)).resolve())
    run_side_by_side()
