"""Meet the product as a reader does: JupyterLab and the book in a real browser.

Runs every notebook's cells in JupyterLab, moves a slider, turns a 3-D view, and looks whether the
screenshots show anything. Needs Chromium and the packages playwright and pillow (extra
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
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

PORT = 8931
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
LEAST_COLOURS = 40  # of a picture that shows something


def main() -> int:
    """Check notebooks and book; print a line each; exit status 1 when one shows nothing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("notebooks", nargs="*", type=Path)
    parser.add_argument("--out", type=Path, default=Path("build/browser"))
    parser.add_argument("--book", type=Path, default=Path("build/book"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    notebooks = args.notebooks or sorted(Path("notebooks").glob("[0-9][0-9]_*.ipynb"))
    failures = []
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1400, "height": 1000})
        for name in ("index", "replay"):
            if (args.book / f"{name}.html").exists():
                page.goto((args.book / f"{name}.html").resolve().as_uri())
                failures += shown(page, args.out / f"book_{name}.png")
        with Lab(notebooks) as address:
            for notebook in notebooks:
                failures += run_notebook(page, address, notebook, args.out)
        browser.close()
    print(f"{len(notebooks)} notebooks run in the browser, {len(failures)} of them not as expected")
    for failure in failures:
        print("  " + failure)
    return 1 if failures else 0


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

    def __enter__(self) -> str:
        token = secrets.token_hex(16)
        settings = Path(self.folder.name) / ".settings" / "@jupyterlab"
        for name, text in SETTINGS.items():
            (settings / name).parent.mkdir(parents=True, exist_ok=True)
            (settings / name).write_text(text)
        self.process = subprocess.Popen(
            [
                ".venv/bin/python", "-m", "jupyterlab", "--no-browser", f"--port={PORT}",
                "--ServerApp.port_retries=0", "--allow-root", f"--notebook-dir={self.folder.name}",
                f"--IdentityProvider.token={token}",
                f"--LabApp.user_settings_dir={settings.parent}",
            ],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        wait_for_port(PORT)
        return f"http://127.0.0.1:{PORT}/lab/tree/{{}}?reset&token={token}"

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait(timeout=30)
        self.folder.cleanup()


def wait_for_port(port: int, limit: float = 120.0) -> None:
    """Wait until something listens on a port of this machine."""
    end = time.monotonic() + limit
    while time.monotonic() < end:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.5)
    raise SystemExit("JupyterLab did not start; try make lab by hand")


def run_notebook(page: Page, address: str, notebook: Path, out: Path) -> list[str]:
    """Run all cells, move the first slider, turn the first 3-D view; return what went wrong."""
    page.goto(address.format(notebook.name))
    page.wait_for_selector(".jp-Notebook .jp-CodeCell", timeout=120_000)
    page.wait_for_selector("text=| Idle", timeout=120_000)
    page.click(".lm-MenuBar-itemLabel:text-is('Run')")
    page.click(".lm-Menu-itemLabel:text-is('Run All Cells')")
    wait_until_run(page)
    errors = page.query_selector_all("[data-mime-type='application/vnd.jupyter.error']")
    wrong = [f"{notebook.name}: {len(errors)} cells failed"] if errors else []
    slider = page.query_selector(".noUi-handle")
    if slider:
        slider.scroll_into_view_if_needed()
        slider.focus()
        for _ in range(4):
            page.keyboard.press("ArrowRight")
        page.wait_for_timeout(2500)
    frame = page.query_selector("iframe[title='grasp browser']")
    if frame:
        frame.scroll_into_view_if_needed()
        box = frame.bounding_box()
        if box:
            x, y = box["x"] + box["width"] / 3, box["y"] + box["height"] / 2
            page.mouse.move(x, y)
            page.mouse.down()
            page.mouse.move(x + 120, y + 40, steps=6)
            page.mouse.up()
            page.wait_for_timeout(800)
    return wrong + shown(page, out / f"{notebook.stem}.png")


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
    print(f"{path.name}: {len(colours)} colours")
    return [] if len(colours) >= LEAST_COLOURS else [f"{path.name} is blank"]


if __name__ == "__main__":
    raise SystemExit(main())
