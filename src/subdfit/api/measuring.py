"""`subdfit.measure`: two-sided errors of any control mesh against any target."""

import logging
import time
from dataclasses import asdict, dataclass
from typing import Any, Literal

from subdfit.api.cages import control_mesh_of
from subdfit.api.fitting import elapsed, shares, tolerances
from subdfit.api.lengths import parse_bytes
from subdfit.api.memory import check_job
from subdfit.api.result import tolerance_dict
from subdfit.api.sources import MeshSource
from subdfit.api.targets import Preparation, Prepared, joined, prepare, stages
from subdfit.api.workers import workers
from subdfit.compiled import compile_clock
from subdfit.errors import InputError
from subdfit.fit.result import errors_dict, mesh_counts
from subdfit.fit.settings import FitSettings
from subdfit.limit.surface import LimitSurface
from subdfit.measure import Measurement, Tolerance
from subdfit.measure import measure as measure_inside
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.frame import Frame
from subdfit.target.target import Target

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Comparison:
    """A control mesh measured against a target.

    Attributes
    ----------
    control_mesh, target : what was compared, in the target's unit.
    measurement : the errors, as shares of the target's diagonal.
    tolerance : what was asked, as shares of the diagonal.
    asked : the arguments.
    seconds : by stage.
    unit : its name, or None.
    """

    control_mesh: ControlMesh
    target: Target
    measurement: Measurement
    tolerance: Tolerance
    asked: dict[str, Any]
    seconds: dict[str, float]
    unit: str | None

    @property
    def status(self) -> str | None:
        """``within_tolerance`` or ``best_effort``; None where no tolerance was asked."""
        if self.tolerance == Tolerance():
            return None
        m = self.measurement
        return "within_tolerance" if self.tolerance.met(m.max, m.rms, m.mean) else "best_effort"

    @property
    def certified(self) -> bool:
        """Whether a tolerance was asked and holds on both sides."""
        return self.status is not None and self.measurement.certifies(self.tolerance)

    def to_dict(self) -> dict[str, Any]:
        """The object that ``measure --json`` writes: a fit's, without history."""
        from subdfit import __version__

        return {
            "scheme": self.control_mesh.scheme,
            "method": None,
            "status": self.status,
            "certified": self.certified,
            "iterations": 0,
            **mesh_counts(self.control_mesh),
            "diagonal": self.measurement.diagonal,
            "unit": self.unit,
            "errors": errors_dict(self.measurement),
            "seconds": self.seconds,
            "settings": tolerance_dict(asdict(self.tolerance)) | self.asked,
            "version": __version__,
        }


def measure(
    control_mesh: ControlMesh | MeshSource,
    target: MeshSource,
    *,
    scheme: str | None = None,
    creases: Literal["auto", "none"] | float = "auto",
    repair: bool = False,
    keep_components: int | None = None,
    fill_holes: int | None = None,
    threads: int | None = None,
    memory: int | str | None = None,
) -> Measurement:
    """Measure the limit surface of a control mesh against a target, on both sides.

    Parameters
    ----------
    control_mesh
        A `ControlMesh`, or a path or object that holds one.
    target
        As for `subdfit.fit`; the reverse side of a cloud is measured to the surface through its points, or to the
        points themselves where there is none.
    scheme
        Overrides the control mesh's own; None takes that, else Loop where all faces are triangles, Catmull-Clark
        elsewhere.
    creases, repair, keep_components, fill_holes, threads, memory
        As for `subdfit.fit`.

    Returns
    -------
    Measurement
        Errors as shares of the target's diagonal.

    Raises
    ------
    InputError
        One of the two cannot be read or used.
    """
    return compare(
        control_mesh,
        target,
        scheme=scheme,
        creases=creases,
        repair=repair,
        keep_components=keep_components,
        fill_holes=fill_holes,
        threads=threads,
        memory=memory,
    ).measurement


def compare(
    control_mesh: ControlMesh | MeshSource,
    target: MeshSource,
    *,
    scheme: str | None = None,
    max_error: float | str | None = None,
    rms_error: float | str | None = None,
    mean_error: float | str | None = None,
    creases: Literal["auto", "none"] | float = "auto",
    repair: bool = False,
    keep_components: int | None = None,
    fill_holes: int | None = None,
    unit: str | None = None,
    threads: int | None = None,
    memory: int | str | None = None,
) -> Comparison:
    """Measure as `measure` does, and judge by tolerances; arguments as for `subdfit.fit`."""
    lengths = tolerances(max_error, rms_error, mean_error)
    how = Preparation(creases, repair, keep_components, fill_holes, parse_bytes(memory))
    asked = {"scheme": scheme, **asdict(how), "threads": threads}
    begun, compiled = time.perf_counter(), compile_clock.seconds
    with workers(threads):
        stages.info("reading")
        mesh = control_mesh_of(control_mesh, scheme)
        ready = prepare(target, how)
        points, corners = len(ready.target.points), ready.target.triangles.size
        check_job(points, corners, how.memory, ready.name, mesh.topology.vertex_count, str(mesh.scheme))
        ready = _joined(ready, how)
        clock = time.perf_counter()
        stages.info("measuring")
        found = _measured(mesh, ready.target)
    seconds = ready.seconds | {"measure": time.perf_counter() - clock} | elapsed(begun, compiled)
    return Comparison(mesh, ready.target, found, shares(lengths, found.diagonal), asked, seconds, unit)


def _joined(ready: Prepared, how: Preparation) -> Prepared:
    """A cloud with the surface through its points, where there is one; only then is it known what lies between them."""
    try:
        return joined(ready, how)
    except InputError as error:
        if how.keep_components is not None or how.fill_holes is not None:
            raise
        logger.warning("%s; the reverse side is measured to the points", error)
        return ready


def _measured(mesh: ControlMesh, target: Target) -> Measurement:
    """Measure in the target's normalised frame."""
    frame = Frame.of(target.points[target.used])
    surface = LimitSurface(mesh.with_points(frame.inside(mesh.points)))
    return measure_inside(surface, target.normalised(frame), FitSettings().sample_spacing, frame.diagonal)
