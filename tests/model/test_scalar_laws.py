"""Laws as data answer as the effects' terms do, for every effect that is found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from stiffcal.compensation.linear_nodes import linear_nodes
from stiffcal.effects.two_slope import TwoSlope
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Effect, Geometry, Law, Place, Values
from stiffcal.model.forms import form_of
from stiffcal.model.parameters import ParameterRole
from stiffcal.model.scalar_laws import ScalarLaw
from tests.laboratory.robots import force_sensor_setup, six_axes

EFFECTS = find_effects()
FORMS = dict(EFFECTS)
FORMS["bearing-tilt, curved"] = form_of(EFFECTS["bearing-tilt"], ("x2",))
FORMS["joint-translation, curved"] = form_of(EFFECTS["joint-translation"], ("tx2",))
FORMS["cubic-stiffness, torque over angle"] = form_of(EFFECTS["cubic-stiffness"], ("p1",))
AT_REST = [name for name, effect in FORMS.items() if isinstance(effect, Law | Geometry)]


@pytest.mark.parametrize("name", AT_REST)
def test_every_effect_at_rest_is_a_matrix_or_a_law(name: str) -> None:
    """`linear_nodes` compares an effect's laws with its terms and refuses what differs."""
    chain, effect = six_axes(), FORMS[name]
    for place in effect.places(chain)[:2]:
        robot = CompliantRobot(chain, (PlacedEffect(effect, place, _values(effect)),))
        nodes = linear_nodes(robot, force_sensor_setup(chain), with_laws=True)
        assert not nodes.left_out


def test_a_law_that_differs_from_its_terms_is_refused() -> None:
    chain, effect = six_axes(), TwoSlope()
    place = effect.places(chain)[0]

    class Wrong(TwoSlope):
        def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
            return effect.scalar_laws(place, chain, {**values, "knee": 1.001 * values["knee"]})

    robot = CompliantRobot(chain, (PlacedEffect(Wrong(), place, _values(effect)),))
    with pytest.raises(ValueError, match="two-slope at j1"):
        linear_nodes(robot, force_sensor_setup(chain), with_laws=True)


def _values(effect: Effect) -> dict[str, float]:
    rng = np.random.default_rng(1)
    values = {}
    for spec in effect.parameters:
        scaled = spec.typical * rng.uniform(0.5, 2.0)
        values[spec.symbol] = spec.typical if spec.discrete or spec.role is ParameterRole.SETUP else scaled
    return values
