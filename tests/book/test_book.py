"""The book opens offline, links only to what exists, and collects verdicts that rules gave."""

import json
import re
from pathlib import Path

import nbformat
import pytest

from medkit.book import replay, replay_missing, replay_statement
from medkit.book.build import write_book
from medkit.book.notebooks import (
    Executed,
    chapter_of,
    execute,
    find_notebooks,
    normalised,
    read,
)
from medkit.book.pages import markdown_html, notebook_html
from medkit.book.replay import rows_of
from medkit.book.replay_page import replay_rows
from medkit.errors import InputError


def chapter(folder, name, *cells):
    node = nbformat.v4.new_notebook(cells=list(cells))
    path = Path(folder) / f"{name}.ipynb"
    nbformat.write(node, path)
    return path


def heading(text):
    return nbformat.v4.new_markdown_cell(f"# {text}\n\nWith $\\alpha > \\pi - 2\\arctan\\mu$.")


def code(source):
    return nbformat.v4.new_code_cell(source)


def test_the_verdict_follows_its_rule():
    held = {"low": 0.9, "high": 1.1, "ours": 1.0}
    assert replay("s", "q", printed=1.05, **held).verdict == "reproduced"
    assert replay("s", "q", printed=2.0, **held).verdict == "contradicted"
    assert replay("s", "q", printed=2.0, better="lower", **held).verdict == "better"
    assert replay("s", "q", printed=2.0, better="higher", **held).verdict == "worse"
    assert replay("s", "q", printed=0.5, better="higher", **held).verdict == "better"
    assert replay_statement("s", "q", holds=True, evidence="e").verdict == "reproduced"
    assert replay_statement("s", "q", holds=None, evidence="e").verdict == "not decided"
    assert replay_missing("s", "q", printed="3", why="no data").verdict == "cannot be rebuilt"
    with pytest.raises(InputError, match="interval"):
        replay("s", "q", printed=1.0, ours=2.0, low=0.0, high=1.0)


def test_a_book_of_two_chapters_opens_offline(tmp_path):
    chapter(
        tmp_path, "11_first", heading("Is one smaller than two?"),
        code("from medkit.book import replay\n"
             "replay('P13 1.1', 'one', printed=1, ours=1, low=0.9, high=1.1)"),
    )  # fmt: skip
    chapter(tmp_path, "12_second", heading("And <three>?"), code("print('[12](11_first.ipynb)')"))
    chapters = [execute(path) for path in find_notebooks(tmp_path)]
    document = tmp_path / "notation.md"
    document.write_text("# Notation\n\nSee [the first](../notebooks/11_first.ipynb).")
    index = write_book(chapters, [document], tmp_path / "out")
    pages = {page.name: page.read_text() for page in index.parent.glob("*.html")}
    assert set(pages) == {
        "index.html", "replay.html", "11_first.html", "12_second.html", "notation.html",
    }  # fmt: skip
    for text in pages.values():
        assert not re.search(r"<(script|link|img)[^>]+(src|href)=['\"]https?:", text)
        for target in re.findall(r"href='([^'#:]+)", text):
            assert (index.parent / target).exists(), target
    assert "<math" in pages["11_first.html"]
    assert 'href="11_first.html"' in pages["notation.html"]
    assert "&lt;three&gt;" in pages["index.html"]
    assert replay_rows(chapters)[0]["link"] == "11_first.html#cell-01"
    assert "reproduced" in pages["replay.html"]
    found = json.loads((index.parent / "search.js").read_text().split(";\n")[0].split(" = ")[1])
    assert {entry["page"] for entry in found} >= {"11_first.html", "notation.html"}


def test_a_failing_chapter_leaves_the_old_book_alone(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "index.html").write_text("old")
    path = chapter(tmp_path, "11_broken", heading("Broken?"), code("1 / 0"))
    with pytest.raises(InputError, match="ZeroDivisionError"):
        write_book((execute(p) for p in [path]), [], out)
    assert (out / "index.html").read_text() == "old"
    assert list(tmp_path.glob(".book-*")) == []


def test_no_heading_and_no_notebooks_are_said(tmp_path):
    with pytest.raises(InputError, match="numbered notebooks"):
        find_notebooks(tmp_path)
    nameless = Executed(tmp_path / "11_x.ipynb", nbformat.v4.new_notebook(cells=[code("1")]), 0.0)
    with pytest.raises(InputError, match="heading"):
        _ = nameless.title


def test_stored_notebooks_do_not_depend_on_the_run(tmp_path):
    path = chapter(tmp_path, "11_same", heading("Same?"), code("print(1)\nprint(2)"))
    first, second = (json.dumps(execute(path).node, sort_keys=True) for _ in range(2))
    assert first == second


def test_widgets_leave_a_note_and_errors_stay_visible():
    cell = code("x")
    view = {"application/vnd.jupyter.widget-view+json": {}, "text/plain": "interactive(...)"}
    cell.outputs = [
        nbformat.v4.new_output("display_data", data=view),
        nbformat.v4.new_output("error", ename="ValueError", evalue="<b>", traceback=[]),
    ]
    page = notebook_html(normalised(nbformat.v4.new_notebook(cells=[cell])))
    assert "control moves" in page
    assert "&lt;b&gt;" in page


def test_headings_can_be_linked_to_and_chapters_are_named():
    assert '<h2 id="what-was-learned">' in markdown_html("## What was learned")
    assert chapter_of("31_power_grasps") == "Grasps"


def test_every_replay_row_of_the_stored_chapters_is_complete():
    root = Path(__file__).parents[2] / "notebooks"
    stored = [Executed(p, nbformat.read(p, as_version=4), 0.0) for p in find_notebooks(root)]
    rows = replay_rows(stored)
    assert len(rows) > 0
    for row in rows:
        assert row["verdict"] in {
            "reproduced", "better", "worse", "contradicted", "not decided", "cannot be rebuilt",
        }  # fmt: skip
        assert row["source"].startswith(("P13", "R12", "L14")), row
    for cell_output in (c for s in stored for c in s.node.cells if c.cell_type == "code"):
        for output in cell_output.outputs:
            for row in rows_of(output.get("data", {})):
                assert set(row) >= {"source", "quantity", "printed", "ours"}


def test_every_link_between_stored_notebooks_leads_somewhere():
    root = Path(__file__).parents[2] / "notebooks"
    notebooks = [*find_notebooks(root), *sorted((root / "labs").glob("*.ipynb"))]
    for path in notebooks:
        for cell in nbformat.read(path, as_version=4).cells:
            if cell.cell_type == "markdown":
                for target in re.findall(r"\]\((?!https?:)([^)#]+\.(?:ipynb|md))", cell.source):
                    assert (path.parent / target).exists(), f"{path.name} links to {target}"


def test_stored_notebooks_name_no_machine_and_keep_their_size():
    root = Path(__file__).parents[2] / "notebooks"
    for path in root.rglob("*.ipynb"):
        text = path.read_text(encoding="utf-8")
        assert len(text) < 1.5e6, path.name
        assert not re.search(r"/(home|root|tmp|usr|work)/|site-packages", text), path.name


def test_a_notebook_that_is_none_gets_one_sentence(tmp_path):
    other = tmp_path / "other.ipynb"
    other.write_text("no notebook")
    for path in (tmp_path / "missing.ipynb", tmp_path, other):
        with pytest.raises(InputError, match="Expected a notebook"):
            read(path)
