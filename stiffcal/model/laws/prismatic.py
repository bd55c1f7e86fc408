"""Laws of drives at prismatic joints: force along the axis in place of torque, and length in place of angle.

The law itself stays; units, bounds and usual sizes follow from those of the rotary drive, as if it moved the joint by a
rack and a pinion of 0.1 m radius: x = r φ and F = τ/r, so that 2e-6 rad/(N·m) become 2e-8 m/N (50 N/µm, a usual rack
or ball screw).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from stiffcal.model.parameters import ParameterSpec

PINION_RADIUS = 0.1
"""m."""
# unit of a rotary drive's parameter: unit along an axis, and the power of the pinion's radius between them
_ALONG_AXIS = {
    "rad": ("m", 1),
    "N·m": ("N", -1),
    "rad/(N·m)": ("m/N", 2),
    "rad/(N·m)²": ("m/N²", 3),
    "rad/(N·m)³": ("m/N³", 4),
    "N·m/rad": ("N/m", -2),
    "N·m/rad²": ("N/m²", -3),
    "N·m/rad³": ("N/m³", -4),
}
_TURN_ABOUT_Z, _SHIFT_ALONG_Z = 5, 2


def spec_along_axis(spec: ParameterSpec) -> ParameterSpec:
    """Return a parameter of a rotary drive's law as it is at a prismatic joint.

    Examples
    --------
    >>> words = {"meaning": "compliance per torque", "meaning_along": "compliance per force"}
    >>> compliance = ParameterSpec("c", "rad/(N·m)", lower=0.0, upper=1e-1, typical=2e-6, source="measured", **words)
    >>> along = spec_along_axis(compliance)
    >>> along.unit, along.meaning, f"{along.typical:.0e}"
    ('m/N', 'compliance per force', '2e-08')
    """
    if spec.unit not in _ALONG_AXIS:
        return spec
    unit, power = _ALONG_AXIS[spec.unit]
    factor = PINION_RADIUS**power
    return replace(
        spec,
        unit=unit,
        meaning=spec.meaning if spec.meaning_along is None else spec.meaning_along,
        lower=factor * spec.lower,
        upper=factor * spec.upper,
        typical=factor * spec.typical,
        tolerance=None if spec.tolerance is None else factor * spec.tolerance,
        source=f"as a rotary drive on a pinion of {PINION_RADIUS:g} m radius: {spec.source}",
        along=_SHIFT_ALONG_Z if spec.along == _TURN_ABOUT_Z else spec.along,
    )


def specs_along_axis(parameters: Iterable[ParameterSpec]) -> tuple[ParameterSpec, ...]:
    """Return the parameters of a rotary drive's law as they are at a prismatic joint."""
    return tuple(spec_along_axis(spec) for spec in parameters)
