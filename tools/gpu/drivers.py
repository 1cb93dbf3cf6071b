#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs eikon on every OpenCL driver that is installed or can be fetched, each alone, and prints a table.

    drivers.py FOLDER [--eikon FILE]     FOLDER keeps the drivers that are fetched from PyPI, and the logs; nothing is installed
    drivers.py FOLDER --installed        only those that are installed

Each driver gets the self-test, the probe of memory (canary), and small renders, driven as a GPU. The bits of their films are compared
with those of the first driver, which is PoCL where it is installed. Exit codes: 0 every driver whose arithmetic is exact computes the same
bits, and eikon refuses others in one line; 1 one computes other bits, crashes or hangs; 3 there is no driver."""
import argparse
import hashlib
import pathlib
import re
import subprocess
import sys
import time
import types

from bench_page import table
from bench_session import ROOT, Failed, Session

sys.path.append(str(ROOT / "tools"))
from common.flags import add_eikon_flag  # noqa: E402

VENDORS = pathlib.Path("/etc/OpenCL/vendors")
SCENES = ["cornell", "cornell_spheres", "window_room", "textured"]
RENDER = ["--size", "16x12", "--spp", "2", "--max-depth", "5", "--guiding", "off", "--light-paths", "off", "--quiet", "--devices", "0"]
AS_GPU = {"EIKON_LANES": "1", "EIKON_FAULT": "device:0:gpu"}
MINUTES = 60

# name -> (library, variables) of drivers that packages of Debian put there without telling the
# loader, or that are off by default.
KNOWN = {
    "Oclgrind": ("/usr/lib/oclgrind/liboclgrind-rt-icd.so", {"EIKON_NO_OPTIMISE": "1", "EIKON_WATCHDOG": "3000"}),
    "Mesa rusticl": ("/usr/lib/x86_64-linux-gnu/libRusticlOpenCL.so.1", {"RUSTICL_ENABLE": "llvmpipe"}),
}
SIMULATORS = ("Oclgrind",)  # a self-test takes them more than a quarter of an hour
# name -> (packages of PyPI, pattern of the library in their folder)
FETCHED = {
    "Intel": (["intel-opencl-rt==2026.2.0", "intel-cmplr-lib-rt==2026.2.0"], "lib/libintelocl.so"),
    "PoCL of PyPI": (["pocl-binary-distribution==3.0"], "lib/python3*/site-packages/pyopencl/.libs/libpocl-*.so"),
}


class Driver:
    """A driver, and what makes it the only one that a process finds."""

    def __init__(self, name, library, variables, folder):
        self.name = name
        place = folder / "vendors" / re.sub(r"\W+", "_", name)
        place.mkdir(parents=True, exist_ok=True)
        (place / "only.icd").write_text(f"{library}\n")
        self.variables = {"OCL_ICD_VENDORS": str(place), **variables}


def installed(folder):
    """PoCL first, then all else."""
    found = []
    for file in sorted(VENDORS.glob("*.icd"), key=lambda file: "pocl" not in file.name):
        found.append(Driver({"pocl": "PoCL"}.get(file.stem, file.stem), file.read_text().strip(), {}, folder))
    libraries = [pathlib.Path(file.read_text().strip()).name for file in VENDORS.glob("*.icd")]
    for name, (library, variables) in KNOWN.items():
        if pathlib.Path(library).exists() and pathlib.Path(library).name not in libraries:
            found.append(Driver(name, library, variables, folder))
    return found


def fetched(folder):
    """(drivers, a line for each that cannot be had)"""
    found, missing = [], []
    for name, (packages, pattern) in FETCHED.items():
        place = folder / re.sub(r"\W+", "_", name)
        if not list(place.glob(pattern)):
            print(f"fetching {' '.join(packages)}", flush=True)
            pip = [place / "bin/python", "-m", "pip", "install", "--quiet", "--no-cache-dir", "--retries", "1", "--timeout", "60"]
            try:
                subprocess.run([sys.executable, "-m", "venv", place], check=True)
                subprocess.run([*pip, *packages], check=True)
            except (OSError, subprocess.CalledProcessError):
                missing.append(f"{name}: PyPI does not give {' '.join(packages)}")
                continue
        library = next(place.glob(pattern)).resolve()
        found.append(Driver(name, library, {"LD_LIBRARY_PATH": str(links(place / "links", library.parent))}, folder))
    return found, missing


def links(place, libraries):
    """A folder with links to what is beside a driver, but for a loader of its own, which would take the place of the system's."""
    place.mkdir(exist_ok=True)
    for file in libraries.iterdir():
        if not file.name.startswith("libOpenCL.so") and not (place / file.name).exists():
            (place / file.name).symlink_to(file)
    return place


class Trial:
    """A driver's row of the table."""

    def __init__(self, session, driver):
        self.session, self.driver = session, driver
        self.version = self.device = self.arithmetic = "-"
        self.selftest, self.canary, self.bits, self.notes = "-", "-", {}, []
        self.seconds = self.test_seconds = 0.0
        self.is_wrong = False

    def eikon(self, what, words, **variables):
        return self.session.eikon(f"{self.driver.name} {what}", words, {**self.driver.variables, **variables})

    def note(self, error):
        """Keeps the line of a failure. One that is no refusal of eikon's counts against the driver, or against eikon."""
        text = str(error)
        if not text.startswith("eikon: ") or error.code != 4:
            self.is_wrong = True
        text = text.removeprefix("eikon: ")
        if text not in self.notes:
            self.notes.append(text)

    def run(self, scenes, films):
        begin = time.monotonic()
        try:
            listing = self.eikon("devices", ["devices"])
            self.device = re.search(r"^0: (.*)", listing, re.M)[1]
            self.version = re.search(r", driver (.*)", listing)[1]
            self.arithmetic = re.search(r"^   arithmetic (.*)", listing, re.M)[1]
        except Failed as error:
            self.note(error)
            return
        for scene in scenes:
            self.render(scene, films)
            if self.canary == "refused":
                break
        self.seconds = time.monotonic() - begin
        self.test()
        self.test_seconds = time.monotonic() - begin - self.seconds

    def render(self, scene, films):
        path = self.session.folder / "film.exr"
        path.unlink(missing_ok=True)
        try:
            self.eikon(scene, ["render", self.session.scene(scene), "-o", self.session.folder / "out.exr", "--checkpoint", path, *RENDER],
                       **AS_GPU)
        except Failed as error:
            self.bits[scene] = "refused" if str(error).startswith("eikon: ") else "failed"
            if "not to be trusted" in str(error):
                self.canary = "refused"
            self.note(error)
            return
        self.canary = "ok"
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        self.bits[scene] = "same" if films.setdefault(scene, digest) == digest else "different"
        # Devices of one class of arithmetic have the same bits; those of another may have others.
        self.is_wrong = self.is_wrong or (self.bits[scene] == "different" and self.arithmetic == "exact")

    def test(self):
        if self.driver.name in SIMULATORS:
            self.selftest = "left out"
            return
        try:
            self.eikon("selftest", ["selftest"])
            self.selftest = "ok"
        except Failed as error:
            failed = re.findall(r"^  (\S.*?) +FAIL ", error.out, re.M)
            self.selftest = f"fails: {', '.join(failed)}" if failed else "refused"
            self.note(error)

    def row(self):
        counts = {word: sum(found == word for found in self.bits.values()) for word in ("same", "different", "refused", "failed")}
        bits = ", ".join(f"{count} {word}" for word, count in counts.items() if count) or "-"
        return (self.driver.name, self.version, self.device, self.arithmetic, self.canary, bits, f"{self.seconds:.0f}", self.selftest,
                f"{self.test_seconds:.0f}", "; ".join(self.notes) or "-")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    add_eikon_flag(parser)
    parser.add_argument("--installed", action="store_true", help="fetch nothing")
    parser.add_argument("--only", metavar="LIST", help="drivers of these names, and the first")
    parser.add_argument("--scenes", default=",".join(SCENES), metavar="LIST", help=f"shipped scenes [{','.join(SCENES)}]")
    options = parser.parse_args()
    folder = options.folder.resolve()
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    drivers, missing = installed(folder), []
    if not options.installed:
        more, missing = fetched(folder)
        drivers += more
    if options.only:
        drivers = drivers[:1] + [driver for driver in drivers[1:] if driver.name in options.only.split(",")]
    session = Session(types.SimpleNamespace(eikon=options.eikon, seconds=None), {"command_seconds": 30 * MINUTES}, folder / "runs")
    films, rows, wrong = {}, [], []
    for driver in drivers:
        trial = Trial(session, driver)
        trial.run(options.scenes.split(","), films)
        rows.append(trial.row())
        print(*rows[-1], sep=" | ", flush=True)
        wrong += [driver.name] * trial.is_wrong
    print("\n" + table(["driver", "version", "device", "arithmetic", "canary", "bits", "seconds", "self-test", "its seconds", "notes"], rows))
    print(*missing, *(f"{name}: see {session.folder}/logs" for name in wrong), sep="\n")
    print(f"{len(rows)} drivers, {len(wrong)} wrong")
    return 1 if wrong else 3 if not rows else 0


if __name__ == "__main__":
    sys.exit(main())
