"""`subdfit.convert`: any control mesh as one that its scheme takes."""

from subdfit.api.cages import control_mesh_of
from subdfit.api.sources import MeshSource
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import scheme_named


def convert(mesh: ControlMesh | MeshSource, scheme: str | None = None) -> ControlMesh:
    """Return a control mesh with its scheme, creases and corners, to be written in another format.

    A mesh that is a manifold as it is keeps all rows and their order; another is mended, with warnings.

    Parameters
    ----------
    mesh
        A path, ``(vertices, faces)`` or an object that holds a control mesh.
    scheme
        Overrides the mesh's own, with a warning; None takes that, else Loop for triangles and Catmull-Clark for others.

    Raises
    ------
    InputError
        The mesh cannot be read or mended, or the scheme cannot take it.

    Examples
    --------
    >>> import subdfit
    >>> square = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> cage = subdfit.convert(square)
    >>> cage.scheme
    'catmull-clark'
    >>> subdfit.write("cage.json", cage)  # doctest: +SKIP
    """
    control = control_mesh_of(mesh, scheme)
    scheme_named(control.scheme or "loop").validate(control.topology)
    return control
