"""Results in words: the line a fit ends with, the table of a measurement."""

from typing import TYPE_CHECKING

from subdfit.wording import counted

if TYPE_CHECKING:
    from subdfit import FitResult, Measurement
    from subdfit.api import Comparison

VERDICTS = {
    "within_tolerance": "within tolerance on the data's side only",
    "best_effort": "tolerance not reached",
    "interrupted": "interrupted, the best so far",
}


def verdict_on(found: "FitResult | Comparison") -> str:
    """How a result stands to what was asked."""
    if found.certified:
        return "certified"
    if found.status == "within_tolerance" and found.measurement.sheets_fell_together:
        return "not certified, part of the surface faces the wrong way"
    return VERDICTS[found.status or "best_effort"]


def error_text(share: float, diagonal: float, unit: str | None) -> str:
    """An error in per cent of the diagonal and in the unit."""
    return f"{100 * share:.4g} % ({share * diagonal:.4g} {unit or 'units'})"


def fit_line(result: "FitResult") -> str:
    """One line on a fit, with what may help one that is not certified."""
    from subdfit.api.remedies import remedy

    m, unit = result.measurement, result.unit
    verdict, helps = verdict_on(result), remedy(result)
    return (
        f"{counted(result.control_mesh.topology.vertex_count, 'control vertex')}, {verdict}: "
        f"E_max {error_text(m.max, m.diagonal, unit)}, E_rms {error_text(m.rms, m.diagonal, unit)}, "
        f"reverse {100 * m.reverse_max:.4g} %, {result.seconds['total']:.1f} s" + (f"; {helps}" if helps else "")
    )


def picture_title(result: "FitResult") -> str:
    """What is written over a picture."""
    m = result.measurement
    verdict = verdict_on(result)
    return (
        f"{counted(result.control_mesh.topology.vertex_count, 'control vertex')}, {verdict}: "
        f"E_max {error_text(m.max, m.diagonal, result.unit)}, reverse {100 * m.reverse_max:.4g} %"
    )


def measure_table(found: "Comparison") -> str:
    """Several lines on a measurement."""
    from subdfit.api.remedies import TURNED

    m, unit = found.measurement, found.unit
    rows = [
        ("", "largest", "rms", "mean"),
        ("data to surface", *_row(m, "max", "rms", "mean")),
        ("surface to data", *_row(m, "reverse_max", "reverse_rms", "reverse_mean")),
    ]
    for name, curve in (("boundary", m.boundary), ("creases", m.crease)):
        if curve is not None:
            rows.append((name, f"{100 * curve.max:.4g} %", "", f"{100 * curve.mean:.4g} %"))
    topology = found.control_mesh.topology
    counts = f"{counted(topology.vertex_count, 'control vertex')}, {counted(topology.face_count, 'face')}"
    tail = [f"diagonal {m.diagonal:.6g} {unit or 'units'}, largest error {m.max * m.diagonal:.4g} {unit or 'units'}"]
    if found.status is not None:
        turned = found.status == "within_tolerance" and found.measurement.sheets_fell_together
        tail.append(verdict_on(found) + (f"; {TURNED}" if turned else ""))
    return "\n".join(
        [
            f"{counts}, {found.control_mesh.scheme}",
            *("".join(f"{cell:<17}" for cell in row).rstrip() for row in rows),
            *tail,
        ]
    )


def _row(m: "Measurement", *names: str) -> list[str]:
    return [f"{100 * getattr(m, name):.4g} %" for name in names]
