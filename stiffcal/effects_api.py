"""What a physical effect of one's own is written with: the names that a plugin may import, and no others.

A plugin is a Python file in the campaign's folder, or an installed package with an entry point in the group
``stiffcal.effects``. docs/how-to/own-effect.md shows one; `stiffcal.effects` holds those that come along, each a file.
"""

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, LoadStates, MeasurementSetup, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import (
    BASE_NODE,
    RX,
    RY,
    RZ,
    TX,
    TY,
    TZ,
    Covariate,
    Effect,
    Geometry,
    Inputs,
    Instrument,
    Law,
    NodeLoads,
    Observed,
    ParameterRole,
    ParameterSpec,
    Place,
    PlaceKind,
    StateOrder,
    Term,
    Values,
    joint_node,
    link_node,
    tool_node,
)
from stiffcal.model.held_frame import HeldFrame
from stiffcal.model.laws.drives import drive_law, drive_terms, drive_torque
from stiffcal.model.laws.prismatic import specs_along_axis
from stiffcal.model.motion import Motion
from stiffcal.model.scalar_laws import LawForm, ScalarLaw

__all__ = [
    "BASE_NODE",
    "RX",
    "RY",
    "RZ",
    "TX",
    "TY",
    "TZ",
    "Attachment",
    "Chain",
    "Covariate",
    "DriveMotion",
    "Effect",
    "Floats",
    "Geometry",
    "HeldFrame",
    "Inputs",
    "Instrument",
    "Law",
    "LawForm",
    "LoadStates",
    "MeasurementSetup",
    "Motion",
    "NodeLoads",
    "Observed",
    "ParameterRole",
    "ParameterSpec",
    "Place",
    "PlaceKind",
    "ScalarLaw",
    "StateOrder",
    "Term",
    "Values",
    "drive_law",
    "drive_terms",
    "drive_torque",
    "joint_node",
    "link_node",
    "members_of",
    "rotation_from_vector",
    "specs_along_axis",
    "tool_node",
]
