"""What was measured already: the fit to all runs, or, half-way through a campaign, to those whose logs are there."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.campaign.loading import Campaign
from stiffcal.planning.measured import MeasuredSoFar
from stiffcal.stages.steps import RunContext

if TYPE_CHECKING:
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.model.assembled.composite import CompliantRobot


def measured_so_far(campaign: Campaign, robot: CompliantRobot, context: RunContext) -> MeasuredSoFar | None:
    """Return the fit to the runs whose logs are there; None where nothing is measured.

    Parameters
    ----------
    campaign : logs of runs that are still to be measured may be missing.
    robot : the campaign's, with the values of model.toml.
    context : store, progress and so on.

    Raises
    ------
    InputError : a log is faulty.
    """
    from stiffcal.ingest.sources import manifest_data_files

    files = manifest_data_files(campaign)
    if not files:
        return None
    if all((campaign.folder / file).exists() for file in files):
        return _of_whole_campaign(campaign, robot, context)
    return _of_first_runs(campaign, robot, context)


def _of_whole_campaign(campaign: Campaign, robot: CompliantRobot, context: RunContext) -> MeasuredSoFar:
    """Return the fit with its frames among the parameters: further places determine them anew."""
    from stiffcal.stages.fit import up_to_date_fit
    from stiffcal.stages.fitted_robot import fitted_robot
    from stiffcal.stages.steps import up_to_date_states

    fitted = fitted_robot(campaign, context)
    data = up_to_date_states(campaign.folder, context)
    identified = up_to_date_fit(data, context)
    robot = robot.with_values(identified.robot_values())
    setup = data.states.setup if data.states.setup.targets else fitted.setup
    in_model, matrix = set(robot.values()), np.array(identified.covariance, dtype=np.float64)
    known = [(k, name) for k, name in enumerate(identified.free_parameters) if name in in_model]
    covariance = {a: {b: float(matrix[i, j]) for j, b in known} for i, a in known}
    estimated = identified.noise_per_axis
    noise = (
        (None,) * 6
        if estimated is None
        else (
            estimated.translation,
            estimated.rotation,
            estimated.force,
            estimated.moment,
            estimated.motor_angle,
            estimated.gauge,
        )
    )
    return MeasuredSoFar(robot, setup, covariance, noise, fitted.source, _readings(data.states))


def _of_first_runs(campaign: Campaign, robot: CompliantRobot, context: RunContext) -> MeasuredSoFar | None:
    """Return the fit to the runs of which every log is there; nothing is stored, as the campaign is not complete."""
    sources = campaign.manifest.sources
    named = {name: list(campaign.manifest.files_of(name).values()) for name in sources if sources[name].in_files}
    complete = []
    for run in campaign.manifest.runs:
        files = [file for name, file in run.files.items() if name in named] + [
            file for of in named.values() for file in of
        ]
        files += [run.states] if run.states is not None else []
        if files and all((campaign.folder / file).exists() for file in files):
            complete.append(run)
    if not complete:
        return None
    from stiffcal.identification.fitting.geometry import with_geometry
    from stiffcal.identification.fitting.identify import Settings, identify_parameters
    from stiffcal.ingest.reading.reducing import reduce_campaign
    from stiffcal.model.assembled.assembly import fixed_parameters

    manifest = campaign.manifest.model_copy(update={"runs": tuple(complete)})
    states = reduce_campaign(replace(campaign, manifest=manifest), context.progress).states
    if not states.used.any():
        return None
    fit = with_geometry(identify_parameters(states, robot, Settings(fixed=fixed_parameters(campaign.model))), states)
    values = {parameter.name: parameter.value for parameter in fit.parameters if parameter.value is not None}
    names = fit.free_names
    covariance = {a: {b: float(fit.covariance[i, j]) for j, b in enumerate(names)} for i, a in enumerate(names)}
    source = f"{len(complete)} of {len(campaign.manifest.runs)} runs, those measured so far"
    return MeasuredSoFar(robot.with_values(values), states.setup, covariance, _noise_of(fit), source, _readings(states))


def _noise_of(fit: Fit) -> tuple[float | None, ...]:
    noise = fit.noise
    if noise is None:
        return (None,) * 6
    sizes = (noise.translation, noise.rotation, noise.force, noise.moment, noise.motor_angle, noise.gauge)
    return tuple(size if size > 0.0 else None for size in sizes)


def _readings(states: LoadStates) -> int:
    """Return how many numbers were read in states that count."""
    per_state = np.isfinite(states.displacement).sum(axis=1)
    per_state += np.isfinite(states.deflection).sum(axis=(1, 2)) + np.isfinite(states.position).sum(axis=(1, 2))
    per_state += 3 * np.isfinite(states.rotation).all(axis=(2, 3)).sum(axis=1)
    return int(per_state[states.used].sum())
