"""Reading OBJ and OFF: faces over vertices, neither triangulated nor merged."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Polygons


def read_obj(path: Path) -> list[tuple[str, Polygons]]:
    """Read every object (`o`) of an OBJ file that has faces, with its name; without any, one empty object.

    Raises ValueError naming the faulty line.
    """
    vertices: list[list[float]] = []
    objects: list[tuple[str, list[list[int]]]] = [("", [])]
    for number, line in enumerate(path.read_text("utf-8", errors="replace").splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append(_numbers(words[1:4], number))
        elif words[0] == "o":
            objects.append((" ".join(words[1:]), []))
        elif words[0] == "f":
            if len(words) < 2:
                raise ValueError(f"line {number}: a face has no vertices")
            objects[-1][1].append([_reference(w, len(vertices), number) for w in words[1:]])
    xyz = np.array(vertices, np.float64).reshape(-1, 3)
    full = [(name, faces) for name, faces in objects if faces] or [("", [])]
    largest = max((i for _, faces in full for face in faces for i in face), default=-1)
    if largest >= len(xyz):
        raise ValueError(f"a face names vertex {largest + 1}, but there are only {len(xyz)}")
    return [(name, _surfaces(xyz, faces)) for name, faces in full]


def read_off(path: Path) -> list[tuple[str, Polygons]]:
    """Read the faces of an OFF file as one unnamed object. Raises ValueError naming what is wrong."""
    lines = [words for line in path.read_text("utf-8").splitlines() if (words := line.split("#")[0].split())]
    if not lines or lines[0][0] != "OFF":
        raise ValueError("it does not begin with OFF")
    rest = lines[1:] if len(lines[0]) == 1 else [lines[0][1:], *lines[1:]]
    if not rest or len(rest[0]) < 2:
        raise ValueError("it does not state the numbers of vertices and faces")
    count, number = int(rest[0][0]), int(rest[0][1])
    if count < 0 or number < 0:
        raise ValueError("it states a negative number of vertices or faces")
    body = rest[1:]
    if len(body) < count + number:
        raise ValueError(f"it ends before its {count} vertices and {number} faces")
    xyz = np.array([_numbers(w[:3], k + 1) for k, w in enumerate(body[:count])], np.float64).reshape(-1, 3)
    faces = []
    for k, words in enumerate(body[count : count + number]):
        ids = [int(w) for w in words[1 : int(words[0]) + 1]]
        if len(ids) != int(words[0]) or any(i < 0 or i >= count for i in ids):
            raise ValueError(f"face {k} is incomplete or names a vertex that does not exist")
        faces.append(ids)
    return [("", _surfaces(xyz, faces))]


def _surfaces(xyz: Float, faces: Sequence[Sequence[int]]) -> Polygons:
    return Polygons.of([[xyz[np.asarray(face, np.int64)]] for face in faces])


def _numbers(words: Sequence[str], line: int) -> list[float]:
    if len(words) < 3:
        raise ValueError(f"vertex {line} has {len(words)} coordinates")
    return [float(w) for w in words]


def _reference(word: str, count: int, line: int) -> int:
    """The vertex number, from 0, of a reference such as `7`, `7/2/3` or `-1`."""
    number = int(word.split("/")[0])
    if number == 0 or -number > count:
        raise ValueError(f"line {line}: a face names vertex {number}")
    return number - 1 if number > 0 else count + number
