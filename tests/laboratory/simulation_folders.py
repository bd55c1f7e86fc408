"""Small campaign folders that can be simulated, for the tests of this room."""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.simulation.settings import SimulationSettings, load_settings

IRB4400 = Path(__file__).parents[2] / "campaigns" / "irb4400"

ROBOT = (IRB4400 / "robot.toml").read_text(encoding="utf-8")
MODEL = (IRB4400 / "model.toml").read_text(encoding="utf-8")

FRAMES = """
schema = "stiffcal/campaign/1"
robot = "robot.toml"
[frames.tracker]
parent = "base"
xyz_m = [3.4, -1.1, 0.35]
rpy_deg = [1.2, -0.6, 120.0]
[frames.ft_sensor]
parent = "flange"
xyz_m = [0.0, 0.0, 0.06]
rpy_deg = [0.0, 0.0, 35.0]
[frames.target]
parent = "flange"
xyz_m = [0.06, -0.04, 0.10]
rpy_deg = [5.0, -8.0, 20.0]
[frames.load_point]
parent = "flange"
xyz_m = [0.02, 0.0, 0.18]
[tool]
mass_kg = 14.0
com_m = [0.01, -0.01, 0.10]
"""

# One table of load states; wrench with moments, pose with a quaternion.
TABLE = """
[sources.table]
format = "csv"
sampling = "states"
file = "raw/states.csv"
run = { column = "run" }
time = { column = "t", unit = "s" }
[sources.table.joints]
position = "A1..A6"
units = { position = "deg" }
[sources.table.wrench]
columns = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
frame = "ft_sensor"
acts_on = "environment"
[sources.table.pose]
frame = "tracker"
body = "target"
position = ["X", "Y", "Z"]
quaternion_wxyz = ["q0", "qx", "qy", "qz"]
units = { position = "mm" }
"""

# Three devices, three formats.
LOGS = """
[sources.ft]
csv = { delimiter = ";", decimal = ",", encoding = "latin-1", skip_rows = 2 }
sampling = "time"
time = { column = "t_ms", unit = "ms" }
[sources.ft.wrench]
columns = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
frame = "ft_sensor"
[sources.tracker]
hdf5 = { group = "/at960" }
sampling = "time"
time = { column = "t", unit = "s" }
[sources.tracker.pose]
frame = "tracker"
body = "target"
position = ["X", "Y", "Z"]
rpy = ["R", "P", "Yaw"]
units = { position = "mm", rotation = "deg" }
[sources.controller]
sampling = "time"
time = { column = "t", unit = "s" }
[sources.controller.joints]
position = "A1..A6"
units = { position = "deg" }
"""

RUNS = "".join(
    f"""
[[runs]]
id = "{name}"
files = {{ ft = "raw/{name}_ft.csv", tracker = "raw/{name}_tracker.h5", controller = "raw/{name}_joints.parquet" }}
"""
    for name in ("a", "b")
)

SETTINGS = """
schema = "stiffcal/simulate/1"
seed = 3
[loads]
levels = [0.5, 1.0]
max_force_N = 400.0
"""

POSES = """
[[runs]]
id = "a"
joints_deg = [-45.8, 4.6, 38.8, -0.1, 51.8, -73.0]
[[runs]]
id = "b"
joints_deg = [12.0, -14.0, 24.0, -55.0, 48.0, 20.0]
"""


def write_folder(folder: Path, manifest: str, settings: str, model: str = MODEL) -> tuple[Campaign, SimulationSettings]:
    """Write a folder for `simulate` and load it."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (
        ("campaign.toml", manifest),
        ("robot.toml", ROBOT),
        ("model.toml", model),
        ("simulate.toml", settings),
    ):
        (folder / name).write_text(text, encoding="utf-8")
    return load_campaign(folder, check_files=False), load_settings(folder)
