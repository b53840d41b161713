"""``medkit check`` from the outside: one line on standard error, exit status 2."""

import pytest
import trimesh

from medkit.cli import main


def test_a_sound_mesh_is_described(tmp_path, capsys):
    trimesh.creation.icosphere(radius=0.04).export(tmp_path / "ball.stl")
    assert main(["check", str(tmp_path / "ball.stl")]) == 0
    shown = capsys.readouterr()
    assert "sound" in shown.out
    assert shown.err == ""


@pytest.mark.parametrize("arguments", [["gone.stl"], ["big.stl"], ["big.stl", "--scale", "-1"]])
def test_bad_input_is_one_line_and_status_two(tmp_path, capsys, arguments, monkeypatch):
    monkeypatch.chdir(tmp_path)
    trimesh.creation.box((80.0, 80.0, 80.0)).export(tmp_path / "big.stl")
    assert main(["check", *arguments]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1


def test_an_unknown_option_is_one_line_too(capsys):
    with pytest.raises(SystemExit) as caught:
        main(["check", "ball.stl", "--wrong"])
    assert caught.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1
