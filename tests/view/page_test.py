#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of `eikon view` in headless Chromium.

  tests/view/page_test.py EIKON [unittest arguments]

browser.py says what it needs."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from browser import ActionChains, BrowserTests, By, Keys
from viewer import CORNELL, LIMIT_S, ROOT, StandInBrowser, Viewer

EIKON = ""
SMALL = ("--size", "320x240", "--spp", "16")


class Page(BrowserTests, unittest.TestCase):
    limit_s = LIMIT_S

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="eikon_page_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.open_browser()

    def view(self, scene, *words, variables=None):
        viewer = Viewer(EIKON, self.folder, scene, *words, variables=variables)
        self.addCleanup(viewer.__exit__)
        self.browser.get(viewer.address)
        return viewer

    def state(self, name):
        return self.run_script("return document.body.dataset[arguments[0]]", name)

    def problem(self):
        return self.run_script("return problem.hidden ? '' : problem.textContent")

    def situation(self):
        return f"{self.state('state')}, {self.problem()!r}"

    def until_done(self):
        is_done = "return status.state === 'done' && status.state_of === adoptedLook && !frame.small && !sending && !restTimer"
        self.until(lambda: self.run_script(is_done), "done")

    def set(self, control, value):
        """Moves a control as its user would, and tells the page."""
        self.run_script("controls[arguments[0]].value = arguments[1];"
                        "for (const kind of ['input', 'change']) controls[arguments[0]].dispatchEvent(new Event(kind));", control, value)

    def canvas(self):
        return self.browser.find_element(By.ID, "canvas")

    def pixels(self):
        """What the canvas shows."""
        return self.run_script("return canvas.toDataURL()")

    def command(self):
        return self.run_script("return controls.command.value")

    def drag(self, across, along):
        actions = ActionChains(self.browser).click_and_hold(self.canvas())
        for _ in range(5):
            actions.move_by_offset(across, along)
        actions.release().perform()

    def no_complaint(self):
        self.assertEqual(self.problem(), "")
        self.assertEqual(self.errors(), [])


class Use(Page):
    def test_it_loads_refines_and_turns_by_mouse_and_keys(self):
        self.view(CORNELL, *SMALL)
        self.until_done()
        self.shot("loaded")
        self.assertEqual(self.state("samples"), "16")
        self.assertIn("cornell.gltf", self.browser.title)
        shown, eye = self.pixels(), self.run_script("return scene.view.eye")
        self.drag(12, 5)
        self.until(lambda: self.run_script("return scene.view.eye") != eye, "turned")
        self.until_done()
        self.assertNotEqual(self.pixels(), shown)
        self.assertIn("--look-at=", self.command())
        self.shot("turned")
        for key in (Keys.ARROW_LEFT, Keys.ARROW_UP, "w", "q", "+", "-", Keys.SHIFT + "d"):
            before = self.command()
            self.canvas().send_keys(key)
            self.until(lambda: self.command() != before, f"moved by {key!r}")
        self.canvas().send_keys(Keys.HOME)
        self.until(lambda: "--look-at" not in self.command(), "as it was")
        self.until_done()
        self.assertEqual(self.pixels(), shown)  # the same bits again
        self.no_complaint()

    def test_open_leads_a_browser_to_the_page(self):
        stand_in = StandInBrowser(self.folder)
        viewer = Viewer(EIKON, self.folder, CORNELL, *SMALL, "--open", variables=stand_in.variables)
        self.addCleanup(viewer.__exit__)
        self.browser.get(pathlib.Path(*stand_in.words()).as_uri())
        self.until(lambda: self.browser.current_url == viewer.address, "at the page")
        self.until_done()
        self.browser.refresh()
        self.until_done()
        self.no_complaint()

    def test_a_look_survives_reload_and_comes_to_another_tab(self):
        viewer = self.view(CORNELL, *SMALL)
        self.until_done()
        self.drag(-15, 4)
        self.set("exposure", 1.5)
        self.set("tone", "agx")
        self.set("layer", "albedo")
        self.until(lambda: "--tonemap=agx" in self.command() and self.run_script("return frame.layer") == "albedo", "albedo")
        self.until_done()
        kept = self.run_script("return [look, controls.exposure.value, controls.tone.value]"), self.pixels()
        self.browser.refresh()
        self.until_done()
        self.assertEqual((self.run_script("return [look, controls.exposure.value, controls.tone.value]"), self.pixels()), kept)
        first = self.browser.current_window_handle
        self.browser.switch_to.new_window("tab")
        self.browser.get(viewer.address)
        self.until_done()
        self.assertEqual(self.pixels(), kept[1])
        self.set("layer", "picture")
        self.drag(10, 0)
        self.until_done()
        moved = self.run_script("return look.flags['--look-at']")
        self.browser.switch_to.window(first)
        self.until(lambda: self.run_script("return look.flags['--look-at']") == moved, "as in the other tab")
        self.until_done()
        self.drag(3, 3)  # goes on from there
        self.until_done()
        self.assertNotIn(moved, self.command())
        self.no_complaint()

    def test_every_control_changes_the_picture_or_the_command(self):
        self.view(CORNELL, *SMALL)
        self.until_done()
        for control, value, flag in (("fov", 70, "--fov=70"), ("lens", 1, "--f-number=2"), ("env", "neutral", "--env=neutral"),
                                     ("rotate", 90, "--env-rotate=90"), ("envScale", 1, "--env-scale=2"),
                                     ("size", "480x360", "--size=480x360"), ("exposure", 2, "--exposure=2"),
                                     ("tone", "aces", "--tonemap=aces")):
            before = self.pixels()
            self.set(control, value)
            self.until(lambda: flag in self.command(), flag)
            self.until_done()
            self.assertNotEqual(self.pixels(), before, control)
            self.assertEqual(self.problem(), "")
        for layer in ("error", "albedo", "normal", "depth", "picture"):
            before = self.pixels()
            self.set("layer", layer)
            self.until(lambda: self.run_script("return frame.layer") == layer, layer)
            self.until_done()
            self.assertNotEqual(self.pixels(), before, layer)
            self.assertEqual(self.run_script("return document.getElementById('legend').hidden"), layer not in ("error", "depth"))
            self.shot(layer)
        self.no_complaint()

    def test_variants_times_cameras_and_light_groups_are_offered_where_a_scene_has_them(self):
        self.view(CORNELL, *SMALL)
        self.until_done()
        for control in ("variant", "time"):
            self.assertTrue(self.run_script("return controls[arguments[0]].parentElement.hidden", control))
        self.assertNotIn("lights", self.run_script("return [...controls.layer.options].map((o) => o.value)"))
        scene = json.loads((ROOT / "scenes/bending_arm.gltf").read_text())
        for number, node in enumerate(scene["nodes"]):
            node.setdefault("extras", {})["lightGroup"] = f"group-{number % 2}"
        (self.folder / "arm.gltf").write_text(json.dumps(scene))
        self.view("arm.gltf", *SMALL)
        self.until_done()
        self.set("time", 0.5)
        self.until(lambda: "--scene-time=0.5" in self.command(), "another time")
        self.until_done()
        self.set("layer", "lights")
        self.until(lambda: self.run_script("return frame.layer") == "lights", "mixed")
        self.until_done()
        self.shot("lights")
        bright = self.pixels()
        for number in range(self.run_script("return scene.lights.length")):
            self.set(f"light{number}", 0)
        self.until(lambda: self.pixels() != bright, "darker")
        self.until(lambda: self.run_script("return linear.every((value) => value === 0)"), "dark")
        self.no_complaint()

    def test_a_click_traces_a_path_and_another_focuses(self):
        self.view(CORNELL, *SMALL)
        self.until_done()
        self.browser.find_element(By.CSS_SELECTOR, "[data-tool=path]").click()
        ActionChains(self.browser).move_to_element_with_offset(self.canvas(), 40, 120).click().perform()
        words = lambda: self.run_script("return controls.path.innerText")
        self.until(lambda: "radiance" in words(), "traced")
        hits = [line for line in words().splitlines() if " m, to (" in line]
        self.assertEqual(self.run_script("return overlay.querySelectorAll('circle').length"), len(hits))
        self.shot("path")
        # The first vertex lies where the click was.
        middle = "const box = arguments[0].getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]"
        dot = self.run_script(middle, self.browser.find_element(By.CSS_SELECTOR, "#overlay circle"))
        canvas = self.run_script(middle, self.canvas())
        self.assertAlmostEqual(dot[0], canvas[0] + 40, delta=4)
        self.assertAlmostEqual(dot[1], canvas[1] + 120, delta=4)
        self.canvas().send_keys(Keys.ESCAPE)
        self.assertEqual(words(), "")
        self.browser.find_element(By.CSS_SELECTOR, "[data-tool=focus]").click()
        self.canvas().send_keys(Keys.ENTER)
        self.until(lambda: "--focus-distance=" in self.command() and "--f-number=2.8" in self.command(), "focused")
        self.until_done()
        self.no_complaint()

    def test_render_to_a_file_writes_it_and_says_so(self):
        self.view(CORNELL, *SMALL)
        self.until_done()
        self.run_script("controls.start.click()")
        self.until(lambda: "written: cornell-view-1.exr" in self.run_script("return controls.finalState.textContent"), "written")
        self.assertTrue((self.folder / "cornell-view-1.exr").exists() and (self.folder / "cornell-view-1.png").exists())
        self.shot("written")
        self.no_complaint()

    def test_another_scene_file_is_opened(self):
        self.view(CORNELL, *SMALL)
        self.until_done()
        self.set("fov", 30)
        self.until_done()
        self.browser.find_element(By.ID, "file").send_keys(str(ROOT / "scenes/sphere_in_sky.gltf"))
        self.until(lambda: "sphere_in_sky.gltf" in self.browser.title, "another title")
        self.until_done()
        self.assertNotIn("--fov", self.command())
        self.drag(9, 9)
        self.until_done()
        self.shot("opened")
        self.no_complaint()

    def test_a_file_that_is_dropped_on_the_page_is_opened(self):
        self.view(CORNELL, *SMALL)
        self.until_done()
        self.run_script("""const carried = new DataTransfer();
          carried.items.add(new File([arguments[0]], "dropped.gltf"));
          canvas.dispatchEvent(new DragEvent("drop", { dataTransfer: carried, bubbles: true, cancelable: true }));""",
                        (ROOT / "scenes/paper.gltf").read_text())
        self.until(lambda: "dropped.gltf" in self.browser.title, "another title")
        self.until_done()
        self.no_complaint()
        self.run_script("openFile(new File(['x'], 'picture.jpg'))")
        self.until(lambda: "a dropped file is a .gltf or .glb" in self.problem(), "refused")

    def test_the_denoised_layer_is_offered_where_the_library_is(self):
        option = "const one = [...controls.layer.options].find((o) => o.value === 'denoised'); return [one.disabled, one.textContent]"
        self.view(CORNELL, *SMALL, variables={"EIKON_OIDN": "/nowhere/libOpenImageDenoise.so.2"})
        self.until_done()
        self.assertEqual(self.run_script(option), [True, "picture, denoised (not available)"])
        self.assertIn("/nowhere/libOpenImageDenoise.so.2", self.run_script("return controls.denoiser.textContent"))
        self.shot("no_denoiser")
        if not os.path.exists(os.environ.get("EIKON_OIDN", "")):
            return
        self.view(CORNELL, *SMALL)
        self.until_done()
        self.assertEqual(self.run_script(option), [False, "picture, denoised"])
        self.assertTrue(self.run_script("return controls.denoiser.hidden"))
        before = self.pixels()
        self.set("layer", "denoised")
        self.until(lambda: self.run_script("return frame.layer === 'denoised' && frame.samples === 16"), "denoised")
        self.assertNotEqual(self.pixels(), before)
        self.shot("denoised")
        self.set("exposure", 1)
        self.until(lambda: "--exposure=1" in self.command(), "brighter")
        self.no_complaint()

    def test_the_page_says_what_takes_long_to_eyes_and_ears(self):
        cache = self.folder / "cache"
        cache.mkdir()
        self.view(CORNELL, *SMALL, variables={"POCL_CACHE_DIR": str(cache)})
        shown = "const one = document.getElementById('waiting'); return one.hidden ? '' : one.textContent"
        self.until(lambda: "compiling for the devices" in self.run_script(shown), "said")
        self.assertEqual(self.run_script("return document.getElementById('spoken').textContent"), "compiling for the devices")
        self.shot("compiling")
        self.until_done()
        self.assertEqual(self.run_script(shown), "")
        self.assertEqual(self.run_script("return document.getElementById('spoken').textContent"), "done")
        self.no_complaint()

    def test_everything_that_takes_input_has_a_label_and_is_reached_by_tab(self):
        self.view(CORNELL, *SMALL)
        self.until_done()
        unnamed = self.run_script("""return [...document.querySelectorAll('input, select, textarea, button, progress, [role=application]')].filter((one) =>
          !one.labels?.length && !one.getAttribute('aria-label') && !one.textContent.trim()).map((one) => one.outerHTML)""")
        self.assertEqual(unnamed, [])
        seen = []
        for _ in range(40):
            ActionChains(self.browser).send_keys(Keys.TAB).perform()
            seen.append(self.run_script("const one = document.activeElement; return one.id || one.textContent"))
        for name in ("canvas", "Orbit", "Trace path", "camera", "fov", "layer", "exposure", "size", "file", "env", "command",
                     "Render to a file", "Copy"):
            self.assertIn(name, seen)


class Trouble(Page):
    def test_a_server_that_is_killed_is_said_and_another_one_is_not_taken_for_it(self):
        viewer = self.view(CORNELL, *SMALL)
        self.until_done()
        viewer.process.kill()
        viewer.process.wait()
        self.until(lambda: "does not answer" in self.problem(), "said")
        self.shot("killed")
        other = Viewer(EIKON, self.folder, CORNELL, *SMALL, "--port", str(viewer.port))
        self.addCleanup(other.__exit__)
        self.until(lambda: "open the address that" in self.problem(), "refused by the other one")

    def test_a_scene_that_fails_to_load_shows_the_line_of_render_and_is_repaired(self):
        whole = CORNELL.read_text()
        (self.folder / "scene.gltf").write_text(whole.replace('"2.0"', '"1.0"'))
        line = subprocess.run([EIKON, "render", "scene.gltf", "-o", "x.exr", "--quiet"], cwd=self.folder, capture_output=True,
                              text=True, check=False).stderr
        self.view("scene.gltf", *SMALL)
        self.until(lambda: self.state("state") == "failed", "failed")
        self.assertEqual(f"eikon: {self.problem()}\n", line)
        self.shot("broken")
        (self.folder / "scene.gltf").write_text(whole)
        self.until_done()
        self.no_complaint()
        (self.folder / "scene.gltf").write_text("{")  # and breaks while it is shown
        self.until(lambda: self.state("state") == "failed", "failed again")
        self.assertNotEqual(self.problem(), "")


class Dark(Page):
    def test_the_page_is_dark_where_the_browser_is(self):
        self.prefer("dark")
        self.view(ROOT / "scenes/sphere_in_sky.gltf", *SMALL)
        self.until_done()
        self.shot("dark")
        self.assertLess(self.luminance(), 64)
        self.set("layer", "error")
        self.until(lambda: self.run_script("return frame.layer") == "error", "error")
        self.shot("dark_error")
        self.no_complaint()


if __name__ == "__main__":
    EIKON = str(pathlib.Path(sys.argv.pop(1)).resolve())
    try:
        unittest.main()
    finally:
        Page.quit()
