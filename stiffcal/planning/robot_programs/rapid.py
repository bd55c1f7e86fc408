"""ABB RAPID: Technical reference manual, RAPID Instructions, Functions and Data types, 3HAC050917."""

from __future__ import annotations

from string import Template

from stiffcal.planning.robot_programs.language import Language

# 50 mm/s of the tool and 10 degrees/s of its orientation: what limits joint moves as well.
LANGUAGE = Language(
    maker="ABB RAPID",
    ending=".mod",
    longest_name=32,
    reserved=frozenset({"main", "user", "base", "measure_poses"}),
    program=Template("""MODULE $program
$comments
  ! tool0 has no load data: put the name of the mounted tool in its place.
  CONST speeddata slow := [50, 10, 50, 10];
  PROC measure_poses()
$body
  ENDPROC
ENDMODULE
"""),
    comment=Template("  ! $text"),
    comment_width=100,
    stop=Template('    TPWrite "$text";\n    Stop;'),
    move=Template("    MoveAbsJ [[$j1,$j2,$j3,$j4,$j5,$j6],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs, slow, fine, tool0;"),
    position=None,
    radians=False,
    numbered=False,
)
