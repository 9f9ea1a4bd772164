"""The pictures of docs/howto/designer.md: every view of the designer in a real browser, at three widths.

Run ``python -m benchmarks.designerpictures docs/designer`` (needs Chromium; two minutes).
"""

import argparse
import io
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.designersession import browser, menu, missing, served, show, tab, workplace
from fuzzy.files.atomic import replacing

WIDTHS = (390, 800, 1600)
HEIGHT = 1000  # px of a narrow window
TALLEST = 1250  # px of a picture, and of a window with two panes, of which one scrolls by itself
PLAYED = ".fd-tryout .fleet-player canvas"  # the small picture under what is edited, which may be hidden, has one too
SCROLLED = ("moments",)  # views further down in a pane that scrolls by itself: on wide screens
DIALOG = -1  # in the place of a group of views
EXACT = 160  # of the 256 colours of a picture: the most frequent, which are flat areas and curves


def take(folder: Path, widths: tuple[int, ...] = WIDTHS) -> list[Path]:
    """Take all pictures into ``folder``; give their paths."""
    taken: list[Path] = []
    with tempfile.TemporaryDirectory() as place:
        workplace(Path(place))
        with served(Path(place), "tracking.fis") as (url, _), browser() as opened:
            page = opened.new_page(viewport=_window(1600))
            show(page, url)
            for name, (group, view) in VIEWS.items():
                view(page)
                for width in widths if name not in SCROLLED else [w for w in widths if w >= 1600]:
                    page.set_viewport_size(_window(width))
                    _rest(page)
                    taken.append(_written(folder / f"{name}-{width}.png", _picture(page, group, width)))
                page.set_viewport_size(_window(1600))
                _rest(page)
            _edited(page)
            taken.append(_written(folder / "designer.png", _picture(page, 1, 1600)))
    return taken


def _window(width: int) -> Any:
    return {"width": width, "height": TALLEST if width >= 900 else HEIGHT}


def _picture(page: Any, group: int, width: int) -> bytes:
    """The whole window where both groups of views stand in it, or a dialog does, else the group of the view."""
    page.evaluate("scrollTo(0, 0)")
    if group == DIALOG:
        shown: bytes = page.screenshot()
        return shown
    if width >= 1600:
        data: bytes = page.screenshot(full_page=True, clip={"x": 0, "y": 0, "width": width, "height": TALLEST})
        return data
    box = page.locator(".shell-group").nth(group).bounding_box()
    # Under what is edited stands a small picture, at the lower end of the window: there the picture ends.
    most = HEIGHT - box["y"] if group == 0 else TALLEST
    clip = {"x": 0 if width < 600 else box["x"] - 10, "y": box["y"], "height": min(most, box["height"] + 10)}
    data = page.screenshot(full_page=True, clip=clip | {"width": width - clip["x"]})
    return data


def _written(path: Path, data: bytes) -> Path:
    from PIL import Image

    picture = Image.open(io.BytesIO(data)).convert("RGB")
    counted = sorted(picture.getcolors(picture.width * picture.height) or [], reverse=True)
    exact = [part for _, colour in counted[:EXACT] for part in colour]  # type: ignore[attr-defined]
    rest = picture.quantize(256 - EXACT, method=Image.Quantize.MAXCOVERAGE).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette((exact + rest)[:768])
    small = picture.quantize(palette=palette, dither=Image.Dither.NONE)
    with replacing(path) as part:
        small.save(part, format="PNG", optimize=True)
    return path


def _rest(page: Any) -> None:
    """Until what was asked for has been drawn; the pictures of a surface become fine after 0.2 s."""
    page.wait_for_timeout(900)
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


# The views --------------------------------------------------------------------------------------------------------


def _memberships(page: Any) -> None:
    page.get_by_role("treeitem", name="Far", exact=False).get_by_text("Far", exact=True).first.click()


def _consequents(page: Any) -> None:
    page.locator(".fd-terms .fd-tab.fd-output").nth(1).click()


def _rules(page: Any) -> None:
    tab(page, "Rules")
    field = page.get_by_role("textbox", name="rule 3", exact=True)
    field.fill("if distance is Medum and x_err is Poserr then v is Slow and w is Zero")
    field.press("Enter")
    page.wait_for_selector(".fd-rules mark")


def _table(page: Any) -> None:
    page.keyboard.press("Control+z")
    page.wait_for_selector(".fd-rules mark", state="detached")
    page.locator(".fd-rules .fd-tab[data-view=table]").click()


def _matrix(page: Any) -> None:
    page.locator(".fd-rules .fd-tab[data-view=matrix]").click()
    page.get_by_role("button", name="Strongest now").click()


def _history(page: Any) -> None:
    page.keyboard.press("Control+z")
    page.wait_for_selector(".state:not(.unsaved)")
    tab(page, "Memberships")
    _memberships(page)
    field = page.get_by_role("spinbutton", name="right foot of Far", exact=True)
    for count, value in enumerate((1.1, 0.8), 1):
        field.fill(str(value))
        field.press("Enter")
        page.wait_for_timeout(1200)  # what is typed within a second is one edit
        tab(page, "History")
        page.get_by_label("Name of a snapshot").fill(f"Far ends at {value} m")
        page.keyboard.press("Enter")
        page.wait_for_function("(n) => document.querySelectorAll('.fd-shot').length === n", arg=count)
        tab(page, "Memberships")
    tab(page, "History")
    page.locator(".fd-edits button").nth(1).click()
    page.wait_for_selector(".fd-edits li:nth-child(2) [aria-current]")
    page.wait_for_function("document.querySelector('.said[role=status]').textContent === ''")
    page.evaluate("document.activeElement.blur()")


def _viewer(page: Any) -> None:
    page.locator(".fd-edits button").last.click()
    tab(page, "Memberships")
    _memberships(page)
    tab(page, "Viewer")
    slider = page.locator(".fd-viewer [role=slider]").nth(1)
    slider.focus()
    for _ in range(3):
        page.keyboard.press("Shift+ArrowRight")
    page.evaluate("document.activeElement.blur()")


def _surface(page: Any) -> None:
    tab(page, "Surface")
    page.wait_for_selector(".fd-surface")
    page.get_by_role("tabpanel", name="Surface").get_by_label("output", exact=True).select_option("1")


def _relief(page: Any) -> None:
    page.locator(".fd-surface .fd-tab[data-view='3d']").click()


def _pairs(page: Any) -> None:
    page.locator(".fd-surface .fd-tab[data-view=contour]").click()
    page.get_by_role("button", name="All pairs").click()
    page.wait_for_selector(".fd-multiple")


def _new_from(page: Any) -> None:
    menu(page, "New from …")
    page.locator(".start-card:has(input[value=clusters])").click()
    page.wait_for_selector(".start-columns .row")
    # The pictures come a few at a time.
    page.wait_for_function("document.querySelector('canvas[data-start=wall-follower]').style.width !== ''")
    page.evaluate("document.querySelector('.starts').scrollTop = 0")


def _compared(page: Any) -> None:
    _closed(page)
    page.locator(".fd-surface .fd-tab[data-mode=one]").click()
    _compare(page, "sharper.fis")


def _closed(page: Any) -> None:
    page.get_by_role("dialog").get_by_role("button", name="Cancel").click()


def _compare(page: Any, name: str) -> None:
    menu(page, "Compare with")
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("combobox").select_option(name)
    dialog.get_by_role("button", name="Compare").click()


def _step(page: Any) -> None:
    _compare(page, "")
    show(page, _address(page, "pd.fis"))
    tab(page, "Step response")
    page.wait_for_selector(".fd-step tbody tr")
    _set(page.get_by_label("Time", exact=True), 40)


def _address(page: Any, name: str) -> str:
    origin: str = page.evaluate("location.origin")
    return f"{origin}/?file={name}"


def _try_it(page: Any) -> None:
    show(page, _address(page, "tracking.fis"))
    tab(page, "Try it")
    _until_run(page, columns=4)
    page.wait_for_selector(".fd-tryout .rs-plot")
    _set(page.locator(".fd-tryout .tr-time input[type=range]").first, 3.2)
    page.wait_for_timeout(500)


def _moments(page: Any) -> None:
    page.locator(".shell-view .fd-tryout .pn-keys").first.evaluate("(keys) => keys.scrollIntoView({ block: 'start' })")


def _check(page: Any) -> None:
    page.locator(".fd-rules .fd-tab[data-view=sentences]").click()
    tab(page, "Memberships")
    page.get_by_role("spinbutton", name="to, the highest value", exact=True).fill("0.6")
    page.keyboard.press("Enter")
    page.get_by_role("group", name="Terms in the new range").get_by_role("button", name="Keep").click()
    page.get_by_role("tab", name="Check").click()
    page.wait_for_timeout(1500)


def _seeds(page: Any) -> None:
    page.get_by_label("Scenario", exact=True).select_option("table-2-1")
    _until_run(page, columns=4)
    page.get_by_label("Seeds at once").select_option("20")
    _until_seeds(page)


def _editing(page: Any) -> None:
    page.get_by_label("Scenario", exact=True).select_option("past-a-post.toml")
    page.wait_for_selector(".fd-tryout .se-stale")
    _until_seeds(page)
    page.wait_for_selector(PLAYED)
    _until_run(page, columns=4)
    page.get_by_role("button", name="Edit the scenario's file").click()
    page.get_by_label("Text of the scenario past-a-post.toml").press("Control+End")
    page.evaluate("document.activeElement.blur()")


def _until_seeds(page: Any) -> None:
    page.wait_for_function("document.querySelectorAll('.fd-tryout .se-row:not(.se-stale) .se-one').length === 20")
    page.wait_for_function("document.querySelector('.fd-tryout .tr-seeds progress').hasAttribute('hidden')")
    page.wait_for_function("!document.querySelector('.fd-tryout .tr-metrics').innerText.includes('…')")


def _team(page: Any) -> None:
    page.get_by_role("button", name="Close", exact=True).click()
    page.get_by_label("Seeds at once").select_option("1")
    page.get_by_label("Scenario", exact=True).select_option("outage-10s")
    page.wait_for_selector(PLAYED)
    _until_run(page, columns=4)
    _set(page.locator(".fd-tryout .fleet-player input[type=range]").first, 24.0)


def _data(page: Any) -> None:
    tab(page, "Data")
    page.locator(".fd-data").get_by_label("File of the folder").select_option("drive.csv")
    page.wait_for_selector(".fd-data .dp-worst button")


def _train(page: Any) -> None:
    page.get_by_label("Scenario", exact=True).select_option("table-2-1")
    tab(page, "Train")
    page.get_by_label("Start from").select_option("grid")
    page.get_by_label("File of the folder").select_option("f:sinc.csv")
    page.wait_for_function("document.querySelector('.fd-training').innerText.includes('400 samples')")
    page.get_by_role("button", name="Train", exact=True).click()
    page.wait_for_function("document.querySelector('.fd-training .pn-said').innerText.includes('all epochs are done')")


def _edited(page: Any) -> None:
    """A wider "Straight" than the file's, dashed behind it, smaller rates of turn, and what the robot makes of them."""
    tab(page, "Try it")
    page.get_by_label("Scenario", exact=True).select_option("fuzzy-off-path")
    _until_run(page, columns=4)
    page.locator(".fd-terms .fd-tab").nth(1).click()
    for foot, value in (("left", -0.9), ("right", 0.9)):
        field = page.get_by_role("spinbutton", name=f"{foot} foot of Straight", exact=True)
        field.fill(str(value))
        field.press("Enter")
    page.locator(".fd-terms .fd-tab.fd-output").nth(1).click()
    for term, value in (("Negative", -1.2), ("Positive", 1.2)):
        field = page.get_by_role("spinbutton", name=f"value of {term}", exact=True)
        field.fill(str(value))
        field.press("Enter")
    _compare(page, "tracking.fis")
    page.get_by_role("treeitem", name="Straight", exact=False).get_by_text("Straight", exact=True).first.click()
    page.evaluate("document.activeElement.blur()")
    page.wait_for_timeout(2000)
    _until_run(page, columns=4)


def _until_run(page: Any, columns: int) -> None:
    page.wait_for_function(f"document.querySelectorAll('.fd-tryout .tr-metrics thead th').length >= {columns}")
    page.wait_for_function("document.querySelector('.fd-tryout .tr-busy').innerText === ''")


def _set(slider: Any, value: float) -> None:
    slider.evaluate("(node, value) => { node.value = value; node.dispatchEvent(new Event('input')); }", value)


# By name: the group of tabs that the view belongs to, and how one comes to it from the view before
VIEWS: dict[str, tuple[int, Callable[[Any], None]]] = {
    "memberships": (0, _memberships),
    "consequents": (0, _consequents),
    "rules": (0, _rules),
    "table": (0, _table),
    "matrix": (0, _matrix),
    "check": (0, _check),
    "history": (0, _history),
    "viewer": (1, _viewer),
    "surface": (1, _surface),
    "relief": (1, _relief),
    "pairs": (1, _pairs),
    "new-from": (DIALOG, _new_from),
    "compared": (1, _compared),
    "data": (1, _data),
    "step": (1, _step),
    "try-it": (1, _try_it),
    "moments": (1, _moments),
    "seeds": (1, _seeds),
    "editing": (1, _editing),
    "team": (1, _team),
    "train": (1, _train),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, help="where the pictures go, such as docs/designer")
    arguments = parser.parse_args()
    why = missing()
    if why is not None:
        sys.exit(why)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    taken = take(arguments.folder)
    print(f"{len(taken)} pictures, {sum(path.stat().st_size for path in taken) / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
