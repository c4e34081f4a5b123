"""The driver: from a target to a certified result, by any method."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from subdfit.compiled import compile_clock
from subdfit.errors import InputError
from subdfit.fit.choice import suits_lavoue
from subdfit.fit.data import FitData
from subdfit.fit.fitter import Fitter
from subdfit.fit.geometric import Geometric
from subdfit.fit.held import boundary_held
from subdfit.fit.lavoue import Lavoue
from subdfit.fit.result import FitResult, Iteration, Status
from subdfit.fit.settings import FitSettings
from subdfit.fit.starts import Start, own_start, parted, second_start, started
from subdfit.fit.state import FitState
from subdfit.fit.stop import badness, error_that_matters, surface_within, within
from subdfit.fit.tangential import Tangential
from subdfit.fit.thinning import Thinning
from subdfit.limit.surface import LimitSurface
from subdfit.measure import Measurement, Outliers, Tolerance, measure
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.frame import Frame
from subdfit.target.target import Target

logger = logging.getLogger(__name__)

METHODS: dict[str, Callable[[FitSettings], Fitter]] = {
    "auto": Tangential,
    "tangent": Tangential,
    "geometric": Geometric,
    "lavoue": Lavoue,
}
"""Fitters by name; ``auto`` is ``tangent``, or ``lavoue`` for targets that suit it."""

CLOSER = 3
"""So often a fit goes on that is within tolerance by its own account but not by the certificate's."""
REVERSE_GROWTH, REVERSE_ROOM = 1.3, 300
"""Factor of control vertices spent on the reverse side after the data's side is within tolerance, or so many more."""


class Progress(NamedTuple):
    """What a progress callback receives.

    Attributes
    ----------
    stage : ``start``, ``fit`` or ``thin``.
    iteration, control_vertices : where the fit stands.
    max, rms : errors as shares of the diagonal.
    seconds : since the fit began.
    control_mesh : this iteration's control mesh, in the target's unit: usable as it is.
    """

    stage: str
    iteration: int
    control_vertices: int
    max: float
    rms: float
    seconds: float
    control_mesh: ControlMesh


@dataclass
class _Run:
    """One fit under way: its clock, its history, its best state."""

    target: Target
    settings: FitSettings
    callback: Callable[[Progress], None] | None
    begun: float = field(default_factory=time.perf_counter)
    compiled: float = field(default_factory=lambda: compile_clock.seconds)
    history: list[Iteration] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    best: FitState | None = None
    best_standing: tuple[int, float] = (3, np.inf)
    best_iteration: int = 0
    first_within: tuple[int, int] | None = None

    @cached_property
    def frame(self) -> Frame:
        """The frame in which the target is fitted."""
        return Frame.of(self.target.points[self.target.used])

    def fitter(self) -> Fitter:
        """The method of the settings, ready for its first round."""
        return METHODS[self.settings.method](self.settings)

    def record(self, stage: str, state: FitState, fitter: Fitter) -> None:
        """Note an iteration, and keep the state if it is the best."""
        standing = self._standing(state, fitter)
        if standing < self.best_standing:
            self.best, self.best_standing, self.best_iteration = state, standing, len(self.history)
        self._note(stage, state)

    def record_lighter(self, state: FitState) -> None:
        """Note and keep a state that is lighter than the best and holds what that holds."""
        self.best = state
        self._note("thin", state)

    def _note(self, stage: str, state: FitState) -> None:
        """Add a row to the history, and tell the caller."""
        errors = state.errors
        elapsed = time.perf_counter() - self.begun - (compile_clock.seconds - self.compiled)
        count = state.surface.topology.vertex_count
        row = Iteration(len(self.history), count, errors.max, errors.rms, errors.mean, elapsed)
        self.history.append(row)
        logger.debug("%s %d: %d vertices, max %.3e, rms %.3e", stage, row.iteration, count, errors.max, errors.rms)
        if self.callback is not None:
            mesh = self.outside(state.surface)
            self.callback(Progress(stage, row.iteration, count, errors.max, errors.rms, elapsed, mesh))

    def _standing(self, state: FitState, fitter: Fitter) -> tuple[int, float]:
        """What orders states, the best first: those within tolerance, with their curves and without, then others.

        Of states within tolerance that one is best whose surface strays least between the data.
        """
        tolerance = self.settings.tolerance
        if not surface_within(state, tolerance):
            return 2, badness(state, tolerance)
        return int(not within(state, tolerance)), fitter.stray(state)

    def disproved(self, state: FitState, strays: float) -> None:
        """Let a state stand by how far, in tolerances, the certificate found its surface to stray."""
        if self.best is state:
            self.best_standing = self.best_standing[0], strays

    def spent_on_reverse(self, state: FitState, patience: int) -> bool:
        """Whether, once the data's side is within tolerance, enough was tried for the reverse side."""
        count = state.surface.topology.vertex_count
        if self.first_within is None:
            self.first_within = (len(self.history), count)
        iteration, vertices = self.first_within
        most = max(REVERSE_GROWTH * vertices, vertices + REVERSE_ROOM)
        return len(self.history) - iteration > patience or count > most

    def excused(self, state: FitState) -> FitState:
        """The state with its outliers left out, where that is allowed."""
        return state.excusing(self.settings.robust, self.settings.tolerance.max)

    def outside(self, surface: LimitSurface) -> ControlMesh:
        """The surface's control mesh in the target's coordinates."""
        mesh = surface.control_mesh
        return ControlMesh(mesh.topology, self.frame.outside(mesh.points), surface.scheme.name)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Add the time of what follows to a stage."""
        since = time.perf_counter()
        yield
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - since


def fit_target(
    target: Target,
    settings: FitSettings,
    progress: Callable[[Progress], None] | None = None,
    unit: str | None = None,
) -> FitResult:
    """Fit a subdivision surface to a target.

    Parameters
    ----------
    target
        The data, in the caller's unit.
    settings
        What is asked.
    progress
        Called after every iteration with a `Progress`.
    unit
        The unit's name, for messages.

    Returns
    -------
    FitResult
        Running out of iterations or budget is a status, not an error; so is Ctrl-C, which returns the best so far.

    Raises
    ------
    InputError
        Unknown method, or a scheme that cannot take the target.
    KeyboardInterrupt
        Ctrl-C before there was a first control mesh.
    """
    if settings.method not in METHODS:
        raise InputError(f"unknown method '{settings.method}'; choose one of {', '.join(METHODS)}")
    # More control vertices than data would follow nothing.
    settings = replace(settings, max_control_vertices=settings.max_control_vertices or len(target.used))
    own = None
    if settings.method == "auto" and suits_lavoue(target, settings):
        own = _fitted_from_own_faces(_Run(target, replace(settings, method="lavoue"), progress), unit)
        if own is not None and (own.certified or own.status == "interrupted"):
            return own
        logger.info("the part's own faces and edges gave no certified fit; its mesh is decimated instead")
    run = _Run(target, settings, progress)
    return _fitted(run, unit) if own is None else _preferred(own, lambda: _fitted(run, unit))


def _fitted_from_own_faces(run: _Run, unit: str | None) -> FitResult | None:
    """A fit by the method ``lavoue``; None where the part's faces and edges alone do not begin it."""
    try:
        state = _first_state(run)
    except InputError as error:
        logger.info("%s", error)
        return None
    with run.timed("footpoints"):
        start = own_start(state, run.settings, run.fitter())
    return None if start is None else _advanced(run, start, unit)


def _fitted(run: _Run, unit: str | None) -> FitResult:
    """A fit by the method of its settings."""
    state = _first_state(run)
    with run.timed("footpoints"):
        start = parted(state, run.settings, run.fitter)
    found = _advanced(run, start, unit)
    # Short of the tolerance on the data's side too, a mesh decimated less would end no nearer.
    hopeful = not found.certified and (
        found.status == "within_tolerance" or (start.own and found.status == "best_effort")
    )
    if not hopeful or run.best is None:
        return found
    settings, best, again = run.settings, run.best, _Run(run.target, run.settings, run.callback)

    def other() -> FitResult | None:
        second = second_start(start, best, settings, again.fitter)
        return None if second is None else _advanced(again, second, unit)

    return _preferred(found, other)


def _preferred(found: FitResult, other: Callable[[], FitResult | None]) -> FitResult:
    """The better of a fit without a certificate and another; Ctrl-C in the other leaves the one that is there."""
    try:
        result = other()
    except KeyboardInterrupt:
        return replace(found, status="interrupted")
    if result is None or result.certified:
        return result or found
    if _off(found) < _off(result):
        return replace(found, status="interrupted") if result.status == "interrupted" else found
    return result


def _off(found: FitResult) -> tuple[bool, float]:
    """What orders fits without a certificate, the better first."""
    m, asked = found.measurement, found.settings.tolerance
    bounds = ((asked.max, m.max), (asked.rms, m.rms), (asked.mean, m.mean))
    return found.status != "within_tolerance", max((value / bound for bound, value in bounds if bound), default=0.0)


def _first_state(run: _Run) -> FitState:
    """The first control mesh with the footpoints of the data that count."""
    settings = run.settings
    with run.timed("start"):
        inside, mesh = started(run.target.normalised(run.frame), settings)
        data = FitData.of(inside, settings.sample_spacing, error_that_matters(settings.tolerance))
    with run.timed("footpoints"):
        return run.excused(FitState.start(data, LimitSurface(mesh, settings.scheme)))


def _advanced(run: _Run, start: Start, unit: str | None) -> FitResult:
    """The fit from its start to its end, or to Ctrl-C."""
    settings = run.settings
    if settings.fixed_boundary:
        with run.timed("footpoints"):
            start = Start(boundary_held(start.state, settings), run.fitter())
    interrupted, measurement = False, None
    with run.timed("fit"):
        try:
            run.record("start", start.state, start.fitter)
            state, measurement = _iterate(run, start)
            surface = state.surface
            if measurement is not None and _is_thinned(settings, start, measurement):
                surface, measurement, interrupted = _thinned(run, state, measurement)
        except KeyboardInterrupt:
            if run.best is None:
                raise
            interrupted, surface, measurement = True, run.best.surface, None
    measurement = measurement or _measured(run, surface, start.state.data.target)
    return _result(run, surface, measurement, interrupted, unit)


def _iterate(run: _Run, start: Start) -> tuple[FitState, Measurement | None]:
    """Advance until a state is within tolerance by its measurement, or there is no hope; return the best."""
    settings, closer = run.settings, 0
    state, fitter, advanced = start.state, start.fitter, start.advanced
    for _ in range(settings.max_iterations):
        if within(state, settings.tolerance) and fitter.stray(state) <= 1:
            measurement = _measured(run, state.surface, state.data.target)
            if not measurement.meets(settings.tolerance):
                state = run.excused(state.verified())
            elif closer < CLOSER and (strays := _strays(measurement, settings.tolerance)) > 1:
                closer += 1
                run.disproved(state, strays)
                fitter.look_closer()
            else:
                return state, measurement
        if within(state, settings.tolerance) and run.spent_on_reverse(state, fitter.patience):
            break
        state, advanced = run.excused(advanced or fitter.advance(state)), None
        run.record("fit", state, fitter)
        if len(run.history) - run.best_iteration > fitter.patience:
            break
    assert run.best is not None
    # The certificate asks for no curves.
    held = run.best_standing[0] <= 1 and run.best_standing[1] <= 1
    return run.best, _measured(run, run.best.surface, run.best.data.target) if held else None


def _strays(measurement: Measurement, tolerance: Tolerance) -> float:
    """How far the surface lies off between the data, in tolerances; 0 where no largest error is asked."""
    return 0.0 if tolerance.max is None else measurement.reverse_excess / tolerance.max


def _is_thinned(settings: FitSettings, start: Start, measurement: Measurement) -> bool:
    """Whether a fit is made lighter: not one whose sheets fell together where another begins from the part's mesh."""
    wanted = settings.thin or settings.method == "lavoue"
    return wanted and not (start.own and measurement.sheets_fell_together)


def _thinned(run: _Run, state: FitState, measurement: Measurement) -> tuple[LimitSurface, Measurement, bool]:
    """The lightest fit with a certificate, or the given one, which is measured; and whether Ctrl-C came."""
    tolerance, lighter, interrupted = run.settings.tolerance, [], False
    try:
        for found in Thinning(run.settings).lighter(state):
            # Only the mesh: what surfaces are compiled to would take gigabytes.
            lighter.append(found.surface.control_mesh)
            run.record_lighter(found)
    except KeyboardInterrupt:
        interrupted = True
    for mesh in reversed(lighter):
        surface = LimitSurface(mesh, state.surface.scheme)
        measured = _measured(run, surface, state.data.target)
        if measured.certifies(tolerance) or (measured.meets(tolerance) and not measurement.certifies(tolerance)):
            return surface, measured, interrupted
    return state.surface, measurement, interrupted


def _measured(run: _Run, surface: LimitSurface, target: Target) -> Measurement:
    """The measurement of a surface, from nothing."""
    settings = run.settings
    allowed = Outliers(settings.robust, settings.tolerance.max)
    with run.timed("certificate"):
        return measure(surface, target, settings.sample_spacing, run.frame.diagonal, allowed)


def _result(
    run: _Run, surface: LimitSurface, measurement: Measurement, interrupted: bool, unit: str | None
) -> FitResult:
    tolerance = run.settings.tolerance
    certified = measurement.certifies(tolerance)
    status: Status = (
        "interrupted" if interrupted else ("within_tolerance" if measurement.meets(tolerance) else "best_effort")
    )
    run.seconds["compile"] = compile_clock.seconds - run.compiled
    run.seconds["total"] = time.perf_counter() - run.begun - run.seconds["compile"]
    return FitResult(
        run.outside(surface), status, certified, measurement, tuple(run.history), run.settings, run.seconds, unit
    )
