"""Meet the product as a reader does: JupyterLab and the book in a real browser.

Runs every notebook's cells in JupyterLab, moves the first slider, turns the first 3-D view, and
holds what the screen shows before and after against each other. Leaves a picture of each whole
notebook to be looked at. Needs Chromium and the packages playwright and pillow (extra
``browser``); called by ``make browser``.
"""

from __future__ import annotations

import argparse
import io
import json
import re
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.request
from pathlib import Path

from PIL import Image, ImageChops
from playwright.sync_api import ElementHandle, Page, sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome") or "/usr/bin/chromium"
FLAGS = [
    "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--no-first-run", "--disable-quic",
]  # fmt: skip
#: All cells in the page at once, so that they can be found; no question about news.
SETTINGS = {
    "notebook-extension/tracker.jupyterlab-settings": '{"windowingMode": "none"}',
    "apputils-extension/notification.jupyterlab-settings": '{"fetchNews": "false"}',
}
WIDTH, HEIGHT, TALLEST = 1400, 1000, 7_000  # [px]
LEAST_COLOURS = 40  # of a picture that shows something
PATIENCE = 15  # seconds for a picture to follow its slider on a busy machine
LEAST_CHANGE = 0.002  # share of pixels that a moved slider or a turned view changes
IDLE = "text=| Idle"


def main() -> int:
    """Check notebooks and book; print a line each; exit status 1 when one shows nothing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("notebooks", nargs="*", type=Path)
    parser.add_argument("--out", type=Path, default=Path("build/browser"))
    parser.add_argument("--book", type=Path, default=Path("build/book"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    chapters = [
        *Path("notebooks").glob("[0-9][0-9]_*.ipynb"),
        *Path("notebooks/labs").glob("*.ipynb"),
    ]
    notebooks = args.notebooks or sorted(chapters)
    failures: list[str] = []
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
        page.on("pageerror", lambda error: failures.append(f"script error: {error}"))
        if (args.book / "index.html").exists():
            failures += look_at_book(page, args.book.resolve(), args.out)
        with Lab(notebooks) as lab:
            for notebook in notebooks:
                failures += run_notebook(page, lab, notebook, args.out)
        browser.close()
    print(f"{len(notebooks)} notebooks run in the browser, {len(failures)} things not as expected")
    for failure in failures:
        print("  " + failure)
    return 1 if failures else 0


def look_at_book(page: Page, book: Path, out: Path) -> list[str]:
    """Open index and replay page from disk, use the search and a filter."""
    page.goto((book / "index.html").as_uri())
    wrong = shown(page, out / "book_index.png")
    page.fill("#search", "epsilon")
    if not page.query_selector_all("#found li"):
        wrong.append("the book's search finds nothing for epsilon")
    page.goto((book / "replay.html").as_uri())
    rows = "#rows tr[data-verdict]:visible"
    before = page.locator(rows).count()
    page.click("#chips .chip[data-value='not decided']")
    if not 0 < page.locator(rows).count() < before:
        wrong.append("the replay page's filter leaves the rows as they were")
    return wrong + shown(page, out / "book_replay.png")


class Lab:
    """JupyterLab on the loopback interface for a block, over copies of the notebooks."""

    def __init__(self, notebooks: list[Path]) -> None:
        self.folder = tempfile.TemporaryDirectory()
        for notebook in notebooks:
            content = json.loads(notebook.read_text(encoding="utf-8"))
            for cell in content["cells"]:
                if cell["cell_type"] == "code":
                    # a stored number would look like a finished run
                    cell["outputs"], cell["execution_count"] = [], None
            (Path(self.folder.name) / notebook.name).write_text(json.dumps(content))

    def __enter__(self) -> Lab:
        self.token, self.port = secrets.token_hex(16), free_port()
        settings = Path(self.folder.name) / ".settings" / "@jupyterlab"
        for name, text in SETTINGS.items():
            (settings / name).parent.mkdir(parents=True, exist_ok=True)
            (settings / name).write_text(text)
        self.process = subprocess.Popen(
            [
                ".venv/bin/python", "-m", "jupyterlab", "--no-browser", f"--port={self.port}",
                "--ServerApp.port_retries=0", "--allow-root", f"--notebook-dir={self.folder.name}",
                f"--IdentityProvider.token={self.token}",
                f"--LabApp.user_settings_dir={settings.parent}",
            ],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        wait_for_port(self.port)
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait(timeout=30)
        self.folder.cleanup()

    def address(self, notebook: Path) -> str:
        """Where a notebook opens in a fresh workspace."""
        return f"http://127.0.0.1:{self.port}/lab/tree/{notebook.name}?reset&token={self.token}"

    def end_kernels(self) -> None:
        """End what the last notebook started; thirty kernels would fill the memory."""
        address = f"http://127.0.0.1:{self.port}/api/sessions"
        headers = {"Authorization": f"token {self.token}"}
        with urllib.request.urlopen(urllib.request.Request(address, headers=headers)) as answer:
            sessions = json.load(answer)
        for session in sessions:
            urllib.request.urlopen(
                urllib.request.Request(
                    f"{address}/{session['id']}", headers=headers, method="DELETE"
                )
            ).close()


def free_port() -> int:
    """Return a port of this machine that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def wait_for_port(port: int, limit: float = 120.0) -> None:
    """Wait until something listens on a port of this machine."""
    end = time.monotonic() + limit
    while time.monotonic() < end:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.5)
    raise SystemExit("JupyterLab did not start; try make lab by hand")


def run_notebook(page: Page, lab: Lab, notebook: Path, out: Path) -> list[str]:
    """Run all cells, move the first slider, turn the first 3-D view; return what went wrong."""
    page.set_viewport_size({"width": WIDTH, "height": HEIGHT})
    page.goto(lab.address(notebook))
    page.wait_for_selector(".jp-Notebook .jp-CodeCell", timeout=120_000)
    page.wait_for_selector(IDLE, timeout=120_000)
    page.keyboard.press("Control+b")  # the list of files is of no use here
    page.click(".lm-MenuBar-itemLabel:text-is('Run')")
    page.click(".lm-Menu-itemLabel:text-is('Run All Cells')")
    wait_until_run(page)
    errors = page.query_selector_all("[data-mime-type='application/vnd.jupyter.error']")
    wrong = [f"{len(errors)} cells failed"] if errors else []
    wrong += move_slider(page) + turn_view(page)
    wrong += pictures(page, out, notebook.stem)
    lab.end_kernels()
    return [f"{notebook.name}: {failure}" for failure in wrong]


def pictures(page: Page, out: Path, stem: str) -> list[str]:
    """Save the whole notebook, in as many tall pictures as it needs."""
    panels = "[...document.querySelectorAll('[class*=jp-WindowedPanel]')]"
    tall = int(page.evaluate(f"Math.max(...{panels}.map(n => n.scrollHeight))"))
    page.set_viewport_size({"width": WIDTH, "height": min(tall + 160, TALLEST)})
    wrong, step = [], TALLEST - 160
    for part in range(-(-tall // step)):
        page.evaluate(f"{panels}.forEach(n => {{ n.scrollTop = {part * step}; }})")
        page.wait_for_timeout(1500)
        wrong += shown(page, out / (f"{stem}.png" if part == 0 else f"{stem}_{part + 1}.png"))
    return wrong


def move_slider(page: Page) -> list[str]:
    """Move the first slider by the keyboard and see whether what its cell shows follows."""
    slider = page.query_selector(".jp-Notebook .noUi-handle")
    if slider is None:
        return []
    slider.scroll_into_view_if_needed()
    before = beside(slider)
    # a slider that starts at its upper end can only go back
    for key in ("ArrowRight", "ArrowLeft"):
        slider.focus()
        for _ in range(4):
            page.keyboard.press(key)
        for _ in range(PATIENCE):
            page.wait_for_timeout(1000)
            if beside(slider) != before:
                return []
    return ["moving the slider changes nothing"]


def beside(slider: ElementHandle) -> str:
    """Pictures and texts in the output of a slider's cell, the controls left aside."""
    return str(
        slider.evaluate(
            """n => [...n.closest('.jp-CodeCell').querySelectorAll(
                '.jp-RenderedImage img, .jp-RenderedText, .jp-RenderedHTMLCommon, iframe')]
                .filter(m => !m.closest('.widget-hslider'))
                .map(m => m.src || m.textContent).join()"""
        )
    )


def turn_view(page: Page) -> list[str]:
    """Drag in the first 3-D view and see whether it turns."""
    frame = page.query_selector(
        ".jp-Notebook iframe[title='grasp browser'], .jp-Notebook iframe[title='live scene']"
    )
    if frame is None:
        return []
    frame.scroll_into_view_if_needed()
    page.wait_for_timeout(1500)
    before = picture_of(frame, page)
    box = frame.bounding_box()
    if box is None:
        return ["the 3-D view has no size"]
    x, y = box["x"] + box["width"] / 3, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 120, y + 40, steps=6)
    page.mouse.up()
    page.wait_for_timeout(1000)
    return [] if differ(before, picture_of(frame, page)) else ["dragging does not turn the view"]


def picture_of(element: ElementHandle | None, page: Page) -> Image.Image:
    """What an element looks like now (or the page, where there is none)."""
    taken = page.screenshot() if element is None else element.screenshot()
    return Image.open(io.BytesIO(taken)).convert("RGB")


def differ(one: Image.Image, other: Image.Image) -> bool:
    """Whether two pictures of the same thing show something else."""
    if one.size != other.size:
        return True
    changed = ImageChops.difference(one, other).convert("L").point(lambda v: 255 if v > 16 else 0)
    return changed.histogram()[255] > LEAST_CHANGE * one.size[0] * one.size[1]


def wait_until_run(page: Page, limit: float = 300.0) -> None:
    """Wait until every code cell carries a number again."""
    end = time.monotonic() + limit
    pending = True
    while pending and time.monotonic() < end:
        page.wait_for_timeout(1000)
        prompts = page.eval_on_selector_all(
            ".jp-Notebook .jp-CodeCell .jp-InputArea-prompt", "all => all.map(n => n.textContent)"
        )
        pending = any(not re.search(r"\d", prompt) for prompt in prompts)
    page.wait_for_timeout(1000)


def shown(page: Page, path: Path) -> list[str]:
    """Save a screenshot and say so if it shows nothing."""
    picture = page.screenshot(path=str(path))
    colours = Image.open(io.BytesIO(picture)).convert("RGB").getcolors(1 << 24) or []
    print(f"{path.name}: {len(colours)} colours", flush=True)
    return [] if len(colours) >= LEAST_COLOURS else [f"{path.name} is blank"]


if __name__ == "__main__":
    raise SystemExit(main())
