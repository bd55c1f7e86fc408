"""An answer of a lab: which motor became hottest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from stiffcal.documents import CommandResult
from stiffcal.presentation.pictures import Line, Panel, Picture
from stiffcal.presentation.values import Page
from stiffcal.show.builder import PageBuilder, number
from stiffcal.show.options import ShowOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class HottestMotorResult(CommandResult):
    schema: Literal["stiffcal/hottest-motor/1"] = "stiffcal/hottest-motor/1"
    celsius: list[float]


def page(result: HottestMotorResult, options: ShowOptions) -> Page:
    made = PageBuilder("The hottest motor")
    made.say(f"motor {int(np.argmax(result.celsius)) + 1} became <hottest>", "hottest", "warn")
    made.table(("motor", number("temperature [°C]")), [(f"{k}", f"{t:.1f}") for k, t in enumerate(result.celsius, 1)])
    line = Line(np.arange(1.0, 1.0 + len(result.celsius)), np.array(result.celsius))
    made.draw(Picture((Panel("", "motor", "temperature [°C]", (line,)),), columns=1, height=40.0, caption=("Warmth.",)))
    return made.page()
