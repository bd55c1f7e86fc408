"""What the report shows of links with rods: readings, the link's end, the tool with and without the link."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.bodies.measured_links import MeasuredLink, measure_links
from stiffcal.identification.derivatives.observation import Observations, observe
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.identification.readings.row_layout import LENGTH, TRANSLATION
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.beam import axis_displacement
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.reduction.loads.cycles import UNLOADING, find_load_cycles
from stiffcal.report.link_pictures import BentLink, LinkPicture, LinkRun
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.steps import Ingested
from stiffcal.validation.validate import load_in_base

# Runs drawn large: the paper shows four (Fig. 7).
HOW_MANY = 4
# Two rods are on opposite sides where their middles lie across the axis, this near to opposite and equally long.
OPPOSITE_M = 0.02
ALONG, UNLOADED = 0.7, 0.02
"""States of a run that are drawn over its force: this share of the load is along it, or the load is at most this share
of the largest. Pictures alone hang on both."""
POINTS = 41


def link_pictures(data: Ingested, identified: IdentifyResult) -> tuple[LinkPicture, ...]:
    """Return the pictures of every link with rods; none where there are no rods."""
    states = data.states
    if not states.setup.rods or not len(states):
        return ()
    robot = placed_robot(data.campaign).with_values(identified.robot_values())
    readings = observe(states, robot.chain)
    noise = None if identified.noise_per_axis is None else identified.noise_per_axis.length
    observed = _ObservedLinks.of(readings, states, robot)
    return tuple(_picture(link, observed) for link in measure_links(readings, robot, noise))


@dataclass(frozen=True)
class _ObservedLinks:
    """What was read and what the model predicts, (m, n) rows by states; the load in base axes, (n, 3) N."""

    data: Observations
    states: LoadStates
    robot: CompliantRobot
    predicted: Floats
    load: Floats
    unloading: NDArray[np.bool_]

    @classmethod
    def of(cls, data: Observations, states: LoadStates, robot: CompliantRobot) -> _ObservedLinks:
        """Predict everything once."""
        branch = find_load_cycles(states).branch[data.index]
        predicted = predict_observations(robot, data)
        return cls(data, states, robot, predicted, load_in_base(data, robot), branch == UNLOADING)

    def without(self, link: str) -> Floats:
        """Return (m, n) the prediction with one link rigid, all else as fitted."""
        kept = tuple(placed_effect for placed_effect in self.robot.placed if placed_effect.place.link != link)
        return predict_observations(replace(self.robot, placed=kept), self.data)


def _picture(link: MeasuredLink, observed: _ObservedLinks) -> LinkPicture:
    rods, shape = link.estimate.rods, link.estimate.shape
    modelled = any(placed_effect.place.link == link.link for placed_effect in observed.robot.placed)
    rigid = observed.without(link.link) if modelled else None
    runs = tuple(_run(int(number), link, observed, rigid) for number in np.unique(link.run))
    size = [float(np.nanmax(np.abs(run.lengths), initial=0.0)) for run in runs]
    rows = sorted(int(k) for k in np.argsort(size)[::-1][: HOW_MANY - 1])
    # the campaign's first run, then those with the largest readings
    rows = sorted({0, *rows})
    lead = int(np.argmax(size))
    state = int(np.argmax(np.abs(runs[lead].lengths).max(axis=1)))
    x1 = np.linspace(0.0, shape.length, POINTS)
    tip = np.nan_to_num(runs[lead].end[state])[None]
    bent = BentLink(
        x1, axis_displacement(shape, tip, x1)[0][:, :3], rods.start, rods.end, runs[lead].lengths[state],
        float(runs[lead].force[state]), runs[lead].name,
    )  # fmt: skip
    return LinkPicture(
        link.link, rods.names, rods.length, _opposite(rods.start, rods.end), runs, tuple(rows), bent,
        _sentences(link),
    )  # fmt: skip


def _run(number: int, link: MeasuredLink, observed: _ObservedLinks, rigid: Floats | None) -> LinkRun:
    """Gather one run, in the states in which all the link's rods were read."""
    in_run = np.flatnonzero(link.run == number)
    load = observed.load[link.index[in_run]]
    size = np.linalg.norm(load, axis=1)
    direction = load[int(np.argmax(size))] / max(float(size.max()), 1e-300)
    # over the force along one direction, what loads across it make would stand at no force
    along_it = (np.abs(load @ direction) >= ALONG * size) | (size <= UNLOADED * size.max())
    in_run, load = in_run[along_it], load[along_it]
    where = link.index[in_run]
    # a device that pushes and pulls is called by its own direction, not by the larger of its two ends
    direction = direction * (1.0 if direction[int(np.argmax(np.abs(direction)))] > 0.0 else -1.0)
    rows = _rows_of(link, observed.data)
    measured = observed.data.measured[np.ix_(rows, where)]
    reference = int(np.argmin(np.sum(load**2, axis=1)))
    modelled = observed.predicted[np.ix_(rows, where)]
    shift = (measured - modelled).mean(axis=1, keepdims=True)
    still = measured[:, [reference]].mean(axis=1, keepdims=True) if rigid is None else shift
    along = _tool_reader(observed, where, direction)
    tool, with_link = along(observed.data.measured), along(observed.predicted)
    offset = 0.0 if tool is None or with_link is None else float(np.mean(tool - with_link))
    zero = link.estimate.displacement[in_run[reference]]
    return LinkRun(
        name=observed.states.runs[number].name,
        along=_words(direction),
        force=load @ direction,
        unloading=observed.unloading[where],
        lengths=(measured - still).T,
        modelled=None if rigid is None else modelled.T,
        end=link.estimate.displacement[in_run] - zero,
        end_std=np.sqrt(np.diag(link.estimate.covariance)),
        by_wrench=link.compliance.predict(link.wrench[in_run] - link.wrench[in_run[reference]]),
        tool=None if tool is None else tool - offset,
        with_link=with_link,
        without_link=None if rigid is None else along(rigid),
    )


def _rows_of(link: MeasuredLink, data: Observations) -> Integers:
    """Return the rows of the link's rods."""
    number = next(k for k, rods in enumerate(data.setup.rods) if rods.link == link.link)
    return np.flatnonzero((data.kind == LENGTH) & (data.body == number))


def _tool_reader(observed: _ObservedLinks, where: Integers, direction: Floats) -> Callable[[Floats], Floats | None]:
    """Return a function of (m, n) rows: the first target's displacement along a direction, None if not measured."""
    data = observed.data
    rows = data.rows_of(TRANSLATION)
    rows = rows[data.body[rows] == 0]
    if len(rows) == 3:
        return lambda values: np.asarray(direction @ values[np.ix_(rows, where)])
    gauges = data.layout.gauges
    if gauges is None:
        return lambda values: None
    row, sign = int(gauges.row[0]), np.sign(direction @ gauges.direction[0][:, where])
    return lambda values: np.asarray(values[row, where] * sign)


def _words(direction: Floats) -> str:
    """Return a direction in words: the base axis that it lies along, or its components."""
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) > 0.99:
        return "xyz"[axis]
    return "(" + ", ".join(f"{component:.2f}" for component in direction) + ")"


def _opposite(start: Floats, end: Floats) -> tuple[tuple[int, int], ...]:
    """Return pairs of rods that lie on opposite sides of the link, at the same height along it."""
    middle, length = 0.5 * (start + end), np.linalg.norm(end - start, axis=1)
    pairs = []
    for second in range(len(middle)):
        for first in range(second):
            across = np.abs(middle[second, 1:] + middle[first, 1:]).max()
            distance = abs(middle[second, 0] - middle[first, 0]) + abs(length[second] - length[first])
            if across < OPPOSITE_M and distance < 2.0 * OPPOSITE_M:
                pairs.append((first, second))
    return tuple(pairs)


def _sentences(link: MeasuredLink) -> tuple[str, ...]:
    """Return the notes on the pictures, in words."""
    sentences = [fault.sentence for fault in link.faults]
    sentences += link.compliance.not_identifiable
    if not link.estimate.torsion.identifiable and link.compliance.twist is None:
        sentences.append(f"torsion is not known: {link.estimate.torsion.why}")
    return tuple(dict.fromkeys(sentences))
