"""Laws of the two-contact bound and of the table of materials."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.errors import InputError
from medkit.planar import (
    MATERIALS,
    cone_half_angle,
    is_antipodal,
    material,
    min_friction,
    min_object_angle,
)

FRICTIONS = st.floats(0.0, 10.0)
EXACT = settings(derandomize=True, max_examples=50, deadline=None)


@EXACT
@given(FRICTIONS)
def test_bound_and_its_inverse_agree(friction):
    angle = min_object_angle(friction)
    assert 0.0 < angle <= math.pi
    assert min_friction(angle) == pytest.approx(friction, abs=1e-12)


@EXACT
@given(FRICTIONS, FRICTIONS)
def test_more_friction_never_asks_for_a_larger_angle(first, second):
    low, high = sorted((first, second))
    assert min_object_angle(high) <= min_object_angle(low)


def test_known_values():
    assert min_object_angle(1.0) == pytest.approx(math.pi / 2, abs=1e-15)
    assert min_object_angle(math.tan(math.radians(30))) == pytest.approx(math.radians(120))
    assert min_object_angle(0.0) == math.pi
    assert cone_half_angle(1.0) == pytest.approx(math.pi / 4)


def test_equality_is_not_force_closure():
    bound = min_object_angle(0.5)
    assert not is_antipodal(bound, friction=0.5)
    assert is_antipodal(bound + 1e-9, friction=0.5)


@pytest.mark.parametrize("bad", [-0.1, float("nan"), float("inf"), "much", None])
def test_bad_friction_is_refused(bad):
    with pytest.raises(InputError, match="friction"):
        min_object_angle(bad)


@pytest.mark.parametrize("bad", [0.0, 120.0, -1.0, float("nan")])
def test_bad_angle_is_refused(bad):
    with pytest.raises(InputError, match="object"):
        min_friction(bad)


def test_materials_are_ranges_and_found_in_either_order():
    assert len(MATERIALS) == 8
    assert all(0.0 < pair.low <= pair.high for pair in MATERIALS)
    assert material("wood", "leather") is material("leather", "wood")
    assert material("rubber", "solids").middle == 2.5
    with pytest.raises(InputError, match="wood on metals"):
        material("wood", "ice")
