"""A joint on a bench: laws in plain numpy or by MuJoCo, logs as CSV files, as `clamped` and `friction` runs.

Nothing here imports a law of the package: angle over torque of a locked joint and torque over motion of a free one are
written down once more, so that the diagnosis is not judged by its own formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats, Integers
from tests.rates.measuring import Player
from tests.rates.mujoco_clamped import bench_angle, hinge_of
from tests.rates.mujoco_friction import friction_torque

CLASSES = tuple(
    f"{experiment} {what}" for experiment in ("clamped", "friction") for what in ("none", "3x", "1x", "two", "outside")
)
RATE = 50.0
REFERENCE_K = 22.0
Draw = Callable[[np.random.Generator], dict[str, float]]


@dataclass(frozen=True)
class Bench:
    """What one campaign hides.

    Attributes
    ----------
    experiment : ``clamped`` or ``friction``.
    hidden : effect and joint, from 1, to its values in SI units; laws outside the catalogue begin with ``outside``.
    sizes : rms of each effect beyond what the base model absorbs, in units of one sample's noise.
    settings : in words.
    """

    experiment: str
    hidden: Mapping[tuple[str, int], Mapping[str, float]]
    sizes: tuple[float, ...]
    settings: str

    @property
    def outside(self) -> bool:
        """No effect of the catalogue explains it."""
        return any(name.startswith("outside") for name, _ in self.hidden)


@dataclass(frozen=True)
class Motion:
    """n samples of one joint, run after run.

    Attributes
    ----------
    run : (n,) number of the run. time : (n,) s in the run. position : (n,) rad, of the locked output or of the joint.
    torque : (n,) N·m, of the load (clamped). velocity : (n,) rad/s (friction). temperature : (n,) °C.
    """

    run: Integers
    time: Floats
    position: Floats
    torque: Floats
    velocity: Floats
    temperature: Floats


def player_of(kind: str, number: int) -> Player:
    """Return what plays a campaign: MuJoCo every second one, else our balance a whole robot, numpy's laws a bench."""
    if kind.startswith("absolute"):
        return "balance"
    if number % 2:
        return "mujoco"
    return "balance" if kind.startswith("robot") else "laws"


def play_operator(values: Floats, slip: float, run: Integers) -> Floats:
    """Return (n,) what stays behind values by slip, from zero at each run's start."""
    result, state, last = np.empty_like(values), 0.0, -1
    for k, value in enumerate(values):
        if run[k] != last:
            state, last = 0.0, int(run[k])
        state = min(max(state, value - slip), value + slip)
        result[k] = state
    return result


def kelvin_voigt(motion: Motion, time: float) -> Floats:
    """Return (n,) N·m: the torque behind a first-order lag."""
    result, state, last = np.empty_like(motion.torque), 0.0, -1
    share = 1.0 - np.exp(-1.0 / RATE / time)
    for k, torque in enumerate(motion.torque):
        if motion.run[k] != last:
            state, last = 0.0, int(motion.run[k])
        state += share * (torque - state)
        result[k] = state
    return result


def path_length(motion: Motion) -> Floats:
    """Return (n,) N·m, how far the torque has gone up and down since the run began."""
    steps = np.abs(np.diff(motion.torque, prepend=motion.torque[0]))
    steps[np.flatnonzero(np.diff(motion.run, prepend=-1))] = 0.0
    total = np.cumsum(steps)
    first = np.unique(motion.run, return_index=True)[1]
    return np.asarray(total - total[first][motion.run])


# What a locked joint gives, rad, for values that are still to be scaled by ``c``-like amplitudes.
CLAMPED: Mapping[str, Callable[[Motion, Mapping[str, float]], Floats]] = {
    "backlash": lambda m, v: 0.5 * v["width"] * np.tanh(m.torque / v["band"]),
    "friction-hysteresis": lambda m, v: v["c"] * play_operator(m.torque, v["slip"], m.run),
    "cubic-stiffness": lambda m, v: v["c2"] * m.torque**2 + v["c3"] * m.torque**3,
    "two-slope": lambda m, v: v["c"] * np.clip(m.torque, -v["knee"], v["knee"]),
    "asymmetric-stiffness": lambda m, v: v["c"] * np.maximum(m.torque, 0.0),
    "periodic-stiffness": lambda m, v: (
        (v["a"] * np.cos(v["order"] * m.position) + v["b"] * np.sin(v["order"] * m.position)) * m.torque
    ),
    "creep": lambda m, v: v["c"] * kelvin_voigt(m, v["time"]),
    "encoder-drift": lambda m, v: v["rad_per_s"] * m.time,
    "outside softening": lambda m, v: v["c"] * m.torque * path_length(m) / path_length(m).max(),
    "outside waves": lambda m, v: v["c"] * np.sin(v["waves"] * m.torque / np.abs(m.torque).max()),
    "outside cycles": lambda m, v: v["c"] * m.torque * np.sin(v["waves"] * m.time),
}
# What a free joint's torque gains, N·m.
FRICTION: Mapping[str, Callable[[Motion, Mapping[str, float]], Floats]] = {
    "stribeck": lambda m, v: (
        v["stribeck"] * np.exp(-(np.abs(m.velocity / v["velocity"]) ** v["exponent"])) * np.sign(m.velocity)
    ),
    "friction-temperature": lambda m, v: (
        (v["coulomb_K"] * np.sign(m.velocity) + v["viscous_K"] * m.velocity) * (m.temperature - REFERENCE_K)
    ),
    "torque-ripple": lambda m, v: v["a"] * np.cos(v["order"] * m.position) + v["b"] * np.sin(v["order"] * m.position),
    "viscous-power": lambda m, v: v["factor"] * np.abs(m.velocity) ** v["power"] * np.sign(m.velocity),
    "friction-asymmetry": lambda m, v: np.where(m.velocity == 0.0, 0.0, v["offset"]),
    "outside after-speed": lambda m, v: v["size"] * after_fast(m, v["seconds"]) * np.sign(m.velocity),
    "outside wander": lambda m, v: v["size"] * wander(m, v["seconds"], int(v["seed"])) * np.sign(m.velocity),
    "outside window": lambda m, v: (
        v["size"]
        * np.sign(m.velocity)
        * (np.abs(m.position - m.position.min() - v["middle"]) < v["half"]).astype(np.float64)
    ),
}


def after_fast(motion: Motion, seconds: float) -> Floats:
    """Return (n,) what fast motion leaves for a while, 0 to 1."""
    size: Floats = np.abs(motion.velocity)
    fast = np.asarray(size > 0.4 * size.max(), dtype=np.float64)
    result, state, share = np.empty_like(fast), 0.0, 1.0 - np.exp(-1.0 / RATE / seconds)
    for k, value in enumerate(fast):
        state = max(state * (1.0 - share), value)
        result[k] = state
    return result


def wander(motion: Motion, seconds: float, seed: int) -> Floats:
    """Return (n,) a random walk that comes back, of unit variance."""
    white = np.random.default_rng(seed).standard_normal(motion.time.size)
    keep, state = np.exp(-1.0 / RATE / seconds), 0.0
    result = np.empty_like(white)
    for k, value in enumerate(white):
        state = keep * state + np.sqrt(1.0 - keep**2) * value
        result[k] = state
    return result


def draw_clamped_motion(rng: np.random.Generator, largest: float) -> Motion:
    """Draw cycles of torque in several positions; every file's clock begins at zero, the room warms up."""
    n_runs, cycles, period = int(rng.integers(5, 8)), int(rng.integers(2, 4)), float(rng.uniform(12.0, 25.0))
    count = int(cycles * period * RATE)
    phase = np.arange(count) / RATE / period
    wave = 1.0 - 4.0 * np.abs((phase + 0.25) % 1.0 - 0.5)
    positions = rng.uniform(0.0, np.pi, n_runs)
    time = np.tile(np.arange(count) / RATE, n_runs)
    warmed = np.arange(n_runs * count) / RATE
    return Motion(
        run=np.repeat(np.arange(n_runs), count), time=time, position=np.repeat(positions, count),
        torque=largest * np.tile(wave, n_runs), velocity=np.zeros(time.size),
        temperature=REFERENCE_K + 8.0 * (1.0 - np.exp(-warmed / 900.0)),
    )  # fmt: skip


def draw_friction_motion(rng: np.random.Generator) -> Motion:
    """Draw strokes at many speeds, both ways, in random order, at rest in between; the drive warms up."""
    slow, fast = rng.uniform(0.005, 0.015), rng.uniform(0.8, 1.6)
    speeds = np.repeat(np.geomspace(slow, fast, int(rng.integers(10, 14))), 2)
    rng.shuffle(speeds)
    velocity: list[Floats] = [np.zeros(25)]
    rise = np.linspace(0.0, 1.0, 6)[1:]
    for speed in speeds:
        held = int(min(8.0, 0.45 / speed) * RATE)
        stroke = speed * np.concatenate([rise, np.ones(held), rise[::-1]])
        velocity += [stroke, np.zeros(20), -stroke, np.zeros(20)]
    v = np.concatenate(velocity)
    time = np.arange(v.size) / RATE
    position = rng.uniform(-1.0, 1.0) + np.cumsum(v) / RATE
    temperature = REFERENCE_K + 9.0 * (1.0 - np.exp(-time / 250.0))
    return Motion(np.zeros(v.size, dtype=np.int64), time, position, np.zeros(v.size), v, temperature)


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def draw_clamped_values(name: str, rng: np.random.Generator, largest: float) -> dict[str, float]:
    """Draw an effect's values, amplitudes of about one still to be scaled."""
    angle = float(rng.uniform(0.0, 2.0 * np.pi))
    return {
        "backlash": lambda: {"width": 1.0, "band": float(rng.uniform(0.005, 0.03)) * largest},
        "friction-hysteresis": lambda: {"c": 1.0, "slip": float(rng.uniform(0.05, 0.25)) * largest},
        "cubic-stiffness": lambda: {"c2": float(rng.choice([0.0, 0.5])) / largest, "c3": _sign(rng) / largest**2},
        "two-slope": lambda: {"c": 1.0, "knee": float(rng.uniform(0.15, 0.5)) * largest},
        "asymmetric-stiffness": lambda: {"c": 1.0},
        "periodic-stiffness": lambda: {
            "a": float(np.cos(angle)), "b": float(np.sin(angle)), "order": float(rng.integers(1, 5))
        },
        "creep": lambda: {"c": 1.0, "time": float(rng.uniform(2.0, 15.0))},
        "encoder-drift": lambda: {"rad_per_s": _sign(rng)},
        "outside softening": lambda: {"c": 1.0},
        "outside waves": lambda: {"c": 1.0, "waves": float(rng.uniform(9.0, 16.0))},
        "outside cycles": lambda: {"c": 1.0, "waves": float(rng.uniform(0.3, 0.8))},
    }[name]()  # fmt: skip


def draw_friction_values(name: str, rng: np.random.Generator) -> dict[str, float]:
    """Draw an effect's values, amplitudes of about one still to be scaled."""
    angle = float(rng.uniform(0.0, 2.0 * np.pi))
    return {
        "stribeck": lambda: {
            "stribeck": 1.0, "velocity": float(rng.uniform(0.02, 0.1)), "exponent": float(rng.uniform(0.8, 2.0))
        },
        "friction-temperature": lambda: {"coulomb_K": 0.0, "viscous_K": -1.0},
        "torque-ripple": lambda: {
            "a": float(np.cos(angle)), "b": float(np.sin(angle)), "order": float(rng.integers(20, 60))
        },
        "viscous-power": lambda: {"factor": 1.0, "power": float(rng.uniform(0.3, 0.6))},
        "friction-asymmetry": lambda: {"offset": _sign(rng)},
        "outside after-speed": lambda: {"size": 1.0, "seconds": float(rng.uniform(5.0, 20.0))},
        "outside wander": lambda: {"size": 1.0, "seconds": 30.0, "seed": float(rng.integers(1 << 30))},
        "outside window": lambda: {"size": 1.0, "middle": float(rng.uniform(0.1, 0.3)), "half": 0.05},
    }[name]()  # fmt: skip


AMPLITUDES = (
    "width", "c", "c2", "c3", "a", "b", "rad_per_s", "stribeck", "coulomb_K", "viscous_K", "factor", "offset", "size",
)  # fmt: skip


def scaled_to(values: Mapping[str, float], factor: float) -> dict[str, float]:
    """Return an effect's values with its amplitudes multiplied."""
    return {name: value * (factor if name in AMPLITUDES else 1.0) for name, value in values.items()}


def beyond_base(part: Floats, base: Floats) -> float:
    """Return the rms of what columns (p, n) leave of a part (n,)."""
    scale = np.linalg.norm(base, axis=1)
    base = base[scale > 0.0] / scale[scale > 0.0, None]
    left = part - base.T @ np.linalg.lstsq(base.T, part, rcond=None)[0]
    return float(np.sqrt(np.mean(left**2)))


def _names(kind: str, pool: Mapping[str, object], rng: np.random.Generator) -> tuple[list[str], list[float]]:
    """Return the names of hidden effects and their sizes in units of the noise."""
    inside = sorted(name for name in pool if not name.startswith("outside"))
    outside = sorted(name for name in pool if name.startswith("outside"))
    what = kind.split(" ", 1)[1]
    if what == "none":
        return [], []
    if what == "two":
        return [str(name) for name in rng.choice(inside, 2, replace=False)], [3.0, 3.0]
    if what == "outside":
        return [str(rng.choice(outside))], [3.0]
    return [str(rng.choice(inside))], [float(what.removesuffix("x"))]


def write_bench(folder: Path, kind: str, rng: np.random.Generator, player: Player = "laws") -> Bench:
    """Draw a campaign of one of the classes and write it into a new folder.

    Parameters
    ----------
    kind : ``clamped`` or ``friction``, then ``none``, ``3x``, ``1x``, ``two`` or ``outside``.
    player : ``mujoco`` has hinges for friction, springs, slip, stops and dampers; the laws below give all the rest.
    """
    (folder / "raw").mkdir(parents=True)
    clamped = kind.startswith("clamped")
    n_joints = 1 if clamped else int(rng.choice([1, 6]))
    joints = "".join(f'\n[[joints]]\nname = "axis{number + 1}"\n' for number in range(n_joints))
    (folder / "robot.toml").write_text(
        'schema = "stiffcal/robot/1"\nname = "bench"\nconvention = "modified-dh"\ngravity_mps2 = [0, 0, 0]\n' + joints
    )
    return (
        _write_clamped(folder, kind, rng, player) if clamped else _write_friction(folder, kind, rng, player, n_joints)
    )


def _write_clamped(folder: Path, kind: str, rng: np.random.Generator, player: Player) -> Bench:
    stiffness, largest = 10.0 ** rng.uniform(4.0, 5.5), 10.0 ** rng.uniform(1.5, 2.5)
    motion = draw_clamped_motion(rng, largest)
    angle_noise, torque_noise = 4e-6, largest * float(rng.uniform(1e-3, 3e-3))
    step = 2.0 * np.pi / 2.0 ** int(rng.integers(20, 23))
    noise = float(np.sqrt(angle_noise**2 + step**2 / 12.0 + (torque_noise / stiffness) ** 2))
    starts = (motion.run[:, None] == np.unique(motion.run)).T.astype(np.float64)
    base = np.concatenate([starts, motion.torque[None]])
    names, sizes = _names(kind, CLAMPED, rng)
    hidden: dict[tuple[str, int], dict[str, float]] = {}
    for name, size in zip(names, sizes, strict=True):
        values = draw_clamped_values(name, rng, largest)
        unit = beyond_base(CLAMPED[name](motion, values), base)
        hidden[name, 1] = scaled_to(values, size * noise / unit)
    angle = _locked_angle(motion, stiffness, {name: values for (name, _), values in hidden.items()}, player)
    n = angle.size
    logged = motion.position + angle + angle_noise * rng.standard_normal(n)
    logged = np.round(logged / step) * step
    torque = motion.torque + torque_noise * rng.standard_normal(n)
    runs = []
    for run in np.unique(motion.run):
        rows = motion.run == run
        table = np.stack([motion.time[rows], np.degrees(logged[rows]), torque[rows], motion.temperature[rows]], axis=1)
        _write_csv(folder / "raw" / f"p{run + 1}.csv", "t,angle,torque,T", table)
        position = np.degrees(motion.position[rows][0])
        runs.append(
            f'[[runs]]\nid = "p{run + 1}"\nexperiment = "clamped"\nmoved_joint = 1\n'
            f'joints_deg = [{position:.4f}]\nfiles = {{ bench = "raw/p{run + 1}.csv" }}\n'
        )
    source = (
        '[sources.bench]\ntime = { column = "t", unit = "s" }\n'
        'joints = { position = ["angle"], torque = ["torque"], units = { position = "deg", torque = "N*m" } }\n'
    )
    _write_manifest(folder, source, runs, "joint-compliance")
    return Bench("clamped", hidden, tuple(sizes), f"{len(runs)} positions, {largest:.0f} N·m")


def _locked_angle(
    motion: Motion, stiffness: float, hidden: Mapping[str, Mapping[str, float]], player: Player
) -> Floats:
    """Return (n,) rad by which the drive turns; with MuJoCo what of it has a hinge, run after run from rest."""
    hinges = {name: hinge_of(name, values) for name, values in hidden.items()} if player == "mujoco" else {}
    by_law = [CLAMPED[name](motion, values) for name, values in hidden.items() if hinges.get(name) is None]
    angle = motion.torque / stiffness
    if player == "mujoco":
        first = motion.run == motion.run[0]
        # every run goes through the same torques
        once = bench_angle(motion.torque[first], motion.time[first], stiffness, [h for h in hinges.values() if h])
        angle = np.tile(once, motion.run.size // once.size)
    return np.asarray(angle + sum(by_law, np.zeros(angle.size)))


def _write_friction(folder: Path, kind: str, rng: np.random.Generator, player: Player, n_joints: int) -> Bench:
    names, sizes = _names(kind, FRICTION, rng)
    at = rng.integers(n_joints, size=len(names))
    hidden: dict[tuple[str, int], dict[str, float]] = {}
    runs = []
    for joint in range(n_joints):
        coulomb, viscous = float(rng.uniform(10.0, 60.0)), float(rng.uniform(5.0, 40.0))
        motion = draw_friction_motion(rng)
        noise = coulomb * float(rng.uniform(0.01, 0.03))
        sign, moving = np.sign(motion.velocity), motion.velocity != 0.0
        base = np.stack([sign, motion.velocity])[:, moving]
        torque = coulomb * sign + viscous * motion.velocity
        if player == "mujoco":
            torque = friction_torque(motion.velocity, coulomb, viscous)
        for name, size, own in zip(names, sizes, at, strict=True):
            if own == joint:
                values = draw_friction_values(name, rng)
                unit = beyond_base(FRICTION[name](motion, values)[moving], base)
                hidden[name, joint + 1] = scaled_to(values, size * noise / unit)
                torque = torque + np.where(moving, FRICTION[name](motion, hidden[name, joint + 1]), 0.0)
        # a motor at rest holds nothing: only noise is read of the others
        read = noise * rng.standard_normal((3, torque.size, n_joints))
        read[0], read[1] = 0.0, 0.0
        read[0][:, joint], read[1][:, joint] = np.degrees(motion.position), np.degrees(motion.velocity)
        read[2][:, joint] += torque
        columns = np.concatenate([motion.time[:, None], *read, motion.temperature[:, None]], axis=1)
        _write_csv(folder / "raw" / f"j{joint + 1}.csv", ",".join(_friction_columns(n_joints)), columns)
        runs.append(
            f'[[runs]]\nid = "j{joint + 1}"\nexperiment = "friction"\nmoved_joint = {joint + 1}\n'
            f'files = {{ drive = "raw/j{joint + 1}.csv" }}\n'
        )
    listed = [
        "[" + ", ".join(f'"{name}{number + 1}"' for number in range(n_joints)) + "]"
        for name in ("angle", "speed", "torque")
    ]
    source = (
        '[sources.drive]\ntime = { column = "t", unit = "s" }\n'
        f"joints = {{ position = {listed[0]}, velocity = {listed[1]}, torque = {listed[2]}, "
        'units = { position = "deg", velocity = "deg/s", torque = "N*m" } }\n'
    )
    _write_manifest(folder, source, runs, "joint-friction", n_joints)
    return Bench("friction", hidden, tuple(sizes), f"{n_joints} joint{'s' * (n_joints > 1)}")


def _friction_columns(n_joints: int) -> list[str]:
    numbers = range(1, n_joints + 1)
    return ["t", *(f"{name}{number}" for name in ("angle", "speed", "torque") for number in numbers), "T"]


def _write_csv(path: Path, header: str, table: Floats) -> None:
    np.savetxt(path, table, fmt="%.7f", delimiter=",", header=header, comments="")


def _write_manifest(folder: Path, source: str, runs: list[str], effect: str, n_joints: int = 1) -> None:
    temperature = 'temperature = { columns = ["T"], units = { temperature = "degC" } }\n'
    head = 'schema = "stiffcal/campaign/1"\nname = "bench"\nrobot = "robot.toml"\n\n'
    (folder / "campaign.toml").write_text(head + source + temperature + "\n" + "\n".join(runs))
    joints = list(range(1, n_joints + 1))
    model = f'schema = "stiffcal/model/1"\n\n[[effects]]\ntype = "{effect}"\njoints = {joints}\n'
    (folder / "model.toml").write_text(model)
