"""``medkit handover``: the tables, the report, and one sentence for a bad file."""

import re

import pytest

from medkit.cli import main
from medkit.datasets.handover_trials import handover_folder


@pytest.fixture(scope="module")
def lines():
    return (handover_folder() / "trials.csv").read_text().splitlines(keepends=True)


def test_the_thesis_in_one_call(capsys):
    assert main(["handover"]) == 0
    out = capsys.readouterr().out
    assert "9 of 864 cells do not add up to 4 and were dropped" in out
    assert len(re.findall(r"^[1-7]  ", out, flags=re.M)) == 7
    rows = re.findall(r"^   P[12] .*(?:open|narrow|closed)$", out, flags=re.M)
    assert len(rows) == 24
    assert len({len(row[:53]) for row in rows}) == 1


def test_a_table_of_the_labs_own_and_a_report(tmp_path, capsys, lines):
    table, report = tmp_path / "lab.csv", tmp_path / "report.html"
    table.write_text("".join(lines).replace("P1,", "tray,"))
    assert main(["handover", str(table), "--level", "0.5", "--html", str(report)]) == 0
    assert "tray" in capsys.readouterr().out
    text = report.read_text()
    assert text.count("data:image/png;base64,") == 5
    assert "http" not in re.sub(r"base64,[^']*", "", text)
    assert "no data" in text


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("P1,position,-3,100,T9,4,0,0,true", r"line 866, column force_N: .*1 line is bad"),
        ("P1,position,2,100,T9,4,x,0,true", r"line 866, column acceptable: .*'x'"),
        ("P1,position,0.5,24,T1,4,0,0,true", r"line 866, .*this one came before"),
    ],
)
def test_a_bad_row_gives_one_sentence_and_status_two(tmp_path, capsys, lines, row, said):
    table = tmp_path / "lab.csv"
    table.write_text("".join(lines) + row + "\n")
    assert main(["handover", str(table)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert re.search(said, captured.err)


def test_nothing_is_left_half_written(tmp_path, capsys):
    report = tmp_path / "absent" / "report.html"
    assert main(["handover", "--html", str(report)]) == 2
    assert "existing folder" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("arguments", [["--level", "1.5"], ["--bump", "-1"], ["--seed", "-1"]])
def test_bad_arguments_give_one_sentence(capsys, arguments):
    assert main(["handover", *arguments]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def spoilt(lines, kind):
    """The thesis's table as a lab might hand it over by mistake."""
    text = "".join(lines)
    if kind == "rated alike":
        rows = [",".join([*line.split(",")[:5], "4,0,0"]) + "\n" for line in lines[1:]]
        return (",".join(lines[0].split(",")[:8]).strip() + "\n" + "".join(rows)).encode()
    if kind == "kilograms":
        cells = [line.split(",") for line in lines[1:]]
        return (lines[0] + "".join(
            ",".join([*row[:3], str(float(row[3]) / 1000), *row[4:]]) for row in cells
        )).encode()  # fmt: skip
    return {
        "semicolons": text.replace(",", ";").encode(),
        "tabs": text.replace(",", "\t").encode(),
        "workbook": b"PK\x03\x04" + bytes(60),
        "utf16": text.encode("utf-16"),
        "latin1": text.replace("T1", "Jörg").encode("latin-1"),
        "bytes": bytes(range(256)),
        "empty": b"",
        "heading": lines[0].encode(),
    }[kind]


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("semicolons", "separates them by semicolons; export it with commas"),
        ("tabs", "separates them by tabs"),
        ("workbook", "is an Excel workbook; save it as CSV"),
        ("utf16", "is text in UTF-16"),
        ("latin1", "byte [0-9]+ of .* is 0xf6; save it again as CSV"),
        ("bytes", "in UTF-8, but byte"),
        ("empty", "No columns to parse"),
        ("heading", "the table is empty"),
        ("kilograms", "expected grams, but the heaviest object weighs 1; kilograms\\?"),
        ("rated alike", "came 3456 that are all good"),
    ],
)
def test_a_file_of_another_kind_is_named(tmp_path, capsys, lines, kind, said):
    table = tmp_path / "lab.csv"
    table.write_bytes(spoilt(lines, kind))
    assert main(["handover", str(table)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert re.search(said, captured.err)
