"""What `init --from` proposes for the uncertainty of absolute poses whose table states none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.toml_reading import parse_toml
from stiffcal.escapes import toml_text
from stiffcal.mechanics.like_poses import pose_groups
from stiffcal.propose.column_roles import Roles
from stiffcal.propose.lines import ProposedLine
from stiffcal.propose.table_purpose import serves_absolute
from stiffcal.propose.table_sniffing import ROWS_LOOKED_AT
from stiffcal.quantities import UnknownUnitError, unit

SAME_PLACE = float(np.radians(0.1))
"""Rows whose joints agree within this repeat each other, rad; a prismatic joint within as many m."""
ENOUGH_PAIRS = 10
"""Pairs whose 30 differences give the noise to 13 % (1/√(2·30)); fewer are a warning."""
_EXAMPLE_M = (15e-6, 6e-6)
"""Uncertainty of a laser tracker near and per metre, as its data sheet has it."""


def sigma_entry(written: str) -> str:
    """Return an example of `sigma` in the unit of the positions.

    Examples
    --------
    >>> sigma_entry("mm")
    'sigma = { position = 0.015, per_metre = 0.006 }'
    """
    near, far = (value / unit(written, "length").factor for value in _EXAMPLE_M)
    return f"sigma = {{ position = {near:.6g}, per_metre = {far:.6g} }}"


def where_from(written: str) -> str:
    """Return where the numbers of `sigma` are found, and what they are, in words."""
    return (
        f"standard uncertainty per axis, from the data sheet of the instrument, in {written} and {written} per metre "
        "(half of a stated limit, MPE or 2σ; per_metre for laser trackers)"
    )


def with_noise_lines(lines: Sequence[ProposedLine], roles: Roles) -> list[ProposedLine]:
    """Return the lines of a source of absolute poses, next to each position without `sigma` how to state it.

    Parameters
    ----------
    lines : of the source. roles : what the columns are.
    """
    if not serves_absolute(roles):
        return list(lines)
    keys = [parse_toml(line.toml, MANIFEST_FILE) for line in lines]
    joints = next((entry["joints"] for entry in keys if "joints" in entry), None)
    if joints is None:
        return list(lines)
    source = ProposedLine("", noise_source(roles, joints["units"]["position"]))
    result: list[ProposedLine] = []
    for number, line in enumerate(lines):
        result.append(line)
        inline = "pose" in keys[number]
        signal = keys[number].get("pose", keys[number])
        following = keys[number + 1] if number + 1 < len(lines) else {}
        written = signal.get("units", {}).get("position")
        if written is None or "sigma" in signal or "sigma" in following:
            continue
        where = "add to the braces of pose: " if inline else ""
        is_first = source not in result
        result.append(ProposedLine(f"# {where}{sigma_entry(written)}", where_from(written) if is_first else None))
        result += [source] if is_first else []
    return result


def sigma_of_logs(signals: Sequence[ProposedLine]) -> list[ProposedLine]:
    """Return how to state the uncertainty of the positions and forces of a log, where its lines do not.

    Examples
    --------
    >>> line = ProposedLine('pose = { position = ["X", "Y", "Z"], units = { position = "mm" } }')
    >>> [str(line).partition(";")[0] for line in sigma_of_logs([line])]
    ['# to the braces of pose: sigma = { position = 0.015 }, one standard uncertainty of a reading in mm']
    """
    lines = []
    for line in signals:
        entry = parse_toml(line.toml, MANIFEST_FILE)
        for signal, quantity, example in (("pose", "position", _EXAMPLE_M[0]), ("wrench", "force", _EXAMPLE_N)):
            written = entry.get(signal, {}).get("units", {}).get(quantity)
            if written is None or "sigma" in entry[signal]:
                continue
            value = example / unit(written, "length" if quantity == "position" else quantity).factor
            stated = toml_text.pair("sigma", {quantity: float(f"{value:.6g}")})
            lines.append(ProposedLine(f"# to the braces of {signal}: {stated}, {_ONE_READING} in {written}{_REPEATS}"))
    return lines


_EXAMPLE_N = 0.5
_ONE_READING = "one standard uncertainty of a reading"
_REPEATS = "; without it the noise is what repeats of a load show"


def noise_source(roles: Roles, joint_units: str | list[str]) -> str:
    """Return what the noise of absolute poses without `sigma` is taken from, in words.

    Parameters
    ----------
    joint_units : of the joint columns, one for all or one for each.
    """
    pairs, n_rows = repeated_pairs(roles, joint_units)
    if pairs == 0:
        return "no sigma is stated and no row repeats another: without it no error can be compared with the noise"
    at_least = "at least " if n_rows >= ROWS_LOOKED_AT else ""
    count = f"{at_least}{pairs} pair{'s' * (pairs != 1)} of rows that repeat each other (joints within 0.1°)"
    if pairs < ENOUGH_PAIRS:
        return f"no sigma is stated and only {count}: the noise is poorly known without it"
    return f"without sigma the noise is estimated from {count}"


def repeated_pairs(roles: Roles, joint_units: str | list[str]) -> tuple[int, int]:
    """Return how many rows repeat an earlier one, joints and payload alike, and how many rows were looked at."""
    assert roles.joints is not None
    columns = roles.joints.columns
    units = [joint_units] * len(columns) if isinstance(joint_units, str) else joint_units
    values = np.array([np.array(c.values) * _factor(text) for c, text in zip(columns, units, strict=True)])
    mass = roles.mass.columns[0].values if roles.mass is not None else ()
    load = np.array(mass) if len(mass) == values.shape[1] else np.zeros(values.shape[1])
    known = np.isfinite(values).all(axis=0)
    pose = pose_groups(values.T[known], SAME_PLACE)
    distinct = np.unique(np.column_stack([pose, np.nan_to_num(load[known])]), axis=0)
    return int(known.sum()) - len(distinct), values.shape[1]


def _factor(text: str) -> float:
    """Return the factor of a joint's unit to rad, of a prismatic joint's to m."""
    try:
        return unit(text, "angle").factor
    except UnknownUnitError:
        return unit(text, "length").factor
