# SPDX-License-Identifier: Apache-2.0
"""Headless Chromium for the tests of pages. A script that imports this ends with exit code 77, skipped, without Debian's chromium,
chromium-driver and python3-selenium. EIKON_SHOTS names a folder for screenshots."""
import os
import pathlib
import shutil
import sys
import tempfile
import time

if not shutil.which("chromium") or not shutil.which("chromedriver"):
    print("chromium and chromedriver are not installed (Debian: chromium, chromium-driver)")
    sys.exit(77)
sys.path.append("/usr/lib/python3/dist-packages")  # of Debian's python3-selenium, where another Python runs this
try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
except ImportError as error:
    print(f"selenium is not installed (Debian: python3-selenium): {error}")
    sys.exit(77)

__all__ = ["ActionChains", "By", "Keys", "BrowserTests"]


class BrowserTests:
    """A part of test cases that use one browser, one after another; `limit_s` is what they wait at most."""
    browser = None
    scratch = None  # a folder for what Chromium leaves behind
    limit_s = 60

    @staticmethod
    def quit():
        if BrowserTests.browser:
            BrowserTests.browser.quit()
            shutil.rmtree(BrowserTests.scratch, ignore_errors=True)

    def open_browser(self):
        if not BrowserTests.browser:
            options = webdriver.ChromeOptions()
            # In a container there is no sandbox, and little shared memory.
            for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage",
                         "--window-size=1280,900"):
                options.add_argument(word)
            options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
            BrowserTests.scratch = tempfile.mkdtemp(prefix="eikon_browser_")
            service = Service(shutil.which("chromedriver"), env={**os.environ, "TMPDIR": BrowserTests.scratch})
            BrowserTests.browser = webdriver.Chrome(service=service, options=options)
        self.addCleanup(self.clear_browser)

    def clear_browser(self):
        first, *others = self.browser.window_handles
        for other in others:
            self.browser.switch_to.window(other)
            self.browser.close()
        self.browser.switch_to.window(first)
        self.browser.get("about:blank")
        self.browser.get_log("browser")
        self.prefer("light")

    def prefer(self, scheme):
        """light or dark"""
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]})

    def shot(self, name, whole=False):
        """whole: of the whole page, however long it is"""
        if folder := os.environ.get("EIKON_SHOTS"):
            if whole:
                height = self.run_script("return document.documentElement.scrollHeight")
                self.browser.set_window_size(1280, min(height, 6000) + 150)
            self.browser.save_screenshot(str(pathlib.Path(folder) / f"{name}.png"))
            if whole:
                self.browser.set_window_size(1280, 900)

    def run_script(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def until(self, claim, what):
        begin = time.monotonic()
        while not (value := claim()):
            if time.monotonic() - begin > self.limit_s:
                self.fail(f"never {what}; {self.situation()}, {self.browser.get_log('browser')}")
            time.sleep(0.05)
        return value

    def situation(self):
        """What else a failure says."""
        return ""

    def errors(self):
        """What the browser complained of."""
        return [entry for entry in self.browser.get_log("browser") if "favicon" not in entry["message"]]

    def luminance(self):
        """Of the page's background, 0 to 255."""
        return max(self.run_script("return getComputedStyle(document.body).backgroundColor.match(/[0-9]+/g).map(Number)")[:3])
