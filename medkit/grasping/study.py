"""P13's three experiments in full, as stored tables: 300 candidates an object take minutes.

``python -m medkit.grasping.study`` makes the tables anew. A chapter reads them, and tests one
object again to see that they still hold.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from medkit.errors import InputError
from medkit.files import write_text
from medkit.grasping.grasp_set import OUTCOMES
from medkit.grasping.settings import EXPERIMENTS, Experiment
from medkit.grasping.yields import COLUMNS

if TYPE_CHECKING:
    import pandas as pd

#: Candidates of each object and setting: about as many as P13 tests (5.1.3).
CANDIDATES = 300
HAND = "armar3"
STORED = ("object", *COLUMNS, "tested", *OUTCOMES)


def load_study(experiment: int) -> pd.DataFrame:
    """Counts of one of P13's experiments on our objects, as `study` stored them.

    Parameters
    ----------
    experiment : int
        1, 2 or 3: see `medkit.grasping.settings.EXPERIMENTS`.

    Returns
    -------
    pandas.DataFrame
        One row for each object and setting, without times: ``object``, the setting's four columns,
        ``tested``, and the number of candidates that ended in each outcome.

    Raises
    ------
    InputError
        If there is no such experiment.

    Notes
    -----
    Simulated: the ARMAR-III hand, objects made by code, friction 0.5, candidates drawn with seed 0
    (P13 5.1). ``tested`` says how many.

    Examples
    --------
    >>> table = load_study(1)
    >>> len(table), sorted(set(table.planner))
    (40, ['boxes', 'medial', 'medial-plus', 'normals'])
    """
    import pandas as pd

    _known(experiment)
    file = resources.files("medkit.datasets") / "studies" / f"experiment_{experiment}.csv"
    with file.open("r", encoding="utf-8") as text:
        return pd.read_csv(text)


def study(
    experiment: int,
    *,
    candidates_per_object: int = CANDIDATES,
    objects: Sequence[str] | None = None,
    jobs: int = 1,
    cache: bool = True,
    progress: Callable[[str], None] | None = None,
) -> pd.DataFrame:
    """Run one of P13's experiments on the objects made by code.

    Parameters
    ----------
    experiment : int
        1, 2 or 3.
    candidates_per_object : int
        Candidates tested at most for each object and setting.
    objects : sequence of str, optional
        Some of the experiment's objects; all of them when left out.
    jobs : int
        Objects tested at a time.
    cache : bool
        Keep each object's counts in the user's cache.
    progress : callable, optional
        Called with the name of each object when its counts are there.

    Returns
    -------
    pandas.DataFrame
        As `load_study` returns it.

    Raises
    ------
    InputError
        If there is no such experiment, or the experiment has no such object.
    """
    from medkit.datasets import load_object
    from medkit.grasping.experiments import run_experiment
    from medkit.robots import load_hand

    scales = dict(_known(experiment).objects)
    wanted = list(scales) if objects is None else list(objects)
    if unknown := [name for name in wanted if name not in scales]:
        raise InputError(
            f"Expected objects of experiment {experiment} ({', '.join(scales)}), but got"
            f" {', '.join(unknown)}; name some of these."
        )
    counts = run_experiment(
        [(name, load_object(name, scale=scales[name])) for name in wanted],
        load_hand(HAND),
        EXPERIMENTS[experiment].settings,
        candidates_per_object=candidates_per_object,
        cache=cache,
        jobs=jobs,
        progress=progress,
    )
    return counts[list(STORED)]


def _known(experiment: int) -> Experiment:
    if experiment not in EXPERIMENTS:
        raise InputError(
            f"Expected experiment {', '.join(map(str, EXPERIMENTS))}, but got {experiment!r};"
            " name one of these."
        )
    return EXPERIMENTS[experiment]


def _tell(name: str) -> None:
    sys.stderr.write(f"{name}\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Make the stored tables anew; exit status 2 on bad input."""
    parser = argparse.ArgumentParser(prog="python -m medkit.grasping.study", description=__doc__)
    parser.add_argument("experiments", nargs="*", type=int, help="1, 2, 3 (default: all)")
    parser.add_argument("--candidates", type=int, default=CANDIDATES)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument(
        "--out", type=Path, default=Path(str(resources.files("medkit.datasets"))) / "studies"
    )
    args = parser.parse_args(argv)
    try:
        for number in args.experiments or EXPERIMENTS:
            counts = study(
                number, candidates_per_object=args.candidates, jobs=args.jobs, progress=_tell
            )
            write_text(args.out / f"experiment_{number}.csv", counts.to_csv(index=False))
    except InputError as error:
        sys.stderr.write(f"medkit.grasping.study: {error}\n")
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
