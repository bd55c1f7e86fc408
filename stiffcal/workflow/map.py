"""Deflection or stiffness over the workspace."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.sizes import HEAVIEST_KG, LONGEST_M
from stiffcal.errors import InputError
from stiffcal.workflow.compensation_path import numbers_of_words, pose_of_words
from stiffcal.workflow.plot import PICTURES
from stiffcal.workflow.steps import Document, Means
from stiffcal.workflow.valued import ValuedCampaign, valued_campaign

if TYPE_CHECKING:
    from stiffcal.compensation.workspace import MapWish, WorkspaceMap
    from stiffcal.measurements.load_states import MeasurementSetup
    from stiffcal.report.content import WorkspacePicture

Floats = NDArray[np.float64]

PLANES = {"xy": (0, 1, 2), "xz": (0, 2, 1), "yz": (1, 2, 0)}
TABLES = (".csv", ".parquet")
STATUS = ("out of reach", "only beyond joint limits", "reached")


@dataclass(frozen=True)
class MapRequest:
    """What a person asks to see.

    Attributes
    ----------
    load : "Fx,Fy,Fz[,Tx,Ty,Tz]" in N and N·m, base axes, at the load point.
    mass : kg hung on the load point: its weight is the load.
    stiffness : "x", "y", "z" or "dx,dy,dz": stiffness along it is mapped too.
    plane : "xy", "xz" or "yz".
    at : m, where the plane cuts the third axis; None: through the middle of the reach.
    slices : more than one: so many parallel planes through the reach, a volume.
    points : along the longer side of a plane.
    pose : "A1,A2,…" in degrees, whose tool orientation is kept everywhere; None: the orientation is free.
    target : the frame that is moved about; None: the first measured one.
    """

    load: str | None = None
    mass: float | None = None
    stiffness: str | None = None
    plane: str = "xz"
    at: float | None = None
    slices: int = 1
    points: int = 41
    pose: str | None = None
    target: str | None = None


def map_campaign(
    folder: Path,
    request: MapRequest,
    means: Means | None = None,
    picture: Path | None = None,
    table: Path | None = None,
) -> Document:
    """Map deflection and stiffness over a plane or a volume of the workspace.

    Parameters
    ----------
    folder : a campaign folder with a fit, with logs to fit, or with a model file that values every parameter.
    request : load, plane and what is wanted.
    means : store, progress and so on.
    picture : SVG, PNG or PDF. table : CSV or Parquet with every point.

    Returns
    -------
    dict
        The `map` document.

    Raises
    ------
    InputError : the input is wrong, or the load is more than the robot holds.
    """
    from stiffcal.compensation.workspace import map_workspace
    from stiffcal.model.equilibrium import NoBalanceError

    means = means or Means()
    _check_outputs(picture, table)
    campaign = load_campaign(Path(folder), check_files=False)
    valued = valued_campaign(campaign, means)
    setup, target = valued.aimed_at(request.target)
    wrench = _wrench(valued, request)
    direction = _direction(request.stiffness)
    if direction is None and not wrench.any():
        raise InputError.at("command line", "--load", "nothing to map", "give --load, --mass or --stiffness")
    wish, shape, levels = _grid(valued, setup, request, wrench, direction)
    means.progress(f"looking for {len(wish.points)} poses", None)
    try:
        found = map_workspace(valued.robot, setup, wish, valued.covariance)
    except NoBalanceError as error:
        raise error.of_load("command line", "--load", "give a smaller load") from error
    document = _document(valued, request, wish, found, target, shape, levels)
    if table is not None:
        from stiffcal.workflow.export import write_table

        write_table(_table(valued, found), table)
        document["file"] = str(table)
    if picture is not None:
        from stiffcal.report.figures.canvas import save_figure
        from stiffcal.report.figures.workspace import draw_workspace

        save_figure(draw_workspace(_picture(valued, request, wish, found, shape, levels)), picture)
        document["picture"] = str(picture)
    return document


def _check_outputs(picture: Path | None, table: Path | None) -> None:
    for file, kinds, words in ((picture, PICTURES, "picture"), (table, TABLES, "table")):
        if file is not None and file.suffix.lower() not in kinds:
            raise InputError.at(str(file), "", f"no {words} format", f"end the name in one of {', '.join(kinds)}")
        if file is not None and not file.parent.is_dir():
            raise InputError.at(str(file), "", "its folder does not exist", "make the folder first")


def _wrench(valued: ValuedCampaign, request: MapRequest) -> Floats:
    if request.load is not None and request.mass is not None:
        raise InputError.at("command line", "--mass", "there is a --load already", "give one of the two")
    wrench = np.zeros(6)
    if request.mass is not None:
        if not 0.0 < request.mass < np.inf:
            raise InputError.at("command line", "--mass", f"{request.mass:g} kg hang nowhere", "give a mass in kg")
        wrench[:3] = request.mass * valued.campaign.chain.gravity
    elif request.load is not None:
        given = numbers_of_words(request.load, "--load")
        if len(given) not in (3, 6):
            mend = "write Fx,Fy,Fz or Fx,Fy,Fz,Tx,Ty,Tz"
            raise InputError.at("command line", "--load", f"{request.load!r} is no wrench", mend)
        wrench[: len(given)] = given
    return wrench


def _direction(words: str | None) -> Floats | None:
    if words is None:
        return None
    if words in ("x", "y", "z"):
        return np.asarray(np.eye(3)["xyz".index(words)])
    vector = np.array(numbers_of_words(words, "--stiffness"))
    if vector.shape != (3,) or not vector.any():
        raise InputError.at("command line", "--stiffness", f"{words!r} is no direction", "write x, y, z or dx,dy,dz")
    return np.asarray(vector / np.linalg.norm(vector))


def _grid(
    valued: ValuedCampaign, setup: MeasurementSetup, request: MapRequest, wrench: Floats, direction: Floats | None
) -> tuple[MapWish, tuple[int, int, int], Floats]:
    """Return the wish with its points, slice after slice, the grid's shape (slices, rows, columns), and levels, m."""
    from stiffcal.compensation.inverse import middle_of_ranges
    from stiffcal.compensation.workspace import MapWish, reached_box
    from stiffcal.mechanics.kinematics import attached_poses

    if request.plane not in PLANES:
        raise InputError.at("command line", "--plane", f"no plane {request.plane}", f"one of {', '.join(PLANES)}")
    if not (2 <= request.points <= 400 and 1 <= request.slices <= 30):
        mend = "2 to 400 points along a side, 1 to 30 slices"
        raise InputError.at("command line", "--points", f"{request.points} points, {request.slices} slices", mend)
    if request.at is not None and not abs(request.at) <= LONGEST_M:
        reason = f"no robot reaches {request.at:g} m"
        raise InputError.at("command line", "--at", reason, "give the height of the plane in m")
    if request.mass is not None and request.mass > HEAVIEST_KG:
        raise InputError.at("command line", "--mass", f"no robot holds {request.mass:g} kg", "give the mass in kg")
    chain = valued.campaign.chain
    across, up, third = PLANES[request.plane]
    box = reached_box(chain, setup.targets[0])
    middle = float(box[third].mean()) if request.at is None else request.at
    levels = np.array([middle])
    if request.slices > 1:
        # the outermost slices would only touch the reach
        edge = 0.5 / request.slices
        levels = box[third, 0] + np.ptp(box[third]) * np.linspace(edge, 1.0 - edge, request.slices)
    sides = np.ptp(box, axis=1)[[across, up]]
    counts = np.maximum(2, np.round(request.points * sides / sides.max())).astype(int)
    ends = box[[across, up]]
    columns, rows = (np.linspace(low, high, int(count)) for (low, high), count in zip(ends, counts, strict=True))
    points = np.zeros((len(levels), len(rows), len(columns), 3))
    points[..., third] = levels[:, None, None]
    points[..., across], points[..., up] = columns, rows[:, None]
    home, rotation = middle_of_ranges(chain), None
    if request.pose is not None:
        home = pose_of_words(request.pose, chain.joint_names, "--pose")
        _, turned = attached_poses(chain, chain.model_angles(home[None]), setup.targets[0])
        rotation = turned[0]
    wish = MapWish(points.reshape(-1, 3), home, rotation, wrench, direction)
    return wish, (len(levels), len(rows), len(columns)), levels


def _document(
    valued: ValuedCampaign,
    request: MapRequest,
    wish: MapWish,
    found: WorkspaceMap,
    target: str,
    shape: tuple[int, int, int],
    levels: Floats,
) -> Document:
    here = found.status == 2
    moved, turned = (np.linalg.norm(found.deflection[here][:, part], axis=1) for part in (slice(3), slice(3, 6)))
    stiff = found.stiffness[here]

    def ends(values: Floats) -> list[float] | None:
        known = values[np.isfinite(values)]
        return [float(known.min()), float(known.max())] if known.size else None

    warnings = list(valued.warnings)
    if not here.any():
        warnings.append("the robot reaches none of the points: choose another plane, or another --pose")
    return {
        "schema": "stiffcal/map/1",
        "warnings": warnings,
        "values_from": valued.source,
        "target": target,
        "wrench": wish.wrench.tolist(),
        "plane": request.plane,
        "levels": levels.tolist(),
        "shape": list(shape),
        "reached": int(here.sum()),
        "beyond_limits": int((found.status == 1).sum()),
        "position_error": ends(moved),
        "orientation_error": ends(turned),
        "stiffness": ends(stiff),
        "points": [
            {
                "position": found.points[k].tolist(),
                "status": STATUS[int(found.status[k])],
                "joints": _numbers(found.joints[k]),
                "deflection": _numbers(found.deflection[k]),
                "std": _numbers(found.std[k]),
                "stiffness": _number(found.stiffness[k]),
                "limit_margin": _number(found.margin[k]),
            }
            for k in range(len(found.points))
        ],
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _numbers(values: Floats) -> list[float] | None:
    return values.tolist() if np.isfinite(values).all() else None


def _table(valued: ValuedCampaign, found: WorkspaceMap) -> dict[str, Any]:
    columns: dict[str, Any] = {f"{axis} [mm]": 1e3 * found.points[:, k] for k, axis in enumerate("XYZ")}
    columns["status"] = [STATUS[int(one)] for one in found.status]
    names = valued.campaign.chain.joint_names
    columns |= {f"{name} [deg]": np.degrees(found.joints[:, k]) for k, name in enumerate(names)}
    for k, name in enumerate(("dx", "dy", "dz", "rx", "ry", "rz")):
        columns[f"{name} [{'mm' if k < 3 else 'mrad'}]"] = 1e3 * found.deflection[:, k]
    columns["position error [mm]"] = 1e3 * np.linalg.norm(found.deflection[:, :3], axis=1)
    columns["orientation error [mrad]"] = 1e3 * np.linalg.norm(found.deflection[:, 3:], axis=1)
    columns["position error, standard uncertainty [mm]"] = 1e3 * found.std[:, 0]
    columns["orientation error, standard uncertainty [mrad]"] = 1e3 * found.std[:, 1]
    columns["stiffness [N/mm]"] = 1e-3 * found.stiffness
    columns["limit margin [deg]"] = np.degrees(found.margin)
    columns["smallest singular value"] = found.smallest_singular
    return columns


def _picture(
    valued: ValuedCampaign,
    request: MapRequest,
    wish: MapWish,
    found: WorkspaceMap,
    shape: tuple[int, int, int],
    levels: Floats,
) -> WorkspacePicture:
    from stiffcal.mechanics.kinematics import body_poses
    from stiffcal.report.content import WorkspacePicture

    chain = valued.campaign.chain
    across, up, third = PLANES[request.plane]
    quantities: list[tuple[str, str, Floats]] = []
    if wish.wrench.any():
        for name, part, units in (
            ("position error", slice(3), ("µm", "mm")),
            ("orientation error", slice(3, 6), ("µrad", "mrad")),
        ):
            size = np.linalg.norm(found.deflection[:, part], axis=1).reshape(shape)
            small = bool(np.nanmax(size, initial=0.0) < 1e-4)
            quantities.append((name, units[0] if small else units[1], (1e6 if small else 1e3) * size))
    if wish.direction is not None:
        words = ", ".join(f"{value:.3g}" for value in wish.direction)
        quantities.append((f"stiffness along ({words})", "N/mm", 1e-3 * found.stiffness.reshape(shape)))
    points = found.points.reshape(*shape, 3)
    positions, _ = body_poses(chain, chain.model_angles(wish.home[None]))
    load = f"load {_load_words(wish.wrench)}" if wish.wrench.any() else "no load"
    kept = "orientation as in the pose drawn"
    if wish.rotation is None:
        kept = "orientation free, arm near the pose drawn"
    return WorkspacePicture(
        across=points[0, 0, :, across],
        up=points[0, :, 0, up],
        axes=("xyz"[across], "xyz"[up], "xyz"[third]),
        levels=levels,
        status=found.status.reshape(shape),
        margin=np.degrees(found.margin).reshape(shape),
        quantities=tuple(quantities),
        stick=positions[0][:, [across, up]],
        title=f"{valued.campaign.name}: {load}; {kept}",
    )


def _load_words(wrench: Floats) -> str:
    force = ", ".join(f"{value:.4g}" for value in wrench[:3] + 0.0)
    moment = ", ".join(f"{value:.4g}" for value in wrench[3:] + 0.0)
    return f"({force}) N" + (f", ({moment}) N·m" if wrench[3:].any() else "")
