"""What a robot file leaves open that later commands need: limits and masses, and angles that do not fit the limits."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stiffcal.campaign.loading import load_robot
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.toml_reading import parse_toml
from stiffcal.mechanics.chain import Chain
from stiffcal.propose.column_roles import Roles
from stiffcal.propose.from_table import Proposal
from stiffcal.propose.table_purpose import serves_absolute
from stiffcal.quantities import unit
from stiffcal.wording import listing

# Logged angles leave the limits of a controller by rounding and overshoot, not by this, rad.
_BEYOND = float(np.radians(1.0))


def remarks_of(folder: Path, proposal: Proposal, file: str) -> list[str]:
    """Return warnings of `init --from` on the robot of a folder that was written, one sentence each.

    Parameters
    ----------
    folder : the campaign's. proposal : what was written. file : that describes the robot.
    """
    assert proposal.roles is not None
    chain = chain_of(load_robot(folder / "robot.toml"), folder)
    units = parse_toml(proposal.manifest, MANIFEST_FILE)["sources"]["table"]["joints"]["units"]["position"]
    units = [units] * chain.n_joints if isinstance(units, str) else units
    return robot_remarks(chain, proposal.roles, units, file, absolute=serves_absolute(proposal.roles))


def robot_remarks(chain: Chain, roles: Roles, units: Sequence[str], file: str, *, absolute: bool) -> list[str]:
    """Return what a robot leaves open, and which logged positions are beyond its limits.

    Parameters
    ----------
    chain : of the robot. roles : the table's columns. units : of the joint columns. file : that describes the robot.
    absolute : whether weight is the load.
    """
    remarks = []
    open_ones = [
        name for name, (low, high) in zip(chain.joint_names, chain.limits, strict=True) if not np.isfinite(high - low)
    ]
    if open_ones:
        key = "limits_m" if set(open_ones) <= set(chain.prismatic_names) else "limits_deg"
        joints = f"joint{'s' * (len(open_ones) > 1)} {listing(open_ones)}"
        remarks.append(
            f"{file}: no limits of {joints}: plan and simulate may choose any position there, and none is checked; "
            f"state both as {key} in [[joints]] of robot.toml"
        )
    if absolute and not chain.masses_known:  # of displacements under load it is second order, and identify warns
        without = [name for name, mass in zip(chain.link_names, chain.link_mass, strict=True) if mass == 0.0]
        lacking = f"no mass of link{'s' * (len(without) > 1)} {listing(without)}"
        effect = "weight is not modelled, by which absolute poses identify stiffness"
        remarks.append(f"{file}: {lacking}: {effect}; write mass_kg and com_m of the links in robot.toml")
    assert roles.joints is not None
    for k, (column, written) in enumerate(zip(roles.joints.columns, units, strict=True)):
        factor = unit(written, "length" if chain.prismatic[k] else "angle").factor
        read = factor * np.array(column.values)
        low, high = chain.limits[k]
        beyond = np.flatnonzero((read < low - _BEYOND) | (read > high + _BEYOND))
        if beyond.size:
            shown = (chain.printed_positions(np.full(chain.n_joints, end))[k] for end in (low, high, read[beyond[0]]))
            ends = [f"{value:.4g}" for value in shown]
            mark = " mm" if chain.prismatic[k] else "°"
            remarks.append(
                f'column "{column.header}": {beyond.size} of {read.size} values are beyond the limits of joint '
                f"{chain.joint_names[k]} ({ends[0]} to {ends[1]}{mark}), the first is {ends[2]}{mark}: compare unit, "
                f"sign and zero with {file}"
            )
    return remarks
