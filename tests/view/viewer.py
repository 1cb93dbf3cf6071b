# SPDX-License-Identifier: Apache-2.0
"""Starts `eikon view` and speaks to it, for the tests of this folder."""
import concurrent.futures
import http.client
import io
import json
import math
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import time
import unittest
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
CORNELL = ROOT / "scenes/cornell.gltf"
SMALL = ("--size", "64x48", "--spp", "8")
SIDE_BY_SIDE = 6
LIMIT_S = 300  # after which a test calls it a hang; programs may have to be compiled


class Viewer:
    """One `eikon view` in a folder, in which are its temporary files, too; killed at the end if it has not ended."""

    def __init__(self, eikon, folder, scene, *words, variables=None):
        self.folder = pathlib.Path(folder)
        self.process = subprocess.Popen([eikon, "view", scene, *words], cwd=folder, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True,
                                        env={**os.environ, "TMPDIR": str(folder), **(variables or {})})
        self.address = self.process.stdout.readline().strip()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/\?token=([0-9a-f]{32})", self.address)
        if not found:
            raise AssertionError(f"no address: {self.address!r}, {self.process.communicate()}")
        self.port, self.token = int(found[1]), found[2]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def end(self, number=signal.SIGINT):
        """Exit code, stdout and stderr after a signal."""
        self.process.send_signal(number)
        out, err = self.process.communicate(timeout=LIMIT_S)
        return self.process.returncode, out, err

    def wait_until_idle(self):
        """Until it has used no processor for a second."""
        begin, last = time.monotonic(), -1
        while time.monotonic() - begin < LIMIT_S:
            ticks = sum(map(int, pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]))
            if ticks - last < 3:  # of a hundredth of a second: it looks at the scene's file now and then
                return
            last = ticks
            time.sleep(1)
        raise AssertionError("never idle")

    def ask(self, method, path, body=None, headers=None):
        """Status, headers and body of an answer; headers that are None are left out."""
        everything = {"Host": f"127.0.0.1:{self.port}", "X-Eikon-Token": self.token, **(headers or {})}
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=LIMIT_S)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in everything.items():
            if value is not None:
                connection.putheader(name, value)
        if body is not None and "Transfer-Encoding" not in everything:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer.status, answer.headers, content

    def look(self, flags=None, **more):
        """Asks for a look; size 64x48 unless the flags say otherwise."""
        flags = {"--size": "64x48", **(flags or {})}
        status, _, body = self.ask("POST", "/api/look", json.dumps({"flags": flags, **more}).encode())
        if status != 200:
            raise AssertionError(body)
        return json.loads(body)["number"]

    def news(self, after=0, frame=0):
        """The text of the news, and the pixels of its frame."""
        status, _, body = self.ask("GET", f"/api/news?after={after}&frame={frame}")
        if status != 200:
            raise AssertionError(body)
        length = struct.unpack_from("<I", body)[0]
        return json.loads(body[4:4 + length]), body[4 + length:]

    def wait_for(self, state, number=0):
        """News once the look of that number, or a later one, is in that state."""
        begin = time.monotonic()
        while time.monotonic() - begin < LIMIT_S:
            news, pixels = self.news()
            if news["status"]["state"] == state and news["status"]["state_of"] >= number:
                return news, pixels
            if news["status"]["state"] == "failed" and news["status"]["state_of"] >= number:
                raise AssertionError(news["status"]["error"])
            time.sleep(0.05)
        raise AssertionError(f"never {state}: {news['status']}")


class StandInBrowser:
    """A program xdg-open that notes its words in a folder; `variables` are of a process that finds it."""

    def __init__(self, folder):
        self.noted = pathlib.Path(folder) / "xdg-open.words"
        program = pathlib.Path(folder) / "bin/xdg-open"
        program.parent.mkdir()
        program.write_text(f"#!/bin/sh\nprintf '%s\\n' \"$@\" > '{self.noted}.part' && mv '{self.noted}.part' '{self.noted}'\n")
        program.chmod(0o755)
        self.variables = {"PATH": f"{program.parent}:{os.environ['PATH']}"}

    def words(self):
        """The words with which it was started, once it was."""
        begin = time.monotonic()
        while not self.noted.exists():
            if time.monotonic() - begin > LIMIT_S:
                raise AssertionError("no browser is opened")
            time.sleep(0.02)
        return self.noted.read_text().splitlines()


def turned(scene, step):
    """A value of --look-at: the camera of `scene`, as news have it, turned around the middle by so many degrees."""
    (x, y, z), (mx, my, mz), angle = scene["view"]["eye"], scene["middle"], math.radians(step)
    dx, dz = x - mx, z - mz
    eye = (mx + dx * math.cos(angle) + dz * math.sin(angle), y, mz - dx * math.sin(angle) + dz * math.cos(angle))
    return ":".join(",".join(f"{v:.6g}" for v in point) for point in (eye, (mx, my, mz)))


def run_side_by_side():
    """Runs the tests of the script several at a time, since they wait for limits of time most of the time: each alone, but those of a
    class that share a server one after another. With arguments as unittest.main() has them, as that does."""
    if len(sys.argv) > 1:
        unittest.main()
    parts = []
    for suite in unittest.defaultTestLoader.loadTestsFromModule(sys.modules["__main__"]):
        tests = list(suite)
        parts += [unittest.TestSuite(tests)] if tests and hasattr(type(tests[0]), "viewer") else tests

    def run(part):
        text = io.StringIO()
        return unittest.TextTestRunner(text, verbosity=2).run(part), text.getvalue()

    with concurrent.futures.ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        results = list(pool.map(run, parts))
    for result, text in results:
        if not result.wasSuccessful():
            print(text)
    print(f"{sum(result.testsRun for result, _ in results)} tests, {sum(not result.wasSuccessful() for result, _ in results)} parts failed")
    sys.exit(any(not result.wasSuccessful() for result, _ in results))


def floats_of_exr(file):
    """{channel: rows of values} of an image that eikon wrote: scan lines of 32-bit floats, ZIP."""
    data = file.read_bytes()
    at, channels, window = 8, [], None
    while data[at] != 0:
        name, kind = [part.decode() for part in data[at:].split(b"\0", 2)[:2]]
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<I", data, at)[0]
        value = data[at + 4:at + 4 + size]
        at += 4 + size
        if name == "channels":
            while value[0] != 0:
                channel, value = value.split(b"\0", 1)
                if struct.unpack_from("<I", value)[0] != 2:
                    raise AssertionError(f"{channel} does not have floats")
                channels.append(channel.decode())
                value = value[16:]
        elif name == "compression" and value[0] != 3:
            raise AssertionError("not ZIP")
        elif name == "dataWindow":
            window = struct.unpack("<4i", value)
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    planes, line = {channel: [None] * height for channel in channels}, 4 * width * len(channels)
    for (offset,) in struct.iter_unpack("<Q", data[at + 1:at + 1 + 8 * math.ceil(height / 16)]):
        y, size = struct.unpack_from("<2i", data, offset)
        rows = min(16, height - (y - window[1]))
        block = unzipped(data[offset + 8:offset + 8 + size], line * rows)
        for row in range(rows):
            for c, channel in enumerate(channels):
                planes[channel][y - window[1] + row] = struct.unpack_from(f"<{width}f", block, line * row + 4 * width * c)
    return planes


def unzipped(packed, size):
    """A block of OpenEXR's ZIP compression: differences of bytes, first the even ones, then the odd ones."""
    if len(packed) == size:
        return packed
    bytes_ = bytearray(zlib.decompress(packed))
    for i in range(1, size):
        bytes_[i] = (bytes_[i - 1] + bytes_[i] - 128) & 255
    block = bytearray(size)
    block[0::2], block[1::2] = bytes_[:(size + 1) // 2], bytes_[(size + 1) // 2:]
    return bytes(block)


def rgbe_of(planes):
    """The pixels of R, G and B as a page gets them: three mantissas and a power of two, as host/page/page_picture.h has it."""
    pixels = bytearray()
    for rows in zip(planes["R"], planes["G"], planes["B"]):
        for colour in zip(*rows):
            sane = [value if math.isfinite(value) and value > 0 else 0.0 for value in colour]
            exponent = math.frexp(max(sane))[1]
            if max(sane) == 0:
                pixels += bytes(4)
            else:
                pixels += bytes([int(math.ldexp(value, 8 - exponent)) for value in sane] + [exponent + 128])
    return bytes(pixels)
