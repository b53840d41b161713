"""Run benchmarks by name: ``python -m benchmarks [name ...]``; all of them without a name."""

from __future__ import annotations

import importlib
import platform
import sys
from importlib.metadata import version
from pathlib import Path


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def main(names: list[str]) -> int:
    """Run the named benchmarks, or all; return 2 for a name that does not exist."""
    folder = Path(__file__).parent
    known = sorted(p.stem for p in folder.glob("*.py") if not p.stem.startswith("_"))
    for name in names:
        if name not in known:
            print(f"benchmarks: no benchmark {name!r}; there are {', '.join(known)}",
                  file=sys.stderr)  # fmt: skip
            return 2
    packages = ", ".join(f"{p} {version(p)}" for p in ("numpy", "scipy", "numba", "trimesh"))
    print(f"{processor()}; Python {platform.python_version()}; {packages}")
    for name in names or known:
        module = importlib.import_module(f"benchmarks.{name}")
        if hasattr(module, "run"):
            print(f"\n== {name}")
            module.run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
