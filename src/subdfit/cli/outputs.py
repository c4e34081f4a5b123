"""Output files: judged before the work begins, written when it is done."""

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subdfit.errors import InputError, MachineError

if TYPE_CHECKING:
    from subdfit import ControlMesh, LimitSurface

DRAWN = (".stl", ".glb")
"""Formats of the tessellated limit surface."""
SHADED = (".glb",)
"""Those that keep its normals."""

DEFAULT_LEVEL = 2
"""Sixteen triangles a face of the control mesh."""


def check_outputs(
    meshes: Iterable[str],
    inputs: Iterable[str],
    *,
    documents: Iterable[str | None] = (),
    pictures: Iterable[str | None] = (),
) -> None:
    """Raise now what would be raised when the files are written.

    Raises
    ------
    InputError
        An unknown extension, two outputs of one name, or an output that would replace an input.
    MachineError
        A folder that is missing or cannot be written.
    """
    from subdfit.io import check_writable
    from subdfit.io.atomic import check_folder

    meshes, drawings = list(meshes), [path for path in pictures if path]
    others = [path for path in documents if path] + drawings
    taken = {_key(path): "is the input" for path in inputs}
    for path in [*meshes, *others]:
        if _key(path) in taken:
            raise InputError(f"{path}: {taken[_key(path)]}; give each output a name of its own")
        taken[_key(path)] = "is named twice"
    for path in drawings:
        if Path(path).suffix.lower() != ".png":
            raise InputError(f"{path}: pictures are PNG files; give a name that ends in .png")
    for path in meshes:
        check_writable(path)
    for path in others:
        check_folder(path)


def check_level(level: int | None) -> None:
    """Raise InputError unless a level of tessellation is one that can be made."""
    if level is not None and not 0 <= level <= 8:
        raise InputError(f"--tessellate is {level}; give a level from 0 to 8")


def write_surface(path: str, mesh: "ControlMesh", surface: "LimitSurface", level: int | None) -> None:
    """Write the control mesh, or the tessellated limit surface where the format or a level asks for it."""
    from subdfit import api

    kind = Path(path).suffix.lower()
    if level is None and kind not in DRAWN:
        api.write(path, mesh)
    else:
        api.write(path, surface.tessellate(DEFAULT_LEVEL if level is None else level, apart=kind in SHADED))


def made_folder(name: str) -> Path:
    """Make a folder where there is none; raises MachineError."""
    folder = Path(name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MachineError(f"cannot make the folder {name}: {error.strerror or error}; choose another") from error
    return folder


def write_json(path: str | Path, document: dict[str, Any]) -> None:
    """Write a document whole or not at all; numbers that are not finite become null."""
    from subdfit.io.atomic import atomic

    with atomic(path) as stream:
        stream.write((json.dumps(_plain(document), indent=2, allow_nan=False) + "\n").encode())


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _key(path: str) -> str:
    return str(Path(path).resolve())
