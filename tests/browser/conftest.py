"""A headless Chromium, spoken to over its debugging pipe; tests skip where there is none.

What it prints is looked at by pdftoppm, of poppler-utils; tests of that skip without it, too.
"""

import base64
import fcntl
import json
import os
import shutil
import subprocess

import matplotlib.image
import pytest

BINARY = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)

FLAGS = (
    "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--hide-scrollbars", "--disable-dev-shm-usage",
)  # fmt: skip


class Browser:
    """One page of a browser: what it shows, what it complains of, what it asks the network for."""

    def __init__(self, profile):
        self.errors, self.requests, self._number = [], [], 0
        commands, ours = os.pipe()
        theirs, answers = os.pipe()

        def place():
            # Free numbers above 4 first: 3 and 4 may be taken by the pipes themselves.
            apart = [fcntl.fcntl(end, fcntl.F_DUPFD, 5) for end in (commands, answers)]
            for number, end in enumerate(apart, start=3):
                os.dup2(end, number)

        self._process = subprocess.Popen(
            [BINARY, *FLAGS, "--remote-debugging-pipe", f"--user-data-dir={profile}"],
            preexec_fn=place, close_fds=False, stderr=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, env=os.environ | {"XDG_CONFIG_HOME": str(profile)},
        )  # fmt: skip
        for end in (commands, answers):
            os.close(end)
        self._ours, self._theirs, self._rest = ours, theirs, b""
        self._session = None
        target = self("Target.createTarget", url="about:blank")["targetId"]
        attached = self("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Runtime", "Log", "Network", "Page"):
            self(f"{domain}.enable")

    def __call__(self, command, **parameters):
        self._number += 1
        message = {"id": self._number, "method": command, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._ours, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]

    def _read(self):
        while b"\0" not in self._rest:
            part = os.read(self._theirs, 1 << 20)
            assert part, "the browser has gone"
            self._rest += part
        text, _, self._rest = self._rest.partition(b"\0")
        message = json.loads(text)
        what, told = message.get("method"), message.get("params", {})
        if what == "Runtime.exceptionThrown":
            self.errors.append(told["exceptionDetails"]["text"])
        elif what == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning"):
            self.errors.append(told["args"])
        elif what == "Log.entryAdded" and told["entry"]["level"] == "error":
            self.errors.append(told["entry"]["text"])
        elif what == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])
        return message

    def open(self, path, *, width=1280, height=800, dark=False):
        """Open a page and wait until its player stands."""
        self.errors.clear()
        self.requests.clear()
        self("Emulation.setDeviceMetricsOverride", width=width, height=height,
             deviceScaleFactor=1, mobile=False)  # fmt: skip
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self("Emulation.setEmulatedMedia", features=[scheme])
        self("Page.navigate", url=path.resolve().as_uri())
        ready = "new Promise(r => {const t = () => (window.player && player.frames > 1) || " \
            "!error.hidden ? r(error.textContent) : setTimeout(t, 20); addEventListener('load', " \
            "t); if (document.readyState === 'complete') t();})"  # fmt: skip
        assert self.value(ready) == ""

    def value(self, expression):
        """What a JavaScript expression comes to; promises are waited for."""
        answer = self(
            "Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def press(self, key):
        """Press and release a key, wait for the next frame."""
        text = {"text": key} if len(key) == 1 else {}
        self("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
        self("Input.dispatchKeyEvent", type="keyUp", key=key)
        self.value("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")

    def screenshot(self):
        """What the page looks like, as PNG."""
        return base64.b64decode(self("Page.captureScreenshot")["data"])

    def close(self):
        self._session = None
        self("Browser.close")
        self._process.wait(300)
        for end in (self._ours, self._theirs):
            os.close(end)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    if BINARY is None:
        pytest.skip("there is no Chromium on this machine")
    one = Browser(tmp_path_factory.mktemp("profile"))
    yield one
    one.close()


@pytest.fixture
def on_paper(tmp_path_factory):
    """Prints a page as ``chromium --print-to-pdf`` does: a function of its address."""
    for name, program in (("Chromium", BINARY), ("pdftoppm", shutil.which("pdftoppm"))):
        if program is None:
            pytest.skip(f"there is no {name} on this machine")

    def sheets(url, width=1280):
        """Sheets of paper as images of 50 dots an inch: rows, columns, and colours from 0 to 1."""
        folder = tmp_path_factory.mktemp("paper")
        paper = folder / "paper.pdf"
        subprocess.run(
            [BINARY, *FLAGS, f"--user-data-dir={folder / 'profile'}", f"--window-size={width},600",
             f"--print-to-pdf={paper}", "--virtual-time-budget=8000", url],
            check=True, stderr=subprocess.DEVNULL,
            env=os.environ | {"XDG_CONFIG_HOME": str(folder)},
        )  # fmt: skip
        subprocess.run(["pdftoppm", "-r", "50", "-png", paper, folder / "sheet"], check=True)
        found = sorted(folder.glob("sheet-*.png"))
        return [matplotlib.image.imread(sheet)[..., :3] for sheet in found]

    return sheets
