"""Every law is one body; here it meets every scheme over every shape that the scheme takes."""

import pytest

from shapes.parameters import CASES, surface_of


@pytest.fixture(params=CASES, ids=lambda case: "-".join(case).replace(" ", "_"))
def surface(request):
    """A limit surface over a shape of the zoo."""
    return surface_of(*request.param)
