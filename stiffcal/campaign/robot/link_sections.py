"""Drawn sections of links, solved where somebody needs them: rods on the link."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from stiffcal.campaign.robot.robot_file import BeamSectionEntry, LinkBeamEntry, RobotFile
from stiffcal.campaign.toml.naming import body_number
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.section import BeamSection
from stiffcal.mechanics.section_mesh import SectionError, inner_outline
from stiffcal.mechanics.section_solver import MissingSolverError, solve_section

# E/G of steel, aluminium and cast iron with ν = 0.3, where the robot file names no moduli: what counts for fibres and
# warping is their ratio alone, and its root in the decay.
USUAL_RATIO = 2.6


def with_sections(chain: Chain, robot: RobotFile, links: Iterable[str], robot_file: str = "robot.toml") -> Chain:
    """Return the chain with the drawn sections of some links solved.

    Parameters
    ----------
    chain : the robot.
    robot : the robot file, with ``[links.NAME] section``.
    links : names of links, as in the manifest.
    robot_file : for messages.

    Raises
    ------
    InputError : a drawing that is no section, or the extra that solves it is not installed.
    """
    beams = dict(chain.beams)
    for wanted in dict.fromkeys(links):
        number = body_number(wanted, chain.link_names)
        name = next((n for n, beam in beams.items() if n == wanted or beam.joint == number), None)
        if name is None:
            continue
        # The file may call the link by its own name or by swing and arm.
        joint = beams[name].joint
        entries = [(key, entry) for key, entry in robot.links.items() if key in (name, chain.link_names[joint - 1])]
        for key, entry in entries:
            solved = _solve_section(key, entry, robot_file)
            if solved is not None:
                beams[name] = replace(beams[name], section=solved)
    return replace(chain, beams=beams)


def _solve_section(link: str, entry: LinkBeamEntry, robot_file: str) -> BeamSection | None:
    section = entry.section
    if section is None or section.outline is None:
        return None
    place = f"links.{link}.section"
    try:
        return _solve(section)
    except SectionError as error:
        raise InputError.at(
            FaultCode.VALUE_INVALID, robot_file, place, str(error), "draw the corners in order around the section, in m"
        ) from None
    except MissingSolverError as error:
        raise InputError.at(
            FaultCode.LIBRARY_MISSING, robot_file, f"{place}.outline", error.needs, error.install
        ) from None


@lru_cache(maxsize=16)
def _solve(section: BeamSectionEntry) -> BeamSection:
    outline = np.array(section.outline)
    holes = [np.array(hole) for hole in section.holes]
    if section.wall_m is not None:
        holes.append(inner_outline(outline, section.wall_m))
    young, shear = moduli(section)
    return solve_section(outline, holes, young, shear)


def moduli(section: BeamSectionEntry) -> tuple[float, float]:
    """Return E and G, Pa; their usual ratio where the file does not state both, and G = 1 where it states none."""
    if section.E_Pa is not None:
        return section.E_Pa, section.G_Pa if section.G_Pa is not None else section.E_Pa / USUAL_RATIO
    shear = section.G_Pa if section.G_Pa is not None else 1.0
    return USUAL_RATIO * shear, shear
