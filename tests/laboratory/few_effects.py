"""A catalogue of a few effects, for tests of what stands around a search: same code, half the time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

from stiffcal.model.catalogue.catalogue import built_in_effects, find_effects
from stiffcal.model.catalogue.plugin_code import PluginCode
from stiffcal.model.effect import Effect

FEW = ("joint-compliance", "backlash", "two-slope", "bearing-tilt", "link-beam", "axis-coupling")
"""Effects of drives, bearings and links, one of a pair of joints; two that look alike."""


@contextmanager
def few_effects() -> Iterator[None]:
    """Have campaigns know `FEW` and their own code's effects, in this process."""
    others = built_in_effects().keys() - set(FEW)

    def chosen(plugins: PluginCode | None = None) -> dict[str, Effect]:
        return {name: effect for name, effect in find_effects(plugins).items() if name not in others}

    with patch("stiffcal.model.catalogue.campaign_effects.find_effects", chosen):
        yield
