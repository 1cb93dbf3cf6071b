#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Predicts paths a second on GPUs from what is known without one: registers (bounds.tsv), counts of renders (counts.tsv) and assumptions,
which stand here by name. Prints the tables of MODEL.md, the last of which compares this with what was measured (measured.tsv).

    model.py                    the tables
    model.py --adopt            writes them into MODEL.md
    model.py --count            counts steps, tests and vertices anew by --eikon FILE, and writes counts.tsv

A figure of three numbers is what the model gives with all assumptions at their slow end, in the middle, and at their fast end."""
import argparse
import dataclasses
import json
import os
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
from bench_page import table  # noqa: E402
from check import occupancy, read_bounds  # noqa: E402

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from common.eikon_flag import add_eikon_flag  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
COUNTS, MEASURED, PAGE = HERE / "counts.tsv", HERE / "measured.tsv", HERE / "MODEL.md"
BEGIN, END = "<!-- begin of what model.py prints -->\n", "<!-- end of what model.py prints -->\n"
SCENES = ("cornell", "window_room", "cornell_spheres")
LAYOUTS = ("bvh2", "bvh4", "cwbvh")
KINDS = ("camera", "diffuse", "shadow")
CLASSES = ("shade_flat_lambert", "shade_opaque", "shade_transmissive")  # in place of `shade` where a scene has surfaces of several classes


@dataclasses.dataclass(frozen=True)
class Gpu:
    """From the maker's data sheets. dram: bytes a second, of which a copy reaches nine tenths. warps: of an SM at most"""
    name: str
    sms: int
    hertz: float
    dram: float
    l2_bytes: float
    warps: int


GPUS = (Gpu("H100 SXM", 132, 1.755e9, 0.9 * 3.35e12, 50e6, 64), Gpu("H200", 132, 1.755e9, 0.9 * 4.8e12, 50e6, 64),
        Gpu("RTX 4090", 128, 2.52e9, 0.9 * 1.008e12, 72e6, 48))
SCHEDULERS = 4  # of an SM; each issues one instruction of a warp in a clock
LANES = 32      # of a warp

# Instructions, counted in the machine code that ptxas 12.9.86 makes for sm_90 of check.py's
# programs (nvdisasm 13.5.37): the loop over nodes, that over the triangles of a leaf if nothing
# ends it early, and all of `intersect` outside of both that runs once.
NODE_STEP = {"bvh2": 94, "bvh4": 282, "cwbvh": 467}
WHOLE_TRIANGLE, AROUND = 425, 290
INSTRUCTION_BYTES = 16
BOUND_ROOM = 31 / 30  # what check.py adds to bytes of code
# cwbvh counts steps without leaves; the others count each leaf as one, which has so many triangles
# (scenes of boxes: 1.3 to 1.7).
LEAF_TRIANGLES = 1.5

# Bytes that kernels read and write for each item, counted in kernels/shared/path_state.def and the
# stages; those of state that a path has; those of a ray of `bench rays`; those of a pixel of a
# unit's sums that go back to the host, and its counts.
BYTES = {"generate": 76, "intersect": 48, "miss": 20, "shade": 180, "sort_hits": 44, "compact": 14, "shadow": 76, "film": 12}
STATE_BYTES, BENCH_RAY_BYTES, PIXEL_BYTES = 148, 44, 105
SAMPLES_OF_A_UNIT = 64  # of a pixel: all of an image that takes less than a second (render/schedule.cpp)
WAITED_FOR = 1 << 16    # paths of a depth for whose number the host waits (wavefront/stages/depth_plan.h)
MEASURED_SAMPLES = 256  # of measured.tsv
UNITS = (1 << 20, 1 << 23, 1 << 25)  # paths
FILM_LOOP = 0.25        # of the instructions of `film`, those that each sample of a pixel takes


@dataclasses.dataclass(frozen=True)
class Assumed:
    """What is neither counted nor on a data sheet. (slow, middle, fast)"""
    # Share of the lanes of a warp that have work, by kind of ray and in shading.
    camera: tuple = (0.7, 0.8, 0.9)
    diffuse: tuple = (0.35, 0.45, 0.6)
    shadow: tuple = (0.4, 0.55, 0.7)
    shading: tuple = (0.6, 0.8, 0.9)
    # Share of a kernel's instructions that a warp executes, of `shade` and of the small ones.
    executed: tuple = (0.9, 0.7, 0.5)
    triangle: tuple = (250, 160, 120)  # instructions of a test; most are refused at the edges, after about 90
    clocks: tuple = (20, 12, 8)        # from one instruction of a warp to its next, memory included
    shading_clocks: tuple = (60, 42, 24)  # the same in shading, whose loads depend on each other; fitted to measured.tsv
    issue: tuple = (0.6, 0.7, 0.8)     # of all clocks, at most, in which a scheduler issues
    sectors: tuple = (2.7, 2.0, 1.6)   # bytes that memory moves for each that is wanted, as paths thin out
    launch_s: tuple = (10e-6, 7e-6, 3e-6)    # from the end of a kernel to the begin of the next; the middle is measured, with --stats
    read_s: tuple = (15e-6, 8e-6, 5e-6)      # a round's number of paths, to the host and back
    bus: tuple = (3e9, 6e9, 12e9)            # bytes a second, from memory that is not pinned
    film_add_s: tuple = (0.85e-3, 0.2e-3, 0.1e-3)  # the host adds 16,384 pixels to the film; the slow end is one thread, measured

    def at(self, end):
        return Assumed(**{field.name: getattr(self, field.name)[end] for field in dataclasses.fields(self)})


class Model:
    """One GPU, scene and layout, with all assumptions at one end."""

    def __init__(self, gpu, scene, layout, end):
        self.gpu, self.scene, self.layout, self.assumed = gpu, COUNTED[scene], layout, Assumed().at(end)
        own, tree = scene, "cornell" if layout == "bvh2" else f"cornell/{layout}"
        # {kernel: share of the vertices that it shades}
        self.shades = dict(zip(CLASSES, self.scene["classes"])) if "classes" in self.scene else {"shade": 1.0}
        self.rows = {kernel: BOUNDS.get((own, kernel), BOUNDS[("window_room", kernel)]) for kernel in ("generate", "compact", "film", "miss")}
        self.rows |= {kernel: BOUNDS[(own, kernel)] for kernel in self.shading_kernels()}
        self.rows |= {kernel: BOUNDS[(tree, kernel)] for kernel in ("intersect", "shadow")}

    def shading_kernels(self):
        return [*self.shades, *(["sort_hits"] if len(self.shades) > 1 else [])]

    def warps(self, kernel):
        """Of an SM, that the registers allow."""
        return min(self.gpu.warps, occupancy(int(self.rows[kernel]["nv_registers"])))

    def ray_slots(self, kind):
        """Lane-instructions of a ray, those of lanes without work included."""
        steps, tests = self.scene["rays"][self.layout][kind]
        nodes = steps if self.layout == "cwbvh" else steps - tests / LEAF_TRIANGLES
        return (AROUND + nodes * NODE_STEP[self.layout] + tests * self.assumed.triangle) / getattr(self.assumed, kind)

    def code_slots(self, kernel):
        """The same of kernels without loops."""
        instructions = int(self.rows[kernel]["nv_bytes"]) / BOUND_ROOM / INSTRUCTION_BYTES
        return instructions * self.assumed.executed / self.assumed.shading

    def slots(self, kernel, depth=1):
        if kernel == "intersect":
            return self.ray_slots("camera" if depth == 0 else "diffuse")
        if kernel == "shadow":
            return self.ray_slots("shadow")
        return self.code_slots(kernel) * (FILM_LOOP if kernel == "film" else 1)

    def run_s(self, kernel, items, slots, memory_bytes=0.0):
        """Seconds that a kernel runs: as registers and latency let it issue, or as memory lets it move so many bytes."""
        schedulers = self.gpu.sms * SCHEDULERS
        warps = min(self.warps(kernel) / SCHEDULERS, items / LANES / schedulers)
        share = min(self.assumed.issue, warps / (self.assumed.shading_clocks if kernel.startswith("shade") else self.assumed.clocks))
        issue_s = items * slots / (schedulers * LANES * self.gpu.hertz * share) if items else 0.0
        return max(issue_s, memory_bytes / self.gpu.dram)

    def kernel_s(self, kernel, items, depth, paths):
        """The same, for a unit of so many paths, whose state may stay in the cache."""
        sectors = 1.0 if kernel == "generate" else self.assumed.sectors  # no path has ended yet
        moved = 0.0 if paths * STATE_BYTES < self.gpu.l2_bytes else items * BYTES["shade" if kernel in CLASSES else kernel] * sectors
        return self.run_s(kernel, items, self.slots(kernel, depth), moved)

    def rays_per_s(self, kind, count):
        """As `bench rays` measures them."""
        seconds = self.run_s("shadow" if kind == "shadow" else "intersect", count, self.ray_slots(kind), count * BENCH_RAY_BYTES)
        return count / seconds

    def round_s(self, depth, paths):
        """{kernel: seconds} of a round at that depth, of a unit of so many paths."""
        alive = paths * self.scene["alive"][depth]
        items = {"intersect": alive, "miss": alive, "compact": alive, "shadow": alive * self.scene["shadow"][depth]}
        items |= {kernel: alive * self.shades.get(kernel, 1.0) for kernel in self.shading_kernels()}
        if not self.scene["environment"]:
            del items["miss"]
        return {kernel: self.kernel_s(kernel, count, depth, paths) for kernel, count in items.items()}

    def unit(self, paths, samples=SAMPLES_OF_A_UNIT):
        """(seconds, {kernel: seconds}) of a unit of so many paths. The first includes what the device waits between kernels and at the end."""
        pixels = paths / samples
        total = {kernel: self.kernel_s(kernel, paths, 0, paths) for kernel in ("generate", "film")}
        waits = len(total) * self.assumed.launch_s
        for depth, share in enumerate(self.scene["alive"]):
            if paths * share < 0.5:
                break
            seconds = self.round_s(depth, paths)
            for kernel, time in seconds.items():
                total[kernel] = total.get(kernel, 0.0) + time
            waits += (self.assumed.read_s if paths * share > WAITED_FOR else 0.0) + len(seconds) * self.assumed.launch_s
        # The host adds the sums of the unit before at the same time.
        host = pixels * PIXEL_BYTES / self.assumed.bus + self.assumed.film_add_s * pixels / 16384
        return max(sum(total.values()) + waits, host), total

    def full(self):
        """Paths a second if the device were always full and never waited."""
        one = 64e6
        return one / sum(self.unit(one)[1].values())


def read_counts():
    """{scene: {"alive": [share of paths by depth], "shadow": [rays a vertex by depth], "environment", "classes": [share of the vertices],
    "rays": {layout: {kind: ...}}}}"""
    counted = {}
    for line in COUNTS.read_text().splitlines():
        if line.startswith("#"):
            continue
        scene, what, *values = line.split("\t")
        entry = counted.setdefault(scene, {"rays": {}})
        numbers = [float(value) for value in values]
        if what in ("alive", "shadow", "classes"):
            entry[what] = numbers
        elif what == "environment":
            entry[what] = numbers[0] == 1
        else:
            layout, kind = what.split("/")
            entry["rays"].setdefault(layout, {})[kind] = tuple(numbers)
    return counted


def count(eikon, scene, layouts=LAYOUTS):
    """Lines of counts.tsv of a scene. They depend on no device and no speed."""
    file, lines = ROOT / f"scenes/{scene}.gltf", []
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "out.json"

        def run(*words, **environment):
            subprocess.run([eikon, *map(str, words)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                           env={**os.environ, **environment})
            return json.loads(path.read_text())

        render = ["render", file, "-o", pathlib.Path(folder) / "out.exr", "--size", "128x128", "--guiding", "off", "--light-paths", "off",
                  "--devices", "0", "--quiet", "--stats", path, "--spp"]
        stats = run(*render, 64)
        bounces = stats["devices"][0]["bounces"]
        alive = [b["paths"] / stats["samples"] for b in bounces[:-1]]  # the last line has all further depths
        ratio = alive[-1] / alive[-2]
        alive += [alive[-1] * ratio ** n for n in range(1, 16)]
        shadow = [b["shadow_rays"] / b["paths"] for b in bounces[:-1]]
        shadow += [shadow[-1]] * 15
        lines.append([scene, "alive", *(f"{share:.3g}" for share in alive)])
        lines.append([scene, "shadow", *(f"{rays:.3g}" for rays in shadow)])
        lines.append([scene, "environment", int("environment" in stats["features"].split())])
        if len({"flat_lambert_hits", "opaque_hits", "transmissive_hits"} & set(stats["features"].split())) > 1:
            stages = run(*render, 4, EIKON_LANES="1", EIKON_FAULT="device:0:gpu")["stages"]
            items = {stage["stage"]: stage["items"] for stage in stages}
            lines.append([scene, "classes", *(f"{items.get(kernel, 0) / items['intersect']:.3g}" for kernel in CLASSES)])
        for layout in layouts:
            for row in run("bench", "rays", file, "--size", "128x128", "--rays", "65536", "--rounds", "1", "--devices", "0", "--layout",
                           layout, "--count", "--json", path):
                lines.append([scene, f"{layout}/{row['rays']}", f"{row['steps_per_ray']:.1f}", f"{row['tests_per_ray']:.1f}"])
    return ["\t".join(map(str, line)) for line in lines]


def spread(of, digits=0):
    """The figure at the slow end, in the middle and at the fast end of all assumptions."""
    return " / ".join(f"{of(end):.{digits}f}" for end in range(3))


def mpaths(gpu, scene, paths, end, layout="bvh2"):
    """Paths a second in units of so many."""
    return 1e-6 * paths / Model(gpu, scene, layout, end).unit(paths)[0]


def in_kernels(gpu, scene, paths, end):
    """Per cent of the time."""
    seconds, total = Model(gpu, scene, "bvh2", end).unit(paths)
    return 100 * sum(total.values()) / seconds


def stage_shares(gpu, scene, end):
    """{kernel: per cent of the time of all kernels} in the largest units. `shade` is the sum of all classes."""
    total = Model(gpu, scene, "bvh2", end).unit(UNITS[-1])[1]
    shares = {kernel: 100 * seconds / sum(total.values()) for kernel, seconds in total.items()}
    return {**shares, "shade": sum(share for kernel, share in shares.items() if kernel == "shade" or kernel in CLASSES)}


def kernel_table():
    cases = [("cornell", layout, kernel) for kernel in ("intersect", "shadow") for layout in LAYOUTS]
    cases += [(scene, "any", kernel) for scene in SCENES for kernel in Model(GPUS[0], scene, "bvh2", 1).shading_kernels()]
    rows = []
    for scene, layout, kernel in cases:
        model = Model(GPUS[0], scene, "bvh2" if layout == "any" else layout, 1)
        rows.append((scene, layout, kernel, model.rows[kernel]["nv_registers"], model.warps(kernel),
                     f"{model.slots(kernel):.0f}"))
    return table(["scene", "layout", "kernel", "registers", "warps of an SM", "lane-instructions of an item"], rows)


def rays_table():
    return table(["GPU", "scene", "layout", *(f"{kind}, Mrays/s" for kind in KINDS)],
                 [(gpu.name, "cornell", layout, *(spread(lambda end, kind=kind: 1e-6 * Model(gpu, "cornell", layout, end).rays_per_s(kind, 1 << 24))
                                                  for kind in KINDS)) for gpu in GPUS for layout in LAYOUTS])


def paths_table():
    return table(["GPU", "scene", *(f"Mpaths/s: 2^{paths.bit_length() - 1}" for paths in UNITS), "in kernels, %: 2^25", "Mpaths/s: always full"],
                 [(gpu.name, scene, *(spread(lambda end, paths=paths: mpaths(gpu, scene, paths, end)) for paths in UNITS),
                   spread(lambda end: in_kernels(gpu, scene, UNITS[-1], end)),
                   spread(lambda end: 1e-6 * Model(gpu, scene, "bvh2", end).full())) for gpu in GPUS for scene in SCENES])


def stages_table():
    kernels = ("generate", "intersect", "miss", "sort_hits", "shade", *CLASSES, "compact", "shadow", "film")
    return table(["scene", *(f"{kernel}, %" for kernel in kernels)],
                 [(scene, *(f"{stage_shares(GPUS[0], scene, 1).get(kernel, 0):.0f}" for kernel in kernels)) for scene in SCENES])


def claims_table():
    """What would show that the model is wrong, and where: rows of the page that bench_gpu.sh makes."""
    h100, h200, _ = GPUS
    small, middle, large = UNITS
    low, high = (mpaths(h200, "cornell", large, end) for end in (0, 2))
    rays = [1e-6 * Model(h100, "cornell", layout, 1).rays_per_s("diffuse", 1 << 24) for layout in LAYOUTS]
    slowest = 1e-6 * Model(h100, "cornell", "bvh2", 0).rays_per_s("diffuse", 1 << 24)
    return table(["section, row", "the model says", "wrong, and then what is", "if"], [
        ("Paths by unit: cornell, 2^25", f"{low:.0f} to {high:.0f} Mpaths/s on an H200", "anything", "it is outside"),
        ("Paths by unit: cornell, 2^25 over 2^23",
         f"{spread(lambda end: mpaths(h200, 'cornell', large, end) / mpaths(h200, 'cornell', middle, end), 2)} times",
         "that thin depths cost what `launch_s` says", "it is below 1.03"),
        ("Paths by unit: cornell, 2^23 over 2^20",
         f"{spread(lambda end: mpaths(h200, 'cornell', middle, end) / mpaths(h200, 'cornell', small, end), 2)} times",
         "`launch_s`, `read_s`, `bus`", "it is below 1.3"),
        ("Paths by unit: cornell, 2^25, in kernels", f"{spread(lambda end: in_kernels(h200, 'cornell', large, end))} %",
         "`launch_s`, `read_s`", "it is below 85"),
        ("Rays by layout: cornell, bvh2, 2^24, diffuse", f"at least {slowest:.0f} Mrays/s on an H100", "`clocks` and `diffuse`: latency limits",
         "it is below"),
        ("Rays by layout: cornell, cwbvh over bvh2, 2^24, diffuse", f"{rays[2] / rays[0]:.2f} times",
         "that instructions limit, not the latency of memory", "it is above 1.1"),
        ("Time by stage: cornell_spheres, all `shade_*` of all kernels",
         f"{spread(lambda end: stage_shares(h200, 'cornell_spheres', end)['shade'])} %, for want of warps",
         "that registers matter: `shading_clocks`", "it is below 35"),
    ])


def measured_table():
    """What the model gives for the units of each render that was measured, beside the measurement."""
    rows = []
    gpus = {gpu.name: gpu for gpu in GPUS}
    for line in MEASURED.read_text().splitlines():
        if line.startswith("#"):
            continue
        gpu, scene, units, paths, kernel, ms = line.split("\t")
        of_unit = [Model(gpus[gpu], scene, "bvh2", end).unit(int(paths) / int(units), MEASURED_SAMPLES) for end in range(3)]

        def predicted(end, units=int(units), kernel=kernel, of_unit=of_unit):
            seconds, kernels = of_unit[end]
            return 1e3 * units * {**kernels, "all": seconds, "gaps": seconds - sum(kernels.values())}[kernel]

        rows.append((gpu, scene, kernel, spread(predicted), f"{float(ms):.0f}", f"{float(ms) / predicted(1):.2f}"))
    return table(["GPU", "scene", "kernel", "the model says, ms", "measured, ms", "measured / middle"], rows)


def tables():
    return "\n".join((kernel_table(), rays_table(), paths_table(), stages_table(), claims_table(), measured_table()))


BOUNDS = read_bounds()
COUNTED = read_counts() if COUNTS.exists() else {}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", action="store_true")
    add_eikon_flag(parser)
    parser.add_argument("--adopt", action="store_true")
    options = parser.parse_args()
    if options.count:
        head = ["# Counted by model.py --count: shares of paths alive and shadow rays a vertex by depth (from the 16th on extrapolated), and steps",
                "# and tests of a ray by layout and kind; shares of the vertices of each shading class: flat_lambert, opaque, transmissive."]
        COUNTS.write_text("\n".join(head + [line for scene in SCENES for line in count(options.eikon, scene)]) + "\n")
    elif options.adopt:
        before, rest = PAGE.read_text().split(BEGIN)
        PAGE.write_text(before + BEGIN + "\n" + tables() + END + rest.split(END)[1])
    else:
        print(tables(), end="")


if __name__ == "__main__":
    main()
