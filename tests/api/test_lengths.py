"""Tolerances and amounts of memory, as users write them."""

import pytest

from subdfit.api.lengths import Length, parse_bytes, parse_length, share_of, show_bytes
from subdfit.errors import InputError


@pytest.mark.parametrize(
    ("given", "length"),
    [
        ("0.05%", Length(5e-4, True)),
        (" 5 % ", Length(0.05, True)),
        (0.2, Length(0.2, False)),
        ("2e-1", Length(0.2, False)),
    ],
)
def test_lengths(given, length):
    found = parse_length(given, "max_error")
    assert found.relative == length.relative
    assert found.value == pytest.approx(length.value, rel=1e-15)


def test_a_length_is_a_share_of_the_diagonal():
    assert Length(0.5, False).share(10) == 0.05
    assert Length(0.5, True).share(10) == 0.5
    assert parse_length(None, "max_error") is None


def test_a_length_in_another_unit_is_doubted(caplog):
    assert share_of(Length(0.5, True), "max_error", 10) == 0.5
    assert share_of(Length(0.5, False), "max_error", 10) == 0.05
    assert share_of(None, "max_error", 10) is None
    assert not caplog.messages
    for value in (5.0, 1e-6):
        share_of(Length(value, False), "max_error", 10)
    assert [text.startswith("max_error") and "in the data's unit?" in text for text in caplog.messages] == [True, True]
    with pytest.raises(InputError, match="rms_error 10 is 100 % of the diagonal"):
        share_of(Length(10.0, False), "rms_error", 10)


def test_no_error_is_asked_that_anything_holds():
    with pytest.raises(InputError, match="max_error is 200 % of the diagonal; give a smaller share"):
        share_of(Length(2.0, True), "max_error", 10)


@pytest.mark.parametrize("given", ["", "%", "5%%", "0", "-1", 0.0, "nan", "inf", "1mm", True])
def test_what_is_no_tolerance(given):
    with pytest.raises(InputError, match="rms_error is"):
        parse_length(given, "rms_error")


@pytest.mark.parametrize(
    ("given", "amount"),
    [
        ("2G", 2 * 1024**3),
        ("1500M", 1500 * 1024**2),
        ("1.5 GiB", 1536 * 1024**2),
        ("12kb", 12288),
        (4096, 4096),
        ("7", 7),
    ],
)
def test_amounts_of_memory(given, amount):
    assert parse_bytes(given) == amount


@pytest.mark.parametrize("given", ["", "G", "-1G", 0, "2X", "nan", True, -5])
def test_what_is_no_amount(given):
    with pytest.raises(InputError, match="memory is"):
        parse_bytes(given)


def test_amounts_are_shown_rounded_up():
    assert show_bytes(1) == "1M"
    assert show_bytes(1024**3 * 1.5) == "1.50G"
