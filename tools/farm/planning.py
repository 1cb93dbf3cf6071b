# SPDX-License-Identifier: Apache-2.0
"""`plan`: seconds by number of nodes, what limits, and how many nodes are worth it."""
import difflib
import json
import math

from . import errors, flags, jobs, simulate, status, submit

WORTH = 1.5  # twice as many nodes are worth it while they make it so many times faster


def add_plan(commands):
    """The flags of `plan`."""
    parser = commands.add_parser("plan", allow_abbrev=False, help="seconds by number of nodes, from a measured run",
                                 description="Everything that is not listed here is a flag of `eikon render` for SCENE.")
    parser.add_argument("input", metavar="JOBS.txt|SCENE", nargs="?", help="what would be rendered")
    parser.add_argument("--work", metavar="SECONDS,SPP,STARTUP,MB,MERGE", help="invented instead of measured: seconds of "
                        "one node for an image of so many samples per pixel, of start-up, megabytes of a part, and seconds "
                        "of merging it")
    parser.add_argument("--most", type=flags.NODES, default=1024, metavar="NODES", help="the most nodes [1024]")
    parser.add_argument("--spread", type=flags.SHARE, default=0.1, metavar="SHARE", help="speeds of nodes differ by so much [0.1]")
    parser.add_argument("--failures", type=flags.PER_HOUR, default=0.01, metavar="N", help="of a node in an hour [0.01]")
    parser.add_argument("--preemptions", type=flags.PER_HOUR, default=0.0, metavar="N", help="of a node in an hour [0]")
    parser.add_argument("--errors", type=flags.SHARE, default=0.0, metavar="SHARE", help="of attempts that end with a device error [0]")
    parser.add_argument("--disk", type=flags.DISK_MB_S, default=1000.0, metavar="MB/S", help="of the file system, for all nodes [1000]")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the invented failures [1]")
    parser.add_argument("--json", metavar="FILE", help="write the table as JSON")
    parser.add_argument("--svg", metavar="FILE", help="draw it")
    parser.add_argument("--cpus", type=flags.THREADS, default=1, metavar="N", help="threads of each node [1]")
    parser.add_argument("--eikon", metavar="FILE", help="the program [that in PATH]")
    parser.add_argument("--measure", type=flags.MEASURED_S, default=0.1, metavar="SECONDS", help="of the measured run, about [0.1]")
    parser.set_defaults(run=plan)


# The numbers of --work: their names and ranges.
INVENTED = (("SECONDS", 0.001, 1e9), ("SPP", 1, 1e9), ("STARTUP", 0, 1e5), ("MB", 0, 1e6), ("MERGE", 0, 1e5))


def invented(options):
    """The work that --work says. Nothing else says what is rendered beside it."""
    if options.input or options.render:
        word = (options.render or [options.input])[0]
        known = ("--most", "--spread", "--failures", "--preemptions", "--errors", "--disk", "--seed", "--json", "--svg")
        like = difflib.get_close_matches(word.split("=")[0], known, 1)
        raise errors.FarmError(f"plan: {word}: --work stands alone, without a scene and flags of a render"
                               + (f"; did you mean {like[0]}?" if like else ""), errors.USAGE)
    numbers = [flags.number_of(text) for text in options.work.split(",")]
    if len(numbers) != len(INVENTED):
        raise errors.FarmError(f"plan: --work {options.work}: takes {','.join(name for name, _, _ in INVENTED)}", errors.USAGE)
    for value, text, (name, least, most) in zip(numbers, options.work.split(","), INVENTED):
        if not least <= value <= most or name == "SPP" and value % 1:
            kind = "a whole number" if name == "SPP" else "a number"
            raise errors.FarmError(f"plan: --work {options.work}: {name} '{text}' is not {kind} from {least:g} to {most:g}",
                                   errors.USAGE)
    seconds, spp, startup, megabytes, merge = numbers
    return simulate.Work([seconds], int(spp), startup, megabytes, merge)


def work_of(options):
    """Returns the simulate.Work to be done: as it was measured, or as the user invents it. Raises errors.FarmError if there is
    neither."""
    if options.work is not None:
        return invented(options)
    if not options.input:
        raise errors.FarmError("name a jobs file or a scene, or invent one with --work", errors.USAGE)
    eikon = jobs.find_eikon(options.eikon)
    text, base, name, _ = submit.read_input(options)
    images = jobs.read_jobs(eikon, text, base, name)
    largest = max(images, key=lambda job: job.sample_count)
    measured = jobs.measure(eikon, largest, base, options.cpus, options.measure)
    largest.size = measured.size
    merge_s = jobs.measure_merge(eikon, largest, base)
    megabytes = measured.part_bytes / 1e6
    print(f"measured: {measured.samples_per_second / 1e6:.2f} Msamples/s, start-up {measured.startup_s:.2f} s, "
          f"{megabytes:.1f} MB a part, {merge_s:.3f} s to merge one")
    return simulate.Work([measured.seconds(job) for job in images], max(job.samples[1] - job.samples[0] for job in images),
                         measured.startup_s, megabytes, merge_s, measured.finish_s)


def table_of(work, options):
    """Returns a row for each power of two of nodes, up to the most: {"nodes", "seconds", "done": whether all images were written,
    ...}."""
    numbers = sorted({2 ** power for power in range(int(math.log2(max(1, options.most))) + 1)} | {options.most})
    rows = []
    for nodes in numbers:
        cluster = simulate.Cluster(nodes, options.spread, options.failures, preemptions_per_hour=options.preemptions,
                                   errors=options.errors, disk_mb_s=options.disk, seed=options.seed)
        out = simulate.simulate(work, cluster)
        rows.append({"nodes": nodes, "seconds": out.seconds, "parts": out.parts, "tasks": out.tasks, "starts": out.starts,
                     "failed": out.failed, "unfinished": out.unfinished, "done": out.is_done(),
                     "merge_seconds": out.merge_s, "lost_seconds": out.lost_s, "limit": out.limit(nodes)})
    return rows


def nodes_worth_it(rows):
    """Returns the largest number of nodes up to which each doubling is worth it; 0 if the first row is not done.

    rows: those of table_of(), by rising numbers of nodes."""
    best = rows[0]["nodes"] if rows[0]["done"] else 0
    for before, row in zip(rows, rows[1:]):
        doublings = math.log2(row["nodes"] / before["nodes"])
        if not best or not row["done"] or before["seconds"] / row["seconds"] < WORTH ** doublings:
            break
        best = row["nodes"]
    return best


def print_table(rows):
    """Prints the table. A row that is not done has no time."""
    print(f"{'nodes':>6} {'time':>10} {'faster':>7} {'parts':>6} {'failed':>6} {'tasks':>6} {'starts':>6} {'merge':>7}  "
          "limited by")
    for row in rows:
        time, faster, merge = "not done", "-", "-"
        if row["done"]:
            time, merge = status.in_words(row["seconds"]), status.in_words(row["merge_seconds"])
            if rows[0]["done"]:
                faster = f"{rows[0]['seconds'] / row['seconds']:.1f}"
        print(f"{row['nodes']:>6} {time:>10} {faster:>7} {row['parts']:>6} {row['failed']:>6} {row['tasks']:>6} "
              f"{row['starts']:>6} {merge:>7}  {row['limit']}")


def plan(options):
    """Does what the command `plan` says: prints the table, and writes it as JSON and as a drawing where flags ask for it."""
    rows = table_of(work_of(options), options)
    print_table(rows)
    best = nodes_worth_it(rows)
    print(f"up to {best} nodes, each doubling makes it at least {WORTH} times faster" if best else
          "one node does not write all images: there is no time to compare others with")
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump({"rows": rows, "worth": best}, file, indent=1)
    if options.svg:
        done = [row for row in rows if row["done"]]
        if not done:
            raise errors.FarmError(f"{options.svg}: no number of nodes writes all images, so nothing was drawn: try fewer "
                                   "--failures or --errors", errors.NOT_AS_ASKED)
        with open(options.svg, "w", encoding="utf-8") as file:
            file.write(drawing(done))
    return 0


def drawing(rows):
    """Seconds against nodes, both logarithmic, beside the line of a perfect division."""
    width, height, margin = 480, 320, 50
    most = max(math.log10(rows[-1]["nodes"]), 0.3)
    perfect = rows[0]["seconds"] * rows[0]["nodes"] / rows[-1]["nodes"]
    times = [row["seconds"] for row in rows] + [perfect]
    low, high = math.floor(math.log10(min(times))), math.ceil(math.log10(max(times)))

    def place(nodes, seconds):
        x = margin + (width - 2 * margin) * math.log10(nodes) / most
        y = height - margin - (height - 2 * margin) * (math.log10(seconds) - low) / max(high - low, 1)
        return f"{x:.1f},{y:.1f}"

    points = [place(row["nodes"], row["seconds"]) for row in rows]
    marks = "".join(f'<circle cx="{point.split(",")[0]}" cy="{point.split(",")[1]}" r="3" fill="#06c"><title>'
                    f'{row["nodes"]} nodes: {row["seconds"]:.1f} s, limited by {row["limit"]}</title></circle>'
                    for point, row in zip(points, rows))
    labels = "".join(f'<text x="{margin - 6}" y="{place(1, 10.0 ** power).split(",")[1]}" text-anchor="end">1e{power} s</text>'
                     for power in range(low, high + 1))
    labels += "".join(f'<text x="{place(10 ** power, 10.0 ** low).split(",")[0]}" y="{height - margin + 16}" '
                      f'text-anchor="middle">{10 ** power}</text>' for power in range(int(most) + 1))
    ideal = f'{place(rows[0]["nodes"], rows[0]["seconds"])} {place(rows[-1]["nodes"], perfect)}'
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="11">'
            f'<rect width="{width}" height="{height}" fill="#fff"/><polyline points="{ideal}" fill="none" stroke="#bbb"/>'
            f'<polyline points="{" ".join(points)}" fill="none" stroke="#06c" stroke-width="2"/>{marks}{labels}'
            f'<text x="{width / 2}" y="{height - 8}" text-anchor="middle">nodes</text></svg>\n')
