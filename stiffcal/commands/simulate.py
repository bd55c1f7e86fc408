"""Simulate the measurement of a known robot, as a campaign folder."""

from __future__ import annotations

from pathlib import Path

from stiffcal.errors import Progress, no_progress
from stiffcal.results.command_results import SimulateResult


def simulate_campaign(
    folder: Path, out: Path, seed: int | None = None, progress: Progress = no_progress, *, overwrite: bool = False
) -> SimulateResult:
    """Write raw logs of the robot and model of a campaign, with the sensors of its simulate.toml.

    Parameters
    ----------
    folder : a campaign folder with simulate.toml and a model file that values every parameter.
    out : the campaign folder to write.
    seed : the same seed gives the same bytes; None: the one in simulate.toml.
    progress : called with what is being done.
    overwrite : also files that hold something stiffcal did not write.

    Returns
    -------
    SimulateResult
        What was written.

    Raises
    ------
    InputError : a file is wrong, a parameter has no value, or a file to write holds something else.
    """
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.simulation.settings import load_settings
    from stiffcal.simulation.simulate import simulate_campaign as play

    campaign = load_campaign(Path(folder), check_files=False)
    played = play(campaign, load_settings(Path(folder)), Path(out), seed, progress, overwrite=overwrite)
    without_truth = {name: value for name, value in played.items() if name != "truth"}
    return SimulateResult(warnings=[], **without_truth)
