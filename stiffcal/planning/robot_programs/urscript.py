"""Universal Robots script: The URScript Programming Language for e-Series, sections on motion and popup."""

from __future__ import annotations

from string import Template

from stiffcal.planning.robot_programs.language import Language

# 0.2 rad/s is a tenth of the slowest joints' 120 degrees/s.
LANGUAGE = Language(
    maker="Universal Robots script",
    ending=".script",
    longest_name=32,
    reserved=frozenset({"main", "program"}),
    program=Template("""def $program():
$comments
$body
end
"""),
    comment=Template("  # $text"),
    comment_width=100,
    stop=Template('  popup("$text", title="stiffcal", warning=True, error=False, blocking=True)'),
    move=Template("  movej([$j1, $j2, $j3, $j4, $j5, $j6], a=0.2, v=0.2)"),
    position=None,
    radians=True,
    numbered=False,
)
