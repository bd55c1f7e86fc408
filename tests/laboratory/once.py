"""What several tests need and takes long is made once in a session, in whichever of pytest's processes needs it first.

`once` keeps what a function returns, `folder_once` a folder that one has filled; other processes wait meanwhile.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from stiffcal.files import try_lock

PLACE = "STIFFCAL_TESTS_MADE_ONCE"
"""Environment variable with the folder of this session, which all its processes share."""
Made = TypeVar("Made")


def once(make: Callable[..., Made], *arguments: Any) -> Made:
    """Return what ``make`` returns for these arguments, a copy for each caller.

    Parameters
    ----------
    make : a function of a module, whose result can be pickled and depends on its arguments alone.
    arguments : values whose `repr` says all of them.
    """
    with _alone(make, arguments) as place:
        kept = place.with_suffix(".pickle")
        if not kept.exists():
            result = make(*arguments)
            kept.write_bytes(pickle.dumps(result))
            return result
    copy: Made = pickle.loads(kept.read_bytes())
    return copy


def folder_once(make: Callable[..., object], *arguments: Any) -> Path:
    """Return a folder that ``make(folder, *arguments)`` has filled; not to be changed.

    Parameters
    ----------
    make : a function of a module; the folder that it gets exists and is empty.
    arguments : values whose `repr` says all of them.
    """
    with _alone(make, arguments) as place:
        made = place.with_suffix(".made")
        if not made.exists():
            shutil.rmtree(place, ignore_errors=True)  # of a call that failed
            place.mkdir()
            make(place, *arguments)
            made.touch()
    return place


@contextmanager
def _alone(make: Callable[..., object], arguments: tuple[Any, ...]) -> Iterator[Path]:
    """Give the place of a result, which other processes wait for until this one leaves it."""
    call = f"{make.__module__}.{make.__qualname__}{arguments!r}"
    name = hashlib.sha256(call.encode()).hexdigest()[:16]
    place = Path(os.environ[PLACE]) / f"{make.__name__.strip('_')}-{name}"
    with place.with_suffix(".lock").open("w") as lock:
        while not try_lock(lock.fileno()):
            time.sleep(0.05)
        yield place
