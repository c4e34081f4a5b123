"""What ``import subdfit`` offers, and what it costs."""

import subprocess
import sys

import pytest

import subdfit


def test_importing_loads_nothing_heavy():
    code = "import subdfit, sys; print(*{'numpy', 'numba', 'scipy', 'matplotlib', 'rich'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_every_name_is_there():
    assert set(subdfit._HOME) == set(subdfit.__all__) - {"__version__"}
    assert set(dir(subdfit)) == set(subdfit.__all__)
    for name in subdfit.__all__:
        assert getattr(subdfit, name) is not None


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'fitt'"):
        subdfit.fitt  # noqa: B018


def test_rooms_do_not_hide_functions_of_the_same_name():
    code = (
        "import subdfit.fit.driver, subdfit.measure, subdfit\n"
        "from subdfit.fit import FitSettings\n"
        "assert callable(subdfit.fit) and callable(subdfit.measure)\n"
        "from subdfit.interpolate import METHODS\n"
        "assert callable(subdfit.interpolate)\n"
        "from subdfit import fit\n"
        "assert fit is subdfit.fit\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
