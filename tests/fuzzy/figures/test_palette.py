"""A colour stands once: in the palette, from which pictures and pages have it."""

import re
from pathlib import Path

import matplotlib as mpl
from matplotlib.colors import same_color, to_rgb

import fuzzy
from fuzzy.figures.drawing import style
from fuzzy.figures.palette import ROLES, SERIES, STRONG, stylesheet

ROOT = Path(fuzzy.__file__).parent.parent
# Scales of many colours, and what is drawn on them, belong to the picture alone.
EXCEPT = {"palette.py", "field.js"}


def luminance(color: str) -> float:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(color)]
    return sum(weight * c for weight, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def test_no_other_file_has_colours_of_its_own() -> None:
    files = [
        path
        for package in ("anfis", "fuzzy", "robotics")
        for path in (ROOT / package).rglob("*")
        if path.suffix in (".css", ".j2", ".js", ".mplstyle", ".py") and path.name not in EXCEPT
    ]
    found = {
        f"{path.name}: {color}"
        for path in files
        for color in re.findall(r"#(?:[0-9a-fA-F]{3}){1,2}\b", path.read_text(encoding="utf-8"))
    }
    # Black and white are the lines on a coloured surface, whatever the page.
    assert found <= {"designer.css: #000000", "designer.css: #ffffff"}


def test_every_custom_property_is_in_the_palette() -> None:
    defined = set(re.findall(r"--ff-\w+(?=:)", stylesheet()))
    sheets = [path for package in ("anfis", "fuzzy", "robotics") for path in (ROOT / package).rglob("*.css")]
    used = {name for sheet in sheets for name in re.findall(r"--ff-\w+", sheet.read_text(encoding="utf-8"))}
    assert used
    assert used <= defined


def test_text_is_read_on_both_pages() -> None:
    for page in ("light", "dark"):
        shade = {name: getattr(role, page) for name, role in ROLES.items()}
        for name in ("ink", "quiet", "link", "wrong", "mark"):  # 4.5 : 1, WCAG 2.2, 1.4.3
            assert contrast(shade[name], shade["paper"]) >= 4.5, (page, name)
        # 3 : 1 for what is no text, 1.4.11; the pale ones of the light page are marked by their dashes too.
        for n, line in enumerate(SERIES):
            pale = page == "light" and n in STRONG
            color = STRONG[n] if pale else getattr(line, page)
            assert contrast(color, shade["paper"]) >= 3, (page, n)


def test_pictures_take_the_series_in_turn() -> None:
    with style():
        cycle = mpl.rcParams["axes.prop_cycle"].by_key()["color"]
    assert all(same_color(a, b.light) for a, b in zip(cycle, SERIES, strict=True))
