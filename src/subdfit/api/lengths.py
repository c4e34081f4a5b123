"""Tolerances and amounts of memory as users write them."""

import logging
import math
import re
from typing import NamedTuple

from subdfit.errors import InputError

logger = logging.getLogger(__name__)

LARGE, SMALL = 0.1, 1e-6
"""Shares of the diagonal beyond which a length is doubted: a sphere of ten control vertices lies within the first, and
the second is near the last digit of coordinates in single precision."""


class Length(NamedTuple):
    """A positive length, in the unit of the data or as a share of the diagonal."""

    value: float
    relative: bool

    def share(self, diagonal: float) -> float:
        """As a share of a diagonal."""
        return self.value if self.relative else self.value / diagonal


def parse_length(given: float | str | None, name: str) -> Length | None:
    """Read a tolerance: a number is a length, a string such as ``"0.05%"`` a share of the diagonal.

    Raises
    ------
    InputError
        Neither, or not a positive finite number; `name` says which option it is.
    """
    if given is None:
        return None
    text = str(given).strip()
    relative = text.endswith("%")
    try:
        value = float(text.removesuffix("%"))
    except ValueError:
        value = math.nan
    if isinstance(given, bool) or not (math.isfinite(value) and value > 0):
        raise InputError(
            f"{name} is '{given}'; give a positive length such as 0.2, or a share of the diagonal such as 0.05%"
        )
    return Length(value / 100 if relative else value, relative)


def share_of(length: Length | None, name: str, diagonal: float) -> float | None:
    """As a share of the diagonal; a length that seems to be in another unit than the data is doubted.

    Raises
    ------
    InputError
        It is no less than the diagonal, so that anything would do.
    """
    if length is None:
        return None
    share = length.share(diagonal)
    if length.relative:
        if share >= 1:
            raise InputError(f"{name} is {100 * share:.3g} % of the diagonal; give a smaller share, such as 0.05%")
        return share
    text = f"{name} {length.value:g} is {100 * share:.3g} % of the diagonal, {diagonal:.4g}; is it in the data's unit?"
    if share >= 1:
        raise InputError(f"{text} Give a smaller length, or a share of the diagonal such as 0.05%")
    if not SMALL <= share <= LARGE:
        logger.warning("%s", text)
    return share


def parse_share(given: float | str | None, name: str) -> float | None:
    """Read a share: a number from 0 to less than 1, or a string such as ``"0.5%"``.

    Raises
    ------
    InputError
        It is nothing of the kind; `name` says which option it is.
    """
    if given is None:
        return None
    text = str(given).strip()
    try:
        value = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        value = math.nan
    if isinstance(given, bool) or not 0 <= value < 1:
        raise InputError(f"{name} is '{given}'; give a share such as 0.5%, from 0 to less than 100%")
    return value


def parse_bytes(given: int | float | str | None) -> int | None:
    """Read an amount of memory: bytes, or a number with K, M, G or T (powers of 1024).

    Raises
    ------
    InputError
        It is nothing of the kind.
    """
    if given is None:
        return None
    found = re.fullmatch(r"\s*(\d+(?:\.\d*)?(?:e\+?\d+)?)\s*([KMGT]?)(?:i?B)?\s*", str(given), re.IGNORECASE)
    amount = float(found[1]) * 1024 ** " KMGT".index(found[2].upper() or " ") if found else 0.0
    if isinstance(given, bool) or not 1 <= amount < 2**63:
        raise InputError(f"memory is '{given}'; give bytes such as 1500M or 2G")
    return int(amount)


def show_bytes(amount: float) -> str:
    """An amount of memory for messages."""
    return f"{amount / 1024**3:.2f}G" if amount >= 1024**3 else f"{math.ceil(amount / 1024**2)}M"
