"""MATLAB's classes that any program can read from a MAT file."""

from __future__ import annotations

PLAIN_CLASSES = (
    "double",
    "single",
    "logical",
    "char",
    "cell",
    "struct",
    *(f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64)),
)
