"""Readings of one run that were pasted into another with noise: the run is named, and not only where they are exact."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.ingest.checks.loaded import check_campaign
from tests.laboratory.displacement_table import DISPLACEMENTS, FORCES, MANIFEST, ramps, write_displacement_campaign

STEPS = np.linspace(0.0, 1.0, 4)
RUNS = 10
MANIFEST_OF_RUNS = MANIFEST.replace('{ each = "row" }', '{ column = "run" }')


@pytest.mark.parametrize("names", [DISPLACEMENTS, (*FORCES, *DISPLACEMENTS)])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_readings_of_another_run_make_a_run_a_suspect(names: tuple[str, ...], noise: float, tmp_path: Path) -> None:
    rng, n = np.random.default_rng(3), len(STEPS)
    columns = {"run": np.repeat(np.arange(1.0, RUNS + 1.0), n), **ramps(RUNS, STEPS)}
    for name in names:
        columns[name][n : 2 * n] = columns[name][4 * n : 5 * n] + noise * rng.standard_normal(n)
    folder = write_displacement_campaign(tmp_path / "cell", columns, MANIFEST_OF_RUNS)
    suspects = check_campaign(folder).suspects or []
    assert [float(suspect.run) for suspect in suspects] == [2.0]
