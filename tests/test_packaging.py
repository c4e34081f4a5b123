"""What is shipped: a wheel that holds the whole package and nothing else, and imports without its heavy parts."""

import ast
import importlib.metadata
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import subdfit

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "subdfit"
HEAVY = ("numba", "scipy", "matplotlib", "trimesh", "rich", "numpy")
KERNELS = sorted(PACKAGE.rglob("*_kernels.py"))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """The wheel, built as any installer builds it."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return zipfile.ZipFile(next(folder.glob("*.whl")))


def test_wheel_holds_the_package_and_nothing_else(wheel: zipfile.ZipFile) -> None:
    sources = {path.relative_to(ROOT / "src").as_posix() for path in PACKAGE.rglob("*.py")}
    shipped = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert shipped == sources | {"subdfit/py.typed"}


def test_versions_agree(wheel: zipfile.ZipFile) -> None:
    name = next(name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
    metadata = wheel.read(name).decode()
    assert f"\nVersion: {subdfit.__version__}\n" in metadata
    assert f"[{subdfit.__version__}]" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert "\nLicense-Expression: MIT\n" in metadata


def test_command_is_installed() -> None:
    (command,) = importlib.metadata.entry_points(group="console_scripts", name="subdfit")
    assert callable(command.load())


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = f"import sys, subdfit; print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_kernels_import_arrays_and_kernels_only(path: Path) -> None:
    imported = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            imported.add(node.module or "")
    allowed = {"math", "typing", "numpy", "numpy.typing", "numba", "subdfit.compiled"}
    assert {name for name in imported if name not in allowed and not name.endswith("_kernels")} == set()
