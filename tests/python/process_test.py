#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that a render leaves the handlers of signals and the end of its process to Python: process_test.py EIKON [unittest arguments]"""
import os
import signal
import subprocess
import sys
import threading

import eikon
from package_case import SCENES, Package, main


class OtherThreads(Package):
    def run_apart(self, code):
        """What a new process prints, whose driver compiles anew and with that sets handlers of signals."""
        begin = """if True:
            import eikon, os, pathlib, re, signal, threading
            scene = os.environ["SCENE"]
            def caught():
                return int(re.search(r"SigCgt:\\s*(\\w+)", pathlib.Path("/proc/self/status").read_text())[1], 16)
            def on_thread(work):
                thread = threading.Thread(target=work)
                thread.start()
                return thread
            """
        done = subprocess.run([sys.executable, "-c", begin + code], capture_output=True, text=True, check=False,
                              env={**os.environ, "SCENE": os.fspath(SCENES / "furnace.gltf"), "POCL_CACHE_DIR": os.fspath(self.folder)})
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_leave_the_handlers_of_signals_as_they_were(self):
        self.assertEqual(self.run_apart("""
            eikon.devices()
            before = caught()
            for thread in [on_thread(lambda: eikon.render(scene, size=(8, 8), spp=4)) for _ in range(2)]:
                thread.join()
            print(caught() == before)
            try:
                os.kill(os.getpid(), signal.SIGINT)
                threading.Event().wait(60)
            except KeyboardInterrupt:
                print("interrupted")
            """), "True\ninterrupted\n")

    def test_keep_a_handler_that_was_set_meanwhile(self):
        self.assertEqual(self.run_apart("""
            begun, may_end = threading.Event(), threading.Event()
            def progress(_):
                begun.set()
                return not may_end.is_set()
            thread = on_thread(lambda: eikon.render(scene, size=(64, 64), spp=1 << 24, progress=progress))
            begun.wait()
            signal.signal(signal.SIGTERM, lambda *_: print("mine"))
            may_end.set()
            thread.join()
            os.kill(os.getpid(), signal.SIGTERM)
            """), "mine\n")


class Forked(Package):
    def test_a_copy_of_a_process_that_has_rendered_is_refused_and_does_not_hang(self):
        code = """if True:
            import eikon, os
            eikon.render(os.environ["SCENE"], size=(4, 4), spp=1)
            child = os.fork()
            if child == 0:
                try:
                    eikon.render(os.environ["SCENE"], size=(4, 4), spp=1)
                except eikon.DeviceError as error:
                    os._exit("was forked" in str(error))
                os._exit(2)
            print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
            """
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=100,
                              env={**os.environ, "SCENE": os.fspath(SCENES / "furnace.gltf")})
        self.assertEqual(done.stdout, "1\n", done.stderr)


class Exit(Package):
    def test_is_not_held_up_by_a_driver_that_hangs_and_has_its_code(self):
        code = """if True:
            import atexit, eikon, sys
            atexit.register(print, "at exit")
            try:
                eikon.render(sys.argv[1], size=(8, 8), spp=2)
            except eikon.DeviceError as error:
                print("refused")
            sys.exit(9)"""
        done = subprocess.run([sys.executable, "-c", code, SCENES / "furnace.gltf"], capture_output=True, text=True, check=False, timeout=120,
                              env={**os.environ, "EIKON_FAULT": "device:0:hang", "EIKON_WATCHDOG": "1"})
        self.assertEqual((done.returncode, done.stdout, done.stderr), (9, "refused\nat exit\n", ""))


if __name__ == "__main__":
    main()
