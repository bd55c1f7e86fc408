"""The values of a candidate's linear refit, and of all that is missing, against a fit that holds the effect."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.diagnosis.refits.refits import StoredRefits
from stiffcal.measurements.columns import values_of
from stiffcal.stages.diagnoses.stored_curves import REFITS
from stiffcal.stages.steps import RunContext, stored_result, up_to_date_states
from tests.laboratory.small_campaign import write_small_campaign

pytestmark = pytest.mark.usefixtures("few_known_effects")


def test_values_and_intervals_are_those_of_a_fit_with_the_effect(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=4)
    model = folder / "model.toml"
    model.write_text(model.read_text("utf-8").replace("4, 5, 6]", "4, 5]"), encoding="utf-8")
    diagnosis = diagnose_campaign(folder)
    assert [(entry.effect, entry.where.joints) for entry in diagnosis.missing] == [("joint-compliance", [6])]
    store = up_to_date_states(folder, RunContext()).store
    stored = stored_result(store, REFITS, StoredRefits)
    assert stored is not None
    with_all = next(entry for entry in stored.entries if entry.change == "all")
    alone = next(entry for entry in stored.entries if entry.change == "with" and entry.effect == "joint-compliance")
    assert [(entry.effect, entry.where.joints) for entry in with_all.added] == [("joint-compliance", [6])]
    assert with_all.heldout_rms == diagnosis.heldout_rms_with_missing
    # the residuals that the page draws are those of the stated error
    table = store.read_table(REFITS)
    rows = values_of(table.column("entry")) == stored.entries.index(with_all)
    names = [name for name in table.column_names if name.startswith("target_d") and name.endswith("_m_residual")]
    squares = sum(values_of(table.column(name))[rows] ** 2 for name in names)
    assert len(names) == 3
    assert np.sqrt(np.nanmean(squares)) == pytest.approx(with_all.heldout_rms.translation, rel=0.01)
    edit_model(folder, "add", "joint-compliance", where={"joints": "6"})
    fitted = {parameter.name: parameter for parameter in identify_campaign(folder).parameters}
    for refit in (with_all, alone):
        assert [value.name for value in refit.values] == list(fitted)
        for value in refit.values:
            parameter = fitted[value.name]
            assert value.value == pytest.approx(parameter.value, rel=0.01), (refit.change, value.name)
            # a fit adds the geometry's tolerance, and its noise is of its own residuals: by a tenth at most here
            assert _width(value.interval) == pytest.approx(_width(parameter.interval), rel=0.12)


def _width(interval: list[float | None] | None) -> float:
    assert interval is not None
    low, high = interval
    assert low is not None
    assert high is not None
    return high - low
