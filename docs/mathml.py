"""Equations as MathML, which every browser draws: the site needs no script and no network for them."""

from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer; ``html_math_renderer = "mathml"`` chooses it."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _inline(translator, node) -> None:  # type: ignore[no-untyped-def]
    translator.body.append(tex2mathml(node.astext(), as_block=False))
    _left()


def _display(translator, node) -> None:  # type: ignore[no-untyped-def]
    number = f'<span class="eqno">({node["number"]})</span>' if node.get("number") else ""
    translator.body.append(f'<div class="math">{number}{tex2mathml(node.astext(), as_block=True)}</div>')
    _left()


def _left() -> None:
    from docutils.nodes import SkipNode

    raise SkipNode
