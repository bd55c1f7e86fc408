"""A process that is asked to end does it as after Ctrl-C: what it was writing, or keeps for a while, is taken away."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def ended_in_order() -> Iterator[None]:
    """Have whatever asks this process to end do what Ctrl-C does: what is to be taken away is taken away."""
    asked = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in asked}
    # only where nobody else has chosen: nohup has SIGHUP ignored, and threads may not choose
    chosen = [number for number, action in before.items() if action is signal.SIG_DFL]
    if threading.current_thread() is not threading.main_thread():
        chosen = []
    for number in chosen:
        signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        for number in chosen:
            signal.signal(number, before[number])
