"""One line for a picture that moves: controls where a kernel runs, the still picture elsewhere.

The controls and the picture are two outputs of the same cell. The picture is an ordinary image that
the controls replace in place, so it is what an untrusted, a stored and a converted notebook show.
"""

from __future__ import annotations

import html
import inspect
import uuid
from collections.abc import Callable, Mapping
from typing import Any

from medkit.errors import InputError

WIDGET = "application/vnd.jupyter.widget-view+json"
UNITS = ("deg", "rad", "m", "mm", "cm", "N", "kg", "g", "s", "ms", "Hz")
STEPS = 20  # of a range without a step


def explore(function: Callable[..., Any], *, start: Mapping[str, Any] | None = None,
            **controls: Any) -> Explorer:  # fmt: skip
    """Show what a function draws, with a control for each of its parameters.

    Parameters
    ----------
    function : callable
        Draws with matplotlib, or returns or prints a text. It is called anew at every move.
    start : mapping of str to value, optional
        Where the controls start. Else the function's defaults; else the middle of a range and the
        first of a list.
    **controls
        One per parameter: ``(low, high)`` or ``(low, high, step)`` for a slider, a list of choices,
        a mapping of names to choices, True or False for a check box, or any ipywidgets widget. A
        parameter whose name ends in a unit (``angle_deg``) is labelled with it.

    Returns
    -------
    Explorer
        What a cell displays when it stands in its last line.

    Raises
    ------
    InputError
        If a control belongs to no parameter of the function, or a start lies outside its range.

    Notes
    -----
    A plain image needs neither a kernel nor trust, so nothing else has to stand beside it.

    Examples
    --------
    >>> shown = explore(lambda friction: f"{2 * friction:.1f}", friction=(0.0, 1.0, 0.1))
    >>> shown.values, shown.picture["text/plain"]
    ({'friction': 0.5}, '1.0')
    >>> shown.move(friction=0.8)["text/plain"]
    '1.6'
    """
    defaults = _defaults(function, controls)
    defaults.update(start or {})
    if unknown := sorted(set(start or ()) - set(controls)):
        raise InputError(
            f"Expected starts for {', '.join(controls)}, but got {', '.join(unknown)}; give every"
            " start a control."
        )
    return Explorer(
        function, {name: _control(name, spec, defaults) for name, spec in controls.items()}
    )


class Explorer:
    """A function, its controls, and the picture that it draws where they stand."""

    def __init__(self, function: Callable[..., Any], controls: dict[str, Any]) -> None:
        self.function, self.controls = function, controls
        self.picture = _drawn(function, self.values)
        self._place, self._shown = uuid.uuid4().hex, False
        for control in controls.values():
            control.observe(self._moved, names="value")

    @property
    def values(self) -> dict[str, Any]:
        """Value of every parameter, as the controls stand."""
        return {name: control.value for name, control in self.controls.items()}

    def move(self, **values: Any) -> dict[str, Any]:
        """Set controls as the mouse would; return the new picture by media type."""
        for name, value in values.items():
            self.controls[name].value = value
        return self.picture

    def _moved(self, _: Any) -> None:
        try:
            self.picture = _drawn(self.function, self.values)
        except Exception as error:
            # an exception in a widget's callback is seen by nobody: put its words in the picture's
            # place, and let the next move try again
            words = str(error) if isinstance(error, InputError) else repr(error)
            self.picture = {"text/plain": words}
        if self._shown:
            _publish(self.picture, self._place, update=True)

    def _ipython_display_(self) -> None:
        from ipywidgets import VBox

        told = (
            f"In JupyterLab, run this cell to move {_listed(self.controls)}; the picture shows one"
            " setting."
        )
        view = VBox(list(self.controls.values()))._repr_mimebundle_()
        _publish(
            {
                "text/plain": f"controls: {', '.join(self.controls)}",
                "text/html": f"<p class='widget'><em>{html.escape(told)}</em></p>",
                WIDGET: view[WIDGET],
            }
        )
        _publish(self.picture, self._place)
        self._shown = True


def _publish(data: dict[str, Any], place: str | None = None, *, update: bool = False) -> None:
    from IPython.display import display

    if place is None:
        display(data, raw=True)  # type: ignore[no-untyped-call]
    else:
        display(data, raw=True, display_id=place, update=update)  # type: ignore[no-untyped-call]


def _drawn(function: Callable[..., Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Call the function and return what it drew, returned or printed, by media type."""
    import matplotlib.pyplot as plt
    from IPython.utils.capture import capture_output
    from matplotlib.artist import Artist

    before = set(plt.get_fignums())
    with capture_output() as caught:  # type: ignore[no-untyped-call]
        result = function(**values)
    new = [plt.figure(number) for number in plt.get_fignums() if number not in before]
    told = "picture at " + ", ".join(f"{name} = {_short(v)}" for name, v in values.items())
    figure = result.get_figure() if isinstance(result, Artist) else None
    figures = new if figure is None else [figure]
    pictures = [figure_png(figure) for figure in figures[-1:]]
    for open_figure in new:
        plt.close(open_figure)
    # plt.show() of the inline backend has displayed and closed its figures already
    pictures += [o.data["image/png"] for o in caught.outputs or () if "image/png" in o.data]
    if pictures:
        return {"image/png": pictures[0], "text/plain": told}
    return _words(caught.stdout if result is None else result)


def _words(result: Any) -> dict[str, Any]:
    if isinstance(result, str):
        return {"text/plain": result.rstrip("\n")}
    data = {"text/plain": repr(result)}
    if (rich := getattr(result, "_repr_html_", None)) is not None:
        data["text/html"] = rich()
    return data


def figure_png(figure: Any) -> str:
    """Return a figure as base64 text of a PNG, as wide as its labels need."""
    import base64
    import io

    stream = io.BytesIO()
    figure.savefig(stream, format="png", bbox_inches="tight")
    return base64.b64encode(stream.getvalue()).decode("ascii")


def _defaults(function: Callable[..., Any], controls: Mapping[str, Any]) -> dict[str, Any]:
    known = inspect.signature(function).parameters
    free = [name for name in known if known[name].default is inspect.Parameter.empty]
    name = getattr(function, "__name__", "the function")
    if set(controls) - set(known) or set(free) - set(controls) or not controls:
        raise InputError(
            f"Expected a control for each parameter of {name} ({', '.join(known)}), but got"
            f" {', '.join(controls) or 'none'}; name them as in the function."
        )
    return {name: known[name].default for name in controls if name not in free}


def _control(name: str, spec: Any, defaults: Mapping[str, Any]) -> Any:
    """Make the widget for one parameter."""
    import ipywidgets as widgets

    look: dict[str, Any] = {
        "description": label(name),
        "style": {"description_width": "10em"},
        "layout": {"width": "30em"},
    }
    if isinstance(spec, widgets.Widget):
        return spec
    if isinstance(spec, bool):
        return widgets.Checkbox(value=bool(defaults.get(name, spec)), **look)
    if isinstance(spec, tuple):
        return _slider(name, spec, defaults, look)
    options = list(spec.items()) if isinstance(spec, Mapping) else list(spec)
    values = list(spec.values()) if isinstance(spec, Mapping) else options
    if not values:
        raise InputError(f"Expected choices for {name}, but the list is empty; name at least one.")
    first = defaults.get(name, values[0])
    numbers = all(isinstance(value, int | float) for value in options)
    kind = widgets.SelectionSlider if numbers else widgets.Dropdown
    more = {"continuous_update": False} if numbers else {}
    return kind(options=options, value=first, **more, **look)


def _slider(name: str, spec: tuple[Any, ...], defaults: Mapping[str, Any],
            look: dict[str, Any]) -> Any:  # fmt: skip
    import ipywidgets as widgets

    if len(spec) not in (2, 3) or not spec[0] < spec[1]:
        raise InputError(
            f"Expected (low, high) or (low, high, step) for {name}, but got {spec}; for choices"
            " pass a list."
        )
    low, high = spec[:2]
    whole = all(isinstance(value, int) for value in spec)
    step = spec[2] if len(spec) == 3 else 1 if whole else (high - low) / STEPS
    value = defaults.get(name, low + step * round(0.5 * (high - low) / step))
    if not low <= value <= high:
        raise InputError(
            f"Expected a start for {name} from {low} to {high}, but got {value}; widen the range or"
            " move the start."
        )
    kind = widgets.IntSlider if whole and isinstance(value, int) else widgets.FloatSlider
    return kind(min=low, max=high, step=step, value=value, continuous_update=False, **look)


def label(name: str) -> str:
    """Turn a parameter's name into words with its unit.

    Examples
    --------
    >>> label("object_angle_deg"), label("friction")
    ('object angle [deg]', 'friction')
    """
    words, _, unit = name.rpartition("_")
    if words and unit in UNITS:
        return f"{words.replace('_', ' ')} [{unit}]"
    return name.replace("_", " ")


def _listed(names: Any) -> str:
    words = [label(name) for name in names]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _short(value: Any) -> str:
    return f"{value:g}" if isinstance(value, int | float) else str(value)
