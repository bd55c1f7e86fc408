"""Fanuc teach pendant program as text (LS): R-30iB Handling Tool, Setup and Operations Manual, ASCII programs.

Positions state F for the user frame and the tool: joint angles hold with all of them.
"""

from __future__ import annotations

from string import Template

from stiffcal.planning.robot_programs.language import SPEED, Language

LANGUAGE = Language(
    maker="Fanuc LS",
    ending=".ls",
    longest_name=8,
    reserved=frozenset({"main", "pns", "rsr", "style"}),
    program=Template("""/PROG  $program
/ATTR
OWNER = MNEDITOR;
COMMENT = "STIFFCAL PLAN";
PROTECT = READ_WRITE;
TCD:  STACK_SIZE = 0,
      TASK_PRIORITY = 50,
      TIME_SLICE = 0,
      BUSY_LAMP_OFF = 0,
      ABORT_REQUEST = 0,
      PAUSE_REQUEST = 0;
DEFAULT_GROUP = 1,*,*,*,*;
CONTROL_CODE = 00000000 00000000;
/MN
$body
/POS
$positions
/END
"""),
    comment=Template("  !$text ;"),
    comment_width=30,
    stop=Template("  !$text ;\n  PAUSE ;"),
    move=Template(f"J P[$number] {SPEED}% FINE ;"),
    position=Template("""P[$number]{
   GP1:
    UF : F, UT : F,
    J1= $j1 deg, J2= $j2 deg, J3= $j3 deg,
    J4= $j4 deg, J5= $j5 deg, J6= $j6 deg
};"""),
    radians=False,
    numbered=True,
)
