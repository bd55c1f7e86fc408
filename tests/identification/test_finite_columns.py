"""Laws of a campaign's own whose derivatives are no numbers: a typical value of zero is a value, a NaN is an error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Observed, Place, Values
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played
from tests.rates.outside import CrossStiffness, Wander


class WithoutValue(Wander):
    """A law that has no value in these states."""

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return what is no number."""
        return {"c": np.full_like(observed.displacement, np.nan)}


def test_a_phase_that_is_typically_zero_is_fitted() -> None:
    """Its step is one of a size of its own: a step of nothing would divide zero by zero."""
    true = joint_springs(six_axes(), np.array(SIX_STIFFNESS))
    law = PlacedEffect(CrossStiffness(), Place("pairs", (2, 3)), {"c": 4e-7, "order": 2.3, "phase": 0.4})
    states = played(replace(true, placed=(*true.placed, law)), noise=Sigma(3e-6, 3e-6), runs=24)
    started = replace(law, values={"order": 2.3, "phase": 0.0})
    fit = identify_parameters(states, replace(true, placed=(*true.placed, started)))
    found = {parameter.name: parameter for parameter in fit.parameters}["cross-stiffness.j2-j3.phase"]
    assert found.std is not None
    assert found.value == pytest.approx(0.4, abs=4.0 * found.std)


def test_a_law_without_a_value_is_named() -> None:
    true = joint_springs(six_axes(), np.array(SIX_STIFFNESS))
    law = PlacedEffect(WithoutValue(), Place("setup", ()), {"seed": 1.0})
    with pytest.raises(
        InputError, match=r"^model.toml: effects: the derivative by wander.setup.c is not a finite number"
    ):
        identify_parameters(played(true, noise=Sigma(3e-6, 3e-6)), replace(true, placed=(*true.placed, law)))
