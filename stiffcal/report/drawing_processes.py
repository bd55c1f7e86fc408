"""Pictures drawn by several processes at once; the same bytes whatever their number."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.errors import Progress
from stiffcal.processes import run_in_processes
from stiffcal.report.drawing_library import drawing_library
from stiffcal.report.figures.canvas import save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Fewer pictures are drawn before a second process is ready.
LEAST_PICTURES = 4
# Of a large picture there are about as many; what is unused then takes some ten megabytes.
_OBJECTS_BETWEEN_COLLECTIONS = 100_000

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
    if len(pictures) < LEAST_PICTURES:
        processes = 1
    # Loaded once, before processes are split: every one then has it.
    drawing_library()
    import matplotlib.backends.backend_svg
    import matplotlib.figure  # noqa: F401

    def task(number: int) -> Callable[[], None]:
        return lambda: _draw(pictures[number], progress, number / len(pictures))

    with _rarely_collecting():
        run_in_processes([task(number) for number in range(len(pictures))], processes)


@contextmanager
def _rarely_collecting() -> Iterator[None]:
    """Let Python search for unused objects only now and then.

    A picture is some ten thousand objects that refer to each other: the search would go through all of them, and
    through those of all libraries, dozens of times for each picture.
    """
    thresholds = gc.get_threshold()
    gc.freeze()
    gc.set_threshold(_OBJECTS_BETWEEN_COLLECTIONS, *thresholds[1:])
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)
        gc.unfreeze()


def _draw(picture: Picture, progress: Progress, share: float) -> None:
    name, draw, file = picture
    progress(name, 0.9 * share)
    save_figure(draw(), file, text_as_shapes=False)
