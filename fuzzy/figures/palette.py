"""The colours of every picture and page; no drawing library is imported, so that pages need none."""

from typing import NamedTuple


class Shade(NamedTuple):
    """One colour as CSS writes it, on a light and on a dark page; pictures are always light."""

    light: str
    dark: str


# Okabe-Ito, by contrast on white; yellow (1.3 : 1) is no line colour. Every line also has its own dashes.
SERIES = (
    Shade("#0072b2", "#4c9fe0"),
    Shade("#d55e00", "#f07f33"),
    Shade("#009e73", "#17b98b"),
    Shade("#cc79a7", "#e39cc4"),
    Shade("#56b4e9", "#8fd0f5"),
    Shade("#e69f00", "#f0b429"),
    Shade("#000000", "#f4f4f4"),
)
# Some of the series, by number, where thin marks on a light page need more contrast.
STRONG = {3: "#b04a82", 4: "#1f86c4", 5: "#b87900"}
ROLES = {
    "ink": Shade("#1b1f24", "#e6e8eb"),  # text
    "quiet": Shade("#57606a", "#a3abb5"),  # secondary text, axes
    "faint": Shade("#8c959f", "#6b7580"),  # what cannot be used now, frames of the header
    "paper": Shade("#ffffff", "#15181c"),  # the background
    "band": Shade("#f3f5f7", "#1f242a"),  # the background of headings and of what is pointed at
    "line": Shade("#d8dee4", "#343c45"),  # rules between rows, grids
    "edge": Shade("#c3cad2", "#4a535d"),  # frames of controls
    "link": Shade("#0060a0", "#6cb8f0"),  # links, the focus, the main button
    "on": Shade("#e8f1f9", "#1d2e3d"),  # the background of what is selected
    "mark": Shade("#c8102e", "#ff6b7d"),  # the input's value and the result in the rule viewer
    "other": Shade("#767f89", "#8d97a2"),  # the design that another one is compared with
    "hatch": Shade("#a9b1ba", "#59626c"),  # where no rule fires
    "wrong": Shade("#b3261e", "#ff8a80"),  # problems
}
# From the first series over white to the second: of numbers that may lie on both sides of one
DIVERGING = (SERIES[0].light, "#b9d6ea", "#ffffff", "#f7cfae", SERIES[1].light)
COLORS = tuple(shade.light for shade in SERIES)
HIGHLIGHT = ROLES["mark"].light
_FONT = 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif'


def stylesheet() -> str:
    """The palette as CSS custom properties, light or dark as the reader prefers: for a page's head or a widget.

    ``--ff-ink`` and the other ROLES; ``--ff-c0`` to ``--ff-c6``, the series; ``--ff-s3`` to ``--ff-s5``, the strong
    ones; ``--ff-font``, the letters of all pages. A notebook may put a widget into a shadow tree, where ``:root`` finds
    nothing: hence ``:host``.
    """
    shades = {
        **ROLES,
        **{f"c{n}": shade for n, shade in enumerate(SERIES)},
        **{f"s{n}": Shade(light, SERIES[n].dark) for n, light in STRONG.items()},
        "font": Shade(_FONT, _FONT),
    }
    light, dark = (
        " ".join(f"--ff-{name}: {getattr(shade, page)};" for name, shade in shades.items()) for page in Shade._fields
    )
    return f":root, :host {{ {light} }}\n@media (prefers-color-scheme: dark) {{ :root, :host {{ {dark} }} }}\n"
