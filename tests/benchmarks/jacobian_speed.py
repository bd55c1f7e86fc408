"""100 000 Jacobians: ours, batched, against a Python loop over pinocchio.

Both compute the same numbers, checked here: the (6, 6) Jacobian of a point off the flange in base axes for each of the
joint angles, into one array. NonLoadRuns it the leanest loop, which throws its results away.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import jacobians
from tests.laboratory.robots import shifted, six_axes, six_axis_joints

WANTED = 2.5
POINT = Attachment(7, shifted(0.06, -0.04, 0.10))


def shortest(work: Callable[[], object], repeats: int) -> float:
    """Return the shortest of several runs, s: the least disturbed one."""
    times = []
    for _ in range(repeats):
        started = perf_counter()
        work()
        times.append(perf_counter() - started)
    return min(times)


def pinocchio_loop(chain: Chain, angles: Floats, keep: bool) -> Floats:
    """Compute the Jacobians one by one with pinocchio."""
    import pinocchio as pin

    from tests.laboratory.pinocchio_robot import pinocchio_model

    model: Any = pinocchio_model(chain)
    place = pin.SE3(chain.flange) * pin.SE3(POINT.transform)
    frame = model.addFrame(pin.Frame("point", chain.n_joints, place, pin.FrameType.OP_FRAME))
    data, axes, compute = model.createData(), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED, pin.computeFrameJacobian
    result = np.empty((len(angles), 6, chain.n_joints) if keep else (0, 6, chain.n_joints))
    if keep:
        for i, q in enumerate(angles):
            result[i] = compute(model, data, q, frame, axes)
    else:
        for q in angles:
            compute(model, data, q, frame, axes)
    return result


def main(n: int = 100_000, repeats: int = 5) -> bool:
    """Print the comparison; return whether the wanted ratio was met."""
    chain = six_axes()
    angles = chain.model_angles(six_axis_joints(np.random.default_rng(0), n))
    np.testing.assert_allclose(
        jacobians(chain, angles[:200], POINT), pinocchio_loop(chain, angles[:200], True), atol=1e-12
    )
    ours, kept, thrown = [], [], []
    for _ in range(repeats):  # taking turns, so that a busy machine disturbs all alike
        ours.append(shortest(lambda: jacobians(chain, angles, POINT), 2))
        kept.append(shortest(lambda: pinocchio_loop(chain, angles, True), 1))
        thrown.append(shortest(lambda: pinocchio_loop(chain, angles, False), 1))
    ratio = min(kept) / min(ours)
    print(f"{n} Jacobians: ours {1e3 * min(ours):.1f} ms")
    print(f"  loop over pinocchio, results kept    {1e3 * min(kept):7.1f} ms: {ratio:.2f} x ours (wanted {WANTED})")
    print(f"  loop over pinocchio, results dropped {1e3 * min(thrown):7.1f} ms: {min(thrown) / min(ours):.2f} x ours")
    return ratio >= WANTED


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
