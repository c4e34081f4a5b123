"""Whole pictures: files written whole or not at all, the same bytes each time, nothing global touched."""

import os
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from matplotlib.image import imread
from pixels import sphere

from subdfit.draw.error_scale import error_scale
from subdfit.draw.fit_picture import fit_picture
from subdfit.draw.gallery import Panel, gallery
from subdfit.draw.history_picture import histories_picture, history_picture
from subdfit.errors import InputError, MachineError

POINTS, TRIANGLES = sphere(12)
HISTORY = [
    {"iteration": i, "control_vertices": 100 + 40 * i, "max": 0.02 / 2**i, "rms": 0.004 / 2**i, "mean": 0.003 / 2**i,
     "seconds": 0.5 + 0.1 * i}
    for i in range(6)
]  # fmt: skip


def draw_fit(path, **changes):
    options = {
        "target": (POINTS, TRIANGLES),
        "surface": (1.001 * POINTS, TRIANGLES),
        "surface_error": np.linspace(0.0, 2e-3, len(TRIANGLES)),
        "largest": (0.9e-3, 2e-3),
        "control_edges": POINTS[np.stack([TRIANGLES[:, 0], TRIANGLES[:, 1]], axis=1)],
        "control": (POINTS, TRIANGLES),
        "title": "a sphere",
        "tolerance": 1e-3,
        "unit": "mm",
    }
    fit_picture(path, **(options | changes))


def draw_history(path):
    history_picture(path, HISTORY, title="a sphere", tolerance=1e-3)


def draw_histories(path):
    histories_picture(path, [("short", HISTORY[:3]), ("long", HISTORY)])


def draw_gallery(path):
    panels = [Panel(POINTS, TRIANGLES, f"panel {k}", colors=POINTS[:, 1] if k else None) for k in range(6)]
    gallery(path, panels, title="spheres")


@pytest.mark.parametrize("draw", [draw_fit, draw_history, draw_histories, draw_gallery])
def test_the_same_picture_has_the_same_bytes_and_no_time_stamp(draw, tmp_path):
    before = dict(matplotlib.rcParams)
    draw(tmp_path / "one.png")
    draw(tmp_path / "two.png")
    data = (tmp_path / "one.png").read_bytes()
    assert data == (tmp_path / "two.png").read_bytes()
    assert data.startswith(b"\x89PNG")
    assert b"tEXt" not in data
    assert b"tIME" not in data
    assert dict(matplotlib.rcParams) == before
    picture = imread(tmp_path / "one.png")[:, :, :3]
    frame = np.concatenate([picture[:3].reshape(-1), picture[-3:].reshape(-1), picture[:, -3:].reshape(-1)])
    assert np.all(frame == 1.0), "text or a panel runs over the border"


def test_drawing_needs_no_pyplot_and_no_display(tmp_path):
    program = (
        "import sys; sys.path.insert(0, sys.argv[1]); from test_pictures import draw_fit; draw_fit(sys.argv[2]);"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    environment = os.environ | {"MPLBACKEND": "tkagg", "DISPLAY": "", "WAYLAND_DISPLAY": ""}
    done = subprocess.run(
        [sys.executable, "-c", program,
         str(__file__).rsplit("test_pictures", 1)[0], str(tmp_path / "fit.png")],
        env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "fit.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    "changes",
    [
        {"tolerance": None, "unit": None, "title": ""},
        {"surface_error": np.zeros(len(TRIANGLES))},
        {"surface_error": np.linspace(-0.03, 0.02, len(TRIANGLES))},
        {"surface_error": np.linspace(0.0, 1e-5, len(TRIANGLES))},
        {"control_edges": np.empty((0, 2, 3))},
        {"control": (POINTS[:8], [(0, 1, 2, 3), (4, 5, 6, 7)])},
    ],
)
def test_a_fit_of_any_kind_is_drawn(changes, tmp_path):
    draw_fit(tmp_path / "fit.png", **changes)
    assert (tmp_path / "fit.png").stat().st_size > 10_000


def test_the_caption_tells_what_was_measured_of_either_side(tmp_path, monkeypatch):
    written = []
    monkeypatch.setattr("subdfit.draw.fit_picture.text_at", lambda figure, x, y, text, **style: written.append(text))
    draw_fit(tmp_path / "fit.png", largest=(0.0008958, 0.00142))
    assert "0.08958 % from data to surface, 0.142 % from surface to data" in written[-1]


@pytest.mark.parametrize("draw", [
    lambda path: draw_fit(path, surface_error=np.zeros(3)),
    lambda path: draw_fit(path, target=(POINTS, np.empty((0, 3), int))),
    lambda path: history_picture(path, []),
    lambda path: histories_picture(path, [("one", HISTORY), ("none", [])]),
    lambda path: gallery(path, []),
])  # fmt: skip
def test_bad_input_leaves_the_old_file_as_it_was(draw, tmp_path):
    path = tmp_path / "old.png"
    path.write_bytes(b"old")
    with pytest.raises(InputError) as refused:
        draw(path)
    assert "\n" not in str(refused.value)
    assert path.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["old.png"]


def test_a_folder_that_is_not_there_is_said(tmp_path):
    with pytest.raises(MachineError, match="cannot write"):
        draw_history(tmp_path / "nowhere" / "history.png")


@pytest.mark.parametrize("history", [
    HISTORY[:1],
    [step | {"max": 0.0, "rms": 0.0, "mean": 0.0} for step in HISTORY],
    [step | {"mean": step["rms"]} for step in HISTORY],
])  # fmt: skip
def test_short_and_perfect_histories_are_drawn(history, tmp_path):
    history_picture(tmp_path / "history.png", history)
    assert (tmp_path / "history.png").stat().st_size > 5_000


def test_histories_beside_each_other_have_one_scale(tmp_path, monkeypatch):
    figures = []
    monkeypatch.setattr("subdfit.draw.history_picture.write_png", lambda path, figure: figures.append(figure))
    histories_picture(tmp_path / "both.png", [("one", HISTORY), ("coarse", HISTORY[:2])])
    axes = figures[0].axes
    assert [axes[k].get_ylim() for k in range(3)] == [axes[k].get_ylim() for k in range(3, 6)]
    assert axes[0].get_ylim()[0] < 100 * HISTORY[-1]["mean"] < 100 * HISTORY[0]["max"] < axes[0].get_ylim()[1]


def test_colours_change_from_cold_to_warm_at_the_tolerance():
    scale = error_scale(np.array([0.0, 0.0025]), 0.001)
    within, beyond = (scale.cmap(scale.norm(0.001 * factor)) for factor in (0.98, 1.02))
    assert within[2] > within[0]
    assert beyond[0] > beyond[2]
    assert not scale.signed
    assert scale.norm.vmax == 0.0025
    assert scale.largest == 0.0025


def test_a_signed_scale_is_symmetric_and_a_long_one_is_cut():
    scale = error_scale(np.array([-0.5, 0.1]), 0.001)
    assert scale.signed
    assert scale.norm.vmin == -scale.norm.vmax == -0.004
    assert scale.largest == 0.5
    outside, inside = scale.cmap(scale.norm(0.003)), scale.cmap(scale.norm(-0.003))
    assert outside[0] > outside[2]
    assert inside[2] > inside[0]


def test_a_fit_far_within_its_tolerance_still_ends_at_the_tolerance():
    assert error_scale(np.array([0.0, 1e-6]), 0.001).norm.vmax == 0.001
    assert error_scale(np.zeros(3)).norm.vmax > 0.0
