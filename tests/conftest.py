"""What all tests share."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def meshes() -> Path:
    """Return the folder of real models; a test that needs it skips, and says so, where it is not there."""
    folder = Path(__file__).parents[1].parent / "shared" / "meshes"
    if not folder.is_dir():
        if os.environ.get("CI"):
            pytest.fail("shared/meshes must lie beside the checkout in CI")
        pytest.skip("needs the real models in shared/meshes beside the checkout")
    return folder
