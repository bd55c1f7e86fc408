"""The unit table: right factors (pint as outside judge), and refusal of what it does not know."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from stiffcal.quantities import UnknownUnitError, quantities, unit, unit_names
from tests.laboratory.documentation import ROOT

PINT_NAMES = {
    "um": "micrometer",
    "in": "inch",
    "deg": "degree",
    "gon": "gradian",
    "arcmin": "arcminute",
    "arcsec": "arcsecond",
    "rev": "revolution",
    "urad": "microradian",
    "mrad": "milliradian",
    "daN": "decanewton",
    "kgf": "kilogram_force",
    "lbf": "pound_force",
    "N*cm": "newton*centimeter",
    "lbf*in": "pound_force*inch",
    "lbf*ft": "pound_force*foot",
    "h": "hour",
    "min": "minute",
    "t": "metric_ton",
    "lb": "pound",
    "deg/s": "degree/second",
    "mrad/s": "milliradian/second",
    "rev/s": "revolution/second",
    "rpm": "revolution/minute",
    "us": "microsecond",
}
SI = {
    "length": "m", "position": "m", "translation": "m", "angle": "rad", "rotation": "rad", "force": "N",
    "moment": "N*m", "torque": "N*m", "time": "s", "mass": "kg", "velocity": "rad/s", "current": "A",
}  # fmt: skip


def test_every_factor_agrees_with_pint() -> None:
    pint = pytest.importorskip("pint")
    registry = pint.UnitRegistry()
    for quantity, si in SI.items():
        for name in unit_names(quantity):
            expected = registry.Quantity(1.0, PINT_NAMES.get(name, name)).to(si).magnitude
            assert unit(name, quantity).factor == pytest.approx(expected, rel=1e-12), name


@pytest.mark.parametrize(("name", "value", "kelvin"), [("degC", 25.0, 298.15), ("K", 4.0, 4.0), ("degF", 32.0, 273.15)])
def test_temperatures_have_an_offset(name: str, value: float, kelvin: float) -> None:
    assert unit(name, "temperature").to_si(value) == pytest.approx(kelvin)


@pytest.mark.parametrize("name", ["N*m", "Nm", "N m", "N·m", "N.m", " N * m "])
def test_spellings_of_newton_metre(name: str) -> None:
    assert unit(name, "moment").factor == 1.0


@pytest.mark.parametrize("name", ["um", "µm", "μm", "micron"])
def test_spellings_of_micrometre(name: str) -> None:
    assert unit(name, "length").factor == 1e-6


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("Nm", "force"),
        ("nm", "moment"),
        ("MM", "length"),
        ("kg", "force"),
        ("", "time"),
        ("grad", "angle"),
        ("C", "time"),
    ],
)
def test_unknown_units_are_refused(name: str, quantity: str) -> None:
    with pytest.raises(UnknownUnitError) as caught:
        unit(name, quantity)
    assert unit_names(quantity)[0] in caught.value.mend


def test_a_unit_of_another_quantity_is_named() -> None:
    with pytest.raises(UnknownUnitError, match="unit of mass"):
        unit("kg", "force")


def test_unknown_quantity_is_refused() -> None:
    with pytest.raises(UnknownUnitError, match="not a known quantity"):
        unit("m", "colour")
    assert "length" in quantities()


def test_import_is_light() -> None:
    code = "import sys, stiffcal.quantities; print([m for m in ('numpy', 'pydantic', 'scipy') if m in sys.modules])"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"
    )


def test_a_strain_is_no_length_and_none_is_proposed_for_it() -> None:
    for written in ("um/m", "µm/m", "mm/m", "µε", "microstrain"):
        assert unit(written, "strain").factor in (1e-6, 1e-3)
        with pytest.raises(UnknownUnitError) as caught:
            unit(written, "length")
        assert "did you mean" not in caught.value.mend


def test_the_documentation_lists_every_unit() -> None:
    page = (ROOT / "docs" / "reference" / "campaign-folder.md").read_text("utf-8")
    rows = re.findall(
        r"^\| ([a-z, ]+) \| (`.*`) \|$", page.split("| quantity | units |")[1].split("\n\n")[0], re.MULTILINE
    )
    listed = {quantity: units for names, units in rows for quantity in names.split(", ")}
    assert listed == {quantity: ", ".join(f"`{name}`" for name in unit_names(quantity)) for quantity in quantities()}
    words = {
        "Newtons": ("force", "N"),
        "millimetres": ("length", "mm"),
        "degrees": ("angle", "deg"),
        "N-m": ("moment", "N*m"),
    }
    assert all(f"`{word}`" in page and unit(word, of).name == name for word, (of, name) in words.items())
