"""COLLADA: faces of every kind, nodes in nodes, and what contradicts the format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.meshes import collada
from tests.laboratory.mesh_robot import dae_text, tube

TUBE = tube([0.0, 0.0, 0.1], [0.3, 0.0, 0.5], (0.1, 0.05), 6)[:30]
PLAIN = dae_text(TUBE).decode()
CORNERS = "0 0 0  2 0 0  2 1 0  1 2 0  0 1 0  0 0 1"
GROUPS = {
    "polylist": ("<vcount>5 2 3</vcount><p>{}</p>", [[0, 1, 2, 3, 4, 1, 2, 0, 4, 5]]),
    "polygons": ("<p>{}</p><p>{}</p>", [[0, 1, 2, 3, 4], [0, 4, 5]]),
    "trifans": ("<p>{}</p><p>{}</p>", [[0, 1, 2, 3, 4], [0, 4, 5]]),
    "tristrips": ("<p>{}</p><p>{}</p>", [[0, 1, 2, 4, 3], [0, 4, 5]]),
    "lines": ("<p>{}</p>", [[0, 1, 2, 3]]),
}
COUNTS = {"polylist": 3}
SCENE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_geometries>{geometries}</library_geometries>
{library}
<library_visual_scenes><visual_scene id="other"><node><instance_geometry url="#nowhere"/></node></visual_scene>
<visual_scene id="shown"><node><matrix>0 -1 0 10  1 0 0 -20  0 0 1 30  0 0 0 1</matrix>
<node><translate>5 6 7</translate><rotate>0 0 1 30</rotate><rotate>0.6 0.8 0 -50</rotate><scale>2 2 2</scale>
{both}</node><instance_geometry url="#lines"/><instance_geometry url="#trifans"/></node>
<node><rotate>-1 0 0 90</rotate><instance_geometry url="#tristrips"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#shown"/></scene></COLLADA>"""


BOTH = """<node id="both"><translate>30 0 -20</translate><instance_geometry url="#polygons"/>
<node><scale>1 -2 0.5</scale><instance_geometry url="#polylist"/></node></node>"""


def scene(both: str, library: str = "") -> str:
    """Return a file of all kinds of faces, two of them in a node or an instance of one, `both`."""
    return SCENE.format(geometries="".join(map(geometry, GROUPS)), library=library, both=both)


def source(name: str, numbers: str) -> str:
    """Return points of three numbers."""
    count = len(numbers.split())
    array = f'<float_array id="f-{name}" count="{count}">{numbers}</float_array>'
    params = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    accessor = f'<accessor source="#f-{name}" count="{count // 3}" stride="3">{params}</accessor>'
    return f'<source id="{name}">{array}<technique_common>{accessor}</technique_common></source>'


def geometry(name: str) -> str:
    """Return the same surface in a kind of faces; each corner has a number of a normal before that of its point."""
    text, runs = GROUPS[name]
    written = text.format(*(" ".join(f"0 {corner}" for corner in run) for run in runs))
    inputs = f'<input semantic="NORMAL" source="#n-{name}" offset="0"/>'
    inputs += f'<input semantic="VERTEX" source="#v-{name}" offset="1"/>'
    vertices = f'<vertices id="v-{name}"><input semantic="POSITION" source="#s-{name}"/></vertices>'
    faces = f'<{name} count="{COUNTS.get(name, 2)}">{inputs}{written}</{name}>'
    sources = source(f"n-{name}", "0 0 1") + source(f"s-{name}", CORNERS)
    return f'<geometry id="{name}"><mesh>{sources}{vertices}{faces}</mesh></geometry>'


def area(triangles: np.ndarray) -> float:
    a, b, c = np.moveaxis(triangles, 1, 0)
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


@pytest.mark.parametrize("name", ["polylist", "polygons", "trifans", "tristrips"])
def test_faces_are_where_assimp_puts_them(name: str, tmp_path: Path) -> None:
    coal = pytest.importorskip("coal")
    text = scene(BOTH).replace(
        "<vcount>5 2 3</vcount><p>0 0 0 1 0 2 0 3 0 4 0 1 0 2", "<vcount>5 3</vcount><p>0 0 0 1 0 2 0 3 0 4"
    )
    text = text.replace('<polylist count="3">', '<polylist count="2">')
    for other in GROUPS.keys() - {name}:  # of several in nodes in nodes this judge takes one twice, and of lines too
        text = text.replace(f'<instance_geometry url="#{other}"/>', "")
    (tmp_path / "part.dae").write_text(text, encoding="utf-8")
    judge = coal.MeshLoader().load(str(tmp_path / "part.dae"), np.full(3, 0.01))  # it does not look at the unit
    expected = np.array(judge.vertices())[[[judge.tri_indices(k)[i] for i in range(3)] for k in range(judge.num_tris)]]
    surface = collada.surface_of(text.encode(), "part")
    found = surface.points[surface.triangles]
    assert len(found) == len(expected) == 4
    gaps = np.linalg.norm(found.reshape(-1, 1, 3) - expected.reshape(1, -1, 3), axis=2)  # faces are cut in other ways
    assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < 1e-6
    assert area(found) == pytest.approx(area(expected), rel=1e-5)


def test_a_node_of_the_library_is_as_one_in_its_place() -> None:
    there = collada.surface_of(scene(BOTH).encode(), "part")
    library = f"<library_nodes>{BOTH}</library_nodes>"
    named = collada.surface_of(scene('<instance_node url="#both"/>', library).encode(), "part")
    ends = [np.sort(one.points.round(9), axis=0) for one in (there, named)]
    assert np.abs(ends[0] - ends[1]).max() < 1e-9
    assert len(named.triangles) == len(there.triangles) == 4 * 4


def test_all_scenes_are_taken_where_the_file_does_not_say_which() -> None:
    text = PLAIN.replace('<scene><instance_visual_scene url="#scene"/></scene>', "")
    assert len(collada.surface_of(text.encode(), "part").triangles) == len(TUBE)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("</COLLADA>", "", FaultCode.SYNTAX_INVALID),
        ("<COLLADA", "<!DOCTYPE COLLADA [<!ENTITY a 'aaaa'>]><COLLADA", FaultCode.SYNTAX_INVALID),
        ("COLLADA", "robot", FaultCode.FILE_DAMAGED),
        ("<node", "<nod" + "e><node" * 120, FaultCode.SIZE_EXCEEDED),
        ("<triangles", "<lines", FaultCode.SYNTAX_INVALID),
        ("<p>0 0 1 0", "<p>0 0 9999 0", FaultCode.FILE_DAMAGED),
        ("<p>0 0 1 0", "<p>0 0 -1 0", FaultCode.FILE_DAMAGED),
        ("<p>0 0 1 0", "<p>0 0 1.5e300 0", FaultCode.FILE_DAMAGED),
        ("<p>0 0 1 0", "<p>0 0 nan 0", FaultCode.FILE_DAMAGED),
        ("<p>0 0 1 0", "<p>0 0 one 0", FaultCode.FILE_DAMAGED),
        ('semantic="VERTEX"', 'semantic="NORMAL"', FaultCode.FILE_DAMAGED),
        ('offset="0"', 'offset="-1"', FaultCode.FILE_DAMAGED),
        ('offset="1"', 'offset="9e18"', FaultCode.FILE_DAMAGED),
        ('stride="3"', 'stride="0"', FaultCode.FILE_DAMAGED),
        ('stride="3"', 'stride="3" offset="-4"', FaultCode.FILE_DAMAGED),
        ('source="#at"', 'source="#gone"', FaultCode.FILE_DAMAGED),
        ('url="#part"', 'url="other.dae#part"', FaultCode.CONTENT_UNSUPPORTED),
        ("instance_geometry", "instance_controller", FaultCode.CONTENT_UNSUPPORTED),
        ('<node id="whole">', '<node id="whole"><lookat>1 2 3 4 5 6 7 8 9</lookat>', FaultCode.CONTENT_UNSUPPORTED),
        ('<node id="whole">', '<node id="whole"><matrix>1 0 0 1</matrix>', FaultCode.FILE_DAMAGED),
        ('<node id="whole">', '<node id="whole"><scale>1 nan 1</scale>', FaultCode.NUMBER_INVALID),
        ('<node id="whole">', '<node id="whole">' + "<scale>1e200 inf 1</scale>" * 3, FaultCode.NUMBER_INVALID),
        ('meter="1.0"', 'meter="x"', FaultCode.FILE_DAMAGED),
        ('<instance_geometry url="#part"/>', "", FaultCode.FILE_EMPTY),
        ('<instance_geometry url="#part"/>', '<instance_node url="#whole"/>', FaultCode.SIZE_EXCEEDED),
        ('<instance_geometry url="#part"/>', '<instance_node url="#whole"/>' * 3, FaultCode.SIZE_EXCEEDED),
    ],
)
def test_what_is_damaged_is_one_fault(old: str, new: str, code: FaultCode) -> None:
    assert old in PLAIN
    with pytest.raises(InputError) as caught:
        collada.surface_of(PLAIN.replace(old, new).encode(), "part")
    assert [(fault.code, fault.file) for fault in caught.value.faults] == [(code, "part")]


def test_nodes_that_name_each_other_twice_end_soon() -> None:
    named = '<instance_node url="#n{}"/>'
    nodes = "".join(f'<node id="n{k}">{2 * named.format(k + 1)}</node>' for k in range(60)) + '<node id="n60"/>'
    text = PLAIN.replace("<library_visual_scenes>", f"<library_nodes>{nodes}</library_nodes><library_visual_scenes>")
    with pytest.raises(InputError) as caught:
        collada.surface_of(text.replace('<instance_geometry url="#part"/>', named.format(0)).encode(), "part")
    assert [fault.code for fault in caught.value.faults] == [FaultCode.SIZE_EXCEEDED]
