"""Masses that hang on the robot show in which unit the forces of a whole campaign were logged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.ingest import ingest_campaign
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.mistakes.known_weights import STANDARD_GRAVITY, force_over_weight, weight_warnings
from stiffcal.quantities import unit
from stiffcal.reduction.states.raw_states import RawStates, no_states
from tests.laboratory.small_campaign import write_small_campaign

RNG = np.random.default_rng(6)


def loaded(times: float, per_run: int = 4) -> RawStates:
    """Return runs of rising masses, the force as a sensor with a zero and a few newtons of noise reads it."""
    run = [f"pose{k // per_run}" for k in range(5 * per_run)]
    mass = np.tile(np.arange(per_run) * 12.0 if per_run > 1 else [24.0], 5)
    force = np.zeros((len(run), 6))
    force[:, 2] = -STANDARD_GRAVITY * mass * times
    zero = np.repeat(RNG.normal(size=(5, 3)) * 40.0 * times, per_run, axis=0) if per_run > 1 else 0.0
    force[:, :3] += zero + 0.5 * times * RNG.normal(size=(len(run), 3))
    empty = np.full(len(run), np.nan)
    signals = {"mass": mass[:, None], "wrench": force}
    return RawStates(run, np.arange(len(run)) + 1, empty, empty, signals, {}, np.ones(len(run), dtype=np.int64), [])


@pytest.mark.parametrize("per_run", [1, 4])
@pytest.mark.parametrize("logged", ["lbf", "kgf", "kN"])
def test_the_unit_is_named(logged: str, per_run: int) -> None:
    (warning,) = weight_warnings(loaded(1.0 / unit(logged, "force").factor, per_run)) or [""]
    assert f"forces in {logged} in a column of N" in warning


@pytest.mark.parametrize("per_run", [1, 4])
def test_forces_that_are_the_weights_warn_of_nothing(per_run: int) -> None:
    assert weight_warnings(loaded(1.0, per_run)) == []


def test_without_a_known_mass_nothing_is_judged() -> None:
    states = loaded(0.2)
    del states.signals["mass"]
    assert force_over_weight(states) is None
    assert force_over_weight(no_states()) is None


def test_check_and_ingest_say_it(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "weights")
    manifest, table = folder / "campaign.toml", folder / "raw" / "states.csv"
    header, *lines = table.read_text(encoding="utf-8").splitlines()
    columns = header.split(",")
    place = [columns.index(name) for name in ("Fx", "Fy", "Fz")]
    rows = []
    for line in lines:
        size = np.linalg.norm([float(line.split(",")[k]) for k in place])
        rows.append(f"{line},{4.4482216 * size / STANDARD_GRAVITY:.4f}")
    table.write_text("\n".join([f"{header},kg", *rows]) + "\n", encoding="utf-8")
    text = manifest.read_text(encoding="utf-8")
    line = '\ndead_weight = { mass_column = "kg", point = "load_point" }\n[sources.table.pose]'
    manifest.write_text(text.replace("\n[sources.table.pose]", line), encoding="utf-8")
    for answer in (check_campaign(folder), ingest_campaign(folder)):
        assert any("forces in lbf in a column of N" in warning for warning in answer.warnings)
