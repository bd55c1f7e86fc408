"""A small server on this machine for the page of one campaign: it ends with the process that started it.

All that reaches the loopback interface can connect: other users of this machine, and pages of other sites in the
user's browser. So the address holds a token that only the starter's terminal shows, every request must carry it, the
Host header must be ours (a name that somebody lets point to 127.0.0.1 is refused), and so must Origin where it is sent.
"""

from __future__ import annotations

import hmac
import json
import secrets
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

from stiffcal.documents import Document

HOST = "127.0.0.1"
MOST_BYTES = 1_000_000
"""Of a request's body: a choice names effects and rows."""
PATIENCE_S = 2.0
"""How long a log that is being read may hold up the end."""
TOKEN_HEADER = "X-Stiffcal-Token"


class BackgroundTask(Protocol):
    """What goes on in a thread of its own while a server answers."""

    def run(self) -> None:
        """Go on until `stop` is called."""

    def stop(self) -> None:
        """Have `run` end."""

    def close(self) -> None:
        """Give back what it holds."""


class RefusedError(Exception):
    """A request that cannot be answered.

    Parameters
    ----------
    status : of the answer. document : what the page shows.
    """

    def __init__(self, status: HTTPStatus, document: Document) -> None:
        super().__init__(status.phrase)
        self.status, self.document = status, document


class LiveServer:
    """The server of one page.

    Parameters
    ----------
    page : returns the HTML of the page.
    answers : by the name of what the page asks for: takes the request's document, returns a text that is sent as it is.
    background : what goes on while it answers; None: nothing.
    """

    def __init__(
        self,
        page: Callable[[], str],
        answers: dict[str, Callable[[Document], str]],
        background: BackgroundTask | None = None,
    ) -> None:
        self.token = secrets.token_urlsafe(32)
        self.page, self.answers, self.background = page, answers, background
        self._http = ThreadingHTTPServer((HOST, 0), self._handler())
        self._http.daemon_threads = True

    @property
    def port(self) -> int:
        """The port that the system gave."""
        return int(self._http.server_address[1])

    @property
    def address(self) -> str:
        """What to open in the browser on this machine."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    def serve(self) -> None:
        """Answer until the process is interrupted or `stop` is called."""
        background = None if self.background is None else Thread(target=self.background.run, daemon=True)
        if background is not None:
            background.start()
        try:
            self._http.serve_forever(poll_interval=0.2)
        finally:
            if self.background is not None and background is not None:
                self.background.stop()
                background.join(PATIENCE_S)
            self.close()

    def close(self) -> None:
        """Give the port back."""
        self._http.server_close()
        if self.background is not None:
            self.background.close()

    def stop(self) -> None:
        """End `serve`, which runs in another thread."""
        self._http.shutdown()

    def _handler(self) -> type[BaseHTTPRequestHandler]:
        server = self

        class Handler(BaseHTTPRequestHandler):
            """Answers one connection."""

            server_version, sys_version = "stiffcal", ""
            timeout = 60.0

            def do_GET(self) -> None:
                """Send the page."""
                self._answer(self._page)

            def do_POST(self) -> None:
                """Send what the page asks for."""
                self._answer(self._asked)

            def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
                """Write nothing: the address holds the token."""

            def _answer(self, make: Callable[[], tuple[str, str]]) -> None:
                try:
                    self._check()
                    answer = (HTTPStatus.OK, *make())
                except RefusedError as error:
                    answer = error.status, json.dumps(error.document), "application/json"
                try:
                    self._send(*answer)
                except (BrokenPipeError, ConnectionError):  # the page was closed or loaded anew meanwhile
                    self.close_connection = True

            def _page(self) -> tuple[str, str]:
                parts = urlsplit(self.path)
                if parts.path != "/":
                    raise _refused(HTTPStatus.NOT_FOUND)
                self._check_token("".join(parse_qs(parts.query).get("token", [])[:1]))
                return server.page(), "text/html"

            def _asked(self) -> tuple[str, str]:
                self._check_token(self.headers.get(TOKEN_HEADER, ""))
                name = self.path.removeprefix("/")
                if name not in server.answers:
                    raise _refused(HTTPStatus.NOT_FOUND)
                if self.headers.get_content_type() != "application/json":
                    raise _refused(HTTPStatus.UNSUPPORTED_MEDIA_TYPE)
                length = self.headers.get("Content-Length", "")
                if not (length.isascii() and length.isdigit()) or int(length) > MOST_BYTES:
                    raise _refused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
                try:
                    document = json.loads(self.rfile.read(int(length)))
                except (ValueError, RecursionError):
                    raise _refused(HTTPStatus.BAD_REQUEST) from None
                if not isinstance(document, dict):
                    raise _refused(HTTPStatus.BAD_REQUEST)
                return server.answers[name](document), "text/plain"

            def _check(self) -> None:
                own = {f"{HOST}:{server.port}", f"localhost:{server.port}"}
                if self.headers.get("Host", "") not in own:
                    raise _refused(HTTPStatus.MISDIRECTED_REQUEST)
                origin = self.headers.get("Origin")
                if origin is not None and origin not in {f"http://{host}" for host in own}:
                    raise _refused(HTTPStatus.FORBIDDEN)

            def _check_token(self, token: str) -> None:
                if not hmac.compare_digest(token.encode(), server.token.encode()):
                    raise _refused(HTTPStatus.FORBIDDEN)

            def _send(self, status: HTTPStatus, text: str, kind: str) -> None:
                content = text.encode()
                self.send_response(status)
                self.send_header("Content-Type", f"{kind}; charset=utf-8")
                self.send_header("Content-Length", str(len(content)))
                self.send_header("Cache-Control", "no-store")
                self.send_header("X-Content-Type-Options", "nosniff")
                self.send_header("X-Frame-Options", "DENY")
                self.send_header("Referrer-Policy", "no-referrer")
                self.send_header("Cross-Origin-Resource-Policy", "same-origin")
                self.end_headers()
                self.wfile.write(content)

        return Handler


def _refused(status: HTTPStatus) -> RefusedError:
    return RefusedError(status, {"refused": status.phrase})
