"""A drag that follows the joint's angle."""

from __future__ import annotations

import numpy as np

from stiffcal.effects_api import Chain, DriveMotion, Floats, Motion, ParameterSpec, Place, Values


class SineDrag(Motion):
    """Friction grows with the sine of three times the joint's angle.

    Law: τ_f += drag sin(3 q) sign(ω).
    """

    name = "sine-drag"
    summary = "friction follows the joint's angle"
    parameters = (ParameterSpec("drag", "N·m", "its amplitude", -1e4, 1e4, 5.0, "made up for a test"),)

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """Return the torque per unit of the amplitude."""
        return {"drag": np.sin(3.0 * motion.angle) * np.sign(motion.velocity)}
