"""What `[report]` of the manifest asks of the report: stiffness in given poses, a map, a logo."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.compensation.load_table import LoadTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular
from stiffcal.report.content import PoseStiffness, ReportContent
from stiffcal.stages.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.campaign.manifest.report_settings import MapSettings
    from stiffcal.compensation.map_result import MapResult

# Small loads, under which a law that bends gives its stiffness at work near zero load.
_FORCE_N, _MOMENT_NM = 100.0, 20.0
# Along the longer side of a map: enough for a picture of a page's width, and quick.
_MAP_POINTS = 25


def with_requests(content: ReportContent, data: Ingested, context: RunContext) -> ReportContent:
    """Return the content of a report with what the manifest asks for.

    Parameters
    ----------
    content : without it. data : the campaign. context : store and progress.

    Raises
    ------
    InputError : a pose, the load of the map or the logo is wrong.
    """
    settings, folder = data.campaign.manifest.report, data.campaign.folder
    if settings.stiffness_at_deg:
        poses = stiffness_in_poses(data, settings.stiffness_at_deg, context)
        content = replace(content, stiffness_poses=poses)
    if settings.map is not None:
        content = replace(content, workspace=_map(folder, settings.map, context))
    if settings.logo is not None:
        from stiffcal.report.logo import rasterised

        if not (folder / settings.logo).exists():
            reason, mend = f"no such file: {settings.logo}", "add it, or correct the name"
            raise InputError.at(FaultCode.FILE_MISSING, MANIFEST_FILE, "report.logo", reason, mend)
        written = read_regular(folder / settings.logo, settings.logo)
        content = replace(content, logo=rasterised(written, settings.logo, (MANIFEST_FILE, "report.logo")))
    return content


def stiffness_in_poses(
    data: Ingested, poses_deg: tuple[tuple[float, ...], ...], context: RunContext
) -> tuple[PoseStiffness, ...]:
    """Return the Cartesian stiffness in each pose, by the fitted model under a small load along each axis.

    Raises
    ------
    InputError : a pose has another number of angles than the robot has logged joints.
    """
    from stiffcal.commands.predict import predict_campaign

    count = len(data.joint_names)
    for number, pose in enumerate(poses_deg, 1):
        if len(pose) != count:
            place = f"report.stiffness_at_deg[{number}]"
            reason = f"{len(pose)} angles for a robot with {count} joints"
            raise InputError.at(FaultCode.VALUE_INVALID, MANIFEST_FILE, place, reason, f"write {count} angles")
    joints = np.repeat(data.campaign.chain.from_printed(np.array(poses_deg)), 6, axis=0)
    size = np.array([_FORCE_N] * 3 + [_MOMENT_NM] * 3)
    loads = LoadTable(joints, np.tile(np.diag(size), (len(poses_deg), 1)))
    result = predict_campaign(data.campaign.folder, context, poses=loads)
    poses = []
    for first in range(0, len(result.states), 6):
        states = result.states[first : first + 6]
        compliance = np.array([state.deflection[k] / size[k] for k, state in enumerate(states)])
        std = np.array([np.sqrt(max(state.covariance[k, k], 0.0)) / size[k] for k, state in enumerate(states)])
        matrix = states[0].cartesian_stiffness
        held = None if matrix is None else np.diag(matrix).copy()
        poses.append(PoseStiffness(np.asarray(states[0].joints), result.target, compliance, std, held))
    return tuple(poses)


def _map(folder: Path, settings: MapSettings, context: RunContext) -> MapResult:
    from stiffcal.commands.map import robot_to_map
    from stiffcal.compensation.workspace_map import MapWish, map_of_robot

    wish = MapWish(
        wrench=np.array([*settings.load_N, 0.0, 0.0, 0.0]),
        direction=None if settings.stiffness is None else np.eye(3)["xyz".index(settings.stiffness)],
        plane=settings.plane,
        at=settings.at_m,
        points=_MAP_POINTS,
    )
    return map_of_robot(robot_to_map(folder, context), wish, context.progress)
