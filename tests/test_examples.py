"""Every example runs from an empty folder, and what the documents tell readers to type works as it stands."""

import doctest
import os
import re
import shlex
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import trimesh

from subdfit.cli import main

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
DOCTESTED = sorted(path for path in (ROOT / "src").rglob("*.py") if ">>> " in path.read_text(encoding="utf-8"))
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *EXAMPLES.glob("*.md")])


def run_python(arguments: list[str], folder: Path) -> str:
    """Run Python with warnings as errors, and return what it printed."""
    done = subprocess.run(
        [sys.executable, "-W", "error", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def blocks(path: Path, language: str) -> list[str]:
    """The fenced blocks of one language in a document."""
    return re.findall(rf"^```{language}\n(.*?)^```", path.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


@pytest.fixture
def readers_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files that the documents speak of."""
    torus = trimesh.creation.torus(major_radius=30, minor_radius=10, major_sections=96, minor_sections=48)
    torus.export(tmp_path / "scan.ply")
    ring = trimesh.creation.annulus(r_min=20, r_max=40, height=24, sections=48).subdivide_to_size(6)
    ring.export(tmp_path / "part.stl")
    cloud, _ = trimesh.sample.sample_surface_even(torus, 4000, seed=0)
    np.savetxt(tmp_path / "cloud.xyz", cloud)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_example_runs(path: Path, tmp_path: Path) -> None:
    assert run_python([str(path)], tmp_path).strip()


def test_examples_are_listed() -> None:
    listed = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert all(f"({path.name})" in listed for path in EXAMPLES.glob("*.py"))


@pytest.mark.parametrize("name", ["README.md", "docs/user-guide.md"])
def test_documented_commands_and_code_run(name: str, readers_folder: Path) -> None:
    document = ROOT / name
    typed = "".join(blocks(document, "sh")).replace("\\\n", " ").splitlines()
    commands = [shlex.split(line, comments=True)[1:] for line in typed if line.startswith("subdfit ")]
    assert commands
    for command in commands:
        assert main(command) == 0, command
    code = blocks(document, "python")
    assert code
    (readers_folder / "documented.py").write_text("\n".join(code), encoding="utf-8")
    run_python(["documented.py"], readers_folder)


@pytest.mark.parametrize("path", DOCTESTED, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_docstring_examples_run(path: Path) -> None:
    module = import_module(".".join(path.relative_to(ROOT / "src").with_suffix("").parts))
    assert doctest.testmod(module).failed == 0


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text)
    missing = [link for link in links if "://" not in link and not (document.parent / link).exists()]
    assert not missing
    headings = [line.lstrip("# ").lower() for line in text.splitlines() if line.startswith("#")]
    anchors = {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in headings}
    assert set(re.findall(r"\]\(#([^)]+)\)", text)) <= anchors
