"""A shoulder that stands lower than the robot file says."""

from __future__ import annotations

from dataclasses import replace

from stiffcal.effects_api import Chain, Geometry, ParameterRole, ParameterSpec, Place, Values


class LowShoulder(Geometry):
    """Joint 2 lies lower than in the robot file.

    Law: its frame is moved by −drop along z of the frame before.
    """

    name = "low-shoulder"
    place_kind = "setup"
    summary = "joint 2 lies lower than in the robot file"
    parameters = (
        ParameterSpec("drop", "m", "how much lower", -0.1, 0.1, 1e-3, "made up for a test", ParameterRole.SETUP),
    )

    def adjusted_chain(self, place: Place, chain: Chain, values: Values) -> Chain:
        """Return the chain with its second joint moved."""
        fixed = chain.fixed.copy()
        fixed[1, 2, 3] -= values.get("drop", 0.0)
        return replace(chain, fixed=fixed)
