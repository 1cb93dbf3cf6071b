#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The server of `eikon view`: whom it answers, what it takes, and that attacks do it no harm.

  tests/view/server_test.py EIKON [unittest arguments]

A build with EIKON_SANITIZE=address,undefined passes, too, with ASAN_OPTIONS=use_sigaltstack=0: LLVM in PoCL sets signal stacks."""
import concurrent.futures
import contextlib
import json
import os
import pathlib
import random
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from viewer import CORNELL, LIMIT_S, SMALL, Viewer, run_side_by_side

EIKON = ""


class Served(unittest.TestCase):
    """One server for all tests of a class."""
    viewer = None

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="eikon_view_"))
        cls.viewer = Viewer(EIKON, cls.folder, CORNELL, *SMALL)
        cls.viewer.wait_for("done")

    @classmethod
    def tearDownClass(cls):
        ended = cls.viewer.process.poll()
        code, _, err = cls.viewer.end() if ended is None else (ended, "", "")
        shutil.rmtree(cls.folder)
        if code != 0 or err:
            raise AssertionError(f"exit code {code}, stderr {err!r}")

    def assert_alive(self):
        self.assertIsNone(self.viewer.process.poll(), "the server has ended")
        self.assertEqual(self.viewer.news()[0]["status"]["state"], "done")


class Guard(Served):
    def page(self, **headers):
        return self.viewer.ask("GET", f"/?token={self.viewer.token}", headers={"X-Eikon-Token": None, **headers})

    def test_the_page_comes_with_its_token_and_nothing_of_other_servers(self):
        status, headers, body = self.page()
        self.assertEqual(status, 200)
        self.assertIn("default-src 'none'", body.decode())
        for outside in ("https://", "@import", "url("):
            self.assertNotIn(outside, body.decode())
        self.assertEqual(headers["X-Frame-Options"], "DENY")
        self.assertEqual(headers["Cache-Control"], "no-store")
        self.assertIsNone(headers["Access-Control-Allow-Origin"])

    def test_nobody_gets_anything_without_the_token(self):
        for token in (None, "", "0" * 32, self.viewer.token[:-1], self.viewer.token + "0", self.viewer.token.upper()):
            for method, path in (("GET", "/api/news?after=0&frame=0"), ("POST", "/api/look"), ("GET", "/api/path?x=1&y=1&sample=0"),
                                 ("POST", "/api/render"), ("POST", "/api/stop"), ("GET", "/nothing"), ("OPTIONS", "/api/look")):
                status, _, body = self.viewer.ask(method, path, b"{}" if method == "POST" else None, {"X-Eikon-Token": token})
                self.assertEqual((status, "token" in body.decode()), (403, True), (token, path))
            status, _, _ = self.viewer.ask("GET", f"/?token={token or ''}", headers={"X-Eikon-Token": None})
            self.assertEqual(status, 403, token)
        # The header opens no page, so that no address without the token shows one; nor does the
        # address open the rest.
        self.assertEqual(self.viewer.ask("GET", "/")[0], 403)
        status, _, _ = self.viewer.ask("GET", f"/api/news?after=0&frame=0&token={self.viewer.token}", headers={"X-Eikon-Token": None})
        self.assertEqual(status, 403)

    def test_names_of_other_servers_that_lead_here_are_refused(self):
        port = self.viewer.port
        for host in (f"127.0.0.1:{port}", f"localhost:{port}", f"[::1]:{port}", "localhost:8080", "localhost"):
            self.assertEqual(self.page(Host=host)[0], 200, host)
        for host in (None, "", "example.com", f"example.com:{port}", "localhost.example.com", "127.0.0.1.example.com", "localhost:1:2",
                     "localhost:x", "[::1", "0.0.0.0", "127.0.0.1@example.com"):
            self.assertEqual(self.page(Host=host)[0], 403 if host is not None else self.page(Host="")[0], host)

    def test_pages_of_other_origins_are_refused(self):
        here = f"127.0.0.1:{self.viewer.port}"
        self.assertEqual(self.page(Origin=f"http://{here}")[0], 200)
        for origin in ("null", "http://example.com", f"https://{here}", "http://127.0.0.1:1", f"http://localhost:{self.viewer.port}"):
            self.assertEqual(self.page(Origin=origin)[0], 403, origin)
        for site, status in (("same-origin", 200), ("none", 200), ("cross-site", 403), ("same-site", 403)):
            self.assertEqual(self.page(**{"Sec-Fetch-Site": site})[0], status, site)
        # The file of --open, which has the token, leads to the page; nothing else is open to it,
        # nor the page to frames and scripts.
        leads = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}
        self.assertEqual(self.page(**leads)[0], 200)
        self.assertEqual(self.page(**{**leads, "Sec-Fetch-Dest": "iframe"})[0], 403)
        self.assertEqual(self.viewer.ask("GET", "/", headers=leads)[0], 403)
        self.assertEqual(self.viewer.ask("GET", "/api/news?after=0&frame=0", headers=leads)[0], 403)

    def test_it_listens_on_the_loopback_address_alone(self):
        listening = [line.split()[1] for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]
                     if line.split()[3] == "0A" and int(line.split()[1].split(":")[1], 16) == self.viewer.port]
        self.assertEqual([address.split(":")[0] for address in listening], ["0100007F"])
        wide = [line for line in pathlib.Path("/proc/net/tcp6").read_text().splitlines()[1:]
                if line.split()[3] == "0A" and int(line.split()[1].split(":")[1], 16) == self.viewer.port]
        self.assertEqual(wide, [])

    def test_no_path_leads_to_a_file(self):
        for path in ("/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/etc/passwd", "//etc/passwd", "/..%2f..%2fetc%2fpasswd",
                     "/cornell.gltf", "/api/../../etc/passwd", "/%00", "/api/news/../../../etc/passwd", "file:///etc/passwd"):
            status, _, body = self.viewer.ask("GET", path)
            self.assertIn(status, (400, 404), path)
            self.assertNotIn(b"root:", body)


class Limits(Served):
    def refused(self, body, **headers):
        status, _, answer = self.viewer.ask("POST", "/api/look", body, headers)
        self.assertEqual(status, 400, answer)
        self.assertTrue(json.loads(answer)["error"].startswith("view: "), answer)
        return json.loads(answer)["error"]

    def test_flags_that_name_files_or_devices_are_refused_in_one_line(self):
        flags = {"--output": "/tmp/x.exr", "--stats": "x", "--devices": "all", "--checkpoint": "x", "-o": "x", "SCENE": "/etc/passwd",
                 "--env": "/etc/passwd", "--memory": "1", "--png": "x.png", "": "x"}
        for name, value in flags.items():
            line = self.refused(json.dumps({"flags": {"--size": "64x48", name: value}}).encode())
            self.assertIn("--env" if name == "--env" else "may not give", line)
            self.assertNotIn("\n", line)

    def test_what_is_no_look_is_refused_in_one_line(self):
        for body in (b"", b"{", b"[]", b"1", b"null", b"\xff\xfe", b'{"flags": 1}', b'{"flags": {"--size": "64x48"}, "other": 1}',
                     b'{"flags": {"--size": 4}}', b'{"flags": {}}', b'{"flags": {"--size": "0x48"}}', b'{"flags": {"--size": "64x99999"}}',
                     b'{"flags": {"--size": "64x48x1"}}', b'{"flags": {"--size": "64x48"}, "layer": "/etc/passwd"}',
                     b'{"flags": {"--size": "64x48"}, "mix": {"a": -1}}', b'{"flags": {"--size": "64x48"}, "mix": {"a": 1e999}}',
                     b'{"flags": {"--size": "64x48"}, "moving": 1}', b'{"flags": {"--size": "64x48", "--fov": ""}}',
                     b'{"flags": {"--size": "64x48", "--camera": "' + b"x" * 500 + b'"}}', b"[" * 5000, b'{"a":' * 5000):
            self.assertNotIn("\n", self.refused(body), body)
        self.assert_alive()

    def test_bodies_have_a_limit_and_one_form(self):
        self.refused(b"x" * 70000)
        self.refused(b"{}", **{"Content-Encoding": "gzip"})
        self.refused(b"{}", **{"Content-Type": "multipart/form-data; boundary=x"})
        self.refused(b"2\r\n{}\r\n0\r\n\r\n", **{"Transfer-Encoding": "chunked"})
        self.assertEqual(self.viewer.ask("POST", "/api/look", b"{}", {"Range": "bytes=0-1"})[0], 400)
        self.assert_alive()

    def test_values_that_render_refuses_show_its_line(self):
        for name, value in (("--fov", "999"), ("--look-at", "1,2"), ("--camera", "nobody"), ("--scene-time", "soon"), ("--variant", "none")):
            words = ["render", CORNELL, f"{name}={value}", "-o", "x.exr", "--size", "8x8", "--spp", "1", "--quiet"]
            line = subprocess.run([EIKON, *words], cwd=self.folder, capture_output=True, text=True, check=False).stderr
            number = self.viewer.look({"--spp": "8", name: value})
            try:
                self.viewer.wait_for("done", number)
                self.fail(f"{name}={value} was taken")
            except AssertionError as error:
                self.assertEqual(f"eikon: {error}\n", line)
        self.viewer.wait_for("done", self.viewer.look({"--spp": "8"}))

    def test_there_are_no_pixels_beyond_the_picture(self):
        for query in ("x=64&y=0&sample=0", "x=0&y=48&sample=0", "x=-1&y=0&sample=0", "x=0&y=0&sample=99999999999", "x=0&y=0", "", "x=a&y=b&sample=c"):
            self.assertEqual(self.viewer.ask("GET", "/api/path?" + query)[0], 400, query)


class Orders(unittest.TestCase):
    """Orders that come at the same time, each test to a server of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="eikon_view_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def at_once(self, count, call):
        """What call(number) returns for each number, all of them called at the same time."""
        ready = threading.Barrier(count)

        def wait_and_call(number):
            ready.wait()
            return call(number)

        with concurrent.futures.ThreadPoolExecutor(count) as pool:
            return list(pool.map(wait_and_call, range(count)))

    def test_one_of_many_orders_to_render_is_taken(self):
        with Viewer(EIKON, self.folder, CORNELL, "--size", "64x48", "--spp", "100000000") as viewer:
            viewer.wait_for("rendering")
            for _ in range(8):
                answers = self.at_once(4, lambda _: viewer.ask("POST", "/api/render", b"{}"))
                self.assertEqual(sorted(status for status, _, _ in answers), [200] + [400] * 3)
                for status, _, body in answers:
                    self.assertEqual(b"running already" in body, status == 400, body)
                self.assertEqual(len(self.children(viewer)), 1)
                self.assertEqual(viewer.ask("POST", "/api/stop", b"{}")[0], 200)
                begin = time.monotonic()
                while viewer.news()[0]["final"]["state"] == "running" and time.monotonic() - begin < LIMIT_S:
                    time.sleep(0.02)
                self.assertEqual(self.children(viewer), [])
            self.assertEqual(viewer.end(), (0, "", ""))

    def drop(self, viewer, name):
        body = CORNELL.read_bytes()
        return viewer.ask("POST", f"/api/drop?name={name}", body)[0]

    def drop_at_last(self, viewer, name):
        """Drops a scene when those before it are loaded, since it is refused until then."""
        begin = time.monotonic()
        while (status := self.drop(viewer, name)) == 400 and time.monotonic() - begin < LIMIT_S:
            time.sleep(0.02)
        return status

    def dropped(self):
        return sorted(file.name for file in self.folder.glob("eikon_view_*/*/*"))

    def test_the_scene_that_is_shown_is_the_one_that_is_kept(self):
        with Viewer(EIKON, self.folder, CORNELL, *SMALL) as viewer:
            viewer.wait_for("done")
            for part in range(8):
                answers = self.at_once(4, lambda number: self.drop(viewer, f"scene-{part}-{number}.gltf"))
                self.assertIn(200, answers)
                news, _ = viewer.wait_for("done", viewer.news()[0]["status"]["look_number"])
                self.assertEqual(self.dropped(), [news["status"]["scene"]["name"]])
            self.assertEqual(viewer.end(), (0, "", ""))

    def test_a_scene_stays_while_a_final_render_may_read_it(self):
        with Viewer(EIKON, self.folder, CORNELL, "--size", "64x48", "--spp", "100000000") as viewer:
            self.assertEqual(self.drop(viewer, "rendered.gltf"), 200)
            viewer.wait_for("rendering", 2)
            self.assertEqual(viewer.ask("POST", "/api/render", b"{}")[0], 200)
            self.assertEqual(self.drop(viewer, "next.gltf"), 200)
            self.assertEqual(self.dropped(), ["next.gltf", "rendered.gltf"])
            viewer.ask("POST", "/api/stop", b"{}")
            begin = time.monotonic()
            while viewer.news()[0]["final"]["state"] == "running" and time.monotonic() - begin < LIMIT_S:
                time.sleep(0.02)
            self.assertEqual(self.drop_at_last(viewer, "last.gltf"), 200)
            self.assertEqual(self.dropped(), ["last.gltf"])
            self.assertEqual(viewer.end(), (0, "", ""))

    def children(self, viewer):
        """Processes that the server started and has not waited for."""
        found = []
        for file in pathlib.Path("/proc").glob("[0-9]*/stat"):
            try:
                if int(file.read_text().rsplit(")", 1)[1].split()[1]) == viewer.process.pid:
                    found.append(file.parent.name)
            except OSError:  # it has ended meanwhile
                pass
        return found


class Attacked(Served):
    def send(self, raw):
        """The first bytes that the server answers; none if it waits for more."""
        with socket.create_connection(("127.0.0.1", self.viewer.port), timeout=LIMIT_S) as connection:
            try:
                connection.sendall(raw)
                connection.settimeout(0.1)
                return connection.recv(100)
            except OSError:
                return b""

    def open_files(self):
        return len(os.listdir(f"/proc/{self.viewer.process.pid}/fd"))


class Fuzzer(Attacked):
    def test_broken_requests_of_a_fuzzer_do_no_harm(self):
        draw, host = random.Random(27), f"Host: 127.0.0.1:{self.viewer.port}\r\nX-Eikon-Token: {self.viewer.token}\r\n".encode()
        look = b'{"flags": {"--size": "64x48", "--spp": "8"}}'
        good = [b"GET /?token=" + self.viewer.token.encode() + b" HTTP/1.1\r\n" + host + b"\r\n",
                b"GET /api/news?after=0&frame=0 HTTP/1.1\r\n" + host + b"\r\n",
                b"GET /api/path?x=64&y=1&sample=0 HTTP/1.1\r\n" + host + b"\r\n",
                b"POST /api/look HTTP/1.1\r\n" + host + b"Content-Length: " + str(len(look)).encode() + b"\r\n\r\n" + look]
        parts = [b"\r\n", b"\0", b"%", b"%00", b"Range: bytes=0-" + b"0-," * 2000, b"A" * 9000, b"Content-Length: -1\r\n", b"\xff\xfe",
                 b"Expect: 100-continue\r\n", b"Transfer-Encoding: chunked\r\n", b"ffffffffffffffff\r\n", b"..", b"[" * 500,
                 b"Content-Type: multipart/form-data; boundary=" + b"(" * 3000 + b"\r\n", b"Accept-Encoding: gzip\r\n",
                 b"Content-Encoding: br\r\n", b"HTTP/9.9", b"?" * 3000, b"&a=" * 2000, b";q=1,*/*" * 500, b":", b"1e999",
                 b"\x1f\x8b"]
        for _ in range(600):
            raw = bytearray(draw.choice(good))
            for _ in range(draw.randint(1, 4)):
                at = draw.randrange(len(raw))
                how = draw.randrange(4)
                if how == 0:
                    raw[at] = draw.randrange(256)
                elif how == 1:
                    raw[at:at] = draw.choice(parts)
                elif how == 2:
                    del raw[at:at + draw.randint(1, 40)]
                else:
                    raw[at:at] = raw[:draw.randint(1, 200)]
                raw = raw or bytearray(b"G")
            answer = self.send(bytes(raw))
            self.assertTrue(answer == b"" or answer.startswith(b"HTTP/1."), answer)
            self.assertNotIn(b"root:", answer)
        self.assertIsNone(self.viewer.process.poll(), "the server has ended")
        self.viewer.wait_for("done", self.viewer.look({"--spp": "8"}))


class EndlessRequests(Attacked):
    def test_a_request_without_an_end_is_cut(self):
        line = b"X-Padding: " + b"x" * 1000 + b"\r\n"
        for begin in (b"GET / HTTP/1.1\r\n", b"GET / HTTP/1.1\r\nHost: " + b"y" * 100000, b"z" * 100000):
            with socket.create_connection(("127.0.0.1", self.viewer.port), timeout=LIMIT_S) as connection:
                with self.assertRaises(OSError):
                    connection.sendall(begin)
                    for _ in range(100000):
                        connection.sendall(line)
        # A byte now and then does not keep a connection.
        with socket.create_connection(("127.0.0.1", self.viewer.port), timeout=LIMIT_S) as connection, self.assertRaises(OSError):
            for _ in range(2 * LIMIT_S):
                connection.sendall(b"G")
                time.sleep(0.5)
        self.assert_alive()


class Connections(Attacked):
    def answer(self, connection, stream):
        """The headers of an answer to a request for news."""
        connection.sendall(f"GET /api/news?after=0&frame=0 HTTP/1.1\r\nHost: localhost\r\nX-Eikon-Token: {self.viewer.token}\r\n\r\n".encode())
        headers = dict(line.decode().strip().split(": ", 1) for line in list(iter(stream.readline, b"\r\n"))[1:])
        stream.read(int(headers["Content-Length"]))
        return headers

    def test_are_kept_as_long_as_their_answers_say(self):
        with socket.create_connection(("127.0.0.1", self.viewer.port), timeout=LIMIT_S) as connection, connection.makefile("rb") as stream:
            promised = self.answer(connection, stream)["Keep-Alive"]
            timeout, most = map(int, re.fullmatch(r"timeout=(\d+), max=(\d+)", promised).groups())
            asked = 1
            while "Keep-Alive" in self.answer(connection, stream):
                asked += 1
            self.assertEqual(asked + 1, most)
            self.assertEqual(stream.read(1), b"")
        with socket.create_connection(("127.0.0.1", self.viewer.port), timeout=LIMIT_S) as connection, connection.makefile("rb") as stream:
            self.answer(connection, stream)
            begin = time.monotonic()
            self.assertEqual(stream.read(1), b"")
            self.assertLess(abs(time.monotonic() - begin - timeout), 1)

    def test_two_hundred_connections_at_once_are_served_and_closed(self):
        self.viewer.news()
        before = self.open_files()
        request = f"GET /api/news?after=0&frame=0 HTTP/1.1\r\nHost: localhost\r\nX-Eikon-Token: {self.viewer.token}\r\nConnection: close\r\n\r\n".encode()
        idle = []
        for number in range(200):
            idle.append(socket.create_connection(("127.0.0.1", self.viewer.port), timeout=LIMIT_S))
            self.addCleanup(idle[-1].close)
            if number % 2 == 0:
                idle[-1].sendall(request)
        self.assert_alive()  # though every thread has a connection that says nothing
        for number, one in enumerate(idle):
            answer = one.recv(12)
            self.assertEqual(answer, b"HTTP/1.1 200" if number % 2 == 0 else b"")
        for one in idle:
            one.close()
        threads = len(os.listdir(f"/proc/{self.viewer.process.pid}/task"))
        self.assertLess(threads, 100)
        begin = time.monotonic()
        while self.open_files() > before + 2 and time.monotonic() - begin < LIMIT_S:
            time.sleep(0.1)
        self.assertLessEqual(self.open_files(), before + 2)


class SlowFiles(unittest.TestCase):
    """Files that come slowly or not at all, each test to a server of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="eikon_view_")
        self.addCleanup(folder.cleanup)
        self.viewer = self.enterContext(Viewer(EIKON, folder.name, CORNELL, *SMALL))
        self.viewer.wait_for("done")

    def begin(self, *headers):
        """A connection that has sent the headers of a dropped file."""
        connection = self.enterContext(socket.create_connection(("127.0.0.1", self.viewer.port), timeout=LIMIT_S))
        lines = ("POST /api/drop?name=slow.gltf HTTP/1.1", "Host: localhost", f"X-Eikon-Token: {self.viewer.token}", *headers)
        connection.sendall("\r\n".join((*lines, "", "")).encode())
        return connection

    def scene_name(self):
        return self.viewer.news()[0]["status"]["scene"]["name"]

    def test_a_file_may_take_longer_than_an_answer_if_it_goes_on(self):
        body = CORNELL.read_bytes()
        connection = self.begin(f"Content-Length: {len(body)}")
        parts = 14
        for part in range(parts):  # 65 s in all
            connection.sendall(body[len(body) * part // parts:len(body) * (part + 1) // parts])
            time.sleep(5 if part < parts - 1 else 0)
        self.assertIn(b" 200 ", connection.recv(100))
        self.viewer.wait_for("done", 2)
        self.assertEqual(self.scene_name(), "slow.gltf")

    def test_a_file_that_falls_silent_is_given_up(self):
        connection = self.begin("Content-Length: 1000")
        connection.sendall(b"{")
        begin = time.monotonic()
        self.assertIn(b" 400 ", connection.recv(100))
        self.assertTrue(15 < time.monotonic() - begin < 50)
        self.assertEqual(self.scene_name(), CORNELL.name)

    def test_the_view_ends_at_once_while_a_file_comes(self):
        connection = self.begin("Content-Length: 1000")
        connection.sendall(b"{")
        time.sleep(0.5)
        begin = time.monotonic()
        self.assertEqual(self.viewer.end(), (0, "", ""))
        self.assertLess(time.monotonic() - begin, 8)

    def test_a_file_without_its_length_is_refused(self):
        for headers in ((), ("Content-Length: ",), ("Connection: close",)):
            connection = self.begin(*headers)
            answer = b""
            # The server needs no more than the headers to refuse, so it may have left already.
            with contextlib.suppress(OSError):
                connection.sendall(b"{")
                connection.shutdown(socket.SHUT_WR)
            with contextlib.suppress(ConnectionResetError):
                while part := connection.recv(1000):
                    answer += part
            self.assertIn(b" 400 ", answer.split(b"\r\n")[0])
            self.assertIn(b"view: a dropped file comes with its Content-Length", answer)
        self.viewer.wait_for("done")
        self.assertEqual(self.scene_name(), CORNELL.name)


class LazyClients(Attacked):
    def test_a_client_that_stops_reading_is_left(self):
        self.viewer.wait_for("done", self.viewer.look({"--size": "2048x2048", "--spp": "1"}))
        lazy = [socket.socket() for _ in range(40)]
        for one in lazy:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            one.connect(("127.0.0.1", self.viewer.port))
            self.addCleanup(one.close)
            one.sendall(f"GET /api/news?after=0&frame=0 HTTP/1.1\r\nHost: localhost\r\nX-Eikon-Token: {self.viewer.token}\r\n\r\n".encode())
        self.assert_alive()
        self.viewer.wait_for("done", self.viewer.look({"--spp": "8"}))


if __name__ == "__main__":
    EIKON = str(pathlib.Path(sys.argv.pop(1)).resolve())
    run_side_by_side()
