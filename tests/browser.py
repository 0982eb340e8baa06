"""A headless browser for tests of pages, in a process of its own:  python tests/browser.py PAGE < steps.json > answers.json

Steps are a list of lists; each gives one answer:
    ["run", JavaScript]            its value
    ["until", JavaScript]          true once it is true
    ["key", NAME, ...modifiers]    a key that is pressed, e.g. "Home", "Space", "Right"; modifiers e.g. "Shift"
    ["size", WIDTH, HEIGHT]        of the view, in pixels
    ["grab", FILE]                 a picture of what is seen
Last comes what went wrong: {"console": lines of warnings and errors, "requests": addresses that were asked for beside the page}.
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
from pathlib import Path

TIMEOUT = 60.0  # s, of a whole visit; the machine may be busy


@functools.cache
def missing() -> str:
    """Why there is no browser here, or nothing: a library of the system that its wheel needs and does not carry."""
    asked = "from PyQt6.QtWebEngineWidgets import QWebEngineView"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, env=_environment())
    if done.returncode == 0:
        return ""
    last = done.stderr.strip().splitlines()[-1]
    assert "cannot open shared object file" in last, last  # anything else is a fault, not a machine without a screen
    return f"the browser needs a library of the system: {last}"


def visit(page: os.PathLike, steps: list, flags: str = "") -> list:
    """Open a page and go through steps.  Returns: their answers, and last what went wrong."""
    environment = _environment()
    environment["QTWEBENGINE_CHROMIUM_FLAGS"] += f" {flags}"
    done = subprocess.run(
        [sys.executable, __file__, str(page)], input=json.dumps(steps), capture_output=True, text=True, timeout=TIMEOUT, env=environment
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def _environment() -> dict[str, str]:
    flags = "--no-sandbox --disable-gpu --disable-dev-shm-usage"
    return os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_CHROMIUM_FLAGS": flags, "QTWEBENGINE_DISABLE_SANDBOX": "1"}


def _main(page: str) -> None:
    from PyQt6.QtCore import QEvent, Qt, QTimer, QUrl
    from PyQt6.QtGui import QKeyEvent
    from PyQt6.QtWebEngineCore import QWebEnginePage, QWebEngineProfile, QWebEngineUrlRequestInterceptor
    from PyQt6.QtWebEngineWidgets import QWebEngineView
    from PyQt6.QtWidgets import QApplication

    address = QUrl.fromLocalFile(str(Path(page).resolve()))
    console: list[str] = []
    requests: list[str] = []
    answers: list = []

    class Guard(QWebEngineUrlRequestInterceptor):
        def interceptRequest(self, info):  # noqa: N802  (a name of Qt's)
            asked = info.requestUrl()
            if asked != address and asked.scheme() not in ("data", "blob"):
                requests.append(asked.toString())
                info.block(True)

    class Page(QWebEnginePage):
        def javaScriptConsoleMessage(self, level, message, line, source):  # noqa: N802  (a name of Qt's)
            if level != QWebEnginePage.JavaScriptConsoleMessageLevel.InfoMessageLevel:
                console.append(f"{message} ({line})")

    app = QApplication(sys.argv[:1])
    profile, guard, view = QWebEngineProfile(), Guard(), QWebEngineView()
    profile.setUrlRequestInterceptor(guard)
    shown = Page(profile, view)
    view.setPage(shown)
    view.resize(1280, 800)
    steps = json.load(sys.stdin)

    def answer(value):
        answers.append(value)
        QTimer.singleShot(0, go)

    def go():
        if len(answers) == len(steps):
            print(json.dumps([*answers, {"console": console, "requests": requests}]))
            app.quit()
            return
        what, *given = steps[len(answers)]
        if what == "run":
            shown.runJavaScript(given[0], answer)
        elif what == "until":
            look(given[0])
        elif what == "size":
            view.resize(*given)
            look(f"innerWidth === {given[0]}")
        elif what == "grab":
            QTimer.singleShot(150, lambda: answer(view.grab().save(given[0])))
        else:
            press(*given)
            shown.runJavaScript("1", answer)

    def look(condition):
        shown.runJavaScript(condition, lambda value: answer(True) if value is True else QTimer.singleShot(20, lambda: look(condition)))

    def press(name, *modifiers):
        held = Qt.KeyboardModifier.NoModifier
        for one in modifiers:
            held |= getattr(Qt.KeyboardModifier, f"{one}Modifier")
        key, text = getattr(Qt.Key, f"Key_{name}"), {"Space": " ", "Comma": ",", "Period": "."}.get(name, "")
        for kind in (QEvent.Type.KeyPress, QEvent.Type.KeyRelease):
            app.sendEvent(view.focusProxy() or view, QKeyEvent(kind, key, held, text))

    def loaded(well):
        if not well:
            sys.exit("the page did not load")
        go()

    shown.loadFinished.connect(loaded)
    view.show()
    view.setFocus()
    view.load(address)
    app.exec()
    view.setPage(None)
    shown.deleteLater()
    app.processEvents()
    os._exit(0)


if __name__ == "__main__":
    _main(sys.argv[1])
