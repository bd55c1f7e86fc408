"""Two joints of a six-joint robot with heavy links, clamped in three positions each, by our own balance or MuJoCo.

The laws that set the sizes are those of `tests.rates.benches`, in plain numpy; the logs come from `stiffcal simulate`,
the mechanics from its balance or from `tests.rates.mujoco_clamped`.
"""

from __future__ import annotations

import shutil
from contextlib import nullcontext
from pathlib import Path
from unittest import mock

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.kinds.clamped.held.chain import drive_weight
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.clamped_inverse import clamped_inverse
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign
from tests.rates.benches import CLAMPED, Bench, Motion, beyond_base, draw_clamped_values, scaled_to
from tests.rates.measuring import Player
from tests.rates.mujoco_clamped import clamped_by_mujoco

CLASSES = ("robot none", "robot 3x", "robot 1x", "robot two")
SOURCE = Path(__file__).parents[2] / "campaigns" / "mixed"
COMPLIANCE = np.array([1.7e-6, 1.3e-6, 3.3e-6, 1.7e-5, 2.0e-5, 3.3e-5])
LARGEST = np.array([700.0, 700.0, 500.0, 180.0, 150.0, 120.0])
LEVER = np.array([1.5, 1.3, 1.0, 0.3, 0.3, 0.1])
"""m, by which the force sensor's noise is a torque about each joint, typically."""
FORCE_NOISE, ANGLE_NOISE, RATE, CYCLES, POSITIONS = 0.5, 3e-6, 50.0, 3, 3
LEAST_SHARE = 1e-3
"""Of a law that a spring cannot make: one whose torque never comes near its play or knee has none."""
MOST_FORCE = 3000.0
"""N, of the force sensor."""
LEAST_SINGULAR = 0.1
"""Smallest singular value of the Jacobian, m and rad."""
# Effects that three positions show; they do not show an order.
POOL = ("asymmetric-stiffness", "backlash", "creep", "cubic-stiffness", "friction-hysteresis", "two-slope")


def write_clamped_robot(folder: Path, kind: str, rng: np.random.Generator, player: Player = "balance") -> Bench:
    """Draw a campaign of one of the classes and write it into a new folder.

    Parameters
    ----------
    kind : ``robot``, then ``none``, ``3x``, ``1x`` or ``two``.
    player : ``mujoco`` or ``balance``.
    """
    what = kind.split(" ", 1)[1]
    joints = sorted(int(joint) for joint in rng.choice(6, 2, replace=False))
    compliance = COMPLIANCE * rng.uniform(0.6, 1.6, 6)
    largest, period = LARGEST * rng.uniform(0.5, 1.0, 6), float(rng.uniform(15.0, 25.0))
    sizes = {"none": (), "two": (3.0, 3.0)}.get(what) or ((float(what.removesuffix("x")),) if what != "none" else ())
    owners = [int(joint) for joint in rng.permutation(joints)[: len(sizes)]]
    stances = {joint: [_draw_stance(rng, joint, float(largest[joint])) for _ in range(POSITIONS)] for joint in joints}
    hidden: dict[tuple[str, int], dict[str, float]] = {}
    amplitude = compliance * largest
    for size, joint in zip(sizes, owners, strict=True):
        noise = float(np.hypot(ANGLE_NOISE, FORCE_NOISE * LEVER[joint] * compliance[joint]))
        weights = [_weight(stance)[joint] for stance in stances[joint]]
        motions = [_motion(float(largest[joint]), period, weight) for weight in weights]
        free = [str(name) for name in rng.permutation(POOL) if name not in {name for name, _ in hidden}]
        drawn = (_draw_law(name, rng, motions, size * noise, amplitude[joint]) for name in free)
        # under the weight a torque that keeps its sign shows no play and no asymmetry: another law is hidden then
        name, values, added = next(law for law in drawn if law is not None)
        hidden[name, joint + 1] = values
        amplitude[joint] += added
    plan = folder.parent / "plan"
    _write_plan(plan, stances, (compliance, amplitude, period), hidden)
    seed = int(rng.integers(1 << 30))
    by_mujoco = mock.patch("stiffcal.kinds.clamped.simulated.simulation.simulate_clamped", clamped_by_mujoco)
    with by_mujoco if player == "mujoco" else nullcontext():
        simulate_campaign(load_campaign(plan, check_files=False), load_settings(plan), folder, seed=seed)
    settings = f"joints {joints[0] + 1} and {joints[1] + 1}, {POSITIONS} positions each"
    return Bench("clamped", hidden, sizes, settings)


def _draw_law(
    name: str, rng: np.random.Generator, motions: list[Motion], size: float, amplitude: float
) -> tuple[str, dict[str, float], float] | None:
    """Return a law with values for an rms of ``size`` beyond what a spring makes, and how far it turns the joint.

    None where no values do in a hundred draws.

    Parameters
    ----------
    motions : the joint's positions: about the weight's torque in each.
    size : rad. amplitude : rad, what the spring makes of a cycle: a law that makes more is drawn again.
    """
    reach = max(float(np.abs(motion.torque).max()) for motion in motions)
    for _ in range(100):
        values = draw_clamped_values(name, rng, reach)
        turned = [CLAMPED[name](motion, values) for motion in motions]
        bases = [np.stack([np.ones(motion.time.size), motion.torque]) for motion in motions]
        unit = np.sqrt(np.mean([beyond_base(part, base) ** 2 for part, base in zip(turned, bases, strict=True)]))
        spans = [float(np.ptp(part)) for part in turned]
        shows = unit > LEAST_SHARE * max(float(np.abs(part).max()) for part in turned)
        # a spring that softens gives way under the weight
        gives_way = name == "cubic-stiffness" and values["c3"] < 0.0
        if shows and not gives_way and max(spans) * size < amplitude * unit:
            return name, scaled_to(values, size / unit), max(spans) * size / unit
    return None


def _weight(stance: Floats) -> Floats:
    """Return (6,) torques of the weight about the joints in a stance (6,), degrees, N·m."""
    campaign = load_campaign(SOURCE, check_files=False)
    setup = measurement_setup(campaign.manifest, campaign.chain, resolve_frames(campaign.manifest, campaign.chain))
    return drive_weight(campaign.chain, setup, campaign.chain.model_angles(np.radians(stance)[None]))


def _motion(largest: float, period: float, weight: float) -> Motion:
    """Return the cycles of torque of one position, about the weight's."""
    count = int(CYCLES * period * RATE)
    time = np.arange(count) / RATE
    wave = 1.0 - 4.0 * np.abs((time / period + 0.25) % 1.0 - 0.5)
    zero = np.zeros(count)
    return Motion(np.zeros(count, dtype=np.int64), time, zero, weight + largest * wave, zero, zero)


def _draw_stance(rng: np.random.Generator, joint: int, torque: float) -> Floats:
    """Return (6,) degrees in which the fixture holds a joint's torque with no more than `MOST_FORCE`."""
    campaign = load_campaign(SOURCE, check_files=False)
    held = Attachment(campaign.chain.n_joints + 1, np.eye(4))
    while True:
        stance = np.round(rng.uniform([-60, -30, 10, 20, 30, -90], [60, 20, 70, 80, 80, 90]), 1)
        inverse, drives = clamped_inverse(campaign.chain, campaign.chain.model_angles(np.radians(stance)[None]), held)
        far_from_singular = float(np.linalg.svd(drives, compute_uv=False)[-1]) > LEAST_SINGULAR
        if far_from_singular and 2.0 * float(np.linalg.norm(inverse[joint, :3])) * torque < MOST_FORCE:
            return np.asarray(stance)


def _write_plan(
    folder: Path,
    stances: dict[int, list[Floats]],
    drawn: tuple[Floats, Floats, float],
    hidden: dict[tuple[str, int], dict[str, float]],
) -> None:
    compliance, amplitude, period = drawn
    folder.mkdir(parents=True)
    shutil.copyfile(SOURCE / "robot.toml", folder / "robot.toml")
    text = (SOURCE / "campaign.toml").read_text(encoding="utf-8")
    head = (
        text[: text.index("[sources.tracker]")]
        + text[text.index("[sources.controller]") : text.index("[sources.drives]")]
    )
    runs, acts = [], []
    for joint, of_joint in stances.items():
        for position, stance in zip("abc", of_joint, strict=True):
            run = f"{position}{joint + 1}"
            runs.append(
                f'[[runs]]\nid = "{run}"\nexperiment = "clamped"\nmoved_joint = {joint + 1}\n'
                f'files = {{ ft = "raw/{run}_ft.csv", controller = "raw/{run}.csv" }}\n'
                # a clock found from the motion closes the loop, and takes what creeps or rubs for its lag
                "clock_ahead_s = { ft = 0.0 }\n"
            )
            acts.append(
                f'[[runs]]\nid = "{run}"\njoints_deg = {stance.tolist()}\n'
                f"clamped = {{ amplitude_deg = {np.degrees(amplitude[joint]):.5f} }}\n"
            )
    (folder / "campaign.toml").write_text(head + "\n".join(runs), encoding="utf-8")
    (folder / "simulate.toml").write_text(
        f'schema = "stiffcal/simulate/1"\n[clamped]\npoint = "ft_sensor"\ncycles = {CYCLES}\nperiod_s = {period:.2f}\n'
        f"rest_s = 1.5\npoints = 320\n[robot]\nhidden = {sorted({name for name, _ in hidden})}\n"
        f'[sensors.ft]\nclock = "runs on"\nrate_hz = {2.0 * RATE}\n'
        f"white = {{ force_N = {FORCE_NOISE}, moment_Nm = {0.1 * FORCE_NOISE} }}\n"
        f'[sensors.controller]\nclock = "runs on"\nrate_hz = {RATE}\n'
        f"white = {{ angle_rad = {ANGLE_NOISE} }}\n" + "\n".join(acts),
        encoding="utf-8",
    )
    values = [f'"joint-compliance.j{joint + 1}.c" = {{ value = {c} }}' for joint, c in enumerate(compliance)]
    model = 'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = [1, 2, 3, 4, 5, 6]\n'
    model += "[effects.parameters]\n" + "\n".join(values) + "\n"
    for (name, joint), of_effect in hidden.items():
        model += f'[[effects]]\ntype = "{name}"\njoints = [{joint}]\n[effects.parameters]\n'
        model += "".join(f'"{name}.j{joint}.{symbol}" = {{ value = {value} }}\n' for symbol, value in of_effect.items())
    (folder / "model.toml").write_text(model, encoding="utf-8")
