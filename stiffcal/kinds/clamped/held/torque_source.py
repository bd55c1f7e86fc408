"""What measures the torque on a clamped arm."""

from __future__ import annotations

from typing import Literal, TypeAlias

TorqueSource: TypeAlias = Literal["force sensor", "motor torque"]
"""What measures the torque on the arm."""
