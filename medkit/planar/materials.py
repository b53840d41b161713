"""Coefficients of static friction of a few pairs of materials, as the thesis prints them."""

from __future__ import annotations

from dataclasses import dataclass

from medkit.errors import InputError


@dataclass(frozen=True)
class MaterialPair:
    """Two materials and the range of their coefficient of static friction.

    Attributes
    ----------
    first, second : str
        Names of the materials.
    low, high : float
        Smallest and largest printed coefficient of static friction [1]; equal when one number
        is printed.
    """

    first: str
    second: str
    low: float
    high: float

    @property
    def name(self) -> str:
        """Both names, for example ``"wood on metals"``."""
        return f"{self.first} on {self.second}"

    @property
    def middle(self) -> float:
        """Middle of the printed range [1]."""
        return 0.5 * (self.low + self.high)


#: P13 table 4.1, which quotes Murray, Li and Sastry 1994.
MATERIALS = (
    MaterialPair("steel", "steel", 0.58, 0.58),
    MaterialPair("polyethylene", "steel", 0.3, 0.35),
    MaterialPair("polyethylene", "polyethylene", 0.5, 0.5),
    MaterialPair("rubber", "solids", 1.0, 4.0),
    MaterialPair("wood", "wood", 0.25, 0.5),
    MaterialPair("wood", "metals", 0.2, 0.6),
    MaterialPair("wood", "leather", 0.3, 0.4),
    MaterialPair("leather", "metals", 0.6, 0.6),
)


def material(first: str, second: str) -> MaterialPair:
    """Look a pair of materials up, in either order.

    Parameters
    ----------
    first, second : str
        Names as in the table.

    Returns
    -------
    MaterialPair
        The printed range of the coefficient of static friction.

    Raises
    ------
    InputError
        If the table has no such pair.

    Examples
    --------
    >>> material("metals", "wood").high
    0.6
    """
    for pair in MATERIALS if isinstance(first, str) and isinstance(second, str) else ():
        if {first, second} == {pair.first, pair.second}:
            return pair
    known = ", ".join(pair.name for pair in MATERIALS)
    raise InputError(
        f"Expected a pair of materials of the table, but got {first!r} and {second!r};"
        f" choose one of: {known}."
    )
