"""What P13's three experiments test: objects, planners, and the planners' parameters (P13 5.1)."""

from __future__ import annotations

from dataclasses import dataclass

#: The planners that are compared, and P13's names for two of them.
PRINTED_PLANNERS = {"medial": "MAT", "normals": "Berenson07"}


@dataclass(frozen=True)
class Setting:
    """One column of a table: a planner, the kind of grasp, and the medial planner's parameters."""

    planner: str
    grasp: str = "power"
    search_radius: float = 0.03
    min_radius_ratio: float = 0.0


@dataclass(frozen=True)
class Experiment:
    """Objects (name, scale) and settings of one of P13's experiments."""

    title: str
    objects: tuple[tuple[str, float], ...]
    settings: tuple[Setting, ...]


_LARGE = ("glasses", "ant", "chair", "fish_large", "bird", "figure", "bust", "amphora", "teapot",
          "giraffe")  # fmt: skip
_HAND = ("clown", "elephant", "fish", "gnome", "dog", "sitting_cat", "lying_cat", "moon", "seal",
         "star")  # fmt: skip
_PRECISION = (("clown", 1.0), ("elephant", 1.0), ("fish", 1.0), ("moon", 1.0), ("seal", 1.0),
              ("glasses", 0.25), ("giraffe", 0.25))  # fmt: skip
#: P13 5.1.4 to 5.1.6, with the improved planner and the box baseline beside.
EXPERIMENTS = {
    1: Experiment(
        "power grasps, large objects",
        tuple((name, 1.0) for name in _LARGE),
        (
            Setting("medial", "power", 0.06),
            Setting("medial-plus", "power", 0.06),
            Setting("normals"),
            Setting("boxes"),
        ),
    ),
    2: Experiment(
        "power grasps, hand-sized objects",
        tuple((name, 1.0) for name in _HAND),
        (
            *(
                Setting("medial", "power", radius, ratio)
                for radius in (0.01, 0.03)
                for ratio in (0.0, 0.3, 0.5, 0.7)
            ),
            *(Setting("medial-plus", "power", 0.03, ratio) for ratio in (0.0, 0.3, 0.5, 0.7)),
            Setting("normals"),
            Setting("boxes"),
        ),
    ),
    3: Experiment(
        "precision grasps",
        _PRECISION,
        (
            *(
                Setting("medial", "precision", radius, ratio)
                for radius in (0.01, 0.03)
                for ratio in (0.0, 0.3)
            ),
            *(Setting("medial-plus", "precision", radius, 0.3) for radius in (0.01, 0.03)),
            Setting("normals", "precision"),
            Setting("boxes", "precision"),
        ),
    ),
}
