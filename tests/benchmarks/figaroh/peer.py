"""Run by the Python of FIGAROH's environment: fit and predict with FIGAROH what `tests.benchmarks.figaroh_places` asks.

    python peer.py WORK

WORK holds job.json: for each job the names of a table to fit and of one to predict, both in FIGAROH's layout, the
URDF, the frames' names and the measured components. answer.json gets seconds of the fit, predicted components and the
parameters. Nothing of stiffcal is imported.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np


def settings(job: dict[str, Any], table: Path) -> dict[str, Any]:
    """Return FIGAROH's configuration of one job."""
    return {
        "robot": {"name": "arm", "properties": {"joints": {"active_joints": job["joints"]}}},
        "tasks": {
            "calibration": {
                "enabled": True,
                "parameters": {
                    "calibration_level": "full_params",
                    "include_non_geometric": job["springs"],
                    "regularization_coefficient": 0.0,
                    "outlier_threshold": 1.0,
                },
                "kinematics": {"base_frame": "universe", "tool_frame": job["tool"]},
                "measurements": {
                    "markers": [
                        {
                            "name": "marker",
                            "reference_joint": job["joints"][-1],
                            "measurable_dof": job["measured"],
                            "sensor_type": "tracker",
                        }
                    ],
                    "poses": {"base_pose": [0.0] * 6, "tool_pose": [0.0] * 6},
                },
                "data": {"source_file": str(table), "number_of_samples": job["n"]},
            }
        },
    }


def calibration(work: Path, job: dict[str, Any], table: str) -> Any:
    """Return FIGAROH's calibration of a table, its parameters chosen."""
    from figaroh.calibration.base_calibration import BaseCalibration  # only this environment has it
    from figaroh.tools.robot import load_robot

    config = work / "figaroh.yaml"
    config.write_text(json.dumps(settings(job, work / table)), encoding="utf-8")
    robot = load_robot(str(work / job["urdf"]), load_by_urdf=True)
    made = BaseCalibration(robot, str(config))
    made.calib_config["known_baseframe"] = False
    made.calib_config["known_tipframe"] = False
    made.initialize()
    return made


def answer(work: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Fit one table and predict another."""
    from figaroh.calibration.calibration_tools import calc_updated_fkm

    start = time.process_time()
    fitted = calibration(work, job, job["fit"])
    prepared = time.process_time()
    result = fitted.solve(enable_logging=False)
    solved = time.process_time()
    heldout = calibration(work, {**job}, job["predict"])
    places = calc_updated_fkm(
        heldout.model,
        heldout.data,
        result.x,
        heldout.q_measured,
        fitted.calib_config | {"NbSample": len(heldout.q_measured)},
    )
    return {
        "prepare_s": prepared - start,
        "fit_s": solved - prepared,
        "predicted": np.asarray(places).tolist(),
        "measured": np.asarray(heldout.PEE_measured).tolist(),
        "parameters": list(fitted.calib_config["param_name"]),
        "values": np.asarray(result.x).tolist(),
    }


def main() -> None:
    """Do every job of the folder."""
    work = Path(sys.argv[1])
    jobs = json.loads((work / "job.json").read_text(encoding="utf-8"))
    answers = []
    for job in jobs:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            answers.append(answer(work, job))
    (work / "answer.json").write_text(json.dumps(answers), encoding="utf-8")


if __name__ == "__main__":
    main()
