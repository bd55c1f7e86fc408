"""Where the standard uncertainty of a rod's reading is from."""

from __future__ import annotations

from typing import Literal, TypeAlias

SigmaSource: TypeAlias = Literal["stated", "residuals", "none"]
