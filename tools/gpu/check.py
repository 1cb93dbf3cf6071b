#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tells what the kernels become on GPUs, without one: gives the programs of six scenes to the offline compilers of NVIDIA (Clang
and ptxas), AMD (Clang) and Intel (ocloc), prints a table, and fails where a figure is above its bound in bounds.tsv.

    check.py EIKON FOLDER             FOLDER keeps the compilers between runs (fetch_compilers.sh)
    check.py EIKON FOLDER --adopt     writes the figures of this run into bounds.tsv

Exit code 0: all within their bounds; 1: some are not, or a program does not compile; 77: compilers cannot be had."""
import argparse
import concurrent.futures
import math
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.append(str(ROOT / "tools"))
from common import child_process  # noqa: E402

BOUNDS = HERE / "bounds.tsv"

# (name, scene, options of the render, compilers). Traversal is that of `cornell` in all scenes
# without instances and formulas.
PROGRAMS = [
    ("cornell", "cornell", "", "nvidia amd intel"),
    ("cornell/bvh4", "cornell", "--layout bvh4", "nvidia amd"),
    ("cornell/cwbvh", "cornell", "--layout cwbvh", "nvidia amd intel"),
    ("window_room", "window_room", "", "nvidia amd intel"),
    ("textured", "textured", "", "nvidia amd intel"),
    ("cornell_spheres", "cornell_spheres", "", "nvidia amd intel"),
    ("lacquer", "lacquer", "", "nvidia amd intel"),
    ("lamps", "lamps", "--aov albedo,normal,depth,position,uv,direct,indirect,light_groups", "nvidia amd intel"),
]
# A scene has `shade`, or, with surfaces of several classes, one for each class.
KERNELS = ["generate", "intersect", "miss", "shade", "sort_hits", "shade_flat_lambert", "shade_opaque", "shade_transmissive",
           "compact", "shadow", "film"]

# An SM of compute capability 9.0 holds at most so many warps and blocks, and has a file of registers of 32 bits for each of
# its four schedulers, from which a warp gets registers in units [CUDA C++ Programming Guide].
ARCHITECTURE, WARPS, BLOCKS = "sm_90", 64, 32
SCHEDULERS, LANES, SCHEDULER_REGISTERS, REGISTER_UNIT = 4, 32, 16384, 256
GROUP_WARPS = 2  # eikon's kernels run in groups of 64 work-items
CODE_ROOM = 30   # code may grow by one part in so many, so that small changes need no new bounds
MOST_MESSAGE = 1500  # characters of what a compiler says that stand in a complaint; the first error is at its begin
AMD, INTEL = "gfx1100", "dg2"

# (column, heading, whether a larger figure is the better one). `bounds.tsv` has the same columns.
FIGURES = [("nv_registers", "regs", False), ("nv_frame", "frame", False), ("nv_spill", "spill", False),
           ("nv_bytes", "bytes", False), ("amd_registers", "VGPRs", False), ("amd_scratch", "scratch", False),
           ("amd_spill", "spill", False),
           ("intel_lanes", "SIMD", True), ("intel_bytes", "bytes", False)]


class Compilers:
    """Runs the compilers that fetch_compilers.sh has put into a folder."""

    def __init__(self, folder):
        self.root = folder / "root"
        libraries = [self.root / "usr/lib/llvm-19/lib", self.root / "usr/lib/x86_64-linux-gnu"]
        self.environment = {**os.environ, "LD_LIBRARY_PATH": ":".join(map(str, libraries))}
        self.clang = [self.root / "usr/lib/llvm-19/bin/clang", "-x", "cl", "-O3", "-nogpulib", "-Xclang",
                      "-finclude-default-header"]
        self.ocloc = self.root / "usr/bin/ocloc"
        self.ptxas = folder / "nvidia/cuda_nvcc/bin/ptxas"

    def library(self, name):
        """Returns the flags by which Clang links a library of OpenCL's builtins."""
        return ["-Xclang", "-mlink-builtin-bitcode", "-Xclang", self.root / "usr/lib/clc" / name]

    def run(self, command, folder=None):
        """Returns (what a compiler prints, seconds of processor time); raises RuntimeError if it fails."""
        done = child_process.run(command, env=self.environment, cwd=folder)
        text = done.stdout + done.stderr
        if done.exit_code != 0:
            raise RuntimeError(f"{pathlib.Path(command[0]).name} fails: {text.strip()[:MOST_MESSAGE]}")
        return text, done.processor_s


def elf_sections(path):
    """Returns {name: content} of the sections of an ELF file of 64 bits."""
    data = path.read_bytes()
    table_at, = struct.unpack_from("<Q", data, 40)  # e_shoff
    header_bytes, count, names_index = struct.unpack_from("<HHH", data, 58)  # e_shentsize, e_shnum, e_shstrndx
    headers = [struct.unpack_from("<IIQQQQIIQQ", data, table_at + i * header_bytes) for i in range(count)]
    names_at = headers[names_index][4]
    sections = {}
    for name_at, _, _, _, offset, size, *_ in headers:
        begin = names_at + name_at
        sections[data[begin:data.index(b"\0", begin)].decode()] = data[offset:offset + size]
    return sections


def occupancy(registers):
    """Returns how many warps an SM holds of a kernel that has so many registers in each work-item."""
    of_a_warp = math.ceil(max(registers, 1) * LANES / REGISTER_UNIT) * REGISTER_UNIT
    by_registers = SCHEDULERS * (SCHEDULER_REGISTERS // of_a_warp)
    return min(WARPS, min(BLOCKS, by_registers // GROUP_WARPS) * GROUP_WARPS)


# Each of these three compiles a program and returns ({kernel: {column: figure}}, seconds). source and options are those of the
# program, base is the begin of the names of its results.

def nvidia(compilers, source, options, base):
    ptx, cubin = f"{base}.ptx", pathlib.Path(f"{base}.cubin")
    _, first = compilers.run([*compilers.clang, "--target=nvptx64-nvidia-nvcl", "-Xclang", "-target-cpu", "-Xclang", "sm_80",
                              "-Xclang", "-target-feature", "-Xclang", "+ptx78", "-S", *compilers.library("nvptx64--nvidiacl.bc"),
                              *options, source, "-o", ptx])
    log, second = compilers.run([compilers.ptxas, "-v", "-O3", f"-arch={ARCHITECTURE}", ptx, "-o", cubin])
    code, found = elf_sections(cubin), {}
    for kernel, body in re.findall(r"Compiling entry function '(\w+)' for '\w+'\n(.*?)(?=ptxas info\s+: Compiling|\Z)", log, re.S):
        frame, spilled = map(int, re.search(r"(\d+) bytes stack frame, (\d+) bytes spill stores", body).groups())
        registers = int(re.search(r"Used (\d+) registers", body).group(1))
        found[kernel] = {"nv_registers": registers, "nv_frame": frame, "nv_spill": spilled,
                         "nv_bytes": len(code[f".text.{kernel}"]), "warps": occupancy(registers)}
    return found, first + second


def amd(compilers, source, options, base):
    log, seconds = compilers.run([*compilers.clang, "--target=amdgcn-amd-amdhsa", f"-mcpu={AMD}", "-S",
                                  "-Rpass-analysis=kernel-resource-usage", *compilers.library("amdgcn--amdhsa.bc"), *options,
                                  source, "-o", f"{base}.s"])
    found = {}
    for kernel, body in re.findall(r"Function Name: (\w+)(.*?)(?=Function Name|\Z)", log, re.S):
        remarks = re.findall(r"remark:[^\n]*?([A-Z][\w ]*)(?:\[[^\]]*\])?: (\d+)", body)
        number = {name.strip(): int(value) for name, value in remarks}
        found[kernel] = {"amd_registers": number["VGPRs"], "amd_scratch": number["ScratchSize"], "amd_spill": number["VGPRs Spill"],
                         "waves": number["Occupancy"]}
    return found, seconds


def intel(compilers, source, options, base):
    folder = pathlib.Path(base)
    folder.mkdir()
    _, seconds = compilers.run([compilers.ocloc, "compile", "-file", source, "-device", INTEL, "--format", "zebin",
                                "-options", " ".join(options)], folder)
    parts = elf_sections(next(folder.glob("*.bin")))
    found = {}
    for kernel in re.split(r"\n  - name: +", parts[".ze_info"].decode(errors="replace").split("kernels_misc_info")[0])[1:]:
        name = kernel.split("\n")[0].strip()
        lanes = re.search(r"\bsimd_size: +(\d+)", kernel)
        found[name] = {"intel_lanes": int(lanes.group(1)) if lanes else 0, "intel_bytes": len(parts.get(f".text.{name}", b""))}
    return found, seconds


def dump(eikon, scene, options, folder, division):
    """Returns (source, options) of the program that a GPU would get for a scene. division: as in EIKON_DIVISION"""
    folder.mkdir()
    environment = {**os.environ, "EIKON_LANES": "1", "EIKON_FAULT": "device:0:gpu", "EIKON_DUMP_PROGRAMS": str(folder),
                   "EIKON_DIVISION": division}
    subprocess.run([eikon, "render", ROOT / f"scenes/{scene}.gltf", "-o", folder / "out.exr", "--size", "8x8", "--spp", "1",
                    "--quiet", *options.split()], env=environment, check=True, stdout=subprocess.DEVNULL)
    source = next(f for f in sorted(folder.glob("*.cl")) if "kernel void compact(" in f.read_text())
    return source, source.with_suffix(".options").read_text().split()


def measure(eikon, compilers, makers, folder):
    """Compiles all PROGRAMS; returns ({(program, kernel): {column: figure}}, {(program, maker): seconds}, complaints)."""
    figures, seconds, complaints = {}, {}, []
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        wanted = [(n, name, maker, "own" if maker is intel else "driver") for n, (name, _, _, those) in enumerate(PROGRAMS)
                  for maker in makers if maker.__name__ in those]
        dumped = {(n, division): pool.submit(dump, eikon, *PROGRAMS[n][1:3], folder / f"{n}.{division}", division)
                  for n, division in {(n, division) for n, _, _, division in wanted}}
        jobs = {}
        for n, name, maker, division in wanted:
            base = str(folder / f"{n}.{maker.__name__}")
            jobs[pool.submit(maker, compilers, *dumped[n, division].result(), base)] = name, maker.__name__
        for job, (name, maker) in jobs.items():
            try:
                found, seconds[name, maker] = job.result()
            except RuntimeError as error:
                complaints.append(f"{name}, {maker}: {error}")
                continue
            for kernel in KERNELS:
                if kernel in found:
                    figures.setdefault((name, kernel), {}).update(found[kernel])
    return figures, seconds, complaints


def print_table(figures, seconds):
    """Prints what measure() returns."""
    columns = [name for name, _, _ in FIGURES]
    columns.insert(columns.index("nv_bytes") + 1, "warps")
    columns.insert(columns.index("amd_spill") + 1, "waves")
    print(f"{'':<26}{f'NVIDIA {ARCHITECTURE}':<38}{f'AMD {AMD}':<32}Intel {INTEL}")
    headings = {**{name: heading for name, heading, _ in FIGURES}, "warps": "warps", "waves": "waves"}
    print(f"{'program, kernel':<26}" + "".join(f"{headings[c]:>8}" for c in columns))
    for (program, kernel), row in figures.items():
        print(f"{program + ' ' + kernel:<26}" + "".join(f"{row.get(c, '-'):>8}" for c in columns))
    for name, *_ in PROGRAMS:
        print(f"{name}: seconds to compile: " + ", ".join(f"{m} {s:.1f}" for (n, m), s in seconds.items() if n == name))


def read_bounds():
    """Returns {(program, kernel): {column: text of a number, or "-"}} of bounds.tsv."""
    lines = [line.split("\t") for line in BOUNDS.read_text().splitlines() if line and not line.startswith("#")]
    return {(row[0], row[1]): dict(zip(lines[0][2:], row[2:])) for row in lines[1:]}


def bound_breaches(figures):
    """Returns a line for each figure beyond its bound, and for each kernel that has none."""
    found = []
    bounds = read_bounds()
    for key, row in figures.items():
        if key not in bounds:
            found.append(f"{' '.join(key)}: bounds.tsv has no row for it; --adopt writes one")
            continue
        for column, _, larger in FIGURES:
            if column in row and bounds[key][column] != "-":
                bound, figure = int(bounds[key][column]), row[column]
                if figure < bound if larger else figure > bound:
                    found.append(f"{' '.join(key)}: {column} {figure}, {'at least' if larger else 'at most'} {bound} allowed")
    return found


def write_bounds(figures):
    """Writes bounds.tsv. Registers, frames and spills are bounds as they are; code may grow as CODE_ROOM says."""
    comments = [line for line in BOUNDS.read_text().splitlines() if line.startswith("#")] if BOUNDS.exists() else []
    lines = [*comments, "\t".join(["program", "kernel", *(name for name, _, _ in FIGURES)])]
    for (program, kernel), row in figures.items():
        room = {name: row[name] + row[name] // CODE_ROOM if name.endswith("_bytes") else row[name]
                for name, _, _ in FIGURES if name in row}
        lines.append("\t".join([program, kernel, *(str(room.get(name, "-")) for name, _, _ in FIGURES)]))
    BOUNDS.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("eikon")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--adopt", action="store_true")
    arguments = parser.parse_args()
    fetched = subprocess.run([HERE / "fetch_compilers.sh", arguments.folder]).returncode
    if fetched not in (0, 3):
        print("Debian's compilers of GPUs cannot be had")
        return 77
    makers = [nvidia, amd, intel] if fetched == 0 else [amd, intel]
    with tempfile.TemporaryDirectory() as name:
        figures, seconds, complaints = measure(arguments.eikon, Compilers(arguments.folder.resolve()), makers, pathlib.Path(name))
    print_table(figures, seconds)
    if arguments.adopt and not complaints:
        write_bounds(figures)
    complaints += bound_breaches(figures)
    print(*complaints, sep="\n")
    print(f"{len(figures)} kernels, {len(complaints)} above their bounds")
    if fetched == 3 and not complaints:
        print("PyPI does not give ptxas; NVIDIA was left out")
        return 77
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
