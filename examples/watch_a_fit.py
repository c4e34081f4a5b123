"""Watch a fit: every iteration's surface is usable, and a budget gives the best that it allows."""

import trimesh

import subdfit

knot = trimesh.creation.torus(major_radius=30, minor_radius=10, major_sections=128, minor_sections=64)
knot.vertices[:, 2] += 4 * (knot.vertices[:, 0] / 30) ** 3


def show(step: subdfit.Progress) -> None:
    """Print one line an iteration; `step.control_mesh` could be drawn or saved here."""
    print(
        f"{step.stage:6s} {step.iteration:3d}  {step.control_vertices:5d} control vertices  "
        f"E_max {100 * step.max:.4f} %  E_rms {100 * step.rms:.4f} %"
    )


# Nishiyama's method from few vertices: it refines by itself where the error is large.
result = subdfit.fit(knot, max_error="0.1%", method="geometric", control_vertices=60, progress=show)
print(result)

# Too little to reach the tolerance: no exception, but a status, and the best surface that was seen.
modest = subdfit.fit(knot, max_error="0.01%", control_vertices=60, max_control_vertices=100)
print(modest)
print(f"status {modest.status}, certified: {modest.certified}")
