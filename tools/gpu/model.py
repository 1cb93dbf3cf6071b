#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Predicts paths a second on GPUs from what is known without one: registers (bounds.tsv), counts of renders (counts.tsv) and
assumptions, which stand here by name. Prints the tables of MODEL.md, the last of which compares this with what was measured
(measured.tsv).

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
from check import CODE_ROOM, LANES, SCHEDULERS, occupancy, read_bounds  # noqa: E402

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from common.flags import add_eikon_flag  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
COUNTS_HEAD = [
    "# Counted by model.py --count: shares of paths alive and shadow rays a vertex by depth (from the 16th on extrapolated), and steps",
    "# and tests of a ray by layout and kind; shares of the vertices of each shading class: flat_lambert, opaque, transmissive."]
COUNTS, MEASURED, PAGE = HERE / "counts.tsv", HERE / "measured.tsv", HERE / "MODEL.md"
BEGIN, END = "<!-- begin of what model.py prints -->\n", "<!-- end of what model.py prints -->\n"
SCENES = ("cornell", "window_room", "cornell_spheres")
LAYOUTS = ("bvh2", "bvh4", "cwbvh")
KINDS = ("camera", "diffuse", "shadow")
# These are run in place of `shade` where a scene has surfaces of several classes.
CLASSES = ("shade_flat_lambert", "shade_opaque", "shade_transmissive")


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
SLOW, MIDDLE, FAST = ENDS = range(3)  # indices of the ends of an assumption

# Instructions, counted in the machine code that ptxas 12.9.86 makes for sm_90 of check.py's
# programs (nvdisasm 13.5.37): the loop over nodes, and all of `intersect` outside of loops, which
# runs once.
NODE_STEP = {"bvh2": 94, "bvh4": 282, "cwbvh": 467}
AROUND = 290
INSTRUCTION_BYTES = 16
BOUND_ROOM = 1 + 1 / CODE_ROOM  # a bound of check.py over the bytes of code that were measured
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
EXTRAPOLATED = 15       # depths after those that eikon's statistics list one by one
UNITS = (1 << 20, 1 << 23, 1 << 25)  # paths
FILM_ADD_PIXELS = 16384  # for which Assumed.film_add_s stands
FILM_LOOP = 0.25        # of the instructions of `film`, those that each sample of a pixel takes


@dataclasses.dataclass(frozen=True)
class Assumed:
    """Everything that is neither counted nor on a data sheet: (slow, middle, fast) of each."""
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
    launch_s: tuple = (10e-6, 7e-6, 3e-6)    # from a kernel's end to the begin of the next; the middle is measured, with --stats
    read_s: tuple = (15e-6, 8e-6, 5e-6)      # a round's number of paths, to the host and back
    bus: tuple = (3e9, 6e9, 12e9)            # bytes a second, from memory that is not pinned
    film_add_s: tuple = (0.85e-3, 0.2e-3, 0.1e-3)  # the host adds 16,384 pixels to the film; the slow end is one thread, measured

    def at_end(self, end):
        """Returns the assumptions at one of ENDS, a number instead of each triple."""
        return Assumed(**{field.name: getattr(self, field.name)[end] for field in dataclasses.fields(self)})


class Model:
    """One GPU, scene and layout, with all assumptions at one end."""

    def __init__(self, gpu, scene, layout, end):
        self.gpu, self.scene, self.layout, self.assumed = gpu, COUNTED[scene], layout, Assumed().at_end(end)
        own, tree = scene, "cornell" if layout == "bvh2" else f"cornell/{layout}"
        # {kernel: share of the vertices that it shades}
        self.shades = dict(zip(CLASSES, self.scene["classes"])) if "classes" in self.scene else {"shade": 1.0}
        self.rows = {kernel: BOUNDS.get((own, kernel), BOUNDS[("window_room", kernel)])
                     for kernel in ("generate", "compact", "film", "miss")}
        self.rows |= {kernel: BOUNDS[(own, kernel)] for kernel in self.shading_kernels()}
        self.rows |= {kernel: BOUNDS[(tree, kernel)] for kernel in ("intersect", "shadow")}

    def shading_kernels(self):
        return [*self.shades, *(["sort_hits"] if len(self.shades) > 1 else [])]

    def resident_warps(self, kernel):
        """Returns how many warps of a kernel an SM holds, as its registers allow."""
        return min(self.gpu.warps, occupancy(int(self.rows[kernel]["nv_registers"])))

    def ray_lane_instructions(self, kind):
        """Returns the lane-instructions of a ray, those of lanes without work included."""
        steps, tests = self.scene["rays"][self.layout][kind]
        nodes = steps if self.layout == "cwbvh" else steps - tests / LEAF_TRIANGLES
        return (AROUND + nodes * NODE_STEP[self.layout] + tests * self.assumed.triangle) / getattr(self.assumed, kind)

    def code_lane_instructions(self, kernel):
        """Returns the lane-instructions of an item of a kernel without loops."""
        instructions = int(self.rows[kernel]["nv_bytes"]) / BOUND_ROOM / INSTRUCTION_BYTES
        return instructions * self.assumed.executed / self.assumed.shading

    def lane_instructions(self, kernel, depth=1):
        """Returns the lane-instructions of an item of any kernel. depth: of the path; rays of depth 0 come from the camera"""
        if kernel == "intersect":
            return self.ray_lane_instructions("camera" if depth == 0 else "diffuse")
        if kernel == "shadow":
            return self.ray_lane_instructions("shadow")
        return self.code_lane_instructions(kernel) * (FILM_LOOP if kernel == "film" else 1)

    def run_s(self, kernel, items, lane_instructions, memory_bytes=0.0):
        """Returns the seconds that a kernel runs: as registers and latency let it issue so many lane-instructions for each item, or
        as memory lets it move so many bytes."""
        schedulers = self.gpu.sms * SCHEDULERS
        warps = min(self.resident_warps(kernel) / SCHEDULERS, items / LANES / schedulers)
        clocks = self.assumed.shading_clocks if kernel.startswith("shade") else self.assumed.clocks
        share = min(self.assumed.issue, warps / clocks)
        issue_s = items * lane_instructions / (schedulers * LANES * self.gpu.hertz * share) if items else 0.0
        return max(issue_s, memory_bytes / self.gpu.dram)

    def kernel_s(self, kernel, items, depth, paths):
        """Returns the seconds that a kernel runs in a unit of so many paths, whose state may stay in the cache."""
        sectors = 1.0 if kernel == "generate" else self.assumed.sectors  # no path has ended yet
        moved = items * BYTES["shade" if kernel in CLASSES else kernel] * sectors
        is_cached = paths * STATE_BYTES < self.gpu.l2_bytes
        return self.run_s(kernel, items, self.lane_instructions(kernel, depth), 0.0 if is_cached else moved)

    def rays_per_s(self, kind, count):
        """Returns rays a second of a kind, of KINDS, as `bench rays` measures them on so many rays."""
        kernel = "shadow" if kind == "shadow" else "intersect"
        return count / self.run_s(kernel, count, self.ray_lane_instructions(kind), count * BENCH_RAY_BYTES)

    def round_s(self, depth, paths):
        """Returns {kernel: seconds} of a round at that depth, of a unit of so many paths."""
        alive = paths * self.scene["alive"][depth]
        items = {"intersect": alive, "miss": alive, "compact": alive, "shadow": alive * self.scene["shadow"][depth]}
        items |= {kernel: alive * self.shades.get(kernel, 1.0) for kernel in self.shading_kernels()}
        if not self.scene["environment"]:
            del items["miss"]
        return {kernel: self.kernel_s(kernel, count, depth, paths) for kernel, count in items.items()}

    def unit_times(self, paths, samples=SAMPLES_OF_A_UNIT):
        """Returns (seconds, {kernel: seconds}) of a unit of so many paths. The first includes what the device waits between kernels
        and at the end."""
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
        host = pixels * PIXEL_BYTES / self.assumed.bus + self.assumed.film_add_s * pixels / FILM_ADD_PIXELS
        return max(sum(total.values()) + waits, host), total

    def full_paths_per_s(self):
        """Returns paths a second if the device were always full and never waited."""
        many = 64e6  # each of GPUS holds less than a hundredth of them at a time
        return many / sum(self.unit_times(many)[1].values())


def read_counts():
    """Returns {scene: {"alive": [share of paths by depth], "shadow": [rays a vertex by depth], "environment",
    "classes": [share of the vertices], "rays": {layout: {kind: ...}}}}"""
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


def count_lines(eikon, scene, layouts=LAYOUTS):
    """Renders a scene, and returns its lines of counts.tsv. They depend on no device and no speed."""
    file, lines = ROOT / f"scenes/{scene}.gltf", []
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "out.json"

        def run(*words, **environment):
            subprocess.run([eikon, *map(str, words)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                           env={**os.environ, **environment})
            return json.loads(path.read_text())

        render = ["render", file, "-o", pathlib.Path(folder) / "out.exr", "--size", "128x128", "--guiding", "off",
                  "--light-paths", "off", "--devices", "0", "--quiet", "--stats", path, "--spp"]
        stats = run(*render, 64)
        bounces = stats["devices"][0]["bounces"]
        alive = [bounce["paths"] / stats["samples"] for bounce in bounces[:-1]]  # the last line has all further depths
        ratio = alive[-1] / alive[-2]
        alive += [alive[-1] * ratio ** further for further in range(1, 1 + EXTRAPOLATED)]
        shadow = [bounce["shadow_rays"] / bounce["paths"] for bounce in bounces[:-1]]
        shadow += [shadow[-1]] * EXTRAPOLATED
        lines.append([scene, "alive", *(f"{share:.3g}" for share in alive)])
        lines.append([scene, "shadow", *(f"{rays:.3g}" for rays in shadow)])
        lines.append([scene, "environment", int("environment" in stats["features"].split())])
        if len({"flat_lambert_hits", "opaque_hits", "transmissive_hits"} & set(stats["features"].split())) > 1:
            stages = run(*render, 4, EIKON_LANES="1", EIKON_FAULT="device:0:gpu")["stages"]
            items = {stage["stage"]: stage["items"] for stage in stages}
            lines.append([scene, "classes", *(f"{items.get(kernel, 0) / items['intersect']:.3g}" for kernel in CLASSES)])
        for layout in layouts:
            for row in run("bench", "rays", file, "--size", "128x128", "--rays", "65536", "--rounds", "1", "--devices", "0",
                           "--layout", layout, "--count", "--json", path):
                lines.append([scene, f"{layout}/{row['rays']}", f"{row['steps_per_ray']:.1f}", f"{row['tests_per_ray']:.1f}"])
    return ["\t".join(map(str, line)) for line in lines]


def at_all_ends(figure, digits=0):
    """Returns "slow / middle / fast" of figure(end), a number for each of ENDS."""
    return " / ".join(f"{figure(end):.{digits}f}" for end in ENDS)


def megapaths_per_s(gpu, scene, paths, end, layout="bvh2"):
    """Returns millions of paths a second in units of so many paths."""
    return 1e-6 * paths / Model(gpu, scene, layout, end).unit_times(paths)[0]


def percent_in_kernels(gpu, scene, paths, end):
    """Returns the per cent of the time of a unit of so many paths in which a kernel runs."""
    seconds, total = Model(gpu, scene, "bvh2", end).unit_times(paths)
    return 100 * sum(total.values()) / seconds


def stage_shares(gpu, scene, end):
    """Returns {kernel: per cent of the time of all kernels} in the largest units. `shade` is the sum of all classes."""
    total = Model(gpu, scene, "bvh2", end).unit_times(UNITS[-1])[1]
    shares = {kernel: 100 * seconds / sum(total.values()) for kernel, seconds in total.items()}
    return {**shares, "shade": sum(share for kernel, share in shares.items() if kernel == "shade" or kernel in CLASSES)}


def kernel_table():
    """Returns a table of the registers, warps and instructions of the kernels that take most of the time, on the first of GPUS."""
    cases = [("cornell", layout, kernel) for kernel in ("intersect", "shadow") for layout in LAYOUTS]
    cases += [(scene, "any", kernel) for scene in SCENES for kernel in Model(GPUS[0], scene, "bvh2", MIDDLE).shading_kernels()]
    rows = []
    for scene, layout, kernel in cases:
        model = Model(GPUS[0], scene, "bvh2" if layout == "any" else layout, MIDDLE)
        rows.append((scene, layout, kernel, model.rows[kernel]["nv_registers"], model.resident_warps(kernel),
                     f"{model.lane_instructions(kernel):.0f}"))
    return table(["scene", "layout", "kernel", "registers", "warps of an SM", "lane-instructions of an item"], rows)


def rays_table():
    """Returns a table of rays a second by GPU, layout and kind, of so many rays that the device is full."""
    def cell(gpu, layout, kind):
        return at_all_ends(lambda end: 1e-6 * Model(gpu, "cornell", layout, end).rays_per_s(kind, 1 << 24))

    return table(["GPU", "scene", "layout", *(f"{kind}, Mrays/s" for kind in KINDS)],
                 [(gpu.name, "cornell", layout, *(cell(gpu, layout, kind) for kind in KINDS))
                  for gpu in GPUS for layout in LAYOUTS])


def paths_table():
    """Returns a table of paths a second by GPU, scene and size of unit."""
    def row(gpu, scene):
        rates = (at_all_ends(lambda end, paths=paths: megapaths_per_s(gpu, scene, paths, end)) for paths in UNITS)
        busy = at_all_ends(lambda end: percent_in_kernels(gpu, scene, UNITS[-1], end))
        return gpu.name, scene, *rates, busy, at_all_ends(lambda end: 1e-6 * Model(gpu, scene, "bvh2", end).full_paths_per_s())

    headings = [f"Mpaths/s: 2^{paths.bit_length() - 1}" for paths in UNITS]
    return table(["GPU", "scene", *headings, "in kernels, %: 2^25", "Mpaths/s: always full"],
                 [row(gpu, scene) for gpu in GPUS for scene in SCENES])


def stages_table():
    """Returns a table of the shares of the time that kernels take in the largest units, on the first of GPUS."""
    kernels = ("generate", "intersect", "miss", "sort_hits", "shade", *CLASSES, "compact", "shadow", "film")
    rows = [(scene, stage_shares(GPUS[0], scene, MIDDLE)) for scene in SCENES]
    return table(["scene", *(f"{kernel}, %" for kernel in kernels)],
                 [(scene, *(f"{shares.get(kernel, 0):.0f}" for kernel in kernels)) for scene, shares in rows])


def claims_table():
    """Returns a table of findings that would prove the model wrong, and where: rows of the page that bench_gpu.sh makes."""
    h100, h200, _ = GPUS
    small, middle, large = UNITS
    low, high = (megapaths_per_s(h200, "cornell", large, end) for end in (SLOW, FAST))

    def times_as_fast(paths, fewer):
        return at_all_ends(
            lambda end: megapaths_per_s(h200, "cornell", paths, end) / megapaths_per_s(h200, "cornell", fewer, end), 2)

    in_kernels = at_all_ends(lambda end: percent_in_kernels(h200, "cornell", large, end))
    rays = [1e-6 * Model(h100, "cornell", layout, MIDDLE).rays_per_s("diffuse", 1 << 24) for layout in LAYOUTS]
    slowest = 1e-6 * Model(h100, "cornell", "bvh2", SLOW).rays_per_s("diffuse", 1 << 24)
    return table(["section, row", "the model says", "wrong, and then what is", "if"], [
        ("Paths by unit: cornell, 2^25", f"{low:.0f} to {high:.0f} Mpaths/s on an H200", "anything", "it is outside"),
        ("Paths by unit: cornell, 2^25 over 2^23",
         f"{times_as_fast(large, middle)} times",
         "that thin depths cost what `launch_s` says", "it is below 1.03"),
        ("Paths by unit: cornell, 2^23 over 2^20",
         f"{times_as_fast(middle, small)} times",
         "`launch_s`, `read_s`, `bus`", "it is below 1.3"),
        ("Paths by unit: cornell, 2^25, in kernels", f"{in_kernels} %",
         "`launch_s`, `read_s`", "it is below 85"),
        ("Rays by layout: cornell, bvh2, 2^24, diffuse", f"at least {slowest:.0f} Mrays/s on an H100",
         "`clocks` and `diffuse`: latency limits", "it is below"),
        ("Rays by layout: cornell, cwbvh over bvh2, 2^24, diffuse", f"{rays[2] / rays[0]:.2f} times",
         "that instructions limit, not the latency of memory", "it is above 1.1"),
        ("Time by stage: cornell_spheres, all `shade_*` of all kernels",
         f"{at_all_ends(lambda end: stage_shares(h200, 'cornell_spheres', end)['shade'])} %, for want of warps",
         "that registers matter: `shading_clocks`", "it is below 35"),
    ])


def measured_table():
    """Returns a table of the times that the model gives for each render that was measured, beside the measurement."""
    rows = []
    gpus = {gpu.name: gpu for gpu in GPUS}
    for line in MEASURED.read_text().splitlines():
        if line.startswith("#"):
            continue
        gpu, scene, units, paths, kernel, ms = line.split("\t")
        of_unit = [Model(gpus[gpu], scene, "bvh2", end).unit_times(int(paths) / int(units), MEASURED_SAMPLES) for end in ENDS]

        def predicted(end, units=int(units), kernel=kernel, of_unit=of_unit):
            seconds, kernels = of_unit[end]
            return 1e3 * units * {**kernels, "all": seconds, "gaps": seconds - sum(kernels.values())}[kernel]

        rows.append((gpu, scene, kernel, at_all_ends(predicted), f"{float(ms):.0f}", f"{float(ms) / predicted(MIDDLE):.2f}"))
    return table(["GPU", "scene", "kernel", "the model says, ms", "measured, ms", "measured / middle"], rows)


def tables():
    """Returns all tables of MODEL.md, as Markdown."""
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
        COUNTS.write_text("\n".join(COUNTS_HEAD + [line for scene in SCENES for line in count_lines(options.eikon, scene)]) + "\n")
    elif options.adopt:
        before, rest = PAGE.read_text().split(BEGIN)
        PAGE.write_text(before + BEGIN + "\n" + tables() + END + rest.split(END)[1])
    else:
        print(tables(), end="")


if __name__ == "__main__":
    main()
