"""The tool's weight in a force sensor's reading, taken out before it is compensated (001, Fig. 3; 002, Fig. 5).

The filter for its noise stands in `stiffcal.mechanics.low_pass`.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.low_pass import LowPass
from stiffcal.mechanics.rotations import cross_matrix, inverse_transform


def weight_on_sensor(chain: Chain, angles: Floats, sensor: Attachment, mass: float, com: Floats) -> Floats:
    """Return (n, 6) what the weight of a tool beyond the sensor makes it read, as a wrench on the robot, sensor axes.

    Parameters
    ----------
    angles : (n, J) model angles, rad.
    sensor : its axes and origin; on the base: base axes about the base's origin.
    mass : kg of all that is mounted on the sensor.
    com : (3,) its centre in the flange frame, m.
    """
    _, rotation = attached_poses(chain, angles, sensor)
    if sensor.body != 0:
        force = mass * np.einsum("nji,j->ni", rotation, chain.gravity)
        arm = tool_arm(chain, sensor, com)
        return np.concatenate([force, np.cross(arm, force)], axis=1)
    place, turned = attached_poses(chain, angles, Attachment(chain.n_joints + 1, np.eye(4)))
    force = np.broadcast_to(mass * sensor.transform[:3, :3].T @ chain.gravity, place.shape)
    arms = (place + turned @ com - sensor.transform[:3, 3]) @ sensor.transform[:3, :3]
    return np.concatenate([force, np.cross(arms, force)], axis=1)


def tool_arm(chain: Chain, sensor: Attachment, com: Floats) -> Floats:
    """Return (3,) from the origin of a sensor on the last link or flange to a point of the flange frame, sensor axes.

    Raises
    ------
    ValueError : the sensor rides on another body, so that the arm turns with the joints.
    """
    if sensor.body == chain.n_joints + 1:
        flange_from_sensor = sensor.transform
    elif sensor.body == chain.n_joints:
        flange_from_sensor = inverse_transform(chain.flange) @ sensor.transform
    else:
        raise ValueError("the tool weight can be subtracted only for a sensor on the flange or the last link")
    return np.asarray((inverse_transform(flange_from_sensor) @ np.append(com, 1.0))[:3])


def without_tool(
    reading: Floats, chain: Chain, angles: Floats, setup: MeasurementSetup, tool: tuple[float, Floats], zeroed: bool
) -> Floats:
    """Return (n, 6) readings without the weight of the tool beyond the sensor.

    Parameters
    ----------
    reading : (n, 6) on the robot, in the set-up's wrench axes about its wrench point, both of one frame.
    angles : (n, J) model angles, rad.
    tool : mass, kg, and centre in the flange frame, m, of what hangs beyond the sensor.
    zeroed : True where the sensor read zero in the first state, tool and all.
    """
    weight = weight_on_sensor(chain, angles, setup.wrench_axes, *tool)
    return np.asarray(reading - (weight - weight[0] if zeroed else weight))


def weight_matrix(arm: Floats, mass: float) -> Floats:
    """Return (6, 3): a mass's wrench from the direction and size of gravity in sensor axes, m/s²."""
    return np.concatenate([mass * np.eye(3), mass * cross_matrix(arm)])


def tool_in_reading(
    chain: Chain, setup: MeasurementSetup, mass: float, com: Floats, zeroed_at: Floats | None
) -> tuple[Floats, Floats]:
    """Return (6, 3) a tool's weight in a reading over gravity in the reading's axes, and (6,) what of it was zeroed.

    Parameters
    ----------
    setup : its wrench axes and point are one frame, the sensor, where there is a tool.
    mass : kg; 0: no tool. com : (3,) its centre in the flange frame, m.
    zeroed_at : (L,) logged angles, rad, at which the sensor read zero with the tool on; None: it was never zeroed.

    Raises
    ------
    ValueError : axes and point of the reading are different frames, or the sensor is not on the flange or last link.
    """
    if mass <= 0.0:
        return np.zeros((6, 3)), np.zeros(6)
    sensor = setup.wrench_axes
    if not np.allclose(sensor.transform, setup.wrench_point.transform):
        raise ValueError(
            "subtracting the tool weight requires a reading with axes and reference point of one frame, the sensor"
        )
    per_gravity = weight_matrix(tool_arm(chain, sensor, com), mass)
    if zeroed_at is None:
        return per_gravity, np.zeros(6)
    _, rotation = attached_poses(chain, chain.model_angles(np.atleast_2d(zeroed_at)), sensor)
    return per_gravity, per_gravity @ rotation[0].T @ chain.gravity


def reading_filter(cutoff_hz: float | None, cycle_s: float) -> tuple[Floats, Floats]:
    """Return b (3,) and a (2,) of the low-pass of a loop; 1, 0, 0 and 0, 0 without one."""
    if cutoff_hz is None:
        return np.array([1.0, 0.0, 0.0]), np.zeros(2)
    smooth = LowPass(cutoff_hz, 1.0 / cycle_s)
    return smooth.b, smooth.a
