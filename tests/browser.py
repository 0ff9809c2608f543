"""Debian's Chromium, driven by playwright: what a page says on its console, and whom it asks for something."""

import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
BINARY = next(filter(None, map(shutil.which, NAMES)), None)
WHY_NOT = f"no browser: none of {', '.join(NAMES)} is installed" if BINARY is None else ""
needed = pytest.mark.skipif(BINARY is None, reason=WHY_NOT)
WAIT = 60.0  # seconds; far above what any page here takes


@contextmanager
def browser() -> Iterator[Any]:
    """A running browser; the test is skipped where none is installed."""
    if BINARY is None:
        pytest.skip(WHY_NOT)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=BINARY, args=["--no-sandbox"])
        yield running
        running.close()


class Tab:
    """One page, open; `errors`: what it complained of, `asked`: every address that it asked for and is not its own."""

    def __init__(self, running: Any, address: str, width: int = 1200, height: int = 900) -> None:
        self.page = running.new_page(viewport={"width": width, "height": height}, accept_downloads=True)
        self.errors: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda told: self.errors.append(told.text) if told.type == "error" else None)
        self.page.on("pageerror", lambda error: self.errors.append(error.stack or str(error)))
        self.page.on("request", lambda request: self._note(request.url, address))
        self.page.goto(address)
        self.wait("document.documentElement.dataset.ready || !document.getElementById('nothing').hidden")

    def _note(self, url: str, address: str) -> None:
        if url != address and not url.startswith(("data:", "blob:")):
            self.asked.append(url)

    def wait(self, condition: str) -> None:
        """Until the condition, JavaScript, holds. Playwright's own waiting evaluates text, which the pages forbid."""
        end = time.monotonic() + WAIT
        while not self.page.evaluate(f"Boolean({condition})"):
            assert time.monotonic() < end, f"{condition} never held; {self.errors}"
            time.sleep(0.02)

    def drawn(self) -> int:
        """How many pictures it has drawn."""
        return int(self.page.evaluate("Number(document.documentElement.dataset.pictures)"))

    def redrawn(self, act: Any) -> None:
        """Do something, and wait for the picture that follows."""
        before = self.drawn()
        act()
        self.wait(f"Number(document.documentElement.dataset.pictures) > {before}")

    def text(self, selector: str) -> str:
        """What stands there."""
        return str(self.page.inner_text(selector))

    def row(self) -> dict[str, str]:
        """The row that is shown beside the picture."""
        self.wait("document.querySelector('#row dd')")
        both = "[...document.querySelectorAll('#row dt')].map(e => [e.innerText, e.nextSibling.innerText])"
        return dict(self.page.evaluate(both))
