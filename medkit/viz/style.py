"""The house style of every figure: colours that survive grey and colour blindness, sizes, units."""

from __future__ import annotations

from typing import Any

#: Okabe-Ito colours, ordered so that neighbours also differ in grey.
BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE, YELLOW, BLACK = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7", "#F0E442", "#000000",
)  # fmt: skip
CYCLE = (BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE)
MARKERS = ("o", "s", "^", "D", "v", "P")
SEQUENTIAL = "cividis"
DIVERGING = "RdBu_r"
OBJECT_GREY = "#B8B8B8"


def use_house_style() -> None:
    """Set matplotlib's defaults to the house style; called once at the top of a notebook."""
    import matplotlib as mpl
    from cycler import cycler

    mpl.rcParams.update(
        {
            "figure.figsize": (6.4, 4.0),
            "figure.dpi": 100,
            "savefig.dpi": 100,
            "figure.constrained_layout.use": True,
            "font.size": 10,
            "font.family": "DejaVu Sans",
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.grid": True,
            "axes.axisbelow": True,
            "axes.titlesize": 11,
            "axes.titlelocation": "left",
            "grid.color": "#DDDDDD",
            "grid.linewidth": 0.6,
            "legend.frameon": False,
            "lines.linewidth": 1.8,
            "axes.prop_cycle": cycler(color=list(CYCLE)) + cycler(marker=list(MARKERS)),
            "lines.markersize": 4,
            "image.cmap": SEQUENTIAL,
        }
    )


def axes_or_new(ax: Any = None, **subplot_kw: Any) -> Any:
    """Return `ax`, or the axes of a new figure when it is None."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(subplot_kw=subplot_kw)[1]
