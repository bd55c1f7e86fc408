"""Frames that the manifest leaves to be found: tracker and target, from unloaded poses and joint angles.

Why a general least squares: position only or full pose, tracker, target or both, frames that hang on others: all are
one problem, readings = f(placements), with a start from a closed form (Umeyama 1991) and Gauss–Newton steps after it.
What the poses leave open of one frame (a target's orientation from positions, two poses for a tracker) is refused, not
guessed. What they leave open between frames is a convention: a target whose orientation is the same in all of them, as
on a SCARA or a palletiser along the vertical, may be shifted with the instrument. Absolute runs go by places alone, so
that the target stays where the manifest has it along these axes, which is said; displacements under load depend on the
target's place, and there it has to be given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NoReturn

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.tracker_frames import tracker_frames
from stiffcal.campaign.robot.transforms import placement_matrix
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault, InputError
from stiffcal.estimation.distinguish import distinguish, held_for
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.tracker_axes import each_tracker
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import inverse_transform, rotation_from_vector, transform, vector_from_rotation
from stiffcal.quantity import JOINT_ANGLE, of_component
from stiffcal.reduction.registration.frames import AXES, Registration
from stiffcal.reduction.registration.levelled import levelled
from stiffcal.reduction.registration.poses import different_poses, refuse_few_poses
from stiffcal.reduction.registration.run_apart import run_apart
from stiffcal.reduction.registration.still_components import still_words
from stiffcal.wording import in_unit, length

# A robot's absolute accuracy is some tenths of a millimetre to millimetres; an estimate less certain than this is none.
WORST_POSITION_M = 0.02
WORST_ROTATION_RAD = 0.02
# No robot is further from its nominal geometry: places, or orientations, that are off by more are wrongly read.
WORST_M = 3e-2
WORST_RAD = 0.1
# Angles of a robot as built err by some mrad: orientations that differ by less than a degree leave no joint in doubt.
AGREEING_RAD = 0.0175
STEP = 1e-6  # of numerical derivatives, m and rad
# Share of the largest motion of one frame below which another motion of it is rounding of these derivatives.
OPEN = 1e-6
# Steps below this, m and rad, change nothing that a tracker measures; three of position against rotation come first.
SETTLED, MOST_ROUNDS = 1e-9, 30


def register_frames(
    readings: LoadStates, manifest: Manifest, chain: Chain, names: tuple[str, ...], chosen: Booleans | None = None
) -> Registration:
    """Find the frames `names` from the unloaded states.

    Parameters
    ----------
    readings : load states whose positions are in the instrument's own axes (base_from_tracker taken as identity).
    names : frames marked ``estimate = true``.
    chosen : (n,) states to go by; default: each run's reference.

    Raises
    ------
    InputError
        A frame is none that poses determine, or the poses are too few or too much alike.
    """
    setup = measurement_setup(manifest, chain, resolve_frames(manifest, chain))
    trackers = tracker_frames(manifest)
    for name in names:
        if name not in trackers and name not in _carriers(manifest, setup.target_names):
            raise InputError.at(
                FaultCode.REGISTRATION_IMPOSSIBLE,
                "campaign.toml", f"frames.{name}.estimate", "unloaded poses do not determine this frame",
                "only the frames of the instrument and of the target can be estimated; give this one",
            )  # fmt: skip
    mask = readings.reference if chosen is None else chosen
    states = readings.select(mask & readings.used & np.isfinite(readings.position).all(axis=(1, 2)))
    refuse_few_poses(readings.select(mask & readings.used), states, names, trackers)
    n_poses = different_poses(states.joints)
    places_alone = bool(readings.absolute.all())
    problem = _RegistrationProblem(manifest, chain, states, names, places_alone)
    try:
        return problem.solve(n_poses)
    except InputError:
        fault = None if places_alone else _run_apart(problem, n_poses)  # `place_faults` looks at single places
        if fault is None:
            raise
        raise InputError(fault) from None


def _run_apart(problem: _RegistrationProblem, n_poses: int) -> Fault | None:
    """Return the fault of the one run whose joint angles and places contradict all others; None: there is no such."""

    def solve(others: LoadStates) -> Registration:
        own = _RegistrationProblem(problem.manifest, problem.chain, others, problem.names, problem.places_alone)
        return own.solve(n_poses)

    missed = problem.missed_m
    found = run_apart(problem.states, missed, len(problem.free) + len(problem.held), solve)
    if found is None:
        return None
    name, left = found
    reason = (
        "its joint angles and its positions contradict those of all other runs: with it they differ by "
        f"{length(missed)} rms whatever the frames, without it by {length(left, digits=2)}"
    )
    mend = (
        "check that its joint angles and its positions belong together, or leave out its rows ([[exclude]]) or its logs"
    )
    file = _file_of_positions(problem.manifest)
    return Fault(FaultCode.KINEMATICS_MISMATCH, file, f"run {name}", reason, mend)


def _file_of_positions(manifest: Manifest) -> str:
    """Return the file in which the targets' positions are; the manifest where every run has its own."""
    for name, source in manifest.sources.items():
        if source.body_poses():
            return next(iter(manifest.files_of(name).values()), MANIFEST_FILE)
    return MANIFEST_FILE


def _carriers(manifest: Manifest, targets: tuple[str, ...]) -> set[str]:
    """Return the frames on which the targets hang."""
    carriers: set[str] = set()
    for target in targets:
        frame = target
        while frame in manifest.frames and frame not in carriers:
            carriers.add(frame)
            frame = manifest.frames[frame].parent
    return carriers


class _RegistrationProblem:
    """Residuals of readings against kinematics as a function of small changes of the frames."""

    def __init__(
        self,
        manifest: Manifest,
        chain: Chain,
        states: LoadStates,
        names: tuple[str, ...],
        places_alone: bool,
    ) -> None:
        self.manifest, self.chain, self.states, self.names = manifest, chain, states, names
        self.trackers = tracker_frames(manifest)
        self.held: list[tuple[str, int]] = []
        self.places_alone = places_alone
        self.angles = chain.model_angles(states.joints)
        self.full_pose = bool(np.isfinite(states.rotation).all())
        self.frames = {name: placement_matrix(manifest.frames[name]) for name in names}
        self.frames |= {name: self._starting_transform(name) for name in names if name in self.trackers}
        # a target's orientation cannot be derived from its position; a levelled tracker turns about its z axis alone
        self.free = [
            (name, k)
            for name in names
            for k in range(6)
            if (self.full_pose or name in self.trackers or k < 3) and not (manifest.frames[name].level and k in (3, 4))
        ]

    def _starting_transform(self, tracker: str) -> Floats:
        """Return a start for a tracker: the rigid motion that brings its readings and kinematics together."""
        setup = measurement_setup(self.manifest, self.chain, resolve_frames(self.manifest, self.chain, self.frames))
        number = self.trackers.index(tracker)
        own = self.states.tracker == number
        predicted, _ = attached_poses(self.chain, self.angles[own], setup.targets[0])
        measured = self.states.position[own, 0]
        left, _, right = np.linalg.svd((predicted - predicted.mean(axis=0)).T @ (measured - measured.mean(axis=0)))
        turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
        base_from_tracker = transform(turn, predicted.mean(axis=0) - turn @ measured.mean(axis=0))
        # what the manifest hangs between base and this frame stays
        base_from_now = setup.trackers[number].base_from_frame
        base_from_parent = base_from_now @ inverse_transform(self.frames[tracker])
        start = np.asarray(inverse_transform(base_from_parent) @ base_from_tracker)
        return levelled(start, self.chain.gravity) if self.manifest.frames[tracker].level else start

    def residuals(self, frames: Mapping[str, Floats]) -> tuple[Floats, Floats]:
        """Return position residuals (n, B, 3) m and rotation residuals (n, B, 3) rad (empty for positions only)."""
        setup = measurement_setup(self.manifest, self.chain, resolve_frames(self.manifest, self.chain, frames))
        placed = np.stack([tracker.base_from_frame for tracker in setup.trackers])[self.states.tracker]
        turn, shift = placed[:, :3, :3], placed[:, :3, 3]
        places, turns = [], []
        for b, target in enumerate(setup.targets):
            place, rotation = attached_poses(self.chain, self.angles, target)
            places.append(np.einsum("nij,nj->ni", turn, self.states.position[:, b]) + shift - place)
            if self.full_pose:
                measured = turn @ self.states.rotation[:, b]
                turns.append(vector_from_rotation(measured @ np.swapaxes(rotation, -1, -2)))
        return np.stack(places, axis=1), np.stack(turns, axis=1) if turns else np.zeros((len(self.states), 0, 3))

    def _apply_step(self, step: Floats) -> dict[str, Floats]:
        """Return the frames moved by step (p,), in their own axes."""
        frames = dict(self.frames)
        for name in self.names:
            small = np.zeros(6)
            for (free_name, k), value in zip(self.free, step, strict=True):
                if free_name == name:
                    small[k] = value
            frames[name] = frames[name] @ transform(rotation_from_vector(small[3:]), small[:3])
        return frames

    def _flat(self, frames: Mapping[str, Floats], weight: float) -> Floats:
        place, turn = self.residuals(frames)
        return np.concatenate([place.ravel(), weight * turn.ravel()])

    def solve(self, n_poses: int) -> Registration:
        """Find the frames; what is open between them is held and, where that is more than a convention, refused."""
        start = dict(self.frames)
        held = self._open_at(self._jacobian(weight=1.0))
        while True:
            self._hold(held)
            self.frames = dict(start)
            jacobian, sigma = self._iterate()
            held = self._open_at(jacobian) or self._uncertain(jacobian, sigma)
            if not held:
                return self._registration(jacobian, sigma, n_poses)

    def _jacobian(self, weight: float) -> Floats:
        """Return (rows, p) derivatives of the residuals by the free components of the frames."""
        columns = []
        for k in range(len(self.free)):
            step = np.zeros(len(self.free))
            step[k] = STEP
            ahead, back = self._flat(self._apply_step(step), weight), self._flat(self._apply_step(-step), weight)
            columns.append((ahead - back) / (2.0 * STEP))
        return np.stack(columns, axis=1)

    def _iterate(self) -> tuple[Floats, float]:
        """Take steps, weigh rotation against position by what each leaves; return the derivatives and the scatter."""
        weight = 1.0  # m per rad, at first: a milliradian counts like a millimetre
        for rounds in range(MOST_ROUNDS):
            now, jacobian = self._flat(self.frames, weight), self._jacobian(weight)
            step = np.asarray(-np.linalg.lstsq(jacobian, now, rcond=OPEN)[0], dtype=np.float64)
            self.frames = self._apply_step(step)
            if rounds in (3, 6) and self.full_pose:
                place, turn = self.residuals(self.frames)
                weight = float(np.sqrt(np.mean(place**2) / max(float(np.mean(turn**2)), 1e-18)))
            elif rounds > 6 and np.abs(step).max() < SETTLED:
                return jacobian, float(np.sqrt(now @ now / max(now.size - len(self.free), 1)))
        return self._refuse(f"do not converge in {MOST_ROUNDS} steps")

    def _open_at(self, jacobian: Floats) -> tuple[int, ...]:
        """Return the numbers of components that are held because other frames make up for them in these poses.

        Raises
        ------
        InputError : the poses leave a motion of one frame open, whatever the others are.
        """
        # in orthonormal motions of each frame, singular values are the angles between what two frames can do
        motions = np.zeros_like(jacobian)
        back = np.zeros((len(self.free),) * 2)
        for own in self._by_frame():
            length = np.linalg.norm(jacobian[:, own], axis=0)
            left, singular, right = np.linalg.svd(jacobian[:, own] / np.maximum(length, 1e-300), full_matrices=False)
            if singular[-1] < OPEN * singular[0] or not length.all():
                self._refuse("leave a direction open")
            motions[:, own] = left
            back[np.ix_(own, own)] = right.T / singular
        found = distinguish(motions, self._hold_first())
        if not found.held:
            return ()
        # shares of the components, each in columns of unit length
        return held_for(np.linalg.qr(back @ found.null.T)[0].T, self._hold_first())

    def _uncertain(self, jacobian: Floats, sigma: float) -> tuple[int, ...]:
        """Return the numbers of components that are held because a direction is known worse than any registration.

        Raises
        ------
        InputError : one frame alone is not known better, whatever the others are.
        """
        worst = np.array([WORST_POSITION_M if k < 3 else WORST_ROTATION_RAD for _, k in self.free])
        scaled = jacobian * worst / max(sigma, 1e-300)
        for own in self._by_frame():
            spread = np.sqrt(np.sum(np.linalg.pinv(scaled[:, own]) ** 2, axis=1))
            k = int(np.argmax(spread))
            if spread[k] > 1.0:
                value, (name, axis) = spread[k] * worst[own[k]], self.free[own[k]]
                amount = in_unit(value, of_component(axis).usual, 2)
                self._refuse(f"leave frame {name} uncertain by {amount}")
        _, singular, directions = np.linalg.svd(scaled, full_matrices=False)
        if (np.sum((directions.T / singular) ** 2, axis=1) <= 1.0).all():
            return ()
        return held_for(directions[singular < 1.0], self._hold_first())

    def _by_frame(self) -> list[Integers]:
        """Return the numbers of the free components, frame by frame."""
        of = np.array([self.names.index(name) for name, _ in self.free])
        return [np.flatnonzero(of == number) for number in np.unique(of)]

    def _hold_first(self) -> list[int]:
        """Return the components in the order of the convention: targets stay where the manifest has them."""
        return sorted(range(len(self.free)), key=lambda k: (self.free[k][0] in self.trackers, k))

    def _hold(self, numbers: tuple[int, ...]) -> None:
        """Hold components of frames where the manifest has them.

        Raises
        ------
        InputError : displacements under load are measured too, which depend on where a target is.
        """
        if not numbers:
            return
        held = [self.free[number] for number in sorted(numbers)]
        self.free = [component for component in self.free if component not in held]
        self.held += held
        if not self.places_alone:
            names = list(dict.fromkeys(name for name, _ in held))
            others = [name for name in self.names if name not in names]
            where = ", ".join(f"{AXES[axis]} of {name}" for name, axis in held)
            raise InputError.at(
                FaultCode.REGISTRATION_IMPOSSIBLE,
                "campaign.toml", f"frames.{names[0]}.estimate",
                f"the orientation varies too little in the unloaded poses to separate {where} from "
                f"{' and '.join(others) or 'the others'}, and displacements under load depend on it",
                "give this frame (estimate = false), or measure unloaded poses in other orientations",
            )  # fmt: skip

    def _registration(self, jacobian: Floats, sigma: float, n_poses: int) -> Registration:
        inverse = np.linalg.pinv(jacobian)
        uncertainty = {name: np.full(6, np.nan) for name in self.names}
        for (name, k), value in zip(self.free, sigma * np.sqrt(np.sum(inverse**2, axis=1)), strict=True):
            uncertainty[name][k] = value
        _, turn = self.residuals(self.frames)
        rms_rad = float(np.sqrt(np.mean(np.sum(turn**2, axis=-1)))) if turn.size else float("nan")
        held = {name: tuple(AXES[axis] for of, axis in self.held if of == name) for name, _ in self.held}
        return Registration(self.frames, uncertainty, self.missed_m, rms_rad, n_poses, held)

    @property
    def missed_m(self) -> float:
        """Rms distance between kinematics and readings with the present frames."""
        place, _ = self.residuals(self.frames)
        return float(np.sqrt(np.mean(np.sum(place**2, axis=-1))))

    def _refuse(self, reason: str) -> NoReturn:
        _, turn = self.residuals(self.frames)
        missed = self.missed_m
        turned = float(np.sqrt(np.mean(np.sum(turn**2, axis=-1)))) if turn.size else 0.0
        if missed <= WORST_M and turned > WORST_RAD:
            raise InputError.at(
                FaultCode.KINEMATICS_MISMATCH,
                _file_of_positions(self.manifest), "measured orientations",
                f"joint angles and orientations contradict each other: they differ by {np.degrees(turned):.0f}° rms "
                "whatever the frames, where the positions fit",
                "check the order of the columns of the orientation (quaternion_wxyz: w first), their signs and unit, "
                "and that they are the target's in the axes of the frame",
            )  # fmt: skip
        if missed > WORST_M:
            still, first = still_words(self.states)
            if turn.size and turned <= AGREEING_RAD:
                raise InputError.at(
                    FaultCode.KINEMATICS_MISMATCH,
                    _file_of_positions(self.manifest), "lengths of the robot",
                    f"measured positions differ from those of the robot file by {length(missed)} rms whatever the "
                    f"frames, while orientations agree to {in_unit(turned, JOINT_ANGLE.usual, 2)} "
                    f"rms: the joint angles are right, "
                    f"only lengths can be wrong{still}",
                    f"{first}check the lengths of the robot file (is it of this robot?) and the unit of the positions",
                )  # fmt: skip
            raise InputError.at(
                FaultCode.KINEMATICS_MISMATCH,
                _file_of_positions(self.manifest), "joint angles and positions",
                f"joint angles and positions contradict each other: they differ by {length(missed)} rms whatever "
                f"the frames, and no single sign, zero, unit or order of columns explains it{still}",
                f"{first}check that each position is next to its joint angles, that each column holds its joint, and "
                "the lengths and angles of the robot file",
            )  # fmt: skip
        raise InputError.at(
            FaultCode.REGISTRATION_IMPOSSIBLE,
            "campaign.toml", f"frames.{self.names[0]}.estimate", f"the unloaded poses {reason}",
            "measure more poses that differ in position and orientation, or give the frame",
        )  # fmt: skip


def in_instrument_axes(states: LoadStates) -> LoadStates:
    """Return the states with positions and rotations back in the instrument's own axes."""
    position, rotation = np.empty_like(states.position), np.empty_like(states.rotation)
    for read, base_from_tracker in each_tracker(states.setup.trackers, states.tracker):
        tracker_from_base = inverse_transform(base_from_tracker)
        position[read] = states.position[read] @ tracker_from_base[:3, :3].T + tracker_from_base[:3, 3]
        rotation[read] = tracker_from_base[:3, :3] @ states.rotation[read]
    trackers = tuple(replace(tracker, base_from_frame=np.eye(4)) for tracker in states.setup.trackers)
    return replace(states, position=position, rotation=rotation, setup=replace(states.setup, trackers=trackers))
