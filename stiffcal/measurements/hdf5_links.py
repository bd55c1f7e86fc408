"""What lies in an HDF5 file itself, found without opening any other file.

A link can lead to any file of the machine, and opening that can be reading a secret or waiting on a pipe for ever. The
library follows such links as soon as it looks up a name; so each link is looked at first.
"""

from __future__ import annotations

from typing import Any

import h5py

MOST_LINKS = 40  # on one way: more lead in a circle
MOST_LISTED = 20_000
HERE = "."


class LeadsOutsideError(OSError):
    """A name leads to another file."""


def item_inside(group: h5py.Group, path: str) -> Any:
    """Return the object of a path, as ``group[path]`` does, without leaving the file.

    Raises
    ------
    KeyError
        There is no such object, or the links to it lead in a circle.
    LeadsOutsideError
        It lies in another file, or takes its values from one.
    """
    item: Any = group
    names = _parts(path)
    if path.startswith("/"):
        item = group.file["/"]
    links = 0
    while names:
        name = names.pop(0)
        if not isinstance(item, h5py.Group) or not item.id.links.exists(name):
            raise KeyError(path)
        kind = item.id.links.get_info(name).type
        if kind == h5py.h5l.TYPE_HARD:
            item = item[name.decode("utf-8", "surrogateescape")]
            continue
        if kind != h5py.h5l.TYPE_SOFT:
            raise LeadsOutsideError(path)
        links += 1
        if links > MOST_LINKS:
            raise KeyError(path)
        goal = item.id.links.get_val(name)
        names = [*_parts(goal), *names]
        if goal.startswith(b"/"):
            item = group.file["/"]
    check_item(item, path)
    return item


def check_item(item: Any, name: str) -> None:
    """Raise `LeadsOutsideError` where a dataset takes its values from other files; no such file is opened."""
    if isinstance(item, h5py.Dataset) and _other_files(item):
        raise LeadsOutsideError(name)


def members_inside(group: h5py.Group) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the objects of a group by name, and the names that lead to other files; what leads nowhere is left out."""
    members: dict[str, Any] = {}
    elsewhere = []
    for name in group:
        try:
            members[name] = item_inside(group, name)
        except LeadsOutsideError:
            elsewhere.append(name)
        except KeyError:
            continue
    return members, tuple(elsewhere)


def groups_inside(file: h5py.File) -> list[str]:
    """Return the paths of a file's groups, each once; at most `MOST_LISTED` objects are looked at."""
    groups: list[str] = []
    n_visited = 0

    def note(name: str, item: Any) -> bool | None:
        nonlocal n_visited
        n_visited += 1
        if isinstance(item, h5py.Group):
            groups.append(f"/{name}")
        return True if n_visited >= MOST_LISTED else None

    file.visititems(note)  # follows neither soft links nor those to other files
    return groups


def _other_files(dataset: Any) -> bool:
    if dataset.external:
        return True
    if not dataset.is_virtual:
        return False
    settings = dataset.id.get_create_plist()
    return any(settings.get_virtual_filename(number) != HERE for number in range(settings.get_virtual_count()))


def _parts(path: str | bytes) -> list[bytes]:
    text = path if isinstance(path, bytes) else path.encode("utf-8", "surrogateescape")
    return [name for name in text.split(b"/") if name not in (b"", b".")]
