"""One notebook to one HTML page that opens offline: no script and no font from elsewhere."""

from __future__ import annotations

import html
import re
from typing import Any

from latex2mathml.converter import convert as mathml
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

from medkit.book.notebooks import WIDGET

#: What a page shows of an output that comes in several forms, best first.
PREFERENCE = (
    "text/html",
    "image/svg+xml",
    "image/png",
    "image/jpeg",
    "text/markdown",
    "text/plain",
)


class _OfflineRenderer(IPythonRenderer):
    """Markdown whose formulas are MathML, which a browser draws without any script."""

    def inline_math(self, body: str) -> str:
        return mathml(body)

    def block_math(self, body: str) -> str:
        return f"<div class='formula'>{mathml(body, display='block')}</div>"

    def latex_environment(self, name: str, body: str) -> str:
        return self.block_math(f"\\begin{{{name}}}{body}\\end{{{name}}}")


def markdown_html(source: str) -> str:
    """Render markdown, with formulas as MathML and links to notebooks as links to their pages."""
    renderer = _OfflineRenderer(escape=False, anchor_link_text="", exclude_anchor_links=True)
    text = str(MarkdownWithMath(renderer=renderer).render(source))
    text = re.sub(
        r'href="(?:[\w./-]*/)?([\w-]+)\.(?:ipynb|md)(#[^"]*)?"', r'href="\1.html\2"', text
    )
    return re.sub(r"<h([1-4])>(.*?)</h\1>", _anchored, text, flags=re.S)


def notebook_html(node: Any) -> str:
    """Render every cell of an executed notebook (nbformat node) as the body of a page."""
    return "\n".join(_cell_html(cell) for cell in node.cells)


def notebook_text(node: Any) -> str:
    """Words of a notebook's prose, for the search."""
    prose = " ".join(cell.source for cell in node.cells if cell.cell_type == "markdown")
    return " ".join(re.sub(r"[#*`$\\_|>{}\[\]()]+", " ", prose).split())


def code_css() -> str:
    """Style of highlighted code, readable in grey."""
    return str(HtmlFormatter(style="friendly").get_style_defs(".highlight"))


def _anchored(match: re.Match[str]) -> str:
    level, text = match.group(1), match.group(2)
    slug = re.sub(r"[^a-z0-9]+", "-", re.sub(r"<[^>]+>", "", text).lower()).strip("-")
    return f'<h{level} id="{slug}">{text}</h{level}>'


def _cell_html(cell: Any) -> str:
    anchor = html.escape(cell.get("id", ""))
    if cell.cell_type == "markdown":
        return f'<section class="prose" id="{anchor}">{markdown_html(cell.source)}</section>'
    if cell.cell_type != "code" or not cell.source.strip():
        return ""
    code = highlight(cell.source, PythonLexer(), HtmlFormatter())
    outputs = "".join(_output_html(output) for output in cell.outputs)
    return (
        f'<section class="cell" id="{anchor}">{code}<div class="outputs">{outputs}</div></section>'
    )


def _output_html(output: Any) -> str:
    if output.output_type == "stream":
        return f"<pre>{html.escape(output.text)}</pre>"
    if output.output_type == "error":
        return f"<pre class='error'>{html.escape(output.ename)}: {html.escape(output.evalue)}</pre>"
    data = output.data
    if WIDGET in data:
        return (
            "<p class='widget'>Here a control moves in JupyterLab; a picture stands beside it.</p>"
        )
    for kind in PREFERENCE:
        if kind in data:
            return _as_html(kind, data[kind])
    return ""


def _as_html(kind: str, value: str) -> str:
    if kind in ("text/html", "image/svg+xml"):
        return f"<div class='rich'>{value}</div>"
    if kind.startswith("image/"):
        return f"<img alt='figure' src='data:{kind};base64,{value.strip()}'>"
    if kind == "text/markdown":
        return markdown_html(value)
    return f"<pre>{html.escape(value)}</pre>"
