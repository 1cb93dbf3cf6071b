#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures how soon `eikon view` answers somebody who turns the camera, and whether its memory stays flat. This is no test: run it
where nothing else runs.

  tests/view/speed.py EIKON SCENE [--size 640x480] [--steps 1000] [flags of eikon view]

Each step asks for another camera and waits for its first picture, as the page does while the mouse is dragged."""
import argparse
import pathlib
import re
import statistics
import tempfile
import time

from viewer import Viewer, turned


def resident_kb(viewer):
    return int(re.search(r"VmRSS:\s+(\d+) kB", pathlib.Path(f"/proc/{viewer.process.pid}/status").read_text())[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("eikon", type=pathlib.Path)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--steps", type=int, default=1000)
    arguments, words = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder, \
            Viewer(arguments.eikon.resolve(), folder, arguments.scene.resolve(), "--size", arguments.size, *words) as viewer:
        begin = time.monotonic()
        news, _ = viewer.wait_for("rendering")
        print(f"first picture after {time.monotonic() - begin:.2f} s")
        scene, times, memory = news["status"]["scene"], [], []
        frame = news["frame"]["number"]
        for step in range(arguments.steps):
            begin = time.monotonic()
            number = viewer.look({"--size": arguments.size, "--look-at": turned(scene, step)}, moving=True)
            while True:
                news, _ = viewer.news(news["version"], frame)
                frame = news["frame"]["number"] if news["frame"] else frame
                if news["status"]["state"] == "moving" and news["status"]["state_of"] >= number:
                    break
            times.append(1000 * (time.monotonic() - begin))
            if step % max(arguments.steps // 10, 1) == 0:
                memory.append(resident_kb(viewer) // 1000)
        times.sort()
        print(f"{arguments.steps} steps of {arguments.size}: median {statistics.median(times):.0f} ms, nine of ten within "
              f"{times[9 * len(times) // 10]:.0f} ms, the longest {times[-1]:.0f} ms")
        print(f"memory, MB, at each tenth: {memory}, at the end {resident_kb(viewer) // 1000}")


if __name__ == "__main__":
    main()
