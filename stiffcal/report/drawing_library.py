"""Loading matplotlib without the settings that lie in the current folder.

matplotlib looks for a file ``matplotlibrc`` in the current folder before all other places, and has no option against
it. That folder may be somebody else's campaign, and the file there a pipe, which would never end, or settings that
name programs. The user's own settings, ``MATPLOTLIBRC`` included, are read as ever, though every picture is drawn with
settings of its own.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

_SETTINGS = "matplotlibrc"
_lock = threading.Lock()


def drawing_library() -> ModuleType:
    """Return matplotlib."""
    if "matplotlib" in sys.modules:
        return sys.modules["matplotlib"]
    with _lock, _without_settings_of_the_current_folder():
        import matplotlib

        return matplotlib


@contextmanager
def _without_settings_of_the_current_folder() -> Iterator[None]:
    """While matplotlib is loaded, answer its question after that one relative path with no; all others as ever."""
    exists = os.path.exists

    def exists_elsewhere(path: Any) -> bool:
        return path != _SETTINGS and exists(path)

    os.path.exists = exists_elsewhere
    try:
        yield
    finally:
        os.path.exists = exists
