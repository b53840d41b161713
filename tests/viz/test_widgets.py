"""Controls and picture in one line: moves redraw, stored pages keep a still, errors are said."""

import base64
import io
import json
import sys

import matplotlib as mpl
import matplotlib.pyplot as plt
import nbformat
import numpy as np
import pytest
from ipywidgets import Dropdown, FloatSlider, IntSlider, SelectionSlider

from medkit.book.notebooks import WIDGET, execute
from medkit.book.pages import notebook_html
from medkit.errors import InputError
from medkit.viz.widgets import explore, label


def bars(count=3, height=1.0):
    ax = plt.subplots(figsize=(3, 2))[1]
    ax.bar(range(count), height)
    ax.set_ylim(0, 2)
    return ax


def pixels(shown):
    return mpl.image.imread(io.BytesIO(base64.b64decode(shown["image/png"])))


def test_moving_a_control_draws_another_picture_and_moving_back_the_same():
    shown = explore(bars, count=(1, 6), height=(0.5, 2.0, 0.5))
    first = pixels(shown.picture)
    assert not np.array_equal(pixels(shown.move(height=2.0)), first)
    assert np.array_equal(pixels(shown.move(height=1.0)), first)
    assert shown.picture["text/plain"] == "picture at count = 3, height = 1"


def test_no_figure_is_left_open():
    before = plt.get_fignums()
    explore(bars, count=(1, 6)).move(count=5)
    explore(lambda count: bars(count) and None, count=(1, 6)).move(count=5)
    assert plt.get_fignums() == before


def test_a_drawing_without_a_result_and_a_text_are_shown_too():
    assert "image/png" in explore(lambda count: bars(count) and None, count=(1, 6)).picture
    said = explore(lambda n: sys.stdout.write("a" * n) and None, n=(1, 5)).picture
    assert said == {"text/plain": "aaa"}


def test_each_kind_of_control_follows_from_what_is_given():
    def draw(a, b, c, d, e=4):
        return "drawn"

    shown = explore(
        draw, a=(0.0, 1.0), b=["x", "y"], c={"one": 1}, d=[100, 300], e=(0, 9), start={"b": "y"}
    )
    kinds = [type(control) for control in shown.controls.values()]
    assert kinds == [FloatSlider, Dropdown, Dropdown, SelectionSlider, IntSlider]
    assert shown.values == {"a": 0.5, "b": "y", "c": 1, "d": 100, "e": 4}


def test_units_stand_in_brackets():
    assert label("search_radius_cm") == "search radius [cm]"
    assert label("force_N") == "force [N]"
    assert label("cell_density") == "cell density"


@pytest.mark.parametrize(
    ("controls", "words"),
    [
        ({"size": (0, 1)}, "count, height"),
        ({}, "got none"),
        ({"count": (4, 1)}, "low, high"),
        ({"count": (5, 9)}, "start for count from 5 to 9, but got 3"),
        ({"count": []}, "choices for count"),
        ({"count": (1, 5), "start": {"height": 1}}, "every start a control"),
    ],
)
def test_wrong_controls_are_refused_in_one_sentence(controls, words):
    with pytest.raises(InputError, match=words):
        explore(bars, **controls)


def test_an_error_after_a_move_is_read_in_the_pictures_place():
    def root(value=1.0):
        if value < 0:
            raise InputError("Expected a value from zero up, but got less; move right.")
        return f"{value**0.5:.1f}"

    shown = explore(root, value=(-1.0, 4.0))
    assert "move right" in shown.move(value=-1.0)["text/plain"]
    assert shown.move(value=4.0)["text/plain"] == "2.0"
    with pytest.raises(InputError, match="move right"):
        explore(root, value=(-1.0, 4.0), start={"value": -1.0})


def test_a_stored_notebook_holds_the_picture_and_no_dead_widget(tmp_path):
    path = tmp_path / "11_moving.ipynb"
    source = (
        "from medkit.viz.widgets import explore\nimport matplotlib.pyplot as plt\n"
        "def draw(n=2):\n    plt.plot(range(n))\n    plt.show()\nexplore(draw, n=(1, 5))"
    )
    node = nbformat.v4.new_notebook(
        cells=[nbformat.v4.new_markdown_cell("# Moves?"), nbformat.v4.new_code_cell(source)]
    )
    nbformat.write(node, path)
    stored = execute(path).node
    controls, picture = stored.cells[1].outputs
    assert WIDGET not in json.dumps(stored)
    assert set(picture.data) == {"image/png", "text/plain"}
    assert "run this cell to move n" in controls.data["text/html"]
    page = notebook_html(stored)
    assert page.count("<img") == 1
    assert "run this cell to move n" in page
