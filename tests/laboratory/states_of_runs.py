"""Load states of planned runs, played by the exact balance with noise: unloaded, the load steps, unloaded again."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.measurements.load_states import LoadStates, MeasurementSetup, RunInfo
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance


def states_of_runs(
    robot: CompliantRobot,
    joints: Floats,
    loads: Floats,
    setup: MeasurementSetup,
    noise: Noise,
    rng: np.random.Generator,
    with_rotation: bool = False,
) -> LoadStates:
    """Return positions read in every state, and orientations where they are measured.

    Parameters
    ----------
    robot : as built, with the true values.
    joints : (N, L) rad. loads : (N, K, 6) the true load steps.
    setup : where the instruments sit. noise : of one state.
    rng : of the noise. with_rotation : orientations are measured.
    """
    n_runs, n_steps = loads.shape[:2]
    true = np.zeros((n_runs, n_steps + 2, 6))
    true[:, 1:-1] = loads
    true = true.reshape(-1, 6)
    n, targets = len(true), len(setup.targets)
    pose = np.repeat(joints, n_steps + 2, axis=0)
    rest = solve_balance(robot, robot.chain.model_angles(pose), true, setup)
    first = np.arange(n) % (n_steps + 2) == 0
    sigma = np.repeat([noise.force, noise.moment], 3)
    rotation = np.full((n, targets, 3, 3), np.nan)
    if with_rotation:
        turns = rotation_from_vector(noise.rotation * rng.normal(size=(n, targets, 3)))
        rotation = turns @ rest.target_rotation
    return LoadStates(
        runs=tuple(RunInfo(f"run{k + 1}") for k in range(n_runs)),
        run=np.repeat(np.arange(n_runs), n_steps + 2),
        time=np.full(n, np.nan),
        hold=np.full(n, np.nan),
        joints=pose,
        wrench=true + sigma * rng.normal(size=true.shape),
        position=rest.target_position + noise.translation * rng.normal(size=rest.target_position.shape),
        rotation=rotation,
        deflection=np.full((n, targets, 6), np.nan),
        reference=first,
        temperature=np.zeros((n, 0)),
        row=np.arange(1, n + 1),
        n_readings=np.ones(n, dtype=np.int64),
        wrench_scatter=np.full((n, 6), np.nan),
        position_scatter=np.full((n, targets, 3), np.nan),
        set_aside=np.full(n, "", dtype="<U40"),
        setup=setup,
    )
