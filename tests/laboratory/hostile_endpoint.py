"""An endpoint of S3 that hands on to a true one what is asked, until a request of a given kind comes."""

from __future__ import annotations

import re
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

Act = Callable[[socket.socket, bytes], None]
"""What is done instead of handing a request on: it gets the connection to the asker, and the request's first bytes."""
HEAD = b"HTTP/1.1 200 OK\r\nContent-Type: application/xml\r\nConnection: close\r\n\r\n"


class HostileEndpoint:
    """A port of this machine; `begins` is a pattern of the first bytes of the requests that `act` answers."""

    def __init__(self, port: int, begins: bytes, act: Act) -> None:
        self._port, self._begins, self._act = port, re.compile(begins), act
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        self.ended = threading.Event()
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        """Take no more connections."""
        self.ended.set()
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                asker, _ = self._listener.accept()
                threading.Thread(target=self._pass_on, args=(asker,), daemon=True).start()

    def _pass_on(self, asker: socket.socket) -> None:
        with suppress(OSError), asker, socket.create_connection(("127.0.0.1", self._port)) as server:
            threading.Thread(target=_copy, args=(server, asker), daemon=True).start()
            while content := asker.recv(1 << 16):
                if self._begins.match(content):
                    self._act(asker, content)
                    return
                server.sendall(content)


def _copy(source: socket.socket, target: socket.socket) -> None:
    with suppress(OSError):
        while content := source.recv(1 << 16):
            target.sendall(content)


@contextmanager
def hostile_endpoint(true: str, begins: bytes, act: Act) -> Iterator[HostileEndpoint]:
    """Hold an endpoint in front of the one at an address."""
    endpoint = HostileEndpoint(int(true.rpartition(":")[2]), begins, act)
    try:
        yield endpoint
    finally:
        endpoint.close()
