"""Which file extension belongs to which reader and writer."""

import codecs
from collections.abc import Callable
from pathlib import Path

from subdfit.errors import InputError
from subdfit.io import gltf, json_mesh, obj, off, ply, stl, xyz
from subdfit.io.atomic import atomic, check_folder
from subdfit.mesh.data import MeshData
from subdfit.mesh.repair import check

READERS: dict[str, Callable[[bytes, Path], MeshData]] = {
    ".glb": gltf.parse,
    ".gltf": gltf.parse,
    ".json": json_mesh.parse,
    ".obj": obj.parse,
    ".off": off.parse,
    ".ply": ply.parse,
    ".stl": stl.parse,
    ".xyz": xyz.parse,
}
"""Readers by extension: file's bytes and path (to name it in errors) to arrays."""

WRITERS: dict[str, Callable[[MeshData, Path], bytes]] = {
    ".glb": gltf.render,
    ".json": json_mesh.render,
    ".obj": obj.render,
    ".off": off.render,
    ".ply": ply.render,
    ".stl": stl.render,
}
"""Writers by extension: arrays to the file's bytes."""


def read(path: str | Path) -> MeshData:
    """Read a mesh or a point cloud, in the format its extension names.

    The numbers are the file's own: rows keep their order and nothing is merged or mended
    (see `subdfit.mesh.repair.mend`), but coordinates that are not finite and indices out of range are refused.

    Raises
    ------
    InputError
        The file is missing, cannot be read, has an unknown extension, or does not hold what it claims.
    """
    path = _path(path)
    parse = READERS.get(path.suffix.lower())
    if parse is None:
        raise InputError(f"{path}: cannot read {_extension(path)}; use one of {' '.join(READERS)}")
    data = parse(_bytes(path), path)
    check(data, path.name)
    return data


def write(path: str | Path, data: MeshData) -> None:
    """Write a mesh, in the format its extension names; the file appears whole or not at all.

    A control mesh goes to .obj, .ply, .json or .off (which holds neither scheme nor creases, and warns), a tessellation
    to .stl or .glb (triangles only, float32). The same mesh gives the same bytes.

    Raises
    ------
    InputError
        The extension is unknown, or the format cannot hold this mesh.
    MachineError
        The file cannot be written.
    """
    path = _path(path)
    content = _writer(path)(data, path)
    with atomic(path) as stream:
        stream.write(content)


def check_writable(path: str | Path) -> None:
    """Raise early, before long work, what `write` would raise at its end.

    Raises
    ------
    InputError
        The extension is unknown.
    MachineError
        The folder is missing or cannot be written, or `path` is a folder.
    """
    path = _path(path)
    _writer(path)
    check_folder(path)


def _writer(path: Path) -> Callable[[MeshData, Path], bytes]:
    render = WRITERS.get(path.suffix.lower())
    if render is None:
        raise InputError(f"{path}: cannot write {_extension(path)}; use one of {' '.join(WRITERS)}")
    return render


def _path(path: str | Path) -> Path:
    if "\0" in str(path):
        raise InputError(f"{str(path)!r}: a path cannot hold a null character; check the path")
    return Path(path)


def _extension(path: Path) -> str:
    return f"files of type {path.suffix}" if path.suffix else "a file without an extension"


def _bytes(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder; name a file")
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: is not a regular file; copy its content to one")
        content = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except PermissionError:
        raise InputError(f"{path}: no permission to read it; change its mode or owner") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the path") from None
    if not content:
        raise InputError(f"{path}: is empty; export the mesh again")
    return content.removeprefix(codecs.BOM_UTF8)
