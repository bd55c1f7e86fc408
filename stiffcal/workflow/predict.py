"""Predict deflection and stiffness of a fitted robot under given loads."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.errors import InputError
from stiffcal.files import is_given
from stiffcal.workflow.compensation_path import numbers_of_words, pose_of_words
from stiffcal.workflow.load_table import AXES, LoadTable, read_load_table
from stiffcal.workflow.steps import (
    LOAD_PATHS,
    Document,
    Means,
    open_store,
)
from stiffcal.workflow.valued import ValuedCampaign, valued_campaign

if TYPE_CHECKING:
    from stiffcal.compensation.link_parts import LinkPart
    from stiffcal.compensation.prediction import Prediction
    from stiffcal.store.reading import Documents, Stored

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LoadPathWish:
    """A path of loads at one pose.

    Attributes
    ----------
    corners : "Fx,Fy,Fz;Fx,Fy,Fz;…" in N, base axes, or the name of a CSV file with columns Fx … Tz.
    pose : joint angles in degrees, "A1,A2,…", in the order of the robot file; None: the file's joint columns.
    points : steps on each leg.
    note : words for the report: what is shown, and how the pose was found.
    """

    corners: str
    pose: str | None = None
    points: int = 20
    note: str = ""


def predict_campaign(
    folder: Path,
    means: Means | None = None,
    poses: Path | None = None,
    load_path: LoadPathWish | None = None,
    output: Path | None = None,
) -> Document:
    """Predict deflection and Cartesian stiffness at the first measured frame.

    Parameters
    ----------
    folder : a campaign folder: one with a fit, or with logs to fit, or with a model file that values every parameter.
    means : store, progress and so on.
    poses : CSV with a column per joint (degrees) and Fx … Tz (N, N·m): base axes, on the robot, at the manifest's load
        point; one state a row.
    load_path : instead of ``poses``.
    output : CSV or Parquet to write the result to.

    Returns
    -------
    dict
        The `predict` document (interface, section 4).

    Raises
    ------
    InputError : the input is wrong, or a load is more than the robot holds.
    """
    from stiffcal.compensation.link_parts import link_parts
    from stiffcal.compensation.prediction import at_load_point, one_run, predict_states
    from stiffcal.model.equilibrium import NoBalanceError

    means = means or Means()
    if (poses is None) == (load_path is None):
        raise InputError.at(
            "command line", "--poses", "say what to predict", "give either --poses FILE or --load-path F;F"
        )
    campaign = load_campaign(Path(folder), check_files=False)
    loads, corners = _wanted(campaign, poses, load_path)
    valued = valued_campaign(campaign, means)
    means.progress("predicting", None)
    try:
        found = predict_states(
            valued.robot, loads.joints, loads.wrench, valued.setup, valued.covariance, in_order=load_path is not None
        )
    except NoBalanceError as error:
        if load_path is None:
            raise error.of_load(str(poses), "", "give smaller loads") from error
        raise error.of_load("command line", f"--load-path {load_path.corners}", "give smaller loads") from error
    order = one_run(valued.robot, len(loads.joints)) if load_path is not None else None
    angles, setup = valued.robot.chain.model_angles(loads.joints), at_load_point(valued.setup)
    parts = link_parts(valued.robot, angles, loads.wrench, setup, order, valued.link_compliances)
    document = _document(loads, found, valued, parts)
    if load_path is not None:
        document["load_path"] = _load_path_document(campaign, load_path, loads, found, corners)
        _keep(campaign, means, document["load_path"])
    if output is not None:
        from stiffcal.workflow.export import write_table

        write_table(_table(campaign, loads, found, parts), output)
        document["file"] = str(output)
    return document


def _wanted(campaign: Campaign, poses: Path | None, wish: LoadPathWish | None) -> tuple[LoadTable, tuple[int, ...]]:
    """Return the states asked for, and where on a path its corners are."""
    from stiffcal.compensation.prediction import load_path

    names = campaign.chain.joint_names
    if poses is not None:
        return read_load_table(Path(poses), names, joints_needed=True), ()
    assert wish is not None
    if is_given(Path(wish.corners)):
        table = read_load_table(Path(wish.corners), names, joints_needed=wish.pose is None)
        corner_loads, pose = table.wrench, table.joints[0]
        if wish.pose is None and np.ptp(table.joints, axis=0).max() > 0.0:
            raise InputError.at(
                wish.corners, "", "the joints move along the path", "a load path has one pose; see --poses"
            )
    else:
        corner_loads, pose = _corners(wish.corners), np.zeros(len(names))
    if wish.pose is not None:
        pose = pose_of_words(wish.pose, names, "--at")
    elif not is_given(Path(wish.corners)):
        raise InputError.at("command line", "--at", "no pose given", f"give {len(names)} joint angles in degrees")
    if wish.points < 1 or len(corner_loads) < 2:
        mend = "give two loads or more, and at least one point on each leg"
        raise InputError.at("command line", "--load-path", "this is no path", mend)
    wrench, corners = load_path(corner_loads, wish.points)
    return LoadTable(np.repeat(pose[None], len(wrench), axis=0), wrench), corners


def _corners(text: str) -> Floats:
    rows = [numbers_of_words(part, "--load-path") for part in text.split(";") if part.strip()]
    if not rows or any(len(row) != len(rows[0]) for row in rows) or len(rows[0]) not in (3, 6):
        mend = 'write forces like "-100,200,-300;0,0,0;100,-200,100", or name a CSV file'
        raise InputError.at("command line", "--load-path", f"{text!r} is no list of loads", mend)
    return np.array(rows)


def _document(loads: LoadTable, found: Prediction, valued: ValuedCampaign, parts: tuple[LinkPart, ...]) -> Document:
    states = []
    for place in range(len(loads.joints)):
        stiffness, linear = found.cartesian_stiffness[place], found.linear_stiffness[place]
        states.append(
            {
                "joints": loads.joints[place].tolist(),
                "wrench": loads.wrench[place].tolist(),
                "deflection": found.deflection[place].tolist(),
                "covariance": found.covariance[place].tolist(),
                "cartesian_compliance": found.cartesian_compliance[place].tolist(),
                "cartesian_stiffness": None if stiffness is None else stiffness.tolist(),
                "linear_compliance": found.linear_compliance[place].tolist(),
                "linear_stiffness": None if linear is None else linear.tolist(),
                "links": [_link_document(one, place) for one in parts],
            }
        )
    twists = []
    for part in parts:
        if part.link in valued.link_compliances and not np.isfinite(valued.link_compliances[part.link][3, 3]):
            has = "without it" if part.end is None else "with the fit's"
            twists.append(f"the rods on {part.link} do not tell its twist: its part by the rods' 6×6 is {has}")
    return {
        "schema": "stiffcal/predict/1",
        "warnings": [*valued.warnings, *twists],
        "values_from": valued.source,
        "target": valued.setup.target_names[0],
        "states": states,
    }


def _link_document(part: LinkPart, place: int) -> Document:
    def of(values: Floats | None) -> list[float] | None:
        return None if values is None else [float(value) for value in values[place]]

    return {
        "link": part.link,
        "carried": of(part.carried),
        "end": of(part.end),
        "at_target": of(part.at_target),
        "end_by_compliance": of(part.end_by_compliance),
        "at_target_by_compliance": of(part.at_target_by_compliance),
    }


def _load_path_document(
    campaign: Campaign, wish: LoadPathWish, loads: LoadTable, found: Prediction, corners: tuple[int, ...]
) -> Document:
    angles = ", ".join(f"{angle:.4g}°" for angle in np.degrees(loads.joints[0]))
    names = campaign.chain.joint_names
    pose = f"{names[0]} … {names[-1]} = {angles}" + (f"; {wish.note}" if wish.note else "")
    return {
        "name": campaign.name,
        "pose": pose,
        "force": loads.wrench[:, :3].tolist(),
        "deflection": found.deflection[:, :3].tolist(),
        "corners": list(corners),
    }


def _keep(campaign: Campaign, means: Means, path: Document) -> None:
    """Keep the path in the store, where the report finds it; one of each name and pose."""

    def with_path(stored: Stored) -> Documents:
        kept = stored(LOAD_PATHS) or {"schema": "stiffcal/load-paths/1", "paths": []}
        named = (path["name"], path["pose"])
        others = [entry for entry in kept["paths"] if (entry.get("name"), entry.get("pose")) != named]
        return {LOAD_PATHS: kept | {"paths": [*others, path]}}

    open_store(campaign.folder, means).commit(documents=with_path, command="predict")


def _table(campaign: Campaign, loads: LoadTable, found: Prediction, parts: tuple[LinkPart, ...]) -> dict[str, Floats]:
    """Return the prediction as columns: degrees, N, N·m, mm, mrad, each with its unit."""
    columns = {f"{name} [deg]": np.degrees(loads.joints[:, k]) for k, name in enumerate(campaign.chain.joint_names)}
    columns |= {f"{axis} [{'N' if k < 3 else 'N*m'}]": loads.wrench[:, k] for k, axis in enumerate(AXES)}
    std = np.sqrt(np.einsum("nii->ni", found.covariance))
    for k, name in enumerate(("dx", "dy", "dz", "rx", "ry", "rz")):
        unit = "mm" if k < 3 else "mrad"
        columns[f"{name} [{unit}]"] = 1e3 * found.deflection[:, k]
        columns[f"{name} standard uncertainty [{unit}]"] = 1e3 * std[:, k]
    for part in parts:
        for values, by in ((part.at_target, ""), (part.at_target_by_compliance, " by its 6x6")):
            if values is not None:
                columns |= {f"d{axis} of {part.link}{by} [mm]": 1e3 * values[:, k] for k, axis in enumerate("xyz")}
    return columns
