"""A motion in the air that is not steady: angles, velocities, accelerations and torques of all joints at once.

One filter serves all of them (Savitzky & Golay 1964: a cubic fitted to a short window), so that the model's torque and
the measured one are smoothed alike.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.kinds.friction.logs.readings import FreeMotion
from stiffcal.measurements.load_states import RunInfo
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rigid_body import drive_matrix
from stiffcal.reduction.logs.blocks import noise_along_a_course

# A robot's path planner ramps its accelerations in 50 to 100 ms; what is faster is ripple of the drives.
WINDOW_S = 0.055
LEAST_WINDOW = 5
CUBIC = 3
# Below this share of a drive's largest velocity, or of what the encoder's noise makes, it counts as standing.
STANDS = 0.002
NOISE_BAND = 5.0


def free_motion(
    info: RunInfo, chain: Chain, time: Floats, logged: Floats, torque: Floats, excluded: Booleans | None = None
) -> FreeMotion:
    """Return the samples of one run, two to a window, so that neighbours share no more than half of their readings.

    Parameters
    ----------
    info : the run. chain : the robot.
    time : (n,) s. logged : (n, L) joint angles as logged, rad. torque : (n, J) N·m of the drives, joint side.
    excluded : (n,) True for samples that are interpolated over excluded rows: windows that hold one are left out.
    """
    step = float(np.median(np.diff(time)))
    even = np.arange(time[0], time[-1] + 0.5 * step, step)
    logged = np.stack([np.interp(even, time, column) for column in logged.T], axis=1)
    torque = np.stack([np.interp(even, time, column) for column in torque.T], axis=1)
    width = max(LEAST_WINDOW, 2 * round(0.5 * WINDOW_S / step) + 1)
    angles, velocity, acceleration = smoothed(logged, width, step)
    coupling = chain.coupling.T
    to_drives = np.linalg.inv(drive_matrix(chain)).T
    drives = velocity @ coupling @ to_drives
    noise = np.array([noise_along_a_course(column) for column in logged.T])
    doubt = noise @ np.abs(coupling @ to_drives) * np.sqrt(12.0 / width**3) / step  # a fitted slope's
    standstill = np.maximum(STANDS * np.abs(drives).max(axis=0), NOISE_BAND * doubt)
    windows = np.lib.stride_tricks.sliding_window_view(drives, width // 2 * 2 + 1, axis=0)
    one_way = (windows.min(axis=-1) > standstill) | (windows.max(axis=-1) < -standstill)
    # the smoothed signals lack half a window at each end, `one_way` another half
    edge = width // 2
    inside = slice(edge, drives.shape[0] - edge, max(1, edge))
    motion = FreeMotion(
        runs=(info,),
        run=np.zeros(one_way[:: max(1, edge)].shape[0], dtype=np.int64),
        time=even[2 * edge : even.size - 2 * edge][:: max(1, edge)],
        angles=(angles @ coupling + chain.offset)[inside],
        velocity=(velocity @ coupling)[inside],
        acceleration=(acceleration @ coupling)[inside],
        drive_velocity=drives[inside],
        drive_acceleration=(acceleration @ coupling @ to_drives)[inside],
        torque=smoothed(torque, width, step)[0][inside],
        one_way=one_way[:: max(1, edge)],
    )
    if excluded is None:
        return motion
    interpolated = np.interp(even, time, excluded.astype(np.float64)) > 0.0
    touched = np.asarray(np.lib.stride_tricks.sliding_window_view(interpolated, width).any(axis=-1))
    return motion.select(~touched[inside])


def smoothed(values: Floats, width: int, step: float) -> tuple[Floats, Floats, Floats]:
    """Return value, slope and curvature of a cubic fitted to each window (Savitzky & Golay 1964).

    Parameters
    ----------
    values : (n, c), evenly spaced by ``step``. width : samples in a window, odd.

    Returns
    -------
    tuple of (n - width + 1, c)
        At the middles of the windows.

    Examples
    --------
    >>> x = np.arange(20.0)[:, None] * 0.1
    >>> [float(np.round(each[3, 0], 9)) for each in smoothed(x**2, 5, 0.1)]
    [0.25, 1.0, 2.0]
    """
    away = (np.arange(width) - width // 2) * step
    fit = np.linalg.pinv(np.vander(away, CUBIC + 1, increasing=True))
    windows = np.lib.stride_tricks.sliding_window_view(values, width, axis=0)
    value, slope, bend = (np.asarray(windows @ fit[k]) for k in range(3))
    return value, slope, 2.0 * bend
