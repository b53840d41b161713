"""``medkit check-hand`` from the outside."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from medkit.cli import main
from medkit.cli.check_hand import precision_finding
from medkit.grasping.precision_grip import precision_grip
from medkit.robots import hand_names, load_hand

DATA = Path(__file__).parent / "data"


def test_a_good_hand_prints_its_findings_and_draws_a_picture(tmp_path, capsys):
    picture = tmp_path / "hand.png"
    status = main(["check-hand", str(DATA / "two_finger.yaml"), "--picture", str(picture)])
    printed = capsys.readouterr()
    assert status == 0
    assert printed.err == ""
    assert "two_finger: 2 joints, 2 fingers" in printed.out
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_bad_hand_ends_with_one_sentence_and_status_two(tmp_path, capsys):
    document = yaml.safe_load((DATA / "two_finger.yaml").read_text())
    document["urdf"] = str(DATA / "two_finger.urdf")
    document["package_dirs"] = [str(DATA / "packages")]
    document["fingers"][1]["tip_normal"] = [-1, 0, 0]
    path = tmp_path / "hand.yaml"
    path.write_text(yaml.safe_dump(document))
    assert main(["check-hand", str(path)]) == 2
    printed = capsys.readouterr()
    assert printed.err.count("\n") == 1
    assert "right: closing moves the pad sideways or backwards" in printed.err


def test_an_unknown_hand_writes_no_picture(tmp_path, capsys):
    picture = tmp_path / "hand.png"
    assert main(["check-hand", "schunc", "--picture", str(picture)]) == 2
    assert "did you mean 'schunk'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", hand_names())
def test_the_pads_of_the_hands_that_come_along_oppose_each_other(name):
    assert precision_finding(load_hand(name)).level == "ok"


def test_pads_that_pass_each_other_are_noted(tmp_path, capsys):
    document = yaml.safe_load((DATA / "two_finger.yaml").read_text())
    document["urdf"] = str(DATA / "two_finger.urdf")
    document["package_dirs"] = [str(DATA / "packages")]
    document["fingers"][1] |= {"tip_link": "right_finger", "tip_point": [0.006, 0, 0.02]}
    path = tmp_path / "hand.yaml"
    path.write_text(yaml.safe_dump(document))
    hand = load_hand(path)
    grip = precision_grip(hand, idle="power")
    assert np.abs(grip.offsets).max() > 0.03
    finding = precision_finding(hand)
    assert finding.level == "note"
    assert "pass each other" in finding.text
    assert main(["check-hand", str(path)]) == 0
    assert "pass each other" in capsys.readouterr().out


def test_the_picture_shows_the_precision_grip_too(tmp_path):
    picture = tmp_path / "hand.png"
    assert main(["check-hand", "wsg50", "--picture", str(picture)]) == 0
    wide, high = Image.open(picture).size
    assert wide == 3 * high
