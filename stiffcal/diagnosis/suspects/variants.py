"""What may be wrong with a run: its states as they would be if one mistake were taken back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import log, pi

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.suspects.result import SuspectKind
from stiffcal.diagnosis.suspects.time_order import TimeOrder
from stiffcal.measurements.load_states import LoadStates, RunInfo
from stiffcal.mechanics.chain import Chain

KGF, LBF = 9.80665, 4.4482216152605
"""N; kgf by the third General Conference on Weights and Measures (1901), lbf by the international pound of 1959."""
INCH, FOOT = 0.0254, 0.3048  # m

FORCE_UNITS = (
    ("kgf", KGF, 1.0 / KGF),
    ("lbf", LBF, 1.0 / LBF),
    ("kN", 1e3, 1e-3),
)
MOMENT_UNITS = (
    ("N·mm", 1e-3, 1e3),
    ("N·cm", 1e-2, 1e2),
    ("lbf·in", LBF * INCH, 1.0 / (LBF * INCH)),
    ("lbf·ft", LBF * FOOT, 1.0 / (LBF * FOOT)),
    ("kgf·m", KGF, 1.0 / KGF),
    ("kgf·cm", KGF * 1e-2, 1e2 / KGF),
)
LENGTH_UNITS = (
    (1e3, "in m in a column of mm"),
    (1e-3, "in µm in a column of mm, or in mm in a column of m"),
    (1e3 * INCH, "in inches in a column of mm"),
    (1e-3 / INCH, "in mm in a column of inches"),
    (10.0, "in cm in a column of mm"),
    (0.1, "in mm in a column of cm"),
)
ANGLE_UNITS = (
    (1e3, "in rad in a column of mrad"),
    (1e-3, "in mrad in a column of rad"),
    (180.0 / pi, "in rad in a column of degrees"),
    (pi / 180.0, "in degrees in a column of rad"),
)
TWO_FACTORS = 4.0
MOST_NEIGHBOURS = 200
LARGEST_LOAD = 1e5  # N, N·m: beyond it no reading of a robot's load is, in any unit


@dataclass(frozen=True)
class Variant:
    """A run's states with one mistake taken back."""

    kind: SuspectKind
    """What the mistake was."""
    likely: str
    """Cause and cure, in words."""
    factor: float | None = None
    """By what readings are multiplied; None where nothing is."""
    joints: Floats | None = None
    """Of the run's states; None where as read."""
    wrench: Floats | None = None
    """Of the run's states; None where as read."""
    position: Floats | None = None
    """Of the run's states; None where as read."""
    rotation: Floats | None = None
    """Of the run's states; None where as read."""
    deflection: Floats | None = None
    """Of the run's states; None where as read."""
    other: int | None = None
    """The run that has the readings that belong here; None where no other run takes part."""
    penalty: float = 0.0
    """How much less likely it is before any look at the numbers, as a difference of squared misfits: twice the
    logarithm of how many like mistakes there are to choose from.
    """


def variants_of(
    states: LoadStates, members: Sequence[Integers], run: int, chain: Chain, left_out: Sequence[int] = ()
) -> list[Variant]:
    """Return the possible faults of a run.

    Parameters
    ----------
    states : of the whole campaign. members : the states of each run. run : which one.
    chain : for the names of joints.
    left_out : other runs that stand apart. Where there are many runs, a run is compared with these and with those
        measured shortly before and after it.
    """
    run_states = states.select(members[run])
    single = [*_units(run_states), *_signs(run_states, chain)]
    single = [replace(variant, penalty=variant.penalty + 2.0 * log(len(single))) for variant in single]
    return [*single, *_of_others(states, members, run, left_out)]


def trial_states(states: LoadStates, own: Integers, variants: Sequence[Variant]) -> LoadStates:
    """Return a run's states once for every variant, each a run of its own.

    Parameters
    ----------
    states : of the whole campaign. own : (k,) the run's states. variants : V of them.
    """
    picked = states.select(np.tile(own, len(variants)))
    arrays: dict[str, Floats] = {}
    for name in ("joints", "wrench", "position", "rotation", "deflection"):
        as_read = getattr(states, name)[own]
        arrays[name] = np.concatenate(
            [as_read if getattr(variant, name) is None else getattr(variant, name) for variant in variants]
        )
    return replace(
        picked,
        runs=tuple(RunInfo(f"variant {number + 1}") for number in range(len(variants))),
        run=np.repeat(np.arange(len(variants)), len(own)),
        joints=arrays["joints"],
        wrench=arrays["wrench"],
        position=arrays["position"],
        rotation=arrays["rotation"],
        deflection=arrays["deflection"],
    )


def _units(own: LoadStates) -> Iterator[Variant]:
    yield from _wrench_units(own)
    translation = slice(0, 3)
    for factor, text in LENGTH_UNITS:
        likely = f"displacements are {text}: multiply by {factor:.5g}"
        if own.deflection_given:
            yield Variant(SuspectKind.UNIT, likely, factor, deflection=_scaled(own.deflection, translation, factor))
        else:
            likely = f"places are {text}: multiply by {factor:.5g}"
            yield Variant(SuspectKind.UNIT, likely, factor, position=own.position * factor)
    if np.isfinite(own.deflection[:, :, 3:]).any():
        for factor, text in ANGLE_UNITS:
            likely = f"rotations are {text}: multiply by {factor:.5g}"
            yield Variant(SuspectKind.UNIT, likely, factor, deflection=_scaled(own.deflection, slice(3, 6), factor))
    for factor, text in ANGLE_UNITS[2:]:
        likely = f"joint angles are {text}: multiply by {factor:.5g}"
        yield Variant(SuspectKind.UNIT, likely, factor, joints=own.joints * factor)


def _wrench_units(own: LoadStates) -> Iterator[Variant]:
    moments = own.setup.moments_measured
    forces = [
        (factor, f"are in {name}" if factor == up else f"are in N in a column of {name}")
        for name, up, down in FORCE_UNITS
        for factor in (up, down)
    ]
    for factor, text in forces:
        yield _with_wrench(own, factor, 1.0, f"forces {text}: multiply by {factor:.5g}")
    if not moments:
        return
    for factor, text in forces:
        likely = f"forces and moments {text}: multiply both by {factor:.5g}"
        yield _with_wrench(own, factor, factor, likely)
    for name, up, down in MOMENT_UNITS:
        yield _with_wrench(own, 1.0, up, f"moments are in {name}: multiply by {up:.5g}")
        yield _with_wrench(own, 1.0, down, f"moments are in N·m in a column of {name}: multiply by {down:.5g}")
    for name, force, moment in (("lbf and lbf·in", LBF, LBF * INCH), ("lbf and lbf·ft", LBF, LBF * FOOT)):
        likely = f"forces and moments are in {name}: multiply by {force:.5g} and {moment:.5g}"
        yield _with_wrench(own, force, moment, likely)


def _with_wrench(own: LoadStates, force: float, moment: float, likely: str) -> Variant:
    wrench = own.wrench * np.repeat([force, moment], 3)
    # Two factors at once are a mistake on two columns: the simpler one goes first where both explain the run.
    penalty = TWO_FACTORS if 1.0 not in (force, moment) else 0.0
    return Variant(SuspectKind.UNIT, likely, force if force != 1.0 else moment, wrench=wrench, penalty=penalty)


def _signs(own: LoadStates, chain: Chain) -> Iterator[Variant]:
    for component, name in enumerate(("Fx", "Fy", "Fz", "Mx", "My", "Mz")):
        if np.any(own.wrench[:, component]):
            yield Variant(
                SuspectKind.SIGN, f"{name} has the wrong sign: multiply it by −1", -1.0,
                wrench=_scaled(own.wrench, component, -1.0),
            )  # fmt: skip
    forces = own.wrench * np.repeat([-1.0, 1.0], 3)
    if own.setup.moments_measured:
        yield Variant(
            SuspectKind.SIGN, "force and moment have the wrong sign, as of the force of the robot on its "
        "surroundings: multiply them by −1", -1.0, wrench=-own.wrench,
        )  # fmt: skip
    yield Variant(SuspectKind.SIGN, "the force has the wrong sign: multiply it by −1", -1.0, wrench=forces)
    if own.deflection_given:
        for component, name in enumerate(("x", "y", "z", "rx", "ry", "rz")):
            if np.any(np.nan_to_num(own.deflection[:, :, component])):
                yield Variant(
                    SuspectKind.SIGN, f"the displacement {name} has the wrong sign: multiply it by −1", -1.0,
                    deflection=_scaled(own.deflection, component, -1.0),
                )  # fmt: skip
        yield Variant(
            SuspectKind.SIGN, "the displacement has the wrong sign, unloaded minus loaded: multiply it by −1", -1.0,
            deflection=-own.deflection,
        )  # fmt: skip
    else:
        turn = own.base_from_tracker[0]
        for component, name in enumerate("xyz"):
            flip = np.eye(4)
            flip[component, component] = -1.0
            flip_in_base = turn @ flip @ np.linalg.inv(turn)
            yield Variant(
                SuspectKind.SIGN, f"the place {name} has the wrong sign: multiply it by −1", -1.0,
                position=own.position @ flip_in_base[:3, :3].T + flip_in_base[:3, 3],
            )  # fmt: skip
    for joint in range(own.joints.shape[1]):
        if np.any(own.joints[:, joint]):
            name = chain.joint_names[joint] if joint < len(chain.joint_names) else str(joint + 1)
            yield Variant(
                SuspectKind.SIGN, f"the angle of {name} has the wrong sign: multiply it by −1", -1.0,
                joints=_scaled(own.joints, joint, -1.0),
            )  # fmt: skip


def _of_others(states: LoadStates, members: Sequence[Integers], run: int, left_out: Sequence[int]) -> Iterator[Variant]:
    """Yield the run with another run's angles, loads or places in the place of its own."""
    run_states = members[run]
    # Of two runs that are exchanged both stand apart, so that no distance hides the other one.
    distant = {k for k in left_out if abs(k - run) > MOST_NEIGHBOURS}
    neighbours = range(max(run - MOST_NEIGHBOURS, 0), min(run + MOST_NEIGHBOURS + 1, len(members)))
    comparable_runs = [k for k in sorted({*neighbours, *distant}) if k != run and len(members[k]) == len(run_states)]
    order = TimeOrder.of(states, members)
    for other_run in comparable_runs:
        penalty = order.mix_up_penalty(run, other_run, len(comparable_runs))
        other_states, name = members[other_run], states.runs[int(states.run[members[other_run][0]])].name
        if not _alike(states.joints[run_states], states.joints[other_states]):
            yield Variant(
                SuspectKind.MISLABELLED, f'the joint angles that belong here are those of run "{name}": the two are '
                "mixed up; correct the angles, or leave the run out", joints=states.joints[other_states],
                other=other_run, penalty=penalty,
            )  # fmt: skip
        if not _alike(states.wrench[run_states], states.wrench[other_states]):
            yield Variant(
                SuspectKind.EXCHANGED, f'the loads that belong here are those of run "{name}": the force logs are '
                "interchanged; interchange them back", wrench=states.wrench[other_states], other=other_run,
                penalty=penalty,
            )  # fmt: skip
        position, rotation, deflection = _places(states, other_states)
        yield Variant(
            SuspectKind.EXCHANGED, f'the places or displacements that belong here are those of run "{name}": the '
            "tracker logs are interchanged; correct the file names", position=position, rotation=rotation,
            deflection=deflection, other=other_run, penalty=penalty,
        )  # fmt: skip


def _places(states: LoadStates, members: Integers) -> tuple[Floats, Floats, Floats]:
    """Return position, rotation and deflection measured in these states, NaN where they were set aside."""
    unused = ~states.used[members]
    position, rotation, deflection = states.position[members], states.rotation[members], states.deflection[members]
    for values in (position, rotation, deflection):
        values[unused] = np.nan
    return position, rotation, deflection


def _alike(first: Floats, second: Floats) -> bool:
    return bool(np.array_equal(first, second, equal_nan=True))


def _scaled(values: Floats, component: int | slice, factor: float) -> Floats:
    result = values.copy()
    result[..., component] *= factor
    return np.asarray(result)
