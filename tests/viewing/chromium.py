"""Headless Chromium, by the Chrome DevTools protocol."""

import base64
import json
import shutil
import subprocess
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest


@contextmanager
def open_browser(folder: Path, width: int = 1200, height: int = 900) -> Iterator["Browser"]:
    """Headless Chromium with an empty profile; skipped where it is not installed."""
    executable = shutil.which("chromium") or shutil.which("google-chrome")
    if executable is None:
        pytest.skip("chromium is not installed; apt-get install chromium")
    connect = pytest.importorskip("websockets.sync.client", reason="comes with handsim[viewer]")
    switches = ("--headless", "--no-sandbox", "--no-first-run", "--disable-quic", "--disable-sync")
    quiet = ("--disable-background-networking", "--disable-component-update")
    drawing = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars")
    process = subprocess.Popen(
        [executable, *switches, *quiet, *drawing, f"--window-size={width},{height}"]
        + ["--remote-debugging-port=0", f"--user-data-dir={folder}", "about:blank"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        port_file = folder / "DevToolsActivePort"
        wait_until(lambda: port_file.is_file() and port_file.read_text().count("\n") == 1, 30)
        port = port_file.read_text().split()[0]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
            target = next(t for t in json.load(answer) if t["type"] == "page")
        with connect.connect(target["webSocketDebuggerUrl"], max_size=None) as socket:
            yield Browser(socket)
    finally:
        process.kill()
        process.wait()


def wait_until(condition: Callable[[], Any], seconds: float) -> Any:
    """Ask until the answer is true."""
    end = time.monotonic() + seconds
    while not (answer := condition()):
        assert time.monotonic() < end, f"not within {seconds} s"
        time.sleep(0.1)
    return answer


class Browser:
    """One page, by the Chrome DevTools protocol; `events` are what it reported."""

    def __init__(self, socket: Any) -> None:
        self._socket, self._number = socket, 0
        self.events: list[dict[str, Any]] = []
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": params}))
        while True:
            message = json.loads(self._socket.recv(timeout=180))
            if message.get("id") == self._number:
                assert "error" not in message, message
                return message["result"]
            self.events.append(message)

    def visit(self, address: str) -> None:
        self.call("Page.navigate", url=address)
        wait_until(lambda: self.evaluate("document.readyState") == "complete", 60)

    def evaluate(self, script: str) -> Any:
        result = self.call(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def resize(self, width: int, height: int) -> None:
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=False,
        )  # fmt: skip

    def type_into(self, label: str, text: str) -> None:
        """Replace what stands in the last text field of a labelled row."""
        self._enter(label)
        self.call("Input.insertText", text=text)
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key="Enter", windowsVirtualKeyCode=13)

    def choose(self, label: str, option: str) -> None:
        """Choose from a labelled menu."""
        self._enter(label)
        offered = "[...document.querySelectorAll('[role=option]')].map(one => one.innerText.trim())"
        wait_until(lambda: option in self.evaluate(offered), 10)
        self.press(option, "[role=option]")

    def _enter(self, label: str) -> None:
        self.evaluate(
            f"""(() => {{
              let row = [...document.querySelectorAll('label')]
                .find(one => one.innerText.trim() === {label!r});
              while (!row.querySelector('input[type=text]')) row = row.parentElement;
              const field = [...row.querySelectorAll('input[type=text]')].pop();
              field.focus(); field.select(); field.click(); }})()"""
        )

    def press(self, text: str, role: str = "button") -> None:
        """Click on what carries this text."""
        self.evaluate(
            f"""[...document.querySelectorAll({role!r})]
                .find(one => one.innerText.trim() === {text!r}).click()"""
        )

    def mouse(self, kind: str, place: tuple[float, float], shift: bool = False) -> None:
        """Press, move or release the left button at a place on the page [px]."""
        self.call(
            "Input.dispatchMouseEvent",
            type=f"mouse{kind}", x=place[0], y=place[1], button="left", modifiers=8 * shift,
            buttons=0 if kind == "Released" else 1, clickCount=1,
        )  # fmt: skip

    def screenshot(self, path: Path, whole: bool = False) -> np.ndarray:
        """Write a picture of the page and return it."""
        taken = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(taken["data"]))
        return iio.imread(path, plugin="pillow", mode="RGB")

    def requests(self) -> list[str]:
        """Addresses that were asked for, ``data:`` ones apart."""
        asked = [
            e["params"]["request"]["url"]
            for e in self.events
            if e.get("method") == "Network.requestWillBeSent"
        ]
        return [url for url in asked if not url.startswith(("data:", "blob:"))]

    def complaints(self) -> list[str]:
        """Errors on the console."""
        said = [
            e["params"]
            for e in self.events
            if e.get("method") in ("Runtime.exceptionThrown", "Log.entryAdded")
        ]
        return [json.dumps(p) for p in said if p.get("entry", {}).get("level", "error") == "error"]
