"""Conventions of rows of joint parameters: Denavit and Hartenberg's, and Craig's."""

from __future__ import annotations

from typing import Literal, TypeAlias

Convention: TypeAlias = Literal["dh", "modified-dh"]
