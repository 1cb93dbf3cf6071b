# SPDX-License-Identifier: Apache-2.0
"""What `resubmit` does about parts and merged files that stand in the way of a merge."""
import os
import pathlib

from . import merging, scripts, status

# XXH64, by which `eikon batch` knows the files of its ledger: four sums of 64 bits, here in one integer, 128 bits apart.
PRIMES = (0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5)
ONE_SUM = (1 << 64) - 1
ALL_SUMS = sum(ONE_SUM << 128 * lane for lane in range(4))
PIECE = 1 << 16  # bytes


def rotate(value, bits, mask=ONE_SUM):
    """A sum, or all four, turned left by so many bits."""
    return (value << bits | value >> 64 - bits) & mask


def stripes(sums, piece):
    """The four sums after a piece of whole stripes of 32 bytes."""
    spread = bytearray(2 * len(piece))
    for byte in range(8):
        spread[byte::16] = piece[byte::8]
    times = (int.from_bytes(spread, "little") * PRIMES[1]).to_bytes(len(spread) + 8, "little")
    for at in range(0, len(spread), 64):
        sums = sums + (int.from_bytes(times[at:at + 64], "little") & ALL_SUMS) & ALL_SUMS
        sums = rotate(sums, 31, ALL_SUMS) * PRIMES[0] & ALL_SUMS
    return sums


def round_of(value, word):
    """A sum after a word of 8 bytes."""
    return rotate(value + word * PRIMES[1] & ONE_SUM, 31) * PRIMES[0] & ONE_SUM


def last_bytes(value, tail):
    """The hash, of the sum so far and the last bytes."""
    one, two, three, four, five = PRIMES
    while len(tail) >= 8:
        value = rotate(value ^ round_of(0, int.from_bytes(tail[:8], "little")), 27) * one + four & ONE_SUM
        tail = tail[8:]
    if len(tail) >= 4:
        value = rotate(value ^ int.from_bytes(tail[:4], "little") * one & ONE_SUM, 23) * two + three & ONE_SUM
        tail = tail[4:]
    for byte in tail:
        value = rotate(value ^ byte * five & ONE_SUM, 11) * one & ONE_SUM
    value = (value ^ value >> 33) * two & ONE_SUM
    value = (value ^ value >> 29) * three & ONE_SUM
    return value ^ value >> 32


def hash_of(path):
    """The XXH64 of a file in 16 hex digits, as the ledgers have it; some 20 MB in a second."""
    one, two, _, four, five = PRIMES
    start = [one + two & ONE_SUM, two, 0, -one & ONE_SUM]
    sums, size, tail = sum(value << 128 * lane for lane, value in enumerate(start)), 0, b""
    with open(path, "rb") as file:
        while piece := file.read(PIECE):
            size += len(piece)
            whole = len(piece) - len(piece) % 32
            sums, tail = stripes(sums, piece[:whole]), piece[whole:]
    value = five
    if size >= 32:
        each = [sums >> 128 * lane & ONE_SUM for lane in range(4)]
        value = sum(rotate(one_sum, bits) for one_sum, bits in zip(each, (1, 7, 12, 18))) & ONE_SUM
        for one_sum in each:
            value = (value ^ round_of(0, one_sum)) * one + four & ONE_SUM
    return f"{last_bytes(value + size & ONE_SUM, tail):016x}"


def is_whole(farm, entry):
    """Whether the files of a ledger's entry have the bytes that were written."""
    try:
        return all(hash_of(os.path.join(farm.base, output["path"])) == output["hash"] for output in entry["outputs"])
    except OSError:
        return False


def doubtful(farm, job):
    """(parts, merged files) that may be damaged, of an image whose last merge has failed: the parts that no merged file stands
    for, and what a merge that began and failed has read."""
    parts, merged = [], []
    if pathlib.Path(farm.base, scripts.done_mark(farm, job, job.output)).exists():
        return parts, merged
    for level, merges in enumerate(merging.tree(farm, job)):
        for inputs, output in merges:
            mark = pathlib.Path(farm.base, scripts.done_mark(farm, job, output))
            if level == 0 and not mark.exists():
                parts += inputs
            if level > 0 and pathlib.Path(f"{mark}.new").exists():
                merged += inputs
    return parts, merged


def remove(farm, *names):
    """Removes files that may not be there."""
    for name in names:
        pathlib.Path(farm.base, name).unlink(missing_ok=True)


def repair(farm, states):
    """Sees to it that merges find what they need. A task that is killed has not marked its parts, so what the ledgers call done
    is marked here. Of images that could not be merged, damaged parts are removed, so that they are rendered again."""
    for state in states:
        mark = pathlib.Path(farm.base, f"{state.item.output}.done")
        if state.item.job.parts and state.state == "done" and not mark.exists():
            mark.write_text("\n")
    of_output = {state.item.output: state for state in states}
    for job in status.unwritten(farm, states):
        parts, merged = doubtful(farm, job)
        remove(farm, *(f"{name}.done" for name in merged))
        if parts:
            print(f"{job.name} was not merged: checking {len(parts)} parts ...", flush=True)
        for name in parts:
            if not is_whole(farm, of_output[name].entry):
                print(f"{name} is damaged: it is rendered again")
                remove(farm, f"{name}.done", name)
                of_output[name].state = "failed"
