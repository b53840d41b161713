"""A live scene cleans up after itself: no server and no port is left, however its owner ends."""

import base64
import gc
import io
import json
import os
import signal
import socket
import subprocess
import sys
import time
from urllib.parse import urlparse

import matplotlib as mpl
import nbformat
import numpy as np
import pytest
import trimesh

from medkit.book.notebooks import WIDGET, execute
from medkit.errors import InputError
from medkit.geometry import transform
from medkit.robots import load_hand
from medkit.viz.scene_live import HALF_ANGLE, LiveScene, fitting_camera

BOX = trimesh.creation.box((0.05, 0.08, 0.1))
OWNER = """
import sys, time
from medkit.viz.scene_live import LiveScene
scene = LiveScene()
print(scene.url, flush=True)
{then}
"""


def listens(url):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", urlparse(url).port)) == 0


def gone(url):
    """Whether the port falls silent; the system may take a moment to end a process."""
    for _ in range(100):
        if not listens(url):
            return True
        time.sleep(0.1)
    return False


def test_closing_ends_the_server_and_twice_does_no_harm():
    scene = LiveScene()
    assert listens(scene.url)
    scene.close()
    scene.close()
    assert scene.closed
    assert gone(scene.url)


def test_a_block_and_the_last_reference_end_it_too():
    with LiveScene() as scene:
        scene.add("box", BOX)
        inside = scene.url
    assert gone(inside)
    scene = LiveScene()
    address = scene.url
    del scene
    gc.collect()
    assert gone(address)


def test_a_second_scene_takes_the_place_of_the_first():
    with LiveScene() as first, LiveScene() as second:
        assert first.closed
        assert not second.closed
        with pytest.raises(InputError, match="closed; make a new one"):
            first.add("box", BOX)


@pytest.mark.parametrize("end", ["exits", "is killed"])
def test_nothing_is_left_when_the_owner(end):
    then = {"exits": "", "is killed": "time.sleep(600)"}[end]
    owner = subprocess.Popen(
        [sys.executable, "-c", OWNER.format(then=then)],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    url = owner.stdout.readline().strip()
    assert url.startswith("http://127.0.0.1:")
    if end == "is killed":
        assert listens(url)
        os.kill(owner.pid, signal.SIGKILL)
    owner.wait()
    owner.stdout.close()
    assert gone(url)


def pixels(text):
    return mpl.image.imread(io.BytesIO(base64.b64decode(text)))


def test_moving_shows_in_the_view_and_in_the_still():
    hand = load_hand("wsg50")
    with LiveScene() as scene:
        scene.add("box", BOX)
        scene.add_hand("hand", hand, hand.preshapes["power"])
        before = scene._view.window.get_scene(), pixels(scene.still())
        scene.move("box", transform(np.eye(3), [0.0, 0.0, 0.2]))
        scene.move_hand("hand", hand, hand.preshapes["precision"])
        assert scene._view.window.get_scene() != before[0]
        after = pixels(scene.still())
        assert after.shape != before[1].shape or not np.array_equal(after, before[1])


def test_wrong_parts_and_poses_are_refused():
    with LiveScene() as scene:
        scene.add("box", BOX)
        with pytest.raises(InputError, match=r"\(box\), but got 'cup'"):
            scene.move("cup", np.eye(4))
        with pytest.raises(InputError, match="4 x 4"):
            scene.move("box", [0.0, 0.0, 0.1])


def test_a_notebook_stores_a_still_and_leaves_no_server(tmp_path):
    source = (
        "import trimesh\nfrom pathlib import Path\nfrom medkit.viz.scene_live import LiveScene\n"
        "scene = LiveScene()\nscene.add('box', trimesh.creation.box((0.1, 0.1, 0.1)))\n"
        "_ = Path('address').write_text(scene.url)\nscene"
    )
    cells = [nbformat.v4.new_markdown_cell("# Live?"), nbformat.v4.new_code_cell(source)]
    nbformat.write(nbformat.v4.new_notebook(cells=cells), tmp_path / "11_live.ipynb")
    stored = execute(tmp_path / "11_live.ipynb").node
    assert set(stored.cells[1].outputs[0].data) == {"image/png", "text/plain"}
    assert WIDGET not in json.dumps(stored)
    assert gone((tmp_path / "address").read_text())


@pytest.mark.parametrize("size", [0.003, 0.2, 5.0])
def test_the_camera_sees_every_corner_and_no_more_air_than_needed(size):
    points = np.random.default_rng(0).normal(size=(200, 3)) * size + [0.4, -0.2, 1.0]
    middle, eye = fitting_camera(points)
    sight = (middle - eye) / np.linalg.norm(middle - eye)
    rays = points - eye
    angle = np.arccos(rays @ sight / np.linalg.norm(rays, axis=1))
    assert np.all(angle <= HALF_ANGLE + 1e-9)
    assert angle.max() > HALF_ANGLE / 2


def test_an_empty_scene_has_a_view_too():
    with LiveScene() as scene:
        scene.fit_view()
        assert scene._repr_mimebundle_()["image/png"]
