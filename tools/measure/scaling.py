#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures how seconds and memory grow with triangles, lights, pixels, depth and textures.

  tools/measure/scaling.py [--eikon FILE] [--axis NAME,...] [--most N] [--rounds N] [--json FILE] [--plot FILE.png]

For each axis a table: seconds to load the scene and to build its tree, microseconds per sample, and the peak of memory in
MB; below it the exponent of each column between its last points, and over all of them. Each value is the least of the
rounds, since whatever disturbs a run makes it longer; a run before them compiles the kernels. Scripts in tools/ make the
scenes, and need numpy; --plot needs matplotlib.
"""

import argparse
import json
import math
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import zlib

TOOLS = pathlib.Path(__file__).resolve().parents[1]
ROOT = TOOLS.parent
sys.path.append(str(TOOLS))
from common import child_process  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402
from scene_builders.glb_file import pack_glb  # noqa: E402
from scene_builders.png_file import pack_png  # noqa: E402

COLUMNS = {"load_s": "load, s", "build_s": "build, s", "sample_us": "us per sample", "peak_mb": "peak, MB"}
SYSTEM_PYTHON = "/usr/bin/python3"  # whose numpy set-up installs


def png_of_noise(side, seed):
    """A square RGB picture, as the bytes of a PNG file."""
    pixels = random.Random(seed).randbytes(3 * side)
    rows = b"".join(b"\0" + pixels[3 * i:] + pixels[: 3 * i] for i in range(side))
    return pack_png((side, side), zlib.compress(rows, 1))


def make_textured(count, path):
    """A wall of squares, each with a texture of its own of 256 x 256 texels."""
    columns = math.ceil(math.sqrt(count))
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    data = b"".join(struct.pack("<3f", x, y, 0) for x, y in corners) + b"".join(struct.pack("<2f", x, 1 - y) for x, y in corners)
    data += struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    views = [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in ((0, 48), (48, 32), (80, 12))]
    data += b"\0" * (-len(data) % 4)
    for i in range(count):
        picture = png_of_noise(256, i)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(picture)})
        data += picture + b"\0" * (-len(picture) % 4)
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": list(range(count))}],
        "nodes": [{"mesh": i, "translation": [i % columns, i // columns, 0]} for i in range(count)],
        "meshes": [{"primitives": [{**primitive, "material": i}]} for i in range(count)],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}, "metallicFactor": 0}} for i in range(count)],
        "textures": [{"source": i} for i in range(count)],
        "images": [{"bufferView": 3 + i, "mimeType": "image/png"} for i in range(count)],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    path.write_bytes(pack_glb(json.dumps(document).encode(), data))


def made_by(script, flag):
    def make(count, path):
        subprocess.run([SYSTEM_PYTHON, TOOLS / script, flag, str(count), path], check=True, stdout=subprocess.DEVNULL)
    return make


# Name: counts, what makes the scene of a count (none: a shipped one), and the flags of its render.
AXES = {
    "triangles": ([10**n for n in range(3, 8)], made_by("make_dense.py", "--triangles"), lambda n: ["--size", "512x288", "--spp", "16"]),
    "lights": ([10**n for n in range(0, 6)], made_by("make_many_lights.py", "--lights"), lambda n: ["--size", "320x180", "--spp", "16", "--env", "none"]),
    "pixels": ([4**n for n in range(6, 12)], None, lambda n: ["--size", f"{math.isqrt(n)}x{math.isqrt(n)}", "--spp", "8"]),
    "depth": ([1, 2, 4, 8, 16, 32], None, lambda n: ["--size", "256x256", "--spp", "32", "--max-depth", str(n), "--roulette", "0.99"]),
    "textures": ([4**n for n in range(0, 6)], make_textured, lambda n: ["--size", "512x512", "--spp", "8"]),
}
SHIPPED = ROOT / "scenes/cornell.gltf"


def measure(eikon, scene, flags, folder):
    """The columns of one render."""
    stats = folder / "stats.json"
    done = child_process.run_or_exit(eikon, "render", scene, "-o", folder / "out.exr", "--stats", stats, "--quiet", *flags)
    told = json.loads(stats.read_text())
    seconds = told["seconds"]
    return {"load_s": seconds["load"], "build_s": seconds["build"], "sample_us": 1e6 / told["samples_per_second"],
            "peak_mb": done.peak_mib}


def exponent(points):
    """The slope of a least-squares line through the logarithms of (x, y)."""
    logs = [(math.log(x), math.log(y)) for x, y in points if y > 0]
    if len(logs) < 2:
        return math.nan
    mean_x, mean_y = (sum(column) / len(logs) for column in zip(*logs))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)


def measured_axis(name, options, folder):
    counts, make, flags = AXES[name]
    rows = []
    print(f"\n| {name} | " + " | ".join(COLUMNS.values()) + " |\n|" + "---|" * (1 + len(COLUMNS)), flush=True)
    for count in (n for n in counts if n <= options.most):
        scene = SHIPPED if make is None else folder / f"{name}.glb"
        if make is not None:
            make(count, scene)
        measure(options.eikon, scene, flags(count), folder)
        runs = [measure(options.eikon, scene, flags(count), folder) for _ in range(options.rounds)]
        row = {column: min(run[column] for run in runs) for column in COLUMNS}
        rows.append({"count": count, **row})
        print(f"| {count} | " + " | ".join(f"{row[column]:.3g}" for column in COLUMNS) + " |", flush=True)
    for words, some in (("exponent, last two", rows[-2:]), ("exponent, all", rows)):
        print(f"| {words} | " + " | ".join(f"{exponent([(r['count'], r[c]) for r in some]):.2f}" for c in COLUMNS) + " |", flush=True)
    return rows


def plot(axes, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, len(axes), figsize=(4 * len(axes), 3.6), layout="constrained", squeeze=False)
    for panel, (name, rows) in zip(panels[0], axes.items()):
        for column, label in COLUMNS.items():
            panel.loglog([row["count"] for row in rows], [row[column] for row in rows], "o-", label=label)
        panel.set_xlabel(name)
        panel.grid(True, which="major", alpha=0.3)
    panels[0][0].legend()
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
    parser.add_argument("--axis", default=",".join(AXES), help="of " + ", ".join(AXES) + " [all]")
    parser.add_argument("--most", type=int, default=10**9, help="leave out larger counts")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--plot", type=pathlib.Path)
    options = parser.parse_args()
    names = options.axis.split(",")
    if unknown := [name for name in names if name not in AXES]:
        parser.error(f"--axis: no {unknown[0]}; there is {', '.join(AXES)}")
    with tempfile.TemporaryDirectory() as temporary:
        axes = {name: measured_axis(name, options, pathlib.Path(temporary)) for name in names}
    if options.json:
        options.json.write_text(json.dumps(axes, indent=1) + "\n")
    if options.plot:
        plot(axes, options.plot)


if __name__ == "__main__":
    main()
