"""The pictures of docs/howto/designer.md: every view of the designer in a real browser.

`make docs` takes them anew where Chromium is installed and the designer has changed. Those beside the page, for who
reads it without the site, are taken by ``python -m benchmarks.designerpictures docs/howto/designer`` (a minute).
"""

import argparse
import hashlib
import io
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.designersession import browser, menu, missing, purpose, served, show, tab, workplace
from fuzzy.files.atomic import replacing, write_whole

WIDTH, HEIGHT = 1600, 1100  # px
PLAYED = ".fd-tryout .fleet-player canvas"  # the small picture under what is edited, which may be hidden, has one too
COLORS, EXACT = 64, 40  # of a picture; so many of them are its most frequent ones, of flat areas and curves
ROOT = Path(__file__).parent.parent
SOURCES = ("fuzzy", "anfis", "robotics", "benchmarks")  # where what the pictures show is made,
SHOWN = (".py", ".js", ".css", ".fis", ".toml")  # of such files


def take(folder: Path) -> list[Path]:
    """Take all pictures into ``folder``; give their paths."""
    taken: list[Path] = []
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        workplace(Path(place))
        with served(Path(place), "tracking.fis") as (url, _), browser() as opened:
            page = opened.new_page(viewport={"width": WIDTH, "height": HEIGHT})
            show(page, url)
            for name, view in VIEWS.items():
                view(page)
                _rest(page)
                page.evaluate("scrollTo(0, 0)")
                taken.append(_written(folder / f"{name}.webp", page.screenshot()))
            _edited(page)
            taken.append(_written(folder / "designer.webp", page.screenshot()))
            show(page, f"{url.partition('?')[0]}?file=pd2.fis")
            _type2(page)
            taken.append(_written(folder / "type2.webp", page.screenshot()))
    return taken


def take_if_changed(folder: Path) -> bool:
    """Take all pictures into ``folder`` unless it holds those of these sources; False: there is no browser here."""
    if missing() is not None:
        return False
    found = hashlib.sha256()
    for file in sorted(each for place in SOURCES for each in (ROOT / place).rglob("*.*")):
        if file.suffix in SHOWN:
            found.update(file.read_bytes())
    mark = folder / "sources.sha256"
    if not mark.exists() or mark.read_text(encoding="utf-8") != found.hexdigest():
        take(folder)
        write_whole(mark, found.hexdigest())
    return True


def _written(path: Path, data: bytes) -> Path:
    from PIL import Image

    picture = Image.open(io.BytesIO(data)).convert("RGB")
    counted = sorted(picture.getcolors(picture.width * picture.height) or [], reverse=True)
    exact = [part for _, colour in counted[:EXACT] for part in colour]  # type: ignore[attr-defined]
    rest = picture.quantize(COLORS - EXACT, method=Image.Quantize.MAXCOVERAGE).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette((exact + rest)[: 3 * COLORS])
    small = picture.quantize(palette=palette, dither=Image.Dither.NONE).convert("RGB")
    with replacing(path) as part:
        small.save(part, format="WEBP", lossless=True, quality=100, method=6)
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
    purpose(page, "Function")
    page.get_by_role("button", name="Enlarge why").click()
    slider = page.locator(".fd-viewer [role=slider]").nth(1)
    slider.focus()
    for _ in range(3):
        page.keyboard.press("Shift+ArrowRight")
    page.evaluate("document.activeElement.blur()")


def _surface(page: Any) -> None:
    page.get_by_role("button", name="Enlarge why").click()
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


def _sheet(page: Any, on: bool) -> None:
    """Open or close the settings of the robot's runs."""
    page.locator(".fd-tryout details.pn-line").evaluate("(sheet, on) => { sheet.open = on; }", on)


def _choose(page: Any, label: str, value: str) -> None:
    _sheet(page, True)
    page.locator(".fd-tryout").get_by_label(label, exact=True).select_option(value)
    _sheet(page, False)


def _address(page: Any, name: str) -> str:
    origin: str = page.evaluate("location.origin")
    return f"{origin}/?file={name}"


def _try_it(page: Any) -> None:
    show(page, _address(page, "tracking.fis"))
    purpose(page, "Robot")
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
    page.locator(".shell-badge").click()
    page.wait_for_timeout(1500)


def _seeds(page: Any) -> None:
    _choose(page, "Scenario", "table-2-1")
    _until_run(page, columns=4)
    _choose(page, "Seeds at once", "20")
    _until_seeds(page)


def _editing(page: Any) -> None:
    _choose(page, "Scenario", "past-a-post.toml")
    page.wait_for_selector(".fd-tryout .se-stale")
    _until_seeds(page)
    page.wait_for_selector(PLAYED)
    _until_run(page, columns=4)
    _sheet(page, True)
    page.get_by_role("button", name="Edit the scenario's file").click()
    _sheet(page, False)
    page.get_by_label("Text of the scenario past-a-post.toml").press("Control+End")
    page.evaluate("document.activeElement.blur()")


def _until_seeds(page: Any) -> None:
    page.wait_for_function("document.querySelectorAll('.fd-tryout .se-row:not(.se-stale) .se-one').length === 20")
    page.wait_for_function("document.querySelector('.fd-tryout .tr-seeds progress').hasAttribute('hidden')")
    page.wait_for_function("!document.querySelector('.fd-tryout .tr-metrics').innerText.includes('…')")


def _team(page: Any) -> None:
    page.get_by_role("button", name="Close", exact=True).click()
    _choose(page, "Seeds at once", "1")
    _choose(page, "Scenario", "outage-10s")
    page.wait_for_selector(PLAYED)
    _until_run(page, columns=4)
    _set(page.locator(".fd-tryout .fleet-player input[type=range]").first, 24.0)


def _data(page: Any) -> None:
    purpose(page, "Function")
    tab(page, "Data")
    page.locator(".fd-data").get_by_label("File of the folder").select_option("drive.csv")
    page.wait_for_selector(".fd-data .dp-worst button")


def _train(page: Any) -> None:
    tab(page, "Train")
    training = page.locator(".fd-training")
    training.get_by_label("Start from").select_option("grid")
    training.get_by_label("File of the folder").select_option("f:sinc.csv")
    page.wait_for_function("document.querySelector('.fd-training').innerText.includes('400 samples')")
    page.get_by_role("button", name="Train", exact=True).click()
    page.wait_for_function("document.querySelector('.fd-training .pn-said').innerText.includes('all epochs are done')")


def _tune(page: Any) -> None:
    purpose(page, "Robot")
    tab(page, "Tune")
    page.wait_for_selector(".fd-tuning .pn-main:not([disabled])")
    page.locator(".tu-many input[value=fuzzy-off-path]").check()
    page.locator(".tu-many input[value=lyapunov-sine]").uncheck()
    for label, value in (("Runs (seeds) of each", "3"), ("Evaluations", "200")):
        page.get_by_label(label, exact=True).fill(value)
        page.get_by_label(label, exact=True).press("Tab")
    page.get_by_role("button", name="Start").click()
    page.wait_for_selector(".tu-verdict:text('unseen seeds')", timeout=120_000)
    page.locator(".pn-said[role=status]").last.evaluate("(said) => said.scrollIntoView({ block: 'start' })")


def _certificate(page: Any) -> None:
    show(page, _address(page, "correcting.fis"))
    tab(page, "Certificate")
    page.wait_for_selector(".fd-certificate svg.pn-plot path.ce-error", timeout=120_000)


def _edited(page: Any) -> None:
    """A wider "Straight" than the file's, dashed behind it, smaller rates of turn, and what the robot makes of them."""
    tab(page, "Memberships")
    _choose(page, "Scenario", "fuzzy-off-path")
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


def _type2(page: Any) -> None:
    field = page.get_by_role("spinbutton", name="now, the current value")
    field.fill("-0.3")
    field.press("Enter")
    page.wait_for_selector(".said[role=status]:empty", state="attached")
    _rest(page)


def _until_run(page: Any, columns: int) -> None:
    page.wait_for_function(f"document.querySelectorAll('.fd-tryout .tr-metrics thead th').length >= {columns}")
    page.wait_for_function("document.querySelector('.fd-tryout .tr-busy').textContent === ''")


def _set(slider: Any, value: float) -> None:
    slider.evaluate("(node, value) => { node.value = value; node.dispatchEvent(new Event('input')); }", value)


# By name: how one comes to a view from the one before
VIEWS: dict[str, Callable[[Any], None]] = {
    "memberships": _memberships,
    "consequents": _consequents,
    "rules": _rules,
    "table": _table,
    "matrix": _matrix,
    "check": _check,
    "history": _history,
    "viewer": _viewer,
    "surface": _surface,
    "relief": _relief,
    "pairs": _pairs,
    "new-from": _new_from,
    "compared": _compared,
    "data": _data,
    "step": _step,
    "certificate": _certificate,
    "try-it": _try_it,
    "moments": _moments,
    "seeds": _seeds,
    "editing": _editing,
    "team": _team,
    "train": _train,
    "tune": _tune,
}


def run(taking: Callable[[Path], list[Path]], about: str | None, example: str) -> None:
    """Read the command line of a script ``about`` pictures, and take them by ``taking`` into the folder it names."""
    parser = argparse.ArgumentParser(description=(about or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, help=f"where the pictures go, such as {example}")
    arguments = parser.parse_args()
    why = missing()
    if why is not None:
        sys.exit(why)
    taken = taking(arguments.folder)
    print(f"{len(taken)} pictures, {sum(path.stat().st_size for path in taken) / 1e6:.2f} MB")


if __name__ == "__main__":
    run(take, __doc__, "docs/howto/designer")
