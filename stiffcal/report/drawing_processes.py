"""Pictures drawn by several processes at once; the same bytes whatever their number."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.errors import Progress
from stiffcal.report.drawing_library import drawing_library
from stiffcal.report.figures.canvas import save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Processes that draw: each picture takes a tenth of a second to a second, and more would wait for memory.
MOST_PROCESSES = 4
# Fewer pictures are drawn before a second process is ready.
LEAST_PICTURES = 4

Picture = tuple[str, Callable[[], "Figure"], Path]
"""What progress calls it, what draws it, and the SVG file to write."""


def draw_pictures(pictures: Sequence[Picture], progress: Progress, processes: int | None = None) -> None:
    """Draw pictures to files.

    Parameters
    ----------
    pictures : what to draw, and where to.
    progress : receives each picture's name.
    processes : how many draw; None: as many as processors, where a process can be split.
    """
    count = min(_usable_processes() if processes is None else processes, MOST_PROCESSES)
    if count < 2 or len(pictures) < LEAST_PICTURES:
        _draw(pictures, progress)
        return
    import multiprocessing

    # Loaded once, before the split: every process then has it.
    drawing_library()
    import matplotlib.backends.backend_svg
    import matplotlib.figure  # noqa: F401

    split = multiprocessing.get_context("fork")
    shares = [pictures[number::count] for number in range(count)]
    helpers = [split.Process(target=_draw, args=(share, _quiet)) for share in shares[1:]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads in libraries that drawing does not use
        for helper in helpers:
            helper.start()
    try:
        _draw(shares[0], progress)
    finally:
        for helper in helpers:
            helper.join()
    for helper, share in zip(helpers, shares[1:], strict=True):
        if helper.exitcode != 0:
            # Whatever went wrong there happens again here, and is reported as ever.
            _draw(share, progress)


def _draw(pictures: Sequence[Picture], progress: Progress) -> None:
    for number, (name, draw, file) in enumerate(pictures):
        progress(name, 0.9 * number / len(pictures))
        save_figure(draw(), file, text_as_shapes=False)


def _quiet(text: str, share: float | None) -> None:
    """Report no progress: the first process does."""


def _usable_processes() -> int:
    """Return the number of processors that this process may use; 1 where a process cannot be split safely."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else 1
