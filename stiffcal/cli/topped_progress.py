"""A bar of rich with something above it; in a module of its own, as rich is needed when it is defined."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import RenderableType
from rich.progress import Progress


class ToppedProgress(Progress):
    """A progress bar below something else that is drawn with it."""

    above: RenderableType | None = None

    def get_renderables(self) -> Iterable[RenderableType]:
        """Return what is above, and the bar."""
        if self.above is not None:
            yield self.above
        yield from super().get_renderables()
