"""Laws of drives that hold at prismatic joints state what their parameters are there: force and position."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.laws.prismatic import spec_along_axis, specs_along_axis
from stiffcal.model.parameters import ParameterSpec

ROTARY = re.compile(r"torque|angle|turn|rotat|about|\brad\b")


def specs() -> Iterator[tuple[str, ParameterSpec]]:
    for name, effect in built_in_effects().items():
        if effect.prismatic and effect.prismatic == specs_along_axis(effect.parameters):
            forms = effect.forms or (effect,)
            yield from ((f"{name}.{spec.symbol}", spec) for form in forms for spec in form.parameters)


@pytest.mark.parametrize(("name", "spec"), list(specs()), ids=[name for name, _ in specs()])
def test_no_parameter_is_described_as_a_rotary_one(name: str, spec: ParameterSpec) -> None:
    along = spec_along_axis(spec)
    if along.unit == spec.unit:
        return  # no unit of a rotary drive: the same at both kinds of joint
    assert not ROTARY.search(along.unit)
    assert not ROTARY.search(along.meaning), f"{name} needs `meaning_along`"
    if ROTARY.search(spec.meaning):
        assert spec.meaning_along is not None
