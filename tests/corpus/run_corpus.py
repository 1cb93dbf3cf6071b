#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Loads every scene of a corpus (tools/make_corpus.py), each in a process of its own, and judges how that ended.

    run_corpus.py EIKON CORPUS [--jobs N]

A scene that loads ends with 0; one that does not with 3 and one line on stderr that begins with "eikon: ". Neither a signal,
nor a sanitizer's report, nor more than 10 s or 2 GB is ever right, and no message quotes what lies outside the scene's folder.
"""

import argparse
import concurrent.futures
import os
import subprocess
import sys
import tempfile
import time

SECONDS = 10
BYTES = 2 << 30


def run(eikon, scene):
    """(exit code or negative signal, stdout, stderr, seconds, peak bytes); exit code None: out of time."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begin = time.monotonic()
        process = subprocess.Popen([eikon, "info", scene], stdin=subprocess.DEVNULL, stdout=out, stderr=err)
        deadline = begin + SECONDS
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid != 0:
                code = os.waitstatus_to_exitcode(status)
                break
            if time.monotonic() > deadline:
                process.kill()
                _, _, usage = os.wait4(process.pid, 0)
                code = None
                break
            time.sleep(0.002)
        process.returncode = code
        out.seek(0)
        err.seek(0)
        text = [f.read().decode("utf-8", "replace") for f in (out, err)]
        return code, text[0], text[1], time.monotonic() - begin, usage.ru_maxrss * 1024


def judge(expect, code, out, err, peak):
    """What is wrong; empty if nothing is."""
    if code is None:
        return f"took more than {SECONDS} s"
    if code < 0:
        return f"ended by signal {-code}"
    if "Sanitizer" in err or "runtime error" in err:
        return "a sanitizer's report"
    if peak > BYTES:
        return f"took {peak >> 20} MB"
    if code not in (0, 3):
        return f"exit code {code}"
    if expect == "good" and code != 0:
        return "a good scene was refused"
    if expect == "bad" and code != 3:
        return "a bad scene was accepted"
    lines = err.splitlines()
    if code == 3 and (len(lines) != 1 or not lines[0].startswith("eikon: ")):
        return f"{len(lines)} lines instead of one that begins with 'eikon: '"
    if "root:x:" in out + err:
        return "shows a file outside the scene's folder"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("eikon")
    parser.add_argument("corpus")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    args = parser.parse_args()
    with open(os.path.join(args.corpus, "cases.txt"), encoding="utf-8") as file:
        cases = [line.rstrip("\n").split("\t") for line in file]

    def attempt(case):
        name, scene, expect = case
        code, out, err, seconds, peak = run(args.eikon, os.path.join(args.corpus, scene))
        return name, judge(expect, code, out, err, peak), code, err, seconds, peak

    wrong = refused = 0
    slowest = largest = 0.0
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for name, fault, code, err, seconds, peak in pool.map(attempt, cases):
            refused += code == 3
            slowest, largest = max(slowest, seconds), max(largest, peak)
            if fault:
                wrong += 1
                print(f"{name}: {fault}\n  " + "\n  ".join(err.splitlines()[:12]))
    print(
        f"{len(cases)} cases, {refused} refused, {wrong} wrong; slowest {slowest:.2f} s, largest {largest / 2**20:.0f} MB"
    )
    sys.exit(1 if wrong or len(cases) < 500 else 0)


if __name__ == "__main__":
    main()
