"""What the report shows of friction: curves with their readings, and passes that were set aside."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from stiffcal.report.content import SetAside
from stiffcal.report.friction_curves import FrictionCurve
from stiffcal.store import values_of
from stiffcal.workflow.friction import FRICTION_FIT, friction_readings
from stiffcal.workflow.steps import Document, Ingested


def friction_curves(data: Ingested, identified: Document) -> tuple[FrictionCurve, ...]:
    """Return the friction of every joint that the present fit tells; none where there are no friction runs."""
    section = identified.get("friction")
    if not section or not section["joints"] or FRICTION_FIT not in data.store.tables:
        return ()
    table = data.store.read_table(FRICTION_FIT)
    names = np.array(table.column("joint").to_pylist(), dtype=np.str_)
    velocity, friction = (values_of(table.column(name)) for name in ("velocity_radps", "friction_measured_Nm"))
    curves = []
    for one in section["joints"]:
        own = names == one["name"]
        told = [p for p in identified["parameters"] if p["effect"] in _laws(identified) and _is_at(p, one["joint"])]
        curves.append(
            FrictionCurve(
                joint=one["name"],
                steady=one["n_speeds"] is not None,
                velocity=velocity[own],
                friction=friction[own],
                speed=np.array(one["curve"]["velocity"]),
                fitted=np.array(one["curve"]["torque"]),
                std=np.array(one["curve"]["std"]),
                parameters=tuple(
                    (
                        p["name"].rsplit(".", 1)[-1],
                        p["value"],
                        None if p["std"] is None else 1.96 * p["std"],
                        p["unit"],
                    )
                    for p in told
                    if p["value"] is not None
                ),
                remarks=tuple(
                    f"{symbol} friction is not seen: {words['why']}"
                    for symbol, words in one["optional"].items()
                    if not words["seen"]
                ),
                rms=one["rms"],
                noise=one["noise"],
            )
        )
    return tuple(curves)


def _laws(identified: Document) -> set[str]:
    """Return the names of the effects that friction runs tell."""
    return set(identified["friction"].get("effects", ()))


def _is_at(parameter: Document, joint: int) -> bool:
    return bool(parameter["where"].get("joints") == [joint])


def friction_set_aside(data: Ingested) -> tuple[SetAside, ...]:
    """Return the passes of friction runs that were not used, by run and reason."""
    steady, _ = friction_readings(data)
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
