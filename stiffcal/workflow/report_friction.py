"""What the report shows of friction: curves with their readings, and passes that were set aside."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from stiffcal.experiments.friction.parts import FRICTION_FIT, friction_readings
from stiffcal.report.content import SetAside
from stiffcal.report.friction_curves import FrictionCurve
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.store import values_of
from stiffcal.uncertainty import NORMAL_95
from stiffcal.workflow.experiments import measured_runs
from stiffcal.workflow.steps import Ingested


def friction_curves(data: Ingested, identified: IdentifyResult) -> tuple[FrictionCurve, ...]:
    """Return the friction of every joint that the present fit tells; none where there are no friction runs."""
    section = identified.friction
    if section is None or not section.joints or FRICTION_FIT not in data.store.tables:
        return ()
    table = data.store.read_table(FRICTION_FIT)
    names = np.array(table.column("joint").to_pylist(), dtype=np.str_)
    velocity, friction = (values_of(table.column(name)) for name in ("velocity_radps", "friction_measured_Nm"))
    curves = []
    for joint in section.joints:
        own = names == joint.name
        laws = set(section.effects or ())
        parameters = [
            parameter
            for parameter in identified.parameters
            if parameter.effect in laws and parameter.where.joints == [joint.joint]
        ]
        curves.append(
            FrictionCurve(
                joint=joint.name,
                steady=joint.n_speeds is not None,
                velocity=velocity[own],
                friction=friction[own],
                speed=joint.curve.velocity,
                fitted=joint.curve.torque,
                std=joint.curve.std,
                parameters=tuple(
                    (
                        parameter.name.rsplit(".", 1)[-1],
                        parameter.value,
                        None if parameter.std is None else NORMAL_95 * parameter.std,
                        parameter.unit,
                    )
                    for parameter in parameters
                    if parameter.value is not None
                ),
                remarks=tuple(
                    f"{symbol} friction is not seen: {term.why}"
                    for symbol, term in joint.optional.items()
                    if not term.seen
                ),
                rms=joint.rms,
                noise=joint.noise,
            )
        )
    return tuple(curves)


def friction_set_aside(data: Ingested) -> tuple[SetAside, ...]:
    """Return the passes of friction runs that were not used, by run and reason."""
    steady, _ = friction_readings(measured_runs(data))
    if steady is None:
        return ()
    rows: dict[tuple[str, str], list[int]] = defaultdict(list)
    count: dict[str, int] = defaultdict(int)
    for k, why in enumerate(steady.set_aside.tolist()):
        name = steady.runs[int(steady.run[k])].name
        count[name] += 1
        if why:
            rows[name, why].append(count[name])
    return tuple(SetAside(name, tuple(numbers), f"pass: {why}") for (name, why), numbers in rows.items())
