# SPDX-License-Identifier: Apache-2.0
"""The steps of bench_gpu.py, in the order in which they are done. Each returns what the page shows of it."""
import hashlib
import importlib.util
import json
import os
import pathlib
import re
import shutil
import sys

from bench_session import EXECUTION_VARIABLES, ROOT, Failed, LeftOut

LAYOUTS = ("bvh2", "bvh4", "cwbvh")
# Every configuration has the same work: path tracing alone, and no pilot.
PLAIN = ("--guiding", "off", "--light-paths", "off")


def size_of(side):
    return f"{side}x{side}"


def devices(session):
    """Lists the devices, by eikon and by the tools of vendors that are installed."""
    for tool, *words in (["nvidia-smi"], ["nvidia-smi", "-q"], ["rocm-smi", "--showproductname", "--showdriverversion"], ["clinfo"],
                         ["lscpu"]):
        if shutil.which(tool):
            try:
                session.run(" ".join([tool, *words]), [tool, *words])
            except Failed:
                pass  # the log says so; eikon needs none of them
    return {"listing": session.eikon("devices", ["devices"])}


def canary(session):
    """A first small render, which runs the probes of memory and arithmetic; from it the facts about the devices."""
    stats = session.json("canary", ["render", session.scene("cornell"), "-o", session.folder / "canary.exr", "--size", "32x32", "--spp", "4",
                                    "--quiet", "--devices", session.options.devices], "--stats")
    (session.folder / "canary.exr").unlink()
    keys = ("index", "name", "driver", "arithmetic", "lanes", "layout", "device_bytes", "compile_seconds")
    return {"version": stats["version"], "devices": [{key: device[key] for key in keys} for device in stats["devices"]]}


def info(session):
    """Lists what the scenes of the measurements hold and need."""
    return session.each("info", session.sizes["scenes"],
                        lambda name: {"scene": name, "text": session.eikon(f"info {name}", ["info", session.scene(name)])})


def selftest(session):
    return {"listing": session.eikon("selftest", ["selftest", "--devices", session.options.devices])}


def feature_films(session):
    """Adds films to compare that have every feature between them: what the test data_races runs."""
    sys.path.insert(0, str(ROOT / "tests"))
    import data_races
    for write in (data_races.write_everything, data_races.write_places, data_races.write_moving):
        write(session.scratch)
    for number, (scene, options) in enumerate(data_races.RUNS):
        if scene not in session.sizes.get("feature_scenes", [scene]):
            continue
        name, made = f"run_{number}_{scene}", session.scratch / f"{scene}.gltf"
        session.made[name] = made if made.exists() else ROOT / f"scenes/{scene}.gltf"
        session.film_options[name] = re.sub(r"--memory \S+", "", options).split()
        session.sizes["film_scenes"] = [*session.sizes["film_scenes"], name]


def programs(session):
    """Compiles the programs of all films and of step `units`, many at the same time, so that the driver has them when the next steps
    ask for them one by one. On GPUs the most paths of a unit is a constant of the program."""
    cases = [(name, None) for name in session.sizes["film_scenes"]]
    if "units" in session.options.steps.split(","):
        cases += [(name, paths) for paths in {paths for paths, _ in session.sizes["units"]} for name in session.sizes["scenes"]]

    def compiled(case):
        name, paths = case
        words = session.film_options.get(name, ()) if paths is None else PLAIN
        stats = session.json(f"programs {name} {paths}",
                             ["render", session.scene(name), "-o", session.scratch / f"{name}-{paths}.exr", "--size", "8x8", "--spp", "2",
                              "--quiet", "--devices", session.options.devices, *words], "--stats",
                             None if paths is None else {"EIKON_UNIT_PATHS": str(paths)})
        return {"scene": name, "paths": paths, "compile_seconds": stats["seconds"]["compile"]}

    return session.each("programs", cases, compiled, session.options.jobs)


def render_film(session, folder, name, chosen, environment):
    """Renders the picture of a scene into the folder. returns  (digest of its film, its statistics)"""
    film = folder / f"{name}.film.exr"
    film.unlink(missing_ok=True)
    stats = session.json(f"{folder.name} {name}", ["render", session.scene(name), "-o", folder / f"{name}.exr", "--checkpoint", film, "--size",
                                                   session.sizes["film_size"], "--spp", str(session.sizes["film_spp"]), "--quiet",
                                                   "--devices", chosen, *session.film_options.get(name, ())], "--stats", environment)
    digest = hashlib.sha256(film.read_bytes()).hexdigest()
    film.unlink()
    return digest, stats


class Reference:
    """Films to compare with: rendered by another device, or kept by another run of this tool."""

    def __init__(self, session):
        self.session, self.where = session, session.options.reference
        self.kept = None
        if pathlib.Path(self.where).is_dir():
            self.folder = pathlib.Path(self.where)
            self.kept = json.loads((self.folder / "films.json").read_text())
            ours = {key: session.sizes[key] for key in ("film_size", "film_spp")}
            theirs = {key: self.kept[key] for key in ours}
            if ours != theirs:
                raise Failed(f"{self.where} has films of {theirs}, and here they have {ours}: choose the other's --quick, too")
        else:
            self.folder = session.folder / "films/reference"
            self.folder.mkdir(parents=True)

    def film(self, name):
        """(digest, seconds or None). throws Failed"""
        if self.kept is not None:
            if name not in self.kept["films"]:
                raise Failed(f"{self.where} has no film of it")
            return self.kept["films"][name], None
        digest, stats = render_film(self.session, self.folder, name, self.where, dict.fromkeys(EXECUTION_VARIABLES))
        return digest, stats["seconds"]["render"]


def verdict(session, name, same_film, folder, reference):
    """yes: the exact sums agree bit by bit. picture: they do not, but all pixels of the picture do. no: neither."""
    if same_film:
        return "yes", 0.0
    found = json.loads(session.eikon(f"compare {name}", ["compare", folder / f"{name}.exr", reference.folder / f"{name}.exr", "--json"]))
    return ("picture" if found["mse"] == 0 and found["nonfinite"] == 0 else "no"), found["relmse"]


def bits(session):
    """Renders all scenes and features small on the devices and by the reference, and compares their films."""
    folder = session.folder / "films/device"
    folder.mkdir(parents=True)
    reference = None if session.options.reference == "none" else Reference(session)
    films = {}

    def compared(name):
        films[name], stats = render_film(session, folder, name, session.options.devices, None)
        row = {"scene": name, "equal": "not compared", "relmse": None, "seconds": stats["seconds"]["render"], "reference_seconds": None,
               "compile_seconds": stats["seconds"]["compile"], "rejected": stats["rejected_samples"], "events": len(stats["events"])}
        if reference is not None:
            digest, row["reference_seconds"] = reference.film(name)
            row["equal"], row["relmse"] = verdict(session, name, digest == films[name], folder, reference)
            if row["equal"] == "no":
                session.fail("bits", name, f"the picture differs from the reference's by a relMSE of {row['relmse']:.3g}")
        return row

    try:
        return session.each("bits", session.sizes["film_scenes"], compared)
    finally:
        sizes = {key: session.sizes[key] for key in ("film_size", "film_spp")}
        (folder / "films.json").write_text(json.dumps({**sizes, "films": films}, indent=1) + "\n")


def dense(session):
    """Makes one more scene to measure, whose tree is larger than the caches of GPUs."""
    made = session.scratch / "dense.glb"
    try:
        session.run("make dense", [ROOT / "tools/make_dense.py", "--triangles", "1000000", made])
    except Failed as error:
        if "numpy" in str(error):
            raise LeftOut("it needs numpy (Debian: python3-numpy)") from error
        raise
    session.made["dense"] = made
    session.sizes["scenes"] = [*session.sizes["scenes"], "dense"]
    return {"bytes": made.stat().st_size}


def rays(session):
    """Rays a second by layout, kind of ray, and how many are traced at once."""
    rows = []

    def measured(case):
        name, layout, count = case
        rows.extend({"scene": name, "count": count, **row} for row in session.json(
            f"rays {name} {layout} {count}",
            ["bench", "rays", session.scene(name), "--devices", session.options.devices, "--layout", layout, "--rays", str(count),
             "--rounds", str(session.sizes["rounds"]), "--size", size_of(session.sizes["side"])], "--json"))

    session.each("rays", [(name, layout, count) for name in session.sizes["scenes"] for layout in LAYOUTS
                          for count in session.sizes["rays"]], measured)
    return rows


def layouts(session):
    """Error against time by layout: `eikon bench scene`, of whose points the last two give the rate."""

    def measured(case):
        name, layout = case
        found = session.json(f"layouts {name} {layout}",
                             ["bench", "scene", session.scene(name), "--devices", session.options.devices, "--layout", layout, "--spp",
                              str(session.sizes["spp"]), "--size", size_of(session.sizes["side"]), *PLAIN], "--json")
        before, last = found["points"][-2:]
        pixels = found["size"][0] * found["size"][1]
        return {"scene": name, "layout": layout, "spp": last["spp"], "seconds": last["seconds"], "relmse": last["relmse_predicted"],
                "mpaths_per_s": 1e-6 * pixels * (last["spp"] - before["spp"]) / (last["seconds"] - before["seconds"]),
                "efficiency": last["efficiency"]}

    return session.each("layouts", [(name, layout) for name in session.sizes["scenes"] for layout in LAYOUTS], measured)


def render_stats(session, log, name, environment, *more):
    """Statistics of the fastest of some renders."""
    best = None
    for number in range(session.sizes["rounds"]):
        stats = session.json(f"{log} {number}",
                             ["render", session.scene(name), "-o", session.folder / "out.exr", "--devices", session.options.devices,
                              "--spp", str(session.sizes["spp"]), "--size", size_of(session.sizes["side"]), "--quiet", *PLAIN, *more],
                             "--stats", environment)
        if best is None or stats["seconds"]["render"] < best["seconds"]["render"]:
            best = stats
    (session.folder / "out.exr").unlink()
    return best


def units(session):
    """Paths a second by the most paths of a unit, which is the pool, and by the side of its block of pixels."""

    def measured(case):
        name, paths, block = case
        stats = render_stats(session, f"units {name} {paths} {block}", name, {"EIKON_UNIT_PATHS": str(paths), "EIKON_UNIT_BLOCK": str(block)})
        kernels = sum(stage["seconds"] for stage in stats["stages"] if stage["stage"] not in ("read back", "upload"))
        seconds = stats["seconds"]["render"]
        return {"scene": name, "paths": paths, "block": block, "seconds": seconds, "units": sum(d["units"] for d in stats["devices"]),
                "mpaths_per_s": 1e-6 * stats["samples"] / seconds, "mrays_per_s": 1e-6 * stats["rays"]["total"] / seconds,
                "busy": kernels / (seconds * len(stats["devices"])), "device_bytes": max(d["device_bytes"] for d in stats["devices"])}

    return session.each("units", [(name, *unit) for name in session.sizes["scenes"] for unit in session.sizes["units"]], measured)


def stages(session):
    """Measures where the time of a render goes, driven as eikon drives the device by itself; one timeline is kept."""

    def measured(name):
        kept = ("--profile", session.folder / f"{name}.profile.json", "--report", session.folder / f"{name}.html") \
            if name == session.sizes["scenes"][0] else ()
        stats = render_stats(session, f"stages {name}", name, None, *kept)
        keys = ("device", "stage", "launches", "items", "seconds", "bytes")
        return {"scene": name, "seconds": stats["seconds"], "samples": stats["samples"], "rays": stats["rays"],
                "mean": stats["mean_radiance"],
                "stages": [{key: stage[key] for key in keys} for stage in stats["stages"]],
                "gaps": [device["gaps"] for device in stats["devices"]],
                "bounces": [[(b["paths"], b["shadow_rays"]) for b in device["bounces"]] for device in stats["devices"]]}

    return session.each("stages", session.sizes["scenes"], measured)


def luxcore(session):
    """LuxCore's path tracer on the same GPU, by its OpenCL or CUDA, on the scenes that it can be given."""
    home = pathlib.Path(os.environ.get("EIKON_VERSUS", pathlib.Path.home() / "eikon-luxcore"))
    if importlib.util.find_spec("pyluxcore") is None and not (home / "bin/python").exists():
        raise LeftOut("pyluxcore is not installed (python3 -m venv ~/eikon-luxcore && ~/eikon-luxcore/bin/pip install pyluxcore numpy)")
    side, spp = session.sizes["side"], session.sizes["spp"]

    def measured(name):
        path = session.folder / "luxcore.json"
        session.run(f"luxcore {name}", [sys.executable, ROOT / "tools/versus/luxcore_render.py", session.scene(name), "--engine", "opencl",
                                        "--size", size_of(side), "--spp", str(spp), "--warm", "--stats", path],
                    dict.fromkeys(EXECUTION_VARIABLES))
        found = json.loads(path.read_text())
        path.unlink()
        seconds, means = found["seconds"], {row["scene"]: row["mean"] for row in session.results.get("stages") or []}
        ratio = sum(found["mean"]) / sum(means[name]) if name in means else None
        if ratio is not None and not 0.8 < ratio < 1.25:
            session.fail("luxcore", name, f"its picture is {ratio:.3g} times as bright as eikon's, so its rate says nothing")
        return {"scene": name, "seconds": seconds, "mpaths_per_s": 1e-6 * side * side * spp / seconds, "brightness": ratio}

    rows = []
    for name in session.sizes["luxcore_scenes"]:
        try:
            rows.append(measured(name))
        except Failed as error:
            if error.code == 77:
                raise LeftOut(str(error)) from error
            session.fail("luxcore", name, error)
    return rows


STEPS = (devices, canary, info, selftest, programs, bits, rays, layouts, units, stages, luxcore)
