"""Which plugin code runs in this process, and who wants to know before it first does.

Why here, below everything: the command line sets what happens, without importing what loads plugins.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

_before: list[Callable[[tuple[str, ...]], None]] = []
_running: dict[str, str] = {}
_is_interruption: list[Callable[[], bool]] = []


def before_plugin_code(action: Callable[[tuple[str, ...]], None] | None) -> None:
    """Have an action called each time before plugin code is loaded, with the names of its files; None: no action."""
    _before[:] = [] if action is None else [action]


def interruptions_by(asked: Callable[[], bool] | None) -> None:
    """Set how the user's Ctrl-C differs from a `KeyboardInterrupt` that a plugin raises; None: all are the user's."""
    _is_interruption[:] = [] if asked is None else [asked]


def is_interruption() -> bool:
    """Return whether a `KeyboardInterrupt` that is under way is the user's."""
    return _is_interruption[0]() if _is_interruption else True


def about_to_run(files: Sequence[tuple[str, str]]) -> None:
    """Take note that plugin code runs from now on.

    Parameters
    ----------
    files : of each file the name in tracebacks, and the name for messages.
    """
    if any(name not in _running for name, _ in files):
        for action in _before:
            action(tuple(display_name for _, display_name in files))
        _running.update(files)


def running() -> tuple[str, ...]:
    """Return the names of the plugin files whose code has run in this process."""
    return tuple(_running.values())


def display_name_of(file: str) -> str | None:
    """Return the name for messages of a plugin file that has run; None where it is none.

    Parameters
    ----------
    file : its name in tracebacks.
    """
    return _running.get(file)


def forget() -> None:
    """Forget them, at the end of a command in a process that goes on."""
    _running.clear()


def place_in_plugin(error: BaseException) -> tuple[str, int, BaseException] | None:
    """Return file and line of the plugin code that an exception came through last, None where it came through none.

    Returns
    -------
    With it the exception that came from there: `error`, or one that led to it.
    """
    looked_at: set[int] = set()
    cause: BaseException | None = error
    while cause is not None and id(cause) not in looked_at:
        looked_at.add(id(cause))
        frame, origin = cause.__traceback__, None
        while frame is not None:
            display_name = _running.get(frame.tb_frame.f_code.co_filename)
            origin = origin if display_name is None else (display_name, frame.tb_lineno, cause)
            frame = frame.tb_next
        if origin is not None:
            return origin
        cause = cause.__cause__ or cause.__context__
    return None
