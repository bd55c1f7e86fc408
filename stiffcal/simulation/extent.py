"""How much a simulation would compute and log, counted before anything is drawn: settings may come from a stranger."""

from __future__ import annotations

from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.errors import InputError
from stiffcal.limits import BALANCES, SAMPLES, Limit
from stiffcal.simulation.kinds import run_simulation
from stiffcal.simulation.settings import FILE_NAME, SimulatedRun, SimulationSettings


def check_extent(settings: SimulationSettings, manifest: Manifest) -> None:
    """Raise where a simulation asks for more than a machine should spend on it (`stiffcal.limits`).

    Parameters
    ----------
    settings : `simulate.toml`.
    manifest : gives the kind of each run.

    Raises
    ------
    InputError : it does; names the run with which a limit is exceeded.
    """
    kinds = {run.id: run.experiment for run in manifest.runs}
    rates = [settings.sensor(name).rate_hz or 0.0 for name in manifest.sources]
    solved, read = 0.0, 0.0
    for run in settings.runs:
        steps, seconds = _extent_of(settings, run, kinds.get(run.id, "load"))
        solved += steps
        read += sum(max(rate * seconds, steps) for rate in rates)
        for amount, limit in ((solved, BALANCES), (read, SAMPLES)):
            if amount > limit.most:
                raise _extent_fault(limit, run)


def _extent_of(settings: SimulationSettings, run: SimulatedRun, experiment: str) -> tuple[float, float]:
    """Return the number of balances that a run takes, and its length in s, both at most."""
    simulation = run_simulation(experiment)
    if simulation is not None:
        return simulation.extent(settings.motion_of(experiment, run))
    loads = settings.loads_of(run)
    holds = 1.0 + 4.0 * len(loads.directions) * len(loads.levels) * loads.cycles
    steps = holds * (loads.ramp_points + loads.hold_points + 2.0 * loads.waves * (loads.waviness > 0.0))
    # Six standard deviations of the scatter: no draw of a whole campaign lasts longer.
    hold = loads.hold_s * (1.0 + 6.0 * loads.hold_scatter)
    ramp = loads.ramp_s * (1.0 + 6.0 * loads.ramp_scatter)
    return steps, loads.first_hold_s + holds * (hold + ramp + loads.settle_s)


def _extent_fault(limit: Limit, run: SimulatedRun) -> InputError:
    mend = f"log at a lower rate or simulate fewer cycles, or raise {limit.variable}"
    return limit.exceeded(FILE_NAME, f'runs "{run.id}"', mend)
