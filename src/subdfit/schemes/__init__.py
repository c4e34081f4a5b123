"""Subdivision schemes by name: one file each behind the protocol of `subdfit.schemes.scheme`."""

from subdfit.errors import InputError
from subdfit.schemes.catmull_clark import CatmullClark
from subdfit.schemes.doo_sabin import DooSabin
from subdfit.schemes.loop import Loop
from subdfit.schemes.quad_triangle import QuadTriangle
from subdfit.schemes.scheme import Refinement, Scheme

_ALL: tuple[Scheme, ...] = (
    Loop(),
    CatmullClark(),
    DooSabin(),
    DooSabin("doo-sabin-averaging", averaging=True),
    QuadTriangle(),
)

SCHEMES: dict[str, Scheme] = {scheme.name: scheme for scheme in _ALL}

__all__ = ["SCHEMES", "Refinement", "Scheme", "scheme_named"]


def scheme_named(name: str | Scheme) -> Scheme:
    """Return the scheme of that name (a scheme is returned as it is); raises InputError for an unknown name."""
    if isinstance(name, Scheme):
        return name
    if not isinstance(name, str) or name not in SCHEMES:
        raise InputError(f"unknown scheme {name!r}; choose one of {', '.join(SCHEMES)}")
    return SCHEMES[name]
