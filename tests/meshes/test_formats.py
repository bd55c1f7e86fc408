"""Files of meshes: the formats say the same, and what is damaged is one fault."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.meshes import collada, obj, stl
from stiffcal.meshes.surface import Surface
from tests.laboratory.mesh_robot import binary_stl, dae_text, obj_text, text_stl, tube

TUBE = tube([0.0, 0.0, 0.1], [0.3, 0.0, 0.5], (0.1, 0.05))
Reader = Callable[[bytes, str], Surface]


@pytest.mark.parametrize(
    ("read", "written", "step"),
    [
        (stl.surface_of, binary_stl(TUBE), 2.0**-24),  # of single precision, below one metre
        (stl.surface_of, text_stl(TUBE), 1e-9),
        (stl.surface_of, text_stl(TUBE).replace(b"\n", b"\r\n").replace(b"vertex", b"VERTEX"), 1e-9),
        (obj.surface_of, obj_text(TUBE), 1e-9),
        (collada.surface_of, dae_text(TUBE), 1e-9),
        (collada.surface_of, dae_text(TUBE).replace(b"2005/11", b"2008/03"), 1e-9),
        (collada.surface_of, dae_text(1000.0 * TUBE, unit=0.001), 1e-9),
        (collada.surface_of, dae_text(TUBE, up="Y_UP"), 1e-9),
    ],
    ids=["binary STL", "STL", "STL of Windows, in capitals", "OBJ", "COLLADA", "its version 1.5", "in mm", "with Y up"],
)
def test_every_format_gives_the_triangles_that_were_written(read: Reader, written: bytes, step: float) -> None:
    surface = read(written, "part")
    assert np.abs(surface.points[surface.triangles] - TUBE).max() <= step


def test_a_binary_stl_is_known_by_its_length_whatever_it_begins_with() -> None:
    assert binary_stl(TUBE).startswith(b"solid")
    assert len(stl.surface_of(binary_stl(TUBE), "part").triangles) == len(TUBE)


def test_a_face_of_five_corners_is_three_triangles() -> None:
    corners = "".join(f"v {x} {y} 0\n" for x, y in ((0, 0), (2, 0), (2, 1), (1, 2), (0, 1)))
    surface = obj.surface_of(f"o part\nvn 0 0 1\n{corners}usemtl red\nf 1//1 2//1 3//1 4//1 -1//1\n".encode(), "part")
    assert surface.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4]]


def _with_number(number: float) -> bytes:
    triangles: NDArray[np.float64] = TUBE.copy()
    triangles[3, 1, 2] = number
    return binary_stl(triangles)


@pytest.mark.parametrize(
    ("read", "content", "code"),
    [
        (stl.surface_of, b"", FaultCode.FILE_DAMAGED),
        (stl.surface_of, binary_stl(TUBE)[:-7], FaultCode.FILE_DAMAGED),
        (stl.surface_of, b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 500, FaultCode.FILE_DAMAGED),
        (stl.surface_of, b"\0" * 84, FaultCode.FILE_EMPTY),
        (stl.surface_of, b"solid nothing\nendsolid\n", FaultCode.FILE_EMPTY),
        (stl.surface_of, text_stl(TUBE).rpartition(b"vertex")[0], FaultCode.FILE_DAMAGED),
        (stl.surface_of, b"solid a\n" + b"vertex 1 2 abc\n" * 3, FaultCode.FILE_DAMAGED),
        (stl.surface_of, b"solid a\n" + b"vertex 1 2 nan\n" * 3, FaultCode.NUMBER_INVALID),
        (stl.surface_of, _with_number(np.inf), FaultCode.NUMBER_INVALID),
        (stl.surface_of, _with_number(np.nan), FaultCode.NUMBER_INVALID),
        (stl.surface_of, _with_number(3e38), FaultCode.NUMBER_INVALID),
        (
            stl.surface_of,
            binary_stl(TUBE)[:-6] + b"\x00\x00\xa0\x7f\0\0",
            FaultCode.NUMBER_INVALID,
        ),  # a NaN that signals
        (obj.surface_of, b"", FaultCode.FILE_EMPTY),
        (obj.surface_of, b"v 1 2\n", FaultCode.FILE_DAMAGED),
        (obj.surface_of, b"v 1 2 3\nv 1 2 4\nv 1 3 4\nf 1 2 4\n", FaultCode.FILE_DAMAGED),
        (obj.surface_of, b"v 1 2 3\nv 1 2 4\nv 1 3 4\nf 1 2 -4\n", FaultCode.FILE_DAMAGED),
        (obj.surface_of, b"v 1 2 3\nv 1 2 4\nv 1 3 4\nf 1 2 0\n", FaultCode.FILE_DAMAGED),
        (obj.surface_of, b"v 1 2 3\nf 1 2 99999999999999999999999\n", FaultCode.FILE_DAMAGED),
    ],
)
def test_what_is_damaged_is_one_fault(read: Reader, content: bytes, code: FaultCode) -> None:
    with pytest.raises(InputError) as caught:
        read(content, "part")
    assert [(fault.code, fault.file) for fault in caught.value.faults] == [(code, "part")]
