"""The stress classes by name; what is good for each is decided by the table of `tests.calibration.answers`.

========== ===========================================================================================================
robot-…    nothing or one effect on a robot of another kind: as in the mix
law-…      a law outside the catalogue: as *outside* in the mix
broken-…   nothing or one effect, an assumption broken: as in the mix, quiet where nothing is hidden. Where the readings
           can show the break (gravity, tool, payload), unexplained is as right as quiet. Cross-talk is an error of its
           own, of the size at which it shows: as *outside*
mistake-…  the faulty runs are named and no others, or where the fault is below what can be found no firm name. Of a
           saturated sensor any of the runs beyond its range may be named, the one that lost most must be
========== ===========================================================================================================
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError
from stiffcal.model.effect import TX, TZ, Effect, Values, tool_node
from stiffcal.model.laws.drives import drive_torque
from tests.calibration.field_mix import FieldCampaign, draw_size
from tests.calibration.stress import assumptions as broken
from tests.calibration.stress import laws, mistakes
from tests.calibration.stress.drawing import Hidden, Recipe, draw, nothing
from tests.calibration.stress.robots import BY_MUJOCO, GANTRY, RAIL, SCARA, STRESS_ROBOTS
from tests.laboratory.random_robots import draw_robot
from tests.rates.playing import Ruler

Class = Callable[[np.random.Generator, int], FieldCampaign]


def _shape(rng: np.random.Generator, one: PlacedEffect, ruler: Ruler) -> Values:
    """Return the parameters of a law's shape, within what happens in the campaign."""
    chain, loads, state = ruler.truth.chain, ruler.state.loads, ruler.state
    torque = np.abs(drive_torque(chain, loads.wrench, one.place.joints[0])) if one.place.joints else np.zeros(1)
    if one.effect.name == "cable-bent":
        angles = state.data.angles[one.place.joints[0] - 1]
        return {"angle": float(np.quantile(angles, rng.uniform(0.3, 0.7)))}
    if one.effect.name == "magnet-slip":
        force = np.linalg.norm(loads.wrench[tool_node(chain), TX : TZ + 1], axis=0)
        return {"force": float(np.quantile(force, rng.uniform(0.4, 0.8))), "turn": float(rng.uniform(0.0, 2.0 * np.pi))}
    if one.effect.name == "warming-spring":
        return {"warm": float(rng.uniform(0.2, 2.0) * 120.0 * state.data.run.max())}
    if one.effect.name == "link-twisted-by-heat":
        return {"warm": float(rng.uniform(20.0, 400.0))}
    if one.effect.name == "servo-residue":
        return {"kept": float(rng.uniform(0.2, 0.8))}
    if one.effect.name == "stribeck-under-load":
        most = float(torque.max())
        return {"slip": float(rng.uniform(0.1, 0.4)) * most, "falls": float(rng.uniform(0.2, 0.8)) * most}
    return {}


def hide_law(law: Effect, rng: np.random.Generator, ruler: Ruler) -> Hidden:
    """Hide a law outside the catalogue at one of its places."""
    places = law.places(ruler.truth.chain)
    if not places:
        raise NoBalanceError(f"{law.name} has no place on this robot")
    place = places[int(rng.integers(len(places)))]
    one = PlacedEffect(law, place, {"c": 1.0})
    one = PlacedEffect(law, place, {"c": 1.0, **_shape(rng, one, ruler)})
    size = draw_size(rng)
    return Hidden("outside", (ruler.sized(one, size),), (size,))


LAWS: tuple[Effect, ...] = (
    laws.HertzContact(), laws.WarmingSpring(), laws.CableBent(), laws.MagnetSlip(), laws.LinkTwistedByHeat(),
    laws.ServoResidue(), laws.StribeckUnderLoad(), laws.QuillGuide(),
)  # fmt: skip
MISTAKES = (
    mistakes.zeroed_anew, mistakes.saturated, mistakes.row_shifted, mistakes.knocked_and_back,
    mistakes.exchanged_in_part,
)  # fmt: skip
TO_SCALE = (mistakes.zeroed_anew, mistakes.knocked_and_back)

RECIPES: Mapping[str, Recipe] = {
    **{
        f"robot-{name}": Recipe(robot=partial(draw_robot, families=(family,)), mujoco=family in BY_MUJOCO)
        for name, family in STRESS_ROBOTS.items()
    },
    **{f"law-{law.name}": Recipe(hide=partial(hide_law, law)) for law in LAWS[:-1]},
    "law-quill-guide": Recipe(
        robot=partial(draw_robot, families=(SCARA, RAIL, GANTRY)), hide=partial(hide_law, LAWS[-1]), mujoco=False
    ),
    "broken-heavy-tails": Recipe(scatter=broken.heavy_tails),
    "broken-common-noise": Recipe(scatter=broken.common_noise),
    "broken-cross-talk": Recipe(hide=nothing, misread=broken.cross_talk),
    "broken-gravity": Recipe(
        robot=partial(draw_robot, families=BY_MUJOCO), hide=broken.hide_no_torque_law,
        model=broken.gravity_downwards, visible=True,
    ),
    "broken-tool-mass": Recipe(
        hide=broken.hide_no_torque_law, moved=broken.tool_not_stated, model=broken.unchanged, visible=True
    ),
    "broken-payload": Recipe(
        hide=broken.hide_no_torque_law, moved=broken.payload_changed, model=broken.unchanged, visible=True
    ),
    "broken-angles": Recipe(read=broken.quantised_angles),
    "broken-one-direction": Recipe(plan=broken.one_direction),
    "broken-few-poses": Recipe(plan=broken.few_poses),
    "broken-clustered": Recipe(robot=broken.clustered),
    "broken-rotation-noise": Recipe(read=broken.rotation_stated_wrong, noise_known="stated wrong", full_pose=1.0),
    **{
        f"mistake-{one.__name__.replace('_', '-')}": Recipe(hide=nothing, mistake=one, scaled=one in TO_SCALE)
        for one in MISTAKES
    },
}  # fmt: skip
CLASSES: Mapping[str, Class] = {name: partial(draw, recipe) for name, recipe in RECIPES.items()}
"""Class by name: a function of a generator and the campaign's number."""


def draw_stress(name: str, seed: int, number: int) -> FieldCampaign:
    """Return a campaign of a class; it follows from the class, the seed and its number alone.

    Raises
    ------
    RuntimeError : no drawn robot found its balance.
    """
    return CLASSES[name](np.random.default_rng([seed, number, *name.encode()]), number)
