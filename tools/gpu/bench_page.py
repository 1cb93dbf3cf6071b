# SPDX-License-Identifier: Apache-2.0
"""The page of an archive: tables, in Markdown, of what bench_gpu.py found."""


def number(value, digits=2):
    return "-" if value is None else f"{value:.{digits}f}"


def cell(value):
    return str(value).replace("|", "\\|").replace("\n", " ")


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(cell(value) for value in row) + " |" for row in rows]) + "\n"


def power(count):
    """2^20, or the number itself where it is no power of two."""
    return f"2^{count.bit_length() - 1}" if count & (count - 1) == 0 else str(count)


def device_table(canary):
    return table(["device", "driver", "arithmetic", "lanes", "layout", "bytes of paths and scene", "seconds to compile `cornell`"],
                 [(f"{d['index']}: {d['name']}", d["driver"], d["arithmetic"], d["lanes"], d["layout"], d["device_bytes"],
                   number(d["compile_seconds"])) for d in canary["devices"]])


def programs_table(rows):
    return table(["scene", "paths of a unit", "seconds to compile"],
                 [(row["scene"], power(row["paths"]) if row["paths"] else "usual", number(row["compile_seconds"])) for row in rows])


def bits_table(rows):
    equal = sum(row["equal"] == "yes" for row in rows)
    text = f"{equal} of {len(rows)} films have the same bits as the reference's. `picture`: all pixels do, but not the exact sums.\n\n"
    return text + table(["scene", "bits equal", "relMSE", "seconds", "of the reference", "to compile", "samples left out", "events"],
                        [(row["scene"], row["equal"], "-" if row["relmse"] is None else f"{row['relmse']:.3g}", number(row["seconds"], 3),
                          number(row["reference_seconds"], 3), number(row["compile_seconds"]), row["rejected"], row["events"])
                         for row in rows])


def rays_table(rows):
    """A line for each scene, layout and number of rays, with its kinds side by side."""
    kinds = list(dict.fromkeys(row["rays"] for row in rows))
    lines = {}
    for row in rows:
        lines.setdefault((row["scene"], row["layout"], row["count"], row["device"]), {})[row["rays"]] = row
    return table(["scene", "layout", "rays", "device", *(f"{kind}, Mrays/s" for kind in kinds), "bytes"],
                 [(scene, layout, power(count), device, *(number(found[k]["mrays_per_s"], 1) if k in found else "-" for k in kinds),
                   next(iter(found.values()))["bytes"]) for (scene, layout, count, device), found in lines.items()])


def layouts_table(rows):
    return table(["scene", "layout", "Mpaths/s of the last doubling", "samples per pixel", "seconds", "relMSE (predicted)", "1 / (relMSE x s)"],
                 [(row["scene"], row["layout"], number(row["mpaths_per_s"]), row["spp"], number(row["seconds"], 3),
                   "-" if row["relmse"] is None else f"{row['relmse']:.3e}",
                   "-" if row["efficiency"] is None else f"{row['efficiency']:.3g}") for row in rows])


def units_table(rows):
    return table(["scene", "paths of a unit at most", "block", "Mpaths/s", "Mrays/s", "units", "seconds", "in kernels, %", "device, MB"],
                 [(row["scene"], power(row["paths"]), row["block"], number(row["mpaths_per_s"]), number(row["mrays_per_s"]), row["units"],
                   number(row["seconds"], 3), number(100 * row["busy"], 1), number(row["device_bytes"] / 1e6, 0)) for row in rows])


def stages_table(rows):
    lines = []
    for row in rows:
        total = row["seconds"]["render"]
        for stage in row["stages"]:
            rate = number(1e-6 * stage["items"] / stage["seconds"]) if stage["items"] and stage["seconds"] > 0 else "-"
            lines.append((row["scene"], stage["device"], stage["stage"], stage["launches"], number(1e3 * stage["seconds"], 1),
                          number(100 * stage["seconds"] / total, 1), rate, stage["bytes"] or "-"))
        for device, gaps in enumerate(row["gaps"]):
            lines.append((row["scene"], device, "gaps", gaps["count"], number(1e3 * gaps["seconds"], 1),
                          number(100 * gaps["seconds"] / total, 1), "-", "-"))
        lines.append((row["scene"], "all", "render", "-", number(1e3 * total, 1), "100.0", number(1e-6 * row["samples"] / total), "-"))
    return table(["scene", "device", "stage", "launches", "ms", "of the render, %", "M items/s", "bytes"], lines)


def luxcore_table(rows, ours):
    rates = {}  # the best of each scene
    for row in ours:
        rates[row["scene"]] = max(row["mpaths_per_s"], rates.get(row["scene"], 0))
    return table(["scene", "LuxCore, M samples/s", "eikon, M samples/s", "seconds of LuxCore", "brightness of its picture over eikon's"],
                 [(row["scene"], number(row["mpaths_per_s"]), number(rates.get(row["scene"])), number(row["seconds"]),
                   number(row["brightness"], 3)) for row in rows])


def listing(text):
    return "```\n" + text.rstrip() + "\n```\n"


def page(session, sizes_text):
    """The whole page. Sections of steps that brought nothing are left out."""
    results = session.results
    parts = ["# eikon on a GPU\n", f"Made by `{' '.join(session.command)}`. {sizes_text}\n"]
    if "canary" in results:
        parts += [f"{results['canary']['version']}\n", device_table(results["canary"])]
    parts += ["## Steps\n", table(["step", "result", "seconds"], [(s["step"], s["result"], number(s["seconds"], 1)) for s in session.steps])]
    parts.append("## What failed\n")
    parts.append(table(["step", "what", "its line"], [(f["step"], f["what"], f["line"]) for f in session.failures])
                 if session.failures else "Nothing.\n")
    sections = (
        ("bits", "Bits", bits_table),
        ("programs", "Compiling, many at a time", programs_table),
        ("rays", "Rays by layout", rays_table),
        ("layouts", "Paths by layout", layouts_table),
        ("units", "Paths by unit", units_table),
        ("stages", "Time by stage", stages_table),
        ("luxcore", "LuxCore on the same device", lambda rows: luxcore_table(rows, results.get("units", []))),
        ("devices", "`eikon devices`", lambda found: listing(found["listing"])),
        ("selftest", "`eikon selftest`", lambda found: listing(found["listing"])),
    )
    for step, title, text in sections:
        if results.get(step):
            parts += [f"## {title}\n", text(results[step])]
    parts.append("The folder `logs` has what each command printed, `results.json` all figures.\n")
    return "\n".join(parts)
