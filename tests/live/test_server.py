"""The server of a live page: who has no token, another host's name or another origin gets nothing."""

from __future__ import annotations

import http.client
import json
import socket
import struct
import threading
from collections.abc import Iterator
from http import HTTPStatus
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest

from stiffcal.live.page import live_server
from stiffcal.live.server import MOST_BYTES, LiveServer, RefusedError
from stiffcal.stages.steps import RunContext
from stiffcal.view.packing import unpacked


@pytest.fixture
def server(campaign: Path) -> Iterator[LiveServer]:
    made = live_server(campaign, RunContext())
    thread = threading.Thread(target=made.serve)
    thread.start()
    yield made
    made.stop()
    thread.join()


def _ask(
    server: LiveServer, method: str, path: str, body: str | None = None, **headers: str
) -> tuple[int, str, dict[str, str]]:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    connection.request(method, path, body, {name.replace("_", "-"): value for name, value in headers.items()})
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, text, dict(answer.getheaders())


def _post(server: LiveServer, name: str, document: object, **headers: str) -> tuple[int, str]:
    own = {"X_Stiffcal_Token": server.token, "Content_Type": "application/json", **headers}
    return _ask(server, "POST", f"/{name}", json.dumps(document), **own)[:2]


def test_only_the_address_that_the_terminal_shows_opens_the_page(server: LiveServer) -> None:
    path = urlsplit(server.address)
    assert (path.hostname, path.port) == ("127.0.0.1", server.port)
    assert len(parse_qs(path.query)["token"][0]) >= 40
    status, text, headers = _ask(server, "GET", f"/?{path.query}")
    assert status == 200
    assert "connect-src 'self'" in text
    assert server.token not in text
    assert headers["Cache-Control"] == "no-store"
    assert headers["Referrer-Policy"] == "no-referrer"
    for other in ("/", "/?token=", "/?token=x", f"/campaign.toml?{path.query}", "/../campaign.toml"):
        assert _ask(server, "GET", other)[0] in (403, 404), other
    for method in ("PUT", "DELETE", "OPTIONS", "HEAD"):
        assert _ask(server, method, f"/?{path.query}")[0] == 501, method


@pytest.mark.parametrize(
    "headers",
    [
        {"X_Stiffcal_Token": ""},
        {"X_Stiffcal_Token": "x" * 43},
        {"X_Stiffcal_Token": "ü"},
        {"Host": "evil.example"},
        {"Host": "127.0.0.1"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Content_Type": "text/plain"},
        {"Content_Length": "-1"},
        {"Content_Length": str(MOST_BYTES + 1)},
    ],
    ids=str,
)
def test_other_sites_and_users_change_nothing(server: LiveServer, campaign: Path, headers: dict[str, str]) -> None:
    before = (campaign / "model.toml").read_bytes() if (campaign / "model.toml").exists() else b""
    status, _ = _post(server, "write", {"choice": {"added": ["bearing-tilt j2"]}}, **headers)
    assert status in (400, 403, 413, 415, 421)
    assert ((campaign / "model.toml").read_bytes() if (campaign / "model.toml").exists() else b"") == before


def test_a_choice_is_answered_with_the_page_s_data(server: LiveServer) -> None:
    status, text = _post(server, "content", {"choice": {"added": ["bearing-tilt j2"]}})
    assert status == 200
    document, _ = unpacked(text)
    assert document["live"]["added"] == ["bearing-tilt j2"]
    assert next(model for model in document["models"] if model["present"])["label"] == "tried: + bearing-tilt j2"


@pytest.mark.parametrize(
    ("choice", "status"),
    [
        ({"added": ["no-such-effect j2"]}, 422),
        ({"added": ["bearing-tilt j99"]}, 422),
        ({"added": ["bearing-tilt"]}, 422),
        ({"removed": ["backlash j2"]}, 422),
        ({"added": "bearing-tilt j2"}, 400),
        ({"excluded": [{"source": "table", "rows": ["a"]}]}, 400),
        ([], 400),
    ],
    ids=str,
)
def test_what_is_no_choice_is_refused_in_words(server: LiveServer, choice: object, status: int) -> None:
    got, text = _post(server, "content", {"choice": choice})
    assert got == status
    answer = json.loads(text)
    assert {"error", "refused"} & {*answer}
    assert "Traceback" not in text


def test_a_stranger_s_text_is_text(campaign: Path) -> None:
    manifest = campaign / "campaign.toml"
    text = manifest.read_text()
    line = next(line for line in text.splitlines() if line.startswith("name ="))
    manifest.write_text(text.replace(line, 'name = "<script>alert(1)</script>"'))
    made = live_server(campaign, RunContext())
    assert "<script>alert" not in made.page()
    made.close()


def test_who_leaves_before_the_answer_leaves_no_traceback(capfd: pytest.CaptureFixture[str]) -> None:
    asked, gone, answered = threading.Event(), threading.Event(), threading.Event()

    def page() -> str:
        asked.set()
        gone.wait(60.0)
        answered.set()
        raise RefusedError(HTTPStatus.CONFLICT, {"superseded": True})

    made = LiveServer(page, {})
    made._http.daemon_threads = False  # closing the server waits for the one that answers
    thread = threading.Thread(target=made.serve)
    thread.start()
    client = socket.create_connection(("127.0.0.1", made.port))
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # closed at once, as by a reset
    host = f"Host: 127.0.0.1:{made.port}"
    client.sendall(f"GET /?token={made.token} HTTP/1.1\r\n{host}\r\n\r\n".encode())
    assert asked.wait(60.0)
    client.close()
    gone.set()
    assert answered.wait(60.0)
    made.stop()
    thread.join()
    assert "Traceback" not in capfd.readouterr().err
