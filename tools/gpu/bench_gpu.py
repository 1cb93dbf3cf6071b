#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures eikon on GPUs and leaves one archive (.tar.gz) with a page of tables, all figures and the logs.

    tools/bench_gpu.sh [--eikon FILE] [--devices LIST] [--reference LIST|FOLDER|none] [--out FILE.tar.gz] [--quick]

A step that fails is recorded with its line, and the others go on. Exit codes: 0 all is well; 1 something failed, and the page says
what; 2 usage; 3 the archive cannot be written, or eikon cannot be started; 4 there is no such device."""
import argparse
import json
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tarfile
import tempfile

import bench_page
import bench_steps
from bench_session import EXECUTION_VARIABLES, ROOT, Session

NAMES = [step.__name__ for step in bench_steps.STEPS]
NAME = "eikon-gpu"  # of the folder in the archive

# Units of (most paths, side of the block of pixels). A unit has at most 16 samples of a pixel where
# the image has up to 64, so blocks of 128 fill 2^18 paths, of 256 2^20 and of 512 2^22.
FULL = {"film_size": "96x64", "film_spp": 16, "scenes": ["cornell", "cornell_spheres", "window_room", "lacquer"], "side": 1024, "spp": 64,
        "rays": [1 << 20, 1 << 22, 1 << 24], "rounds": 3, "luxcore_scenes": ["cornell", "cornell_spheres", "window_room"],
        "units": [(1 << 20, 256), (1 << 22, 512), (1 << 23, 512), (1 << 24, 1024), (1 << 25, 1024)], "command_seconds": 600}
QUICK = {"film_size": "24x16", "film_spp": 4, "scenes": ["cornell"], "side": 48, "spp": 4, "rays": [1 << 12], "rounds": 1,
         "luxcore_scenes": ["cornell"], "units": [(1 << 12, 32), (1 << 20, 128)], "command_seconds": 120,
         "film_scenes": ["cornell", "nori_triangle_1"], "feature_scenes": ["moving"]}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, prog="bench_gpu.sh")
    parser.add_argument("--eikon", help="the program; without it, bench_gpu.sh builds one")
    parser.add_argument("--devices", default="gpu", metavar="LIST", help="as in `eikon render` [gpu]")
    parser.add_argument("--reference", default="cpu", metavar="LIST|FOLDER|none",
                        help="whose films the bits are compared with: another device's, or the folder films/device of another archive [cpu]")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path(f"{NAME}.tar.gz"), metavar="FILE.tar.gz",
                        help=f"the archive [{NAME}.tar.gz]")
    parser.add_argument("--quick", action="store_true", help="small scenes and sizes: whether all of it works, not how fast it is")
    parser.add_argument("--steps", default=",".join(NAMES), metavar="LIST", help=f"only these [{','.join(NAMES)}]")
    parser.add_argument("--scenes", metavar="LIST", help="shipped scenes whose bits are compared [all, and scenes with the other features]")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N",
                        help="programs that are compiled at the same time [as many as there are cores]")
    parser.add_argument("--seconds", type=float, metavar="N", help="begin nothing after so long, for machines that are lent by the minute")
    parser.add_argument("--side", type=int, metavar="N", help=f"of the pictures that are measured, in pixels [{FULL['side']}]")
    parser.add_argument("--spp", type=int, metavar="N", help=f"of them [{FULL['spp']}]")
    options = parser.parse_args()
    if not options.eikon:
        parser.error("--eikon FILE is missing")
    unknown = sorted(set(options.steps.split(",")) - set(NAMES))
    if unknown:
        parser.error(f"--steps: there is no step {', '.join(unknown)}; there are {', '.join(NAMES)}")
    if options.jobs < 1:
        parser.error("--jobs takes 1 or more")
    if options.spp is not None and options.spp < 2 or options.side is not None and options.side < 1:
        parser.error("--spp takes 2 or more, --side 1 or more")
    return options


def stop(code, line):
    print(f"bench_gpu.sh: {line}", file=sys.stderr)
    sys.exit(code)


def sizes_of(options):
    sizes = {**(QUICK if options.quick else FULL)}
    shipped = sorted(path.stem for path in (ROOT / "scenes").glob("*.gltf"))
    chosen = options.scenes.split(",") if options.scenes else sizes.get("film_scenes", shipped)
    for name in chosen:
        if name not in shipped:
            stop(2, f"--scenes: scenes/{name}.gltf is not there; see scenes/README.md")
    sizes["film_scenes"] = chosen
    return {**sizes, **{key: value for key in ("side", "spp") if (value := getattr(options, key)) is not None}}


def require_eikon(eikon):
    """Ends here if the program cannot be run."""
    try:
        version = subprocess.run([eikon, "--version"], capture_output=True, text=True, errors="replace")
    except OSError as error:
        stop(3, f"{eikon}: {error.strerror}; name the program by --eikon")
    if version.returncode != 0:
        stop(3, f"{eikon} --version ends with exit code {version.returncode}: it cannot be run here (ldd says which library it misses)")


def require_devices(session):
    """Ends here if eikon finds no devices of these names, or does not take the names: then nothing can be measured."""
    for failure in session.failures:
        if failure["line"].startswith(("--devices", "no OpenCL device")):
            shutil.rmtree(session.folder)
            stop(failure["code"], failure["line"])


def write_archive(folder, path):
    partial = path.with_name(path.name + ".partial")
    try:
        with tarfile.open(partial, "w:gz") as archive:
            archive.add(folder, NAME)
        partial.replace(path)
    except OSError:
        partial.unlink(missing_ok=True)
        raise


def require_writable(path):
    """Ends here, before anything is measured, if the archive cannot be written."""
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent or ".", prefix=path.name):
            pass
    except OSError as error:
        stop(3, f"{path}: cannot be written: {error.strerror}; name another place by --out")
    if path.is_dir():
        stop(3, f"{path}: is a folder; name a file by --out")


def measure(session):
    """Does the steps that were asked for, and always the first two, which say what the devices are."""
    chosen = session.options.steps.split(",")
    first, rest = bench_steps.STEPS[:2], bench_steps.STEPS[2:]
    for step in first:
        session.do(step.__name__, step)
    require_devices(session)
    if not session.options.quick and {"rays", "layouts", "units", "stages"} & set(chosen):
        session.do("dense", bench_steps.dense)
    if not session.options.scenes and {"programs", "bits"} & set(chosen):
        bench_steps.feature_films(session)
    for step in rest:
        if step.__name__ in chosen:
            session.do(step.__name__, step)


def write_results(session):
    sizes = session.sizes
    variables = {name: os.environ[name] for name in EXECUTION_VARIABLES if name in os.environ}
    text = (f"Bits: {len(sizes['film_scenes'])} scenes, {sizes['film_size']}, {sizes['film_spp']} samples per pixel. "
            f"Rates: {sizes['side']}x{sizes['side']}, {sizes['spp']} samples per pixel, without pilot and light paths, the best of "
            f"{sizes['rounds']}. Variables: {' '.join(f'{k}={v}' for k, v in variables.items()) or 'none'}.")
    (session.folder / "page.md").write_text(bench_page.page(session, text))
    (session.folder / "results.json").write_text(json.dumps(
        {"command": session.command, "variables": variables, "sizes": sizes, "steps": session.steps, "failures": session.failures,
         **session.results}, indent=1) + "\n")


def main():
    options = arguments()
    sizes = sizes_of(options)
    require_writable(options.out)
    require_eikon(options.eikon)
    folder = pathlib.Path(tempfile.mkdtemp(prefix=NAME))
    with tempfile.TemporaryDirectory(prefix=NAME) as scratch:
        session = Session(options, sizes, folder, pathlib.Path(scratch))
        session.command = ["tools/bench_gpu.sh", *map(shlex.quote, sys.argv[1:])]
        measure(session)
    write_results(session)
    try:
        write_archive(folder, options.out)
    except OSError as error:
        stop(3, f"{options.out}: cannot be written: {error.strerror}; all of it is in {folder}")
    shutil.rmtree(folder)
    failed = len(session.failures)
    print(f"{options.out}: {failed} failed; {NAME}/page.md in it says what and how fast" if failed
          else f"{options.out}: all is well; {NAME}/page.md in it says how fast")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
