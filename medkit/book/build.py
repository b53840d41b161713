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
from medkit.book.replay_page import VERDICTS, Row, replay_html, replay_rows

LIBRARIES = ("numpy", "scipy", "trimesh", "pymunk", "pandas", "statsmodels", "matplotlib")
REPLAY = "What was reproduced"
#: Pages written by hand, in `docs/`, that belong to the book.
DOCUMENTS = ("glossary.md", "notation.md", "references.md", "environment.md")


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


def _write_pages(chapters: list[Executed], documents: list[Path], draft: Path) -> None:
    titles = {document.stem: _first_heading(document) for document in documents}
    page = _page_maker(chapters, titles)
    (draft / "book.css").write_text(_shipped("book.css") + code_css(), encoding="utf-8")
    (draft / "replay.js").write_text(_shipped("replay.js"), encoding="utf-8")
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
    (draft / "replay.html").write_text(
        page(REPLAY, replay_html(rows, chapters), "wide"), encoding="utf-8"
    )
    (draft / "index.html").write_text(page("medkit", _index(chapters, rows)), encoding="utf-8")
    texts = {f"{c.name}.html": (c.title, notebook_text(c.node)) for c in chapters}
    texts |= {f"{d.stem}.html": (titles[d.stem], d.read_text("utf-8")) for d in documents}
    texts["replay.html"] = (REPLAY, " ".join(f"{r['source']} {r['quantity']}" for r in rows))
    entries = [{"page": name, "title": t, "text": text} for name, (t, text) in texts.items()]
    index = json.dumps(entries, ensure_ascii=False).replace("</", "<\\/")
    (draft / "search.js").write_text(
        f"const PAGES = {index};\n{_shipped('search.js')}", encoding="utf-8"
    )


def _shipped(name: str) -> str:
    return files("medkit.book").joinpath(name).read_text(encoding="utf-8")


def _page_maker(chapters: list[Executed], documents: dict[str, str]) -> Callable[..., str]:
    links = [
        "<a class='home' href='index.html'>medkit</a>",
        "<input id='search' type='search' placeholder='search the book'"
        " aria-label='search the book'><ol id='found'></ol>",
    ]
    for chapter, group in groupby(chapters, key=lambda c: chapter_of(c.name)):
        links.append(f"<h2>{html.escape(chapter)}</h2>")
        links += [f"<a href='{c.name}.html'>{html.escape(c.title)}</a>" for c in group]
    links.append("<h2>Beside the chapters</h2><a href='replay.html'>" + REPLAY + "</a>")
    links += [f"<a href='{name}.html'>{html.escape(text)}</a>" for name, text in documents.items()]
    navigation = "\n".join(links)

    def page(title: str, body: str, kind: str = "text") -> str:
        return (
            "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
            "<meta name='viewport' content='width=device-width, initial-scale=1'>"
            f"<title>{html.escape(title)}</title><link rel='stylesheet' href='book.css'></head>"
            f"<body><nav>{navigation}</nav><main class='{kind}'>{body}</main>"
            "<script src='search.js'></script></body></html>\n"
        )

    return page


def _index(chapters: list[Executed], rows: list[Row]) -> str:
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
