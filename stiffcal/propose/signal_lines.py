"""The lines of the signals that a log or a table holds: joints, load, displacement; every guess marked."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from stiffcal.escapes import toml_text
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.lines import DEFAULT_NAMES, FORCE_SENSOR, TRACKER, FrameNames, ProposedLine
from stiffcal.propose.role_units import columns_text, unit_of_signal
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.quantities import unit
from stiffcal.wording import length

_LARGEST_SIGMA_M = 5e-3
"""An instrument that is less certain than this shows no elasticity."""
_SIGMA_DOUBT = "sigma: one standard uncertainty of each reading"


def signal_lines(roles: Roles, names: FrameNames = DEFAULT_NAMES) -> list[ProposedLine]:
    """Return the lines of those signals that a log holds, every guess marked; empty where none is recognised."""
    lines = [joints_line(roles)] if roles.joints is not None else []
    lines += load_lines(roles, names.point, names.axes) if roles.force is not None else []
    moved = roles.deflection is not None or roles.position is not None
    return [*lines, *question_lines(roles), *(moved_lines(roles, names.body) if moved else [])]


def question_lines(roles: Roles) -> list[ProposedLine]:
    """Return a question about columns that may be moments or rotations, where no displacement takes the latter."""
    if roles.rotation is None or not roles.rotation.is_open or roles.deflection is not None:
        return []
    names = ", ".join(column.header for column in roles.rotation.columns)
    return [ProposedLine("", f"{names} are not used: moments (add them to the columns of wrench), or rotations?")]


def joints_line(roles: Roles, prismatic: Collection[SniffedColumn] = ()) -> ProposedLine:
    """Return the line of the joints' angles; `prismatic` are the columns that hold positions of prismatic joints."""
    assert roles.joints is not None
    if prismatic:  # one unit for each column
        return _line_of_mixed_joints(roles.joints, prismatic)
    size = max(column.size for column in roles.joints.columns)
    written, guessed = unit_of_signal(roles.joints, "joints")
    line = f"joints = {{ position = {columns_text(roles.joints)}, {toml_text.pair('units', {'position': written})} }}"
    doubts = [f"{written}, judged by the values (up to {size:.3g})"] if guessed else []
    doubts += [roles.joints.doubt] if roles.joints.doubt else []
    return ProposedLine(line, ", ".join(doubts) if doubts else None)


def _line_of_mixed_joints(joints: Role, prismatic: Collection[SniffedColumn]) -> ProposedLine:
    turns = Role(tuple(column for column in joints.columns if column not in prismatic))
    angle, guessed = unit_of_signal(turns, "joints") if turns.columns else ("", False)
    units, doubts = [angle] * len(joints.columns), [f"{angle}, judged by the values"] if guessed else []
    for k, column in enumerate(joints.columns):
        if column in prismatic:
            units[k], guessed = unit_of_signal(Role((column,)), "joints", prismatic=True)
            doubts += [f"{column.header} in {units[k]} (values up to {column.size:.3g})"] if guessed else []
    line = f"joints = {{ position = {columns_text(joints)}, {toml_text.pair('units', {'position': units})} }}"
    return ProposedLine(line, ", ".join(doubts) if doubts else None)


def load_lines(roles: Roles, tool: str, axes: str = DEFAULT_NAMES.axes) -> list[ProposedLine]:
    """Return the lines of the load: a wrench, or a mass; `tool` is the frame where it acts, `axes` those of a force."""
    if roles.force is None:
        assert roles.mass is not None
        written, _ = unit_of_signal(roles.mass, "mass")
        column = toml_text.value(roles.mass.columns[0].header)
        units = f"{{ mass = {toml_text.value(written)} }}"
        line = f"dead_weight = {{ mass_column = {column}, point = {toml_text.value(tool)}, units = {units} }}"
        return [ProposedLine(line, frames=(tool,))]
    doubts = []
    force, guessed = unit_of_signal(roles.force, "force")
    doubts += ["N"] if guessed else []
    units, columns = f"force = {toml_text.value(force)}", roles.force.columns
    if roles.moment is not None:
        moment, guessed = unit_of_signal(roles.moment, "moment")
        doubts += ["N*m"] if guessed else []
        units += f", moment = {toml_text.value(moment)}"
        columns += roles.moment.columns
    in_base = bool({"base", "world", "robot"} & roles.force.places)
    if roles.moment is not None and not in_base:
        frame = FORCE_SENSOR
        where = f"frame = {toml_text.value(frame)}"
        doubts.append("in the sensor's axes")
    else:
        frame = tool if roles.moment is None else FORCE_SENSOR
        axes = "base" if in_base or roles.moment is not None else axes
        where = f"{toml_text.pair('axes', axes)}, {toml_text.pair('point', frame)}"
        doubts += [] if in_base else [f"in {axes} axes"]
    doubts.append("acts on the robot")
    doubts += [roles.force.doubt] if roles.force.doubt else []
    line = f"wrench = {{ columns = {columns_text(Role(columns))}, units = {{ {units} }}, {where} }}"
    frames = (frame,) if axes in ("base", frame) else (axes, frame)
    return [ProposedLine(line, ", ".join(doubts), frames)]


def moved_lines(roles: Roles, body: str) -> list[ProposedLine]:
    """Return the lines of the displacement or the positions of a frame, `body`."""
    doubts = []
    if roles.deflection is not None:
        size = max(column.size for column in roles.deflection.columns)
        written, guessed = unit_of_signal(roles.deflection, "deflection")
        doubts += [f"{written}, judged by the values (up to {size:.3g})"] if guessed else []
        units, rotation = f"translation = {toml_text.value(written)}", ""
        if roles.rotation is not None:
            angle, guessed = unit_of_signal(roles.rotation, "rotation")
            if roles.rotation.is_open:
                doubts.append(
                    f"{', '.join(column.header for column in roles.rotation.columns)}: rotations, not moments"
                )
            doubts += [f"turns in {angle}"] if guessed else []
            units, rotation = (
                f"{units}, {toml_text.pair('rotation', angle)}",
                f", rotation = {columns_text(roles.rotation)}",
            )
        doubts += [] if roles.deflection.places else ["in base axes"]
        doubts += [roles.deflection.doubt] if roles.deflection.doubt else []
        columns = f"translation = {columns_text(roles.deflection)}{rotation}"
        sigma, why = _sigma(roles.deflection, "translation", written)
        of_body = toml_text.pair("body", body)
        line = f'deflection = {{ {columns}, units = {{ {units} }}{sigma}, {of_body}, axes = "base" }}'
        frames: tuple[str, ...] = (body,)
    else:
        assert roles.position is not None
        size = max(column.size for column in roles.position.columns)
        written, guessed = unit_of_signal(roles.position, "position")
        doubts += [f"{written}, judged by the values (up to {size:.4g})"] if guessed else []
        columns = f"position = {columns_text(roles.position)}"
        doubts += [roles.position.doubt] if roles.position.doubt else []
        doubts += [f"or of {', '.join(roles.position.others)}"] if roles.position.others else []
        for key, role in (("quaternion_wxyz", roles.quaternion), ("matrix", roles.matrix)):
            if role is not None and role.stands_still:
                doubts.append(f"{', '.join(c.header for c in role.columns)} never change: no measured orientation")
            elif role is not None:
                columns += f", {key} = {columns_text(role)}"
                break
        units = f"{{ position = {toml_text.value(written)} }}"
        sigma, why = _sigma(roles.position, "position", written)
        of_body = f"{toml_text.pair('frame', TRACKER)}, {toml_text.pair('body', body)}"
        line = f"pose = {{ {of_body}, {columns}, units = {units}{sigma} }}"
        frames = (TRACKER, body)
    doubts += [_SIGMA_DOUBT] if sigma else []
    return [ProposedLine(line, ", ".join(doubts) if doubts else None, frames), *why]


def target_tables(roles: Roles) -> list[ProposedLine]:
    """Return a table for each of several targets."""
    lines = []
    for name, role in roles.targets:
        size = max(column.size for column in role.columns)
        written, guessed = unit_of_signal(role, "position")
        sigma, why = _sigma(role, "position", written)
        doubt = f"{written}, judged by the values (up to {size:.4g})" if guessed else None
        lines += [
            ProposedLine(f"[sources.table.poses.{name}]"),
            ProposedLine(f"frame = {toml_text.value(TRACKER)}", frames=(TRACKER, name)),
            ProposedLine(f"position = {columns_text(role)}"),
            ProposedLine(f"units = {{ position = {toml_text.value(written)} }}", doubt),
            *([ProposedLine(sigma.removeprefix(", "), _SIGMA_DOUBT)] if sigma else []),
            *why,
        ]
    return lines


def _sigma(role: Role, key: str, written: str) -> tuple[str, list[ProposedLine]]:
    """Return the entry with the columns of a signal's uncertainty, "" without; or why the columns are left out.

    Parameters
    ----------
    role : readings. key : of `sigma`. written : the unit of the readings.
    """
    if role.sigma is None:
        return "", []
    columns = role.sigma.columns
    headers = [column.header for column in columns]
    stated_sigma: dict[str, toml_text.TomlValue] = {key: headers[0] if len(headers) == 1 else headers}
    factor = unit(written, "length").factor / role.sigma.coverage
    typical = float(np.nanmedian([value for column in columns for value in column.values])) * factor
    if role.sigma.coverage != 1.0:
        stated_sigma["coverage"] = role.sigma.coverage
    stated = sorted({column.unit for column in columns if column.unit is not None} - {written})
    if stated:
        why = f"is in {', '.join(stated)}, the readings in {written}"
    elif typical > _LARGEST_SIGMA_M:
        why = f"would be {length(typical)}"
    elif not role.sigma.steady:
        why = "varies as the scatter within single readings does; places may be uncertain by more"
    elif role.sigma.zero_rows:
        why = f"is 0 in {role.sigma.zero_rows} of the rows that were looked at, which states nothing"
    else:
        return f", {toml_text.pair('sigma', stated_sigma)}", []
    return "", [ProposedLine("", f"{toml_text.pair('sigma', stated_sigma)} left out: it {why}")]
