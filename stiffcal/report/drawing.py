"""The pictures of a report, drawn to files.

One after another: a second process would need as long to load what draws as for half of the pictures of a report.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.errors import Progress
from stiffcal.report.drawing_library import drawing_library
from stiffcal.report.figures.canvas import save_figure
from stiffcal.report.kept_pictures import KeptPictures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Of a large picture there are about as many; what is unused then takes some ten megabytes.
_OBJECTS_BETWEEN_COLLECTIONS = 100_000

Picture = tuple[str, Callable[[], "Figure"], Path]
"""What progress calls it, what draws it, and the SVG file to write."""


def draw_pictures(pictures: Sequence[Picture], progress: Progress) -> None:
    """Draw pictures to files; those that were drawn before are taken as they were.

    Parameters
    ----------
    pictures : what to draw, and where to.
    progress : receives each picture's name.
    """
    kept = KeptPictures()
    left = []
    for name, draw, file in pictures:
        key = kept.key(draw)
        if not kept.write(key, file):
            left.append((name, draw, file, key))
    if not left:
        return
    # Loaded first: the search for unused objects then leaves out what the library is made of.
    drawing_library()
    import matplotlib.backends.backend_svg
    import matplotlib.figure  # noqa: F401

    with _rarely_collecting():
        for number, (name, draw, file, key) in enumerate(left):
            progress(name, 0.9 * number / len(left))
            save_figure(draw(), file, text_as_shapes=False)
            kept.keep(key, file)


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
        # what is unused of the pictures, before it stands among objects that are looked at least often
        gc.collect()
        gc.unfreeze()
