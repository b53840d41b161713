"""The book: notebooks executed and linked, an index, the replay page, a search, all offline."""

from __future__ import annotations

import html
import json
import platform
import shutil
import tempfile
from collections.abc import Callable, Iterable
from importlib.metadata import version
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from typing import Any

from medkit.book.notebooks import Executed, chapter_of
from medkit.book.pages import code_css, markdown_html, notebook_html, notebook_text
from medkit.book.replay import MIME

LIBRARIES = ("numpy", "scipy", "trimesh", "pymunk", "pandas", "statsmodels", "matplotlib")
#: Pages written by hand, in `docs/`, that belong to the book.
DOCUMENTS = ("glossary.md", "notation.md", "references.md", "environment.md")
VERDICTS = ("reproduced", "better", "worse", "contradicted", "not decided", "cannot be rebuilt")


def write_book(executed: Iterable[Executed], documents: list[Path], out: Path) -> Path:
    """Write the book into the folder `out` and return the path of its index page.

    Parameters
    ----------
    executed : iterable of Executed
        The chapters, in any order.
    documents : list of Path
        Markdown files that become pages of their own.
    out : Path
        Folder of the book. It is replaced as a whole, or left as it was.

    Returns
    -------
    Path
        ``out/index.html``.
    """
    chapters = sorted(executed, key=lambda chapter: chapter.name)
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=".book-") as folder:
        draft = Path(folder) / "book"
        draft.mkdir()
        _write_pages(chapters, documents, draft)
        if out.exists():
            shutil.rmtree(out)
        draft.rename(out)
    return out / "index.html"


def replay_rows(chapters: list[Executed]) -> list[dict[str, str]]:
    """Collect what the notebooks' own outputs say was reproduced, with a link to the cell."""
    rows = []
    for chapter in chapters:
        for cell in chapter.node.cells:
            for output in cell.get("outputs", []):
                data = output.get("data", {})
                if MIME in data:
                    link = f"{chapter.name}.html#{cell.get('id', '')}"
                    rows.append({**data[MIME], "link": link, "chapter": chapter.title})
    return rows


def _write_pages(chapters: list[Executed], documents: list[Path], draft: Path) -> None:
    titles = {document.stem: _first_heading(document) for document in documents}
    page = _page_maker(chapters, titles)
    style = files("medkit.book").joinpath("book.css").read_text(encoding="utf-8")
    script = files("medkit.book").joinpath("search.js").read_text(encoding="utf-8")
    (draft / "book.css").write_text(style + code_css(), encoding="utf-8")
    for previous, chapter, following in _neighbours(chapters):
        body = notebook_html(chapter.node) + _how_computed(chapter) + _steps(previous, following)
        (draft / f"{chapter.name}.html").write_text(page(chapter.title, body), encoding="utf-8")
    for document in documents:
        body = markdown_html(document.read_text(encoding="utf-8"))
        (draft / f"{document.stem}.html").write_text(
            page(titles[document.stem], f"<section class='prose'>{body}</section>"),
            encoding="utf-8",
        )
    rows = replay_rows(chapters)
    (draft / "replay.html").write_text(page("What was reproduced", _replay(rows)), encoding="utf-8")
    (draft / "index.html").write_text(page("medkit", _index(chapters, rows)), encoding="utf-8")
    entries = [
        {"page": f"{c.name}.html", "title": c.title, "text": notebook_text(c.node)}
        for c in chapters
    ] + [
        {"page": f"{d.stem}.html", "title": titles[d.stem], "text": d.read_text(encoding="utf-8")}
        for d in documents
    ]
    index = json.dumps(entries, ensure_ascii=False).replace("</", "<\\/")
    (draft / "search.js").write_text(f"const PAGES = {index};\n{script}", encoding="utf-8")


def _page_maker(chapters: list[Executed], documents: dict[str, str]) -> Callable[[str, str], str]:
    links = [
        "<a class='home' href='index.html'>medkit</a>",
        "<input id='search' type='search' placeholder='search the book'"
        " aria-label='search the book'><ol id='found'></ol>",
    ]
    for chapter, group in groupby(chapters, key=lambda c: chapter_of(c.name)):
        links.append(f"<h2>{html.escape(chapter)}</h2>")
        links += [f"<a href='{c.name}.html'>{html.escape(c.title)}</a>" for c in group]
    links.append("<h2>Beside the chapters</h2><a href='replay.html'>What was reproduced</a>")
    links += [f"<a href='{name}.html'>{html.escape(text)}</a>" for name, text in documents.items()]
    navigation = "\n".join(links)

    def page(title: str, body: str) -> str:
        return (
            "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
            "<meta name='viewport' content='width=device-width, initial-scale=1'>"
            f"<title>{html.escape(title)}</title><link rel='stylesheet' href='book.css'></head>"
            f"<body><nav>{navigation}</nav><main>{body}</main>"
            "<script src='search.js'></script></body></html>\n"
        )

    return page


def _index(chapters: list[Executed], rows: list[dict[str, str]]) -> str:
    parts = [
        "<h1>medkit</h1><p class='lead'>Robot grasping and handover, chapter by chapter: every"
        " page below is a notebook that was executed from scratch to make it.</p>"
    ]
    counts = {verdict: sum(row["verdict"] == verdict for row in rows) for verdict in VERDICTS}
    told = ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count)
    parts.append(
        f"<p>Held against the theses: <a href='replay.html'>{len(rows)} printed values and"
        f" figures</a> ({told or 'none yet'}).</p>"
    )
    for chapter, group in groupby(chapters, key=lambda c: chapter_of(c.name)):
        parts.append(f"<h2>{html.escape(chapter)}</h2><div class='cards'>")
        for item in group:
            picture = _first_picture(item.node)
            parts.append(
                f"<a class='card' href='{item.name}.html'>{picture}"
                f"<span>{html.escape(item.title)}</span></a>"
            )
        parts.append("</div>")
    return "\n".join(parts)


def _replay(rows: list[dict[str, str]]) -> str:
    heads = ("source", "quantity", "printed", "ours", "interval", "verdict", "note")
    lines = ["<h1>What was reproduced</h1><p>Every row comes from the stored output of a cell; the"
             " last column leads there. Data that medkit simulates are called simulated in the"
             " note.</p><table class='replay-page'><tr>"]  # fmt: skip
    lines += [f"<th>{head}</th>" for head in heads] + ["<th>cell</th></tr>"]
    for row in sorted(rows, key=lambda row: row["source"]):
        kind = row["verdict"].replace(" ", "-")
        cells = "".join(f"<td>{html.escape(row[head])}</td>" for head in heads)
        link = f"<a href='{row['link']}'>{html.escape(row['chapter'])}</a>"
        lines.append(f"<tr class='{kind}'>{cells}<td>{link}</td></tr>")
    return "".join(lines) + "</table>"


def _how_computed(chapter: Executed) -> str:
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return (
        f"<footer>Computed with medkit {version('medkit')}, Python {platform.python_version()},"
        f" {libraries}; executed from top to bottom in {chapter.seconds:.0f} s. Random numbers come"
        " from generators whose seeds stand in the cells.</footer>"
    )


def _steps(previous: Executed | None, following: Executed | None) -> str:
    def link(chapter: Executed | None, arrow: str) -> str:
        if chapter is None:
            return "<span></span>"
        return f"<a href='{chapter.name}.html'>{arrow} {html.escape(chapter.title)}</a>"

    return f"<div class='steps'>{link(previous, '&larr;')}{link(following, '&rarr;')}</div>"


def _neighbours(
    chapters: list[Executed],
) -> list[tuple[Executed | None, Executed, Executed | None]]:
    padded: list[Any] = [None, *chapters, None]
    return [(padded[i - 1], padded[i], padded[i + 1]) for i in range(1, len(padded) - 1)]


def _first_picture(node: Any) -> str:
    for cell in node.cells:
        for output in cell.get("outputs", []):
            if "image/png" in output.get("data", {}):
                return (
                    f"<img alt='' src='data:image/png;base64,{output.data['image/png'].strip()}'>"
                )
    return ""


def _first_heading(document: Path) -> str:
    for line in document.read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            return line[2:].strip()
    return document.stem
