"""Files that appear whole or not at all, and the folder for things computed once."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from medkit.errors import InputError


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path` and move it there when the block ends well.

    Parameters
    ----------
    path : path-like
        Where the finished file has to appear. Its folder must exist.

    Yields
    ------
    pathlib.Path
        Write here. On any exception, an interrupt included, it is removed and `path` is
        left as it was.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     target = pathlib.Path(folder) / "result.txt"
    ...     with whole_file(target) as draft:
    ...         _ = draft.write_text("done")
    ...     target.read_text()
    'done'
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(
            f"Expected an existing folder for the output {target}, but {target.parent} is not one;"
            " create it first."
        )
    if target.is_dir():
        raise InputError(
            f"Expected a file name for the output, but {target} is a folder; name a file in it."
        )
    try:
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix
        )
    except OSError as error:
        raise InputError(
            f"Expected a writable folder for the output {target}, but writing there failed"
            f" ({error.strerror}); choose another folder."
        ) from error
    os.close(handle)
    draft = Path(name)
    try:
        yield draft
        draft.chmod(0o666 & ~_umask())
        os.replace(draft, target)
    finally:
        draft.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write `text` to `path` as UTF-8, whole or not at all."""
    with whole_file(path) as draft:
        draft.write_text(text, encoding="utf-8")


def cache_folder(room: str) -> Path:
    """Return (and create) the user's cache folder for one room of medkit.

    Parameters
    ----------
    room : str
        Name of the subfolder, for example ``"objects"``.

    Returns
    -------
    pathlib.Path
        An existing folder. ``MEDKIT_CACHE`` in the environment overrides its parent.
    """
    from platformdirs import user_cache_path

    root = os.environ.get("MEDKIT_CACHE")
    folder = (Path(root) if root else user_cache_path("medkit")) / room
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
