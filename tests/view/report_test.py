#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of --report in headless Chromium.

  tests/view/report_test.py EIKON [unittest arguments]

browser.py says what it needs."""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from browser import BrowserTests
from viewer import LIMIT_S, ROOT

EIKON = ""
SCENE = ROOT / "scenes/cornell_spheres.gltf"
DRAWN = "return document.documentElement.dataset.ready === 'yes'"


class Report(BrowserTests, unittest.TestCase):
    limit_s = LIMIT_S

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="eikon_report_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.open_browser()

    def eikon(self, *words):
        run = subprocess.run([EIKON, *map(str, words)], cwd=self.folder, capture_output=True, text=True, check=False, timeout=LIMIT_S)
        self.assertEqual(run.returncode, 0, run.stderr)

    def render(self, *words):
        self.eikon("render", SCENE, "-o", "a.exr", "--size", "160x120", "--spp", "16", "--light-paths", "0.0625", "--guiding", "off",
                   "--report", "a.html", "--quiet", *words)

    def open(self, name, painted=True):
        self.browser.get((self.folder / name).as_uri())
        self.until(lambda: self.run_script(DRAWN), "drawn")
        if painted:
            self.until(lambda: self.run_script("return document.documentElement.dataset.painted"), "painted")

    def headings(self):
        return self.run_script("return [...document.querySelectorAll('h2')].map((one) => one.textContent)")

    def test_it_draws_every_part_without_a_complaint_in_light_and_dark(self):
        self.render("--profile", "trace.json")
        self.open("a.html")
        self.assertEqual(self.headings(), ["Picture", "Error over time", "Where the time went", "Timeline", "Scene", "Features", "Settings"])
        self.assertEqual(self.run_script("return document.querySelectorAll('section .bad').length"), 0)
        self.assertNotRegex(self.run_script("return document.body.innerText"), r"\b(null|undefined|NaN)\b")
        self.assertGreater(self.luminance(), 192)
        self.shot("report", whole=True)
        colours = """const c = document.querySelector('figure canvas'), copy = el('canvas', { width: c.width, height: c.height }).getContext('2d');
          copy.drawImage(c, 0, 0);
          return [...copy.getImageData(0, 0, c.width, c.height).data]"""
        before = self.run_script(colours)
        self.assertGreater(len(set(before)), 50)
        self.run_script("const slider = document.getElementById('exposure'); slider.value = 3; slider.dispatchEvent(new Event('input'))")
        after = self.run_script(colours)
        self.assertGreater(sum(after), sum(before))
        self.prefer("dark")
        self.assertLess(self.luminance(), 64)
        self.shot("report_dark", whole=True)
        # What is written can be read on what it is written on, by the contrast of the guidelines
        # for accessible pages.
        self.assertEqual(self.run_script(FAINT), [])
        self.prefer("light")
        self.assertEqual(self.run_script(FAINT), [])
        self.assertEqual(self.errors(), [])

    def test_times_by_depth_add_up_to_the_stages_and_features_have_theirs(self):
        self.render()
        self.open("a.html")
        differences = self.run_script("""return data.stats.devices.map((device, i) => {
          const stages = data.stats.stages.filter((s) => s.device === i);
          const times = timeByDepth(stages, device.bounces).flatMap((at) => at.parts);
          const whole = stages.filter((s) => STAGE_RAYS[s.stage]).reduce((sum, s) => sum + s.seconds, 0);
          return [times.length, Math.abs(times.reduce((sum, part) => sum + part.value, 0) / whole - 1)];
        })""")
        for parts, difference in differences:
            self.assertGreater(parts, 8)
            self.assertLess(difference, 1e-9)
        rows = self.run_script("""return Object.fromEntries([...document.querySelectorAll("[aria-label='features that are in'] tbody tr")]
          .map((row) => [row.children[1].textContent, [row.children[3].textContent, row.children[4].textContent]]))""")
        for feature in ("next_event", "light_paths"):
            self.assertRegex(rows[feature][0], r"^[0-9.]+ m?s, [0-9.]+ %$")
        self.assertEqual(rows["diffuse"], ["", ""])
        self.assertEqual(rows["transmission"], ["", "+77 ns"])

    def test_costs_of_features_are_those_of_the_page_that_was_measured(self):
        page = (ROOT / "kernels/FEATURES.md").read_text()
        measured = {cells[0]: int(cells[3]) for cells in ([cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines())
                    if len(cells) == 7 and re.fullmatch(r"[+-]\d+", cells[3])}
        shown = re.findall(r'^  (\w+): \["(.*)", (-?\d+)\],$', (ROOT / "host/page/web/feature_costs.js").read_text(), re.MULTILINE)
        self.assertGreater(len(shown), 20)
        features = (ROOT / "kernels/shared/features.def").read_text()
        for feature, row, cost in shown:
            self.assertEqual(measured.get(row), int(cost), row)
            self.assertRegex(features, rf"\({feature}[,)]")

    def test_a_batch_has_a_row_for_each_job(self):
        (self.folder / "jobs.txt").write_text("".join(f"{SCENE} -o {name}.exr --size 16x12 --spp 2\n" for name in ("a", "b")) + "nothing.gltf -o c.exr\n")
        run = subprocess.run([EIKON, "batch", "jobs.txt", "--report", "jobs.html"], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertNotEqual(run.returncode, 0)
        self.open("jobs.html", painted=False)
        states = self.run_script("return [...document.querySelectorAll('tbody tr')].map((row) => row.children[1].textContent)")
        self.assertEqual(states, ["done", "done", "failed"])
        self.shot("report_batch")
        self.assertEqual(self.errors(), [])


# Texts whose contrast to the colour behind them is below 4.5, or below 3 where they are large.
FAINT = """
const rgb = (text) => text.match(/[0-9.]+/g).map(Number);
const light = ([r, g, b]) => { const f = (v) => (v /= 255, v <= 0.03928 ? v / 12.92 : Math.pow((v + 0.055) / 1.055, 2.4)); return 0.2126 * f(r) + 0.7152 * f(g) + 0.0722 * f(b); };
const behind = (node) => { for (; node; node = node.parentElement) { const c = rgb(getComputedStyle(node).backgroundColor); if (c.length < 4 || c[3] > 0) return c; } return [255, 255, 255]; };
return [...document.querySelectorAll('body *')].filter((node) => node instanceof HTMLElement && [...node.childNodes].some((c) => c.nodeType === 3 && c.data.trim()) && node.offsetParent)
  .map((node) => { const a = light(rgb(getComputedStyle(node).color)), b = light(behind(node)), size = parseFloat(getComputedStyle(node).fontSize);
    return { text: node.textContent.slice(0, 40), contrast: (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), least: size >= 24 ? 3 : 4.5 }; })
  .filter((one) => one.contrast < one.least);
"""


if __name__ == "__main__":
    EIKON = str(pathlib.Path(sys.argv.pop(1)).resolve())
    try:
        unittest.main()
    finally:
        Report.quit()
