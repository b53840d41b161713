"""The page of what was reproduced: every row from a cell, every printed item accounted for."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import groupby
from typing import Any

from medkit.book.coverage import (
    CHAPTERS,
    THESES,
    Item,
    chapter_of_source,
    coverage,
    items_named,
    natural,
)
from medkit.book.notebooks import Executed
from medkit.book.replay import rows_of

Row = dict[str, str]
VERDICTS = ("reproduced", "better", "worse", "contradicted", "not decided", "cannot be rebuilt")
#: What a printed item without a row of its own is called.
DRAWN, LATER, OUTSIDE = "drawn anew", "later", "not rebuilt"
HEADS = ("source", "what is printed", "printed", "ours", "verdict", "cell")


def replay_rows(chapters: Iterable[Executed]) -> list[Row]:
    """Collect what the notebooks' own outputs say was reproduced, with a link to the cell."""
    rows = []
    for chapter in chapters:
        for cell in chapter.node.cells:
            for output in cell.get("outputs", []):
                link = f"{chapter.name}.html#{cell.get('id', '')}"
                for row in rows_of(output.get("data", {})):
                    rows.append({**row, "link": link, "chapter": chapter.title})
    return rows


def departures(stored: list[Row], fresh: list[Row]) -> list[str]:
    """Say which rows of a fresh execution have another verdict than the stored ones.

    Parameters
    ----------
    stored, fresh : list of Row
        `replay_rows` of the notebooks as they are stored, and as they were just executed.

    Returns
    -------
    list of str
        One sentence a row; empty when every value stayed on its side of its interval.
    """

    def keyed(rows: list[Row]) -> dict[tuple[str, str, str], Row]:
        return {(row["chapter"], row["source"], row["quantity"]): row for row in rows}

    before, after = keyed(stored), keyed(fresh)
    said = []
    for key in sorted(before.keys() | after.keys()):
        old, new = before.get(key), after.get(key)
        verdicts = [row["verdict"] if row else "no row" for row in (old, new)]
        if verdicts[0] != verdicts[1]:
            value = f" (ours now {new['ours']}, {new['interval']})" if new else ""
            said.append(f"{key[1]}, {key[2]}: stored {verdicts[0]}, now {verdicts[1]}{value}")
    return said


def status(item: Item, rows: list[Row]) -> list[str]:
    """Verdicts of the rows that name an item; else what it is instead."""
    found = [row["verdict"] for row in rows if item.key in items_named(row["source"])]
    if found:
        return sorted(set(found), key=VERDICTS.index)
    if item.chapters:
        return [DRAWN]
    return [LATER] if item.why_not.startswith("later") else [OUTSIDE]


def replay_html(rows: list[Row], chapters: list[Executed]) -> str:
    """Body of the page: counts, the table of values, the list of all printed items."""
    counts = Counter(row["verdict"] for row in rows)
    theses = Counter(row["source"][:3] for row in rows)
    pages = {chapter.name[:2]: chapter.name for chapter in chapters}
    chips = [_chip("verdict", verdict, counts[verdict]) for verdict in VERDICTS if counts[verdict]]
    chips += ["<span class='gap'></span>"]
    chips += [_chip("thesis", thesis, theses[thesis]) for thesis in THESES if theses[thesis]]
    return (
        "<h1>What was reproduced</h1><p class='lead'>Every row is the stored output of a cell, and"
        " its verdict follows a rule: <em>reproduced</em> when the printed value lies within our"
        " interval, else on which side it lies; the last column leads to the cell. Data that"
        " medkit simulates are called simulated. <a href='#coverage'>Below</a>, every table and"
        " figure of the three theses is listed.</p>"
        f"<p class='chips' id='chips'>{''.join(chips)}<span id='count'>{len(rows)} rows</span></p>"
        f"<table class='replay-page' id='rows'>{_head(HEADS)}{_groups(rows)}</table>"
        f"{_coverage(rows, pages)}<script src='replay.js'></script>"
    )


def _chip(kind: str, value: str, count: int) -> str:
    css = value.replace(" ", "-")
    return (
        f"<span class='chip {css}' data-kind='{kind}' data-value='{value}'>"
        f"<b>{count}</b> {value}</span>"
    )


def _head(heads: tuple[str, ...]) -> str:
    return "<thead><tr>" + "".join(f"<th>{head}</th>" for head in heads) + "</tr></thead>"


def _place(row: Mapping[str, str]) -> tuple[Any, ...]:
    source = row["source"]
    return THESES.index(source[:3]), natural(chapter_of_source(source)), natural(source)


def _groups(rows: list[Row]) -> str:
    parts = []
    ordered = sorted(rows, key=_place)
    for (thesis, chapter), group in groupby(
        ordered, key=lambda row: (row["source"][:3], chapter_of_source(row["source"]))
    ):
        about = html.escape(CHAPTERS.get(thesis, {}).get(chapter, ""))
        parts.append(
            f"<tbody><tr class='group'><th colspan='{len(HEADS)}'>{thesis}, chapter {chapter}:"
            f" {about}</th></tr>{''.join(_row(row) for row in group)}</tbody>"
        )
    return "".join(parts)


def _row(row: Row) -> str:
    e = {name: html.escape(value) for name, value in row.items()}
    note = f"<small>{e['note']}</small>" if row["note"] else ""
    interval = f"<small>{e['interval']}</small>" if row["interval"] else ""
    css = row["verdict"].replace(" ", "-")
    number = row["link"][:2]
    return (
        f"<tr class='{css}' data-verdict='{e['verdict']}' data-thesis='{row['source'][:3]}'>"
        f"<td>{e['source'][4:]}</td><td>{e['quantity']}{note}</td><td>{e['printed']}</td>"
        f"<td>{e['ours']}{interval}</td><td class='verdict'>{e['verdict']}</td>"
        f"<td><a href='{e['link']}' title='{e['chapter']}'>chapter&nbsp;{number}</a></td></tr>"
    )


def _coverage(rows: list[Row], pages: dict[str, str]) -> str:
    items = coverage()
    parts = [
        "<h2 id='coverage'>Every printed table and figure</h2><p>What a row above names has its"
        " verdict; <em>drawn anew</em> means that a chapter makes the picture or table from its own"
        " data without a number to hold against the print.</p>"
    ]
    for thesis in THESES:
        mine = [item for item in items if item.thesis == thesis]
        counts = Counter(status(item, rows)[0] for item in mine)
        told = ", ".join(
            f"{counts[name]} {name}" for name in (*VERDICTS, DRAWN, LATER, OUTSIDE) if counts[name]
        )
        lines = "".join(_item(item, rows, pages) for item in mine)
        head = _head(("item", "what it shows", "verdict", "where, or why not"))
        parts.append(
            f"<details{' open' if thesis != 'R12' else ''}><summary><b>{thesis}</b>: {len(mine)}"
            f" tables and figures ({told})</summary>"
            f"<table class='replay-page coverage'>{head}{lines}</table></details>"
        )
    return "".join(parts)


def _item(item: Item, rows: list[Row], pages: dict[str, str]) -> str:
    verdicts = status(item, rows)
    links = [
        f"<a href='{row['link']}'>chapter&nbsp;{row['link'][:2]}</a>"
        for row in rows
        if item.key in items_named(row["source"])
    ]
    told = {link.rpartition(";")[2][:2] for link in links}
    links += [
        f"<a href='{pages[number]}.html'>chapter&nbsp;{number}</a>"
        for number in item.chapters
        if number in pages and number not in told
    ]
    why = html.escape(item.why_not)
    return (
        f"<tr class='{verdicts[0].replace(' ', '-')}'><td>{item.kind} {item.number}</td>"
        f"<td>{html.escape(item.what)}</td><td class='verdict'>{', '.join(verdicts)}</td>"
        f"<td>{', '.join(dict.fromkeys(links)) or why}</td></tr>"
    )
