"""Answer the browser of this machine, and nobody else.

The address holds a token: another user of the machine, or a page of another site that the browser shows, does not know
it. The name by which the server is called is looked at too, since a foreign name can be made to point here.
"""

import hmac
import json
import secrets
import threading
from http import HTTPStatus
from http.client import HTTP_PORT  # which browsers leave out of the name by which they call
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from analysis.page import Live, build, payload
from analysis.view.rows import Growing, Seen
from analysis.view.scene import scene_of
from sweep.errors import InputError

LOOPBACK = "127.0.0.1"


class Server(ThreadingHTTPServer):
    """The page of the table at `path`, at `address`, until it is shut down.

    Raises
    ------
    InputError
        For a table that cannot be read, or a port that cannot be had.
    """

    daemon_threads = True

    def __init__(self, path: Path, port: int = 0) -> None:
        self.table = Growing(path)
        self.token = secrets.token_urlsafe(24)
        self.computing = threading.Lock()  # one impact at a time
        try:
            super().__init__((LOOPBACK, port), _Handler)
        except OSError as error:
            raise InputError(f"--port {port}: cannot be had: {error.strerror}") from None

    @property
    def address(self) -> str:
        """What to open in a browser."""
        return f"http://{LOOPBACK}:{self.server_port}/?token={self.token}"

    def page(self) -> bytes:
        """The page with the rows that there are now."""
        seen = self.table.now()
        live = Live(token=self.token, version=seen.version, table=seen.number)
        return build(seen.rows, self.table.path.name, live, seen.part, seen.made).encode()

    def answer(self, path: str, asked: dict[str, list[str]]) -> dict[str, Any] | None:
        """What the page asks for; None where there is no such path."""
        if path not in ("/version", "/rows", "/scene"):
            return None
        seen = self.table.now()
        if path == "/scene":
            return self._scene(seen, asked)
        told = {"version": seen.version, "table": seen.number, "part": seen.part, "problem": self.table.problem()}
        return payload(seen.rows) | told if path == "/rows" else told

    def _scene(self, seen: Seen, asked: dict[str, list[str]]) -> dict[str, Any]:
        task = _whole("task", asked)
        if "table" in asked and _whole("table", asked) != seen.number:
            raise InputError(f"{self.table.path.name} holds another table by now: load this page anew")
        with self.computing:
            return scene_of(seen.rows, task, self.table.path)


def _whole(name: str, asked: dict[str, list[str]]) -> int:
    text = asked.get(name, [""])[0]
    if not (text.isascii() and text.isdecimal()):
        raise InputError(f"{name} must be a whole number, got {text!r}")
    return int(text)


class _Handler(BaseHTTPRequestHandler):
    server: Server

    def do_GET(self) -> None:
        parts = urlsplit(self.path)
        asked = parse_qs(parts.query)
        port = self.server.server_port
        names = {f"{name}:{port}" for name in (LOOPBACK, "localhost")}
        if port == HTTP_PORT:
            names |= {LOOPBACK, "localhost"}
        token = asked.get("token", [""])[0].encode()
        if self.headers.get("Host") not in names or not hmac.compare_digest(token, self.server.token.encode()):
            self._say(
                HTTPStatus.FORBIDDEN, {"problem": "open the address that `analysis view` printed, token included"}
            )
        else:
            self._answer(parts.path, asked)

    def _answer(self, path: str, asked: dict[str, list[str]]) -> None:
        try:
            if path == "/":
                self._send(HTTPStatus.OK, self.server.page(), "text/html; charset=utf-8")
            elif (found := self.server.answer(path, asked)) is None:
                self._say(HTTPStatus.NOT_FOUND, {"problem": f"there is no {path}"})
            else:
                self._say(HTTPStatus.OK, found)
        except ValueError as error:
            self._say(HTTPStatus.UNPROCESSABLE_ENTITY, {"problem": str(error)})

    def _say(self, status: HTTPStatus, answer: dict[str, Any]) -> None:
        self._send(status, json.dumps(answer, allow_nan=False).encode(), "application/json")

    def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
        try:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.send_header("X-Content-Type-Options", "nosniff")
            self.send_header("Referrer-Policy", "no-referrer")
            self.end_headers()
            self.wfile.write(body)
        except ConnectionError:
            self.close_connection = True  # the browser has gone on to something else

    def log_message(self, *_: Any) -> None:
        """Nothing: the terminal is the user's."""
