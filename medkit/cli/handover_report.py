"""The report of ``medkit handover --html``: one file, its figures inside, no network."""

from __future__ import annotations

import base64
import html
import io
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import pandas as pd

from medkit.files import write_text
from medkit.handover import describe_trials, iso_score, subject_estimates
from medkit.viz.handover_figures import figure_boxes_of_all, figure_maps_of_all
from medkit.viz.handover_results import figure_iso_score, figure_recommendation, plot_claims
from medkit.viz.style import use_house_style

_STYLE = (
    "body{font:16px/1.5 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;"
    "color:#222}table{border-collapse:collapse;font-size:14px;display:block;overflow-x:auto}"
    "td,th{padding:.25em .7em;border-bottom:1px solid #ddd;text-align:left}"
    "img{max-width:100%}figcaption{color:#555;font-size:14px}"
)
_RULE = (
    "A claim is supported when the 95 % interval lies on its side of zero and the permutation p"
    " value, corrected for all claims, is below 0.05; contradicted when the interval lies on the"
    " other side; else these data do not decide it. The interval treats each subject as one"
    " observation, so it speaks of people like these; the narrower one speaks of these subjects."
)


def write_report(
    path: str, trials: pd.DataFrame, table: pd.DataFrame, slope: pd.DataFrame,
    force: pd.DataFrame, *, level: float,
) -> None:  # fmt: skip
    """Write the report as one HTML file, whole or not at all.

    Parameters
    ----------
    path : str
        Where it appears.
    trials, table, slope, force : pandas.DataFrame
        Trials, claims, slopes and recommendation.
    level : float
        Expected score.
    """
    with matplotlib.rc_context():
        matplotlib.use("agg")
        use_house_style()
        figures = _figures(trials, table, force, level)
    blocks = [
        f"<h1>Handover ratings</h1><p>{html.escape(describe_trials(trials))}</p>",
        _figure(figures[0], "Mean score over weight and release force."),
        _figure(figures[1], "Scores of the cells at every release force; diamonds are means."),
        f"<h2>Claims</h2><p>{_RULE}</p>{_table(table)}",
        _figure(figures[2], "Black: interval for people. Blue: for these subjects. Circles: each"
                            " subject (claim 5: each pose and mode)."),
        f"<h2>Release force at a score of {level:g}</h2>{_table(slope)}",
        _figure(figures[3], "Band: 95 % interval for people like these."),
        f"<h2>Recommendation</h2>{_table(force)}",
        _figure(figures[4], "Safety asks for more force, naturalness for less."),
    ]  # fmt: skip
    write_text(
        path,
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>Handover ratings"
        f"</title><style>{_STYLE}</style></head><body>{''.join(blocks)}</body></html>\n",
    )


def _figures(
    trials: pd.DataFrame, table: pd.DataFrame, force: pd.DataFrame, level: float
) -> list[str]:
    _, ax = plt.subplots(figsize=(7.5, 4.6))
    subject = next(
        (text.split()[1] for text in table["claim"] if text.startswith("subject ")), "T4"
    )
    plot_claims(table, estimates=subject_estimates(trials, subject=subject), ax=ax)
    drawn = [
        figure_maps_of_all(trials), figure_boxes_of_all(trials), ax.figure,
        figure_iso_score(iso_score(trials, level), level=level), figure_recommendation(force),
    ]  # fmt: skip
    return [_encoded(figure) for figure in drawn]


def _encoded(figure: Any) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    plt.close(figure)
    return base64.b64encode(buffer.getvalue()).decode("ascii")


def _figure(data: str, caption: str) -> str:
    text = html.escape(caption)
    return (
        f"<figure><img alt='{text}' src='data:image/png;base64,{data}'>"
        f"<figcaption>{text}</figcaption></figure>"
    )


def _table(frame: pd.DataFrame) -> str:
    return str(frame.to_html(float_format="{:.3g}".format, border=0, na_rep="no data"))
