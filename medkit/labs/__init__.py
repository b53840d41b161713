"""Labs: exercises that check themselves, and the instructor's grading of a folder of them.

The same check runs for the student in the notebook, in CI against the solution, and for the
instructor with hidden cases. A check tests properties, so that every right answer passes, and it
hints at the usual mistake.

Examples
--------
>>> import numpy as np
>>> check("planar-2", lambda friction: np.pi - 2 * np.arctan(friction))
planar-2 passed
>>> check("planar-2", lambda friction: np.pi - np.arctan(friction)).hint[:23]
'the bound is too large:'
"""

from medkit.labs.exercise import Exercise, Verdict
from medkit.labs.registry import check, exercises_of, lab_names

__all__ = ["Exercise", "Verdict", "check", "exercises_of", "lab_names"]
