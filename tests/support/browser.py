"""A real headless Chromium for tests of pages, spoken to over pipes (the DevTools protocol); no network reaches it."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
SECONDS = 60  # for anything that a page does: a drawing without a GPU takes some
FLAGS = [
    "--headless=new", "--no-sandbox", "--no-first-run", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--host-resolver-rules=MAP * ~NOTFOUND", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--mute-audio", "--remote-debugging-pipe", "about:blank",
]  # fmt: skip


def browser() -> str | None:
    """Path of a Chromium, if this machine has one."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


class Chromium:
    """One browser with one page; use it in a with statement."""

    def __init__(self, width: int = 1000, height: int = 700) -> None:
        self.size = width, height
        self.events: list[dict] = []
        self._left = b""
        self._number = 0
        self._session: str | None = None

    def __enter__(self) -> Chromium:
        self._folder = tempfile.mkdtemp(prefix="bladesmith-chromium-")
        command_read, self._write = os.pipe()
        self._read, answer_write = os.pipe()

        def pipes() -> None:  # the browser reads commands from 3 and answers on 4
            high = [os.dup(command_read), os.dup(answer_write)]
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        self._process = subprocess.Popen(
            [browser(), f"--user-data-dir={self._folder}", *FLAGS],
            preexec_fn=pipes,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(command_read)
        os.close(answer_write)
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        width, height = self.size
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._write)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(5)
        self._process.kill()
        self._process.wait()
        os.close(self._read)
        shutil.rmtree(self._folder, ignore_errors=True)

    def call(self, method: str, **parameters: object) -> dict:
        """The browser's answer to a command; what it tells in between is kept in `events`."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + SECONDS
        while True:
            told = self._next(end)
            if told.get("id") == self._number:
                assert "error" not in told, (method, told)
                return told["result"]
            self.events.append(told)

    def _next(self, end: float) -> dict:
        while b"\0" not in self._left:
            assert select.select([self._read], [], [], max(0.0, end - time.monotonic()))[0], "the browser is silent"
            got = os.read(self._read, 1 << 20)
            assert got, "the browser has gone"
            self._left += got
        told, _, self._left = self._left.partition(b"\0")
        return json.loads(told)

    def open(self, page: Path) -> None:
        """Load a page and wait until it says that it is ready, or that it failed."""
        self.events.clear()
        self.call("Page.navigate", url=page.resolve().as_uri())
        self.wait("document.body && document.body.dataset.state")

    def wait(self, expression: str) -> object:
        """The value of an expression, as soon as it is true."""
        end = time.monotonic() + SECONDS
        while not (value := self.value(expression)):
            assert time.monotonic() < end, f"{expression} never came true"
            time.sleep(0.05)
        return value

    def value(self, expression: str) -> object:
        """What JavaScript makes of an expression; promises are waited for."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def click(self, selector: str) -> None:
        """Click on an element."""
        self.value(f"document.querySelector({json.dumps(selector)}).click()")

    def point(self, x: float, y: float) -> None:
        """Move the mouse there."""
        for step in (3.0, 0.0):
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + step, y=y)

    def picture(self) -> bytes:
        """A PNG of the page as it stands."""
        self.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def complaints(self) -> list[str]:
        """Errors and warnings on the console, uncaught exceptions, and what its policy stopped."""
        found = []
        for event in self.events:
            told = event.get("params", {})
            if event.get("method") == "Runtime.exceptionThrown":
                found.append(str(told["exceptionDetails"].get("exception", told)))
            if event.get("method") == "Runtime.consoleAPICalled" and told["type"] in ("error", "assert"):
                found.append(str(told["args"]))
            if event.get("method") == "Log.entryAdded" and told["entry"]["level"] == "error":
                found.append(told["entry"]["text"])
        return found

    def requests(self) -> list[str]:
        """Addresses that the page asked for."""
        return [
            event["params"]["request"]["url"]
            for event in self.events
            if event.get("method") == "Network.requestWillBeSent"
        ]
