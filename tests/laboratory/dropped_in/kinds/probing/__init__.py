"""Runs that touch a plate: its height is where the tip stood, and they judge each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.kinds import ExperimentKind
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.kinds.reduction import RunsReduction
from stiffcal.kinds.results import ExperimentFit, ExperimentValidation
from stiffcal.measurements.columns import table_of, values_of
from stiffcal.presentation.pictures import Line, Marks, Panel, Picture
from stiffcal.presentation.values import Column, Overview, Page, Plot, Sentence, Table
from stiffcal.presentation.words import Digits, Words
from stiffcal.reduction.logs.blocks import Blocks
from stiffcal.reduction.states.ingested_runs import IngestedRun
from stiffcal.store.provenance import IngestSettings

if TYPE_CHECKING:
    from stiffcal.kinds.results import IdentifiedModel


class ProbingOptions(TomlTable):
    """What is touched.

    Attributes
    ----------
    plate : its name.
    """

    plate: Name


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbingSection:
    """The plate."""

    plate: str
    height: float
    """m."""
    heights: dict[str, float]
    """By run, m."""


class ProbingReduction(RunsReduction):
    """The height at which each run touches."""

    def __init__(self, campaign: Campaign) -> None:
        super().__init__(campaign)
        self._heights: dict[str, float] = {}

    def add(self, run: Run, logs: Mapping[str, Blocks]) -> None:
        """Average the height over a run."""
        (blocks,) = logs.values()
        self._heights[run.id] = float(blocks.mean["position.tip"][:, 2].mean())
        entry = IngestedRun(id=run.id, clock_ahead_s={}, n_states=0, n_readings=len(blocks), dropped=[])
        self.entries.append(entry)

    def tables(self, settings: IngestSettings) -> dict[str, pa.Table]:
        """Return a row for each run."""
        if not self._heights:
            return {}
        return {"probing": table_of({"run": list(self._heights), "height_m": np.array(list(self._heights.values()))})}

    def check(self) -> tuple[list[str], list[str]]:
        """Ask for two runs."""
        return (["probing: touch the plate twice"] if len(self._heights) == 1 else []), []


class ProbingKind(ExperimentKind):
    """The height of a plate."""

    def reduction(self, campaign: Campaign) -> RunsReduction:
        """Collect the heights."""
        return ProbingReduction(campaign)

    def fit(self, data: MeasuredRuns) -> ExperimentFit | None:
        """Average the heights of all runs."""
        heights = data.read("probing", _heights)
        if heights is None:
            return None
        found = np.array(list(heights.values()))
        plate = str(data.campaign.manifest.runs[0].options_of("probing")["plate"])
        return ExperimentFit(
            name="probing",
            section=ProbingSection(plate=plate, height=float(found.mean()), heights=heights),
            rms={"translation": _rms(found - found.mean())},
            n_runs=found.size,
            n_readings=found.size,
            expected="the plate stands where it was touched",
            tables={"probing_fit": table_of({"run": list(heights), "residual_m": found - found.mean()})},
        )

    def section_type(self) -> type[object]:
        """Return the type of the section in ``identify``."""
        return ProbingSection

    def validate(self, data: MeasuredRuns) -> ExperimentValidation | None:
        """Hold each run against the mean of the others."""
        heights = data.read("probing", _heights)
        if heights is None:
            return None
        found = np.array(list(heights.values()))
        left = (found - found.mean()) * found.size / (found.size - 1)
        return ExperimentValidation(
            name="probing",
            scheme="each run left out",
            rms={"translation": _rms(left)},
            max={"translation": float(np.abs(left).max())},
            noise={},
            relative={},
            zero_model={"translation": _rms(found)},
            n_readings=found.size,
        )

    def overview(self, identified: IdentifiedModel) -> Overview | None:
        """Return a row for each run."""
        section = _section(identified)
        return None if section is None else Overview((_sentence(section), _table(section)))

    def page(self, data: MeasuredRuns, identified: IdentifiedModel) -> Page | None:
        """Return the same with a picture."""
        section = _section(identified)
        if section is None:
            return None
        blocks = (_sentence(section), _table(section), _picture(section))
        return Page("The plate", blocks, subject="touched plate", subject_of_model="Height of a plate")

    def plot(self, data: MeasuredRuns, identified: IdentifiedModel, run: str | None, joint: str | None) -> Plot | None:
        """Return the picture alone."""
        section = _section(identified)
        return None if section is None else Plot(_picture(section), "heights of the plate")


def _section(identified: IdentifiedModel) -> ProbingSection | None:
    section = identified.section("probing")
    return section if isinstance(section, ProbingSection) else None


def _heights(table: pa.Table) -> dict[str, float]:
    return dict(zip(table.column("run").to_pylist(), values_of(table.column("height_m")).tolist(), strict=True))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _sentence(section: ProbingSection) -> Sentence:
    return Sentence((f"the {section.plate} plate stands at ", Digits(section.height, 4), " m"), "plate")


def _table(section: ProbingSection) -> Table:
    rows: tuple[tuple[Words, ...], ...] = tuple(
        ((run,), (Digits(1e3 * height, 6),)) for run, height in section.heights.items()
    )
    return Table((Column("touched in", numbers=False), Column("height", "mm")), rows, "Where the tip stood.")


def _picture(section: ProbingSection) -> Picture:
    number, height = np.arange(len(section.heights), dtype=np.float64), np.array(list(section.heights.values()))
    series = (Marks(number, height, "o", 0, label="a run"), Line(number, np.full(number.size, section.height)))
    return Picture((Panel("heights", "run", "height [m]", series),), columns=1, height=60.0, caption=("Heights.",))


KIND = ProbingKind("probing", options=ProbingOptions, tables=("probing",), fit_tables=("probing_fit",), measures=None)
