"""KUKA Robot Language: KUKA System Software 8.x, Operating and Programming Instructions for System Integrators."""

from __future__ import annotations

from string import Template

from stiffcal.planning.robot_programs.language import SPEED, Language

LANGUAGE = Language(
    maker="KUKA KRL",
    ending=".src",
    longest_name=24,
    reserved=frozenset({"main", "cell", "sps", "bas", "ir_stopm"}),
    program=Template(f"""&ACCESS RVP
DEF $program()
$comments
BAS(#INITMOV, 0)
BAS(#VEL_PTP, {SPEED})
BAS(#ACC_PTP, {SPEED})
$body
END
"""),
    comment=Template("; $text"),
    comment_width=100,
    stop=Template("; $text\nWAIT SEC 0\nHALT"),
    move=Template("PTP {AXIS: A1 $j1, A2 $j2, A3 $j3, A4 $j4, A5 $j5, A6 $j6}"),
    position=None,
    radians=False,
    numbered=False,
)
