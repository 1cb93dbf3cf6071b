# SPDX-License-Identifier: Apache-2.0
"""Plots, table and page of what versus.py measured. Needs numpy and matplotlib."""

import base64
import html
import io
import json
import pathlib

import numpy as np

import error_time

COLORS = {"eikon": "#d55e00", "mitsuba": "#0072b2", "mitsuba-multijitter": "#56b4e9", "mitsuba-ptracer": "#999999",
          "cycles": "#009e73", "cycles-guided": "#117733", "luxcore": "#cc79a7", "luxcore-hybrid": "#e69f00",
          "luxcore-bidir": "#882255"}
HEAD = ["scene", "renderer", "M samples/s", "eikon's rate to it", "relMSE", "eikon to equal error, least", "median",
        "from process start", "eikon's mean to it", "rounds"]


class Measured:
    """A scene's folder, read."""

    def __init__(self, folder):
        self.name = folder.name
        self.settings = json.loads((folder / "settings.json").read_text())
        with (folder / "runs.jsonl").open() as file:
            runs = [json.loads(line) for line in file]
        self.runs = {name: [run for run in runs if run["renderer"] == name] for name in COLORS}
        self.runs = {name: own for name, own in self.runs.items() if own}
        self.means = {}
        for name in COLORS:
            parts = [np.load(path).mean() for path in sorted(folder.glob(f"{name}.reference*.npy"))]
            if parts:
                self.means[name] = float(np.mean(parts))
        if "mitsuba" in self.means:
            self.means["mitsuba-multijitter"] = self.means["mitsuba"]
        pictures = sorted(folder.glob("eikon.reference*.npy")) or sorted(folder.glob("*.reference*.npy"))
        self.picture = np.mean([np.load(path) for path in pictures], axis=0) if pictures else None

    def curve(self, renderer, seconds):
        return error_time.curve_of(self.runs[renderer], seconds)


def rows(scene):
    """The table's cells, a row per renderer: (text, number or None) each."""
    pixels = scene.settings["size"][0] * scene.settings["size"][1]
    result = []
    ours = scene.runs.get("eikon")
    for name, runs in scene.runs.items():
        rate = error_time.rate(runs, pixels)
        curve = scene.curve(name, "seconds")
        most = max(run["spp"] for run in runs)
        row = {"scene": scene.name, "renderer": name, "samples_per_second": rate, "rate_of_eikon": None,
               "relmse": curve[-1][1], "spp": most, "equal_error": None, "equal_error_median": None,
               "equal_error_from_start": None, "ratio_of_means": None, "rounds": sum(run["spp"] == most for run in runs)}
        if ours and name != "eikon":
            row["rate_of_eikon"] = error_time.rate(ours, pixels) / rate
            row["equal_error"], row["equal_error_median"] = error_time.times_as_fast(scene.curve("eikon", "seconds"), curve)
            row["equal_error_from_start"] = error_time.times_as_fast(
                scene.curve("eikon", "seconds_from_start"), scene.curve(name, "seconds_from_start"))[0]
            if name in scene.means and "eikon" in scene.means:
                row["ratio_of_means"] = scene.means["eikon"] / scene.means[name]
        result.append(row)
    return result


def cells(row):
    def times(key):
        return "" if row[key] is None else f"{row[key]:.2f} x"

    means = "" if row["ratio_of_means"] is None else f"{row['ratio_of_means']:.4f}"
    if means and abs(row["ratio_of_means"] - 1) > 0.01:
        means += " (differ)"
    return [row["scene"], row["renderer"], f"{row['samples_per_second'] / 1e6:.2f}", times("rate_of_eikon"),
            f"{row['relmse']:.2e} at {row['spp']} spp", times("equal_error"), times("equal_error_median"),
            times("equal_error_from_start"), means, str(row["rounds"])]


def whole_decades(limits):
    """Powers of ten around the limits of an axis, so that there are labels at both ends."""
    return 10.0 ** np.floor(np.log10(limits[0])), 10.0 ** np.ceil(np.log10(limits[1]))


def plot(scene):
    """PNG bytes: error against seconds of rendering alone, from start, and against samples."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib import ticker
    figure, axes = plt.subplots(1, 3, figsize=(15, 4.6), sharey=True, layout="constrained")
    for name in scene.runs:
        curves = [scene.curve(name, "seconds"), scene.curve(name, "seconds_from_start"),
                  error_time.curve_of(scene.runs[name], "spp")]
        for axis, curve in zip(axes, curves):
            axis.loglog(*zip(*curve), "o-", color=COLORS[name], label=name, markersize=4)
    for axis, label in zip(axes, ("seconds of rendering", "seconds from process start", "samples per pixel")):
        axis.set_xlabel(label)
        axis.xaxis.set_minor_formatter(ticker.NullFormatter())
        axis.yaxis.set_minor_formatter(ticker.NullFormatter())
        axis.grid(True, which="both", alpha=0.25)
    for axis in axes[:2]:
        axis.set_xlim(*whole_decades(axis.get_xlim()))
    axes[0].set_ylim(*whole_decades(axes[0].get_ylim()))
    counts = sorted({run["spp"] for runs in scene.runs.values() for run in runs})
    axes[2].set_xticks(counts, [str(count) for count in counts])
    axes[0].set_ylabel("relMSE")
    axes[0].legend()
    width, height = scene.settings["size"]
    figure.suptitle(f"{scene.settings['scene']}, {width} x {height}, depth {scene.settings['max_depth']}")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    plt.close(figure)
    return stream.getvalue()


def write_overview(scenes, path):
    """A PNG with a panel for each scene: error against seconds of rendering alone."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib import ticker
    figure, axes = plt.subplots(1, len(scenes), figsize=(3.2 * len(scenes), 3), sharey=True, squeeze=False, layout="constrained")
    for scene, axis in zip(scenes, axes[0]):
        for name in scene.runs:
            axis.loglog(*zip(*scene.curve(name, "seconds")), "o-", color=COLORS[name], label=name, markersize=4)
        axis.set_title(scene.name)
        axis.set_xlabel("seconds of rendering")
        axis.set_xlim(*whole_decades(axis.get_xlim()))
        axis.xaxis.set_minor_formatter(ticker.NullFormatter())
        axis.grid(True, alpha=0.3)
    axes[0][0].set_ylabel("error (relMSE)")
    axes[0][0].legend(fontsize="small")
    figure.savefig(path, dpi=90)
    plt.close(figure)


def picture_png(scene):
    """PNG bytes of the scene itself, exposed to its mean."""
    import matplotlib.image
    image = np.clip(scene.picture * (0.18 / max(scene.picture.mean(), 1e-9)), 0, 1)
    image = np.where(image <= 0.0031308, 12.92 * image, 1.055 * image ** (1 / 2.4) - 0.055)
    stream = io.BytesIO()
    matplotlib.image.imsave(stream, np.clip(image, 0, 1), format="png")
    return stream.getvalue()


def embedded(png, text):
    return f'<img alt="{html.escape(text)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'


STYLE = """body{font:15px/1.5 sans-serif;max-width:1240px;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.25em .6em;text-align:right}
td:nth-child(-n+2),th{text-align:left}img{max-width:100%}"""


def write(out, overview=None):
    """Reads every scene's folder in `out`; writes SCENE.png, results.json and index.html there, and prints the table.
    overview: a PNG of all scenes, if wanted"""
    scenes = [Measured(path.parent) for path in sorted(pathlib.Path(out).glob("*/runs.jsonl")) if path.stat().st_size]
    if not scenes:
        print(f"{out}: nothing is measured yet")
        return
    table = [row for scene in scenes for row in rows(scene)]
    (out / "results.json").write_text(json.dumps(table, indent=1) + "\n")
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD))
    for row in table:
        print("| " + " | ".join(cells(row)) + " |")

    if overview:
        write_overview(scenes, overview)
    body = []
    for scene in scenes:
        png = plot(scene)
        (out / f"{scene.name}.png").write_bytes(png)
        body.append(f"<h2>{html.escape(scene.name)}</h2>")
        if scene.picture is not None:
            body.append(embedded(picture_png(scene), f"{scene.name}, rendered"))
        body.append(embedded(png, f"{scene.name}: error against time"))
    head = "".join(f"<th>{html.escape(word)}</th>" for word in HEAD)
    lines = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells(row)) + "</tr>" for row in table)
    (out / "index.html").write_text(
        f"""<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Error against time</title>
<style>{STYLE}</style></head><body><h1>Error against time</h1>
<p>relMSE (eps 0.01) of each renderer against its own converged image, whose noise is taken off; seconds are the best of
the rounds, errors their mean. "To equal error": how many times as long the other takes to the least error that both
reach, and the median over the errors that both reach; from rendering alone, and from the process's start.</p>
<table><tr>{head}</tr>{lines}</table>{"".join(body)}</body></html>
""")
    print(f"{out / 'index.html'}")
