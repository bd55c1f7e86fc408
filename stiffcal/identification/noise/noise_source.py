"""Where the standard uncertainty of a reading is from."""

from __future__ import annotations

from typing import Literal, TypeAlias

NoiseSource: TypeAlias = Literal["repeats", "neighbours", "manifest", "none"]
