"""What was reproduced: rows agree with their rule, changes are noticed, nothing printed is lost."""

import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import nbformat
import pytest

from medkit.book.coverage import chapter_of_source, coverage, items_named
from medkit.book.notebooks import Executed, find_notebooks
from medkit.book.replay import MIME, replay, replay_table, rows_of
from medkit.book.replay_page import VERDICTS, departures, replay_html, replay_rows, status
from medkit.errors import InputError

ROOT = Path(__file__).parents[2]
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
ROW = "replay('P13 table 5.1', 'mean yield', printed=73.2, ours={ours}, low={low}, high={high})"
HELD = {"ours": 70.0, "low": 55.8, "high": 83.3}
LEFT = {"ours": 60.0, "low": 55.8, "high": 63.3}


@pytest.fixture(scope="module")
def stored():
    paths = find_notebooks(ROOT / "notebooks")
    return [Executed(path, nbformat.read(path, as_version=4), 0.0) for path in paths]


def chapter(path, stored, code):
    """Store the output of one row under the code of another, as after a change of the package."""
    source = f"from medkit.book import replay\n{ROW.format(**code)}"
    data = eval(ROW.format(**stored), {"replay": replay})._repr_mimebundle_()
    output = nbformat.v4.new_output("execute_result", data=data, execution_count=1)
    cell = nbformat.v4.new_code_cell(source, outputs=[output], execution_count=1)
    node = nbformat.v4.new_notebook(cells=[nbformat.v4.new_markdown_cell("# Yield?"), cell])
    nbformat.write(node, path)
    return Executed(path, nbformat.read(path, as_version=4), 0.0)


def test_a_value_that_leaves_its_interval_fails_the_notebook_check(tmp_path):
    chapter(tmp_path / "36_stays.ipynb", HELD, HELD)
    chapter(tmp_path / "37_leaves.ipynb", HELD, LEFT)
    command = [
        sys.executable, "-m", "pytest", "-p", "no:doctest", "-p", "no:cacheprovider", "--nbval",
        "-rA", "--nbval-sanitize-with", str(ROOT / "tests" / "nbval_sanitize.cfg"), str(tmp_path),
    ]  # fmt: skip
    told = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert told.returncode == 1
    assert "contradicted" in told.stdout
    assert re.search(r"PASSED \S*36_stays", told.stdout)
    assert re.search(r"FAILED \S*37_leaves", told.stdout)


def test_a_changed_verdict_is_named(tmp_path):
    path = tmp_path / "36_yield.ipynb"
    before, after = (replay_rows([chapter(path, value, value)]) for value in (HELD, LEFT))
    assert departures(before, before) == []
    assert departures(before, after) == [
        "P13 table 5.1, mean yield: stored reproduced, now contradicted (ours now 60, 55.8 to 63.3)"
    ]
    assert "now no row" in departures(before, [])[0]


def numbers(text):
    return [float(number) for number in NUMBER.findall(text.replace(" to ", " "))]


def test_every_stored_row_agrees_with_the_rule_of_its_verdict(stored):
    held = 0
    for row in replay_rows(stored):
        assert row["verdict"] in VERDICTS, row
        if not row["interval"]:
            statement = {"reproduced", "contradicted", "not decided"}
            assert row["verdict"] in ({"cannot be rebuilt"} if not row["ours"] else statement), row
            assert row["ours"] or row["note"], row
            continue
        printed, ours = numbers(row["printed"])[0], numbers(row["ours"])[0]
        low, high = numbers(row["interval"])[:2]
        # the numbers are rounded alike, which keeps their order but may make two of them equal
        assert low <= ours <= high, row
        if row["verdict"] == "reproduced":
            assert low <= printed <= high, row
        else:
            assert printed <= low or printed >= high, row
        held += 1
    assert held >= 10


def test_every_item_that_a_row_names_is_in_the_list(stored):
    known = {item.key for item in coverage()}
    for row in replay_rows(stored):
        assert chapter_of_source(row["source"]), row["source"]
        for key in items_named(row["source"]):
            assert key in known, row["source"]
        if re.search(r"\b(fig|table)\w*\.? [\dA]", row["source"]):
            assert items_named(row["source"]), row["source"]


def test_the_list_has_no_gap_and_every_item_a_place_or_a_reason(stored):
    items = coverage()
    keys = [item.key for item in items]
    assert len(set(keys)) == len(keys)
    assert Counter(item.thesis for item in items) == {"P13": 69, "L14": 66, "R12": 58}
    last = Counter()
    for item in items:
        place = (item.thesis, item.kind, item.number.partition(".")[0])
        number = int(item.number.partition(".")[2])
        begun = place in last or number == 1 or (item.thesis, item.kind) == ("R12", "table")
        assert begun or item.kind == "table", item
        assert number > last[place], item
        if item.kind == "figure":
            assert number == last[place] + 1, item
        last[place] = number
        assert bool(item.chapters) != bool(item.why_not), item
    numbered = {chapter.name[:2] for chapter in stored}
    assert {number for item in items for number in item.chapters} <= numbered


def test_the_page_shows_rows_items_and_links(stored):
    rows = replay_rows(stored)
    page = replay_html(rows, stored)
    assert page.count("<tr class=") == len(rows) + len(coverage()) + page.count("class='group'")
    for row in rows:
        assert f"href='{row['link']}'" in page
    ids = {f"{c.name}.html#{cell.id}" for c in stored for cell in c.node.cells}
    assert {row["link"] for row in rows} <= ids
    assert not re.search(r"https?:", page)


def test_an_item_without_a_row_says_what_it_is_instead():
    by_key = {item.key: item for item in coverage()}
    rows = [
        {"source": "P13 tables 5.1 and 5.2", "verdict": "better"},
        {"source": "P13 5.1.4, table 5.1", "verdict": "reproduced"},
    ]
    assert status(by_key["P13", "table", "5.1"], rows) == ["reproduced", "better"]
    assert status(by_key["P13", "figure", "4.6"], rows) == ["drawn anew"]
    assert status(by_key["P13", "figure", "6.3"], rows) == ["later"]
    assert status(by_key["L14", "figure", "3.1"], rows) == ["not rebuilt"]


def test_a_table_of_rows_is_worth_its_rows_one_by_one():
    values = {**HELD, "printed": 73.2}
    rows = [replay("P13 table 5.1", f"<{name}>", **values) for name in "ab"]
    bundles = [row._repr_mimebundle_() for row in rows]
    table = replay_table(rows)._repr_mimebundle_()
    assert rows_of(table) == [row for bundle in bundles for row in rows_of(bundle)]
    assert rows_of({"text/plain": "1"}) == []
    lines = table["text/plain"].splitlines()
    assert len(lines) == 3
    assert all(row.verdict in line for row, line in zip(rows, lines[1:], strict=True))
    assert "<a>" not in table["text/html"]
    assert table["text/html"].count("<tr>") == 3
    assert "note" not in lines[0]
    with pytest.raises(InputError, match="at least one row"):
        replay_table([])


def test_rows_come_from_outputs_alone():
    output = nbformat.v4.new_output(
        "display_data", data={MIME: {"source": "P13 1.1", "verdict": "reproduced"}}
    )
    cell = nbformat.v4.new_code_cell("1", outputs=[output], id="cell-00")
    heading = nbformat.v4.new_markdown_cell("# One?")
    one = Executed(Path("11_one.ipynb"), nbformat.v4.new_notebook(cells=[cell, heading]), 0.0)
    assert replay_rows([one])[0]["link"] == "11_one.html#cell-00"
