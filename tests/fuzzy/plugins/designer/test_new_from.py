"""New designs in the browser: from starts, with terms spread evenly, and small surfaces that follow."""

import json
import os
import shutil

import numpy as np
import pytest

import fuzzy
from fuzzy.files.fisfile import read_fis, write_fis
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.folder import open_folder
from fuzzy.plugins.designer.open_documents import OpenDocuments
from fuzzy.plugins.designer.starting import pictures
from fuzzy.plugins.designer.starts.grid import grid
from fuzzy.plugins.designer.starts.packaged import packaged
from fuzzy.plugins.designer.starts.samples import example_table
from fuzzy.plugins.designer.views import several_data, surface_data
from tests.browsers import rest, run_apart
from tests.fuzzy.plugins.designer.served import Server, Watched, tipper
from tests.fuzzy.plugins.designer.test_designer_page import menu

pytest.importorskip("nicegui", reason="the designer needs the extra design")


@pytest.fixture
def server(tmp_path, site, monkeypatch):
    """A designer in a folder without a .fis file, with the entry points of this tree."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(site), *filter(None, [os.environ.get("PYTHONPATH")])]))
    shutil.copy(example_table(), tmp_path / "samples.csv")
    server = Server(tmp_path)
    yield server
    if server.process.poll() is None:
        assert server.end() == (0, "")


@pytest.fixture
def tab(server, browser):
    context = browser.new_context(viewport={"width": 1600, "height": 1000})
    tab = Watched(context, server)
    tab.open(server.address)
    yield tab
    assert tab.wrong == []
    context.close()


def card(page, start):
    return page.locator(f".start-card:has(input[value='{start}'])")


def small(page):
    return page.evaluate("[...document.querySelectorAll('.fd-multiple canvas')].map((c) => c.toDataURL())")


def fields(page):
    return page.locator(".fd-list input, .fd-list select").evaluate_all("(nodes) => nodes.map((node) => node.value)")


def until_terms(page, count):
    page.wait_for_function("(n) => document.querySelectorAll('.fd-list [role=listitem]').length === n", arg=count)


def test_a_new_design_is_kept_unsaved_and_takes_no_name_that_is_there(tmp_path):
    write_fis(tipper(), tmp_path / "taken.fis")
    opened = OpenDocuments(open_folder(tmp_path))

    document = opened.begun("mine.fis", tipper())
    assert (document.saved, document.touched, document.can_undo) == (False, True, None)
    assert not (tmp_path / "mine.fis").exists()
    again = Document(tmp_path / "mine.fis")  # after a crash
    assert again.restored is not None
    assert again.design.system == tipper()
    for name, said in (
        ("taken.fis", "exists already; choose another name, such as taken-2.fis"),
        ("mine.fis", "is open, or has unsaved work"),
        ("../out.fis", "begins with a dot"),
        ("mine.txt", "end the name in .fis"),
    ):
        with pytest.raises(fuzzy.errors.InputError, match=said):
            opened.begun(name, tipper())

    async def save():
        opened.save(document)

    run_apart(save())
    assert read_fis(tmp_path / "mine.fis") == tipper()
    assert document.saved
    assert read_fis(tmp_path / "taken.fis") == tipper()


def test_small_pictures_are_those_of_the_large_surface():
    design = design_of(packaged("tracking"))
    data = several_data(design, "pairs", [0, 1], 1, 9)
    assert [p["inputs"] for p in data["pictures"]] == [[i, j] for i in range(4) for j in range(i + 1, 4)]
    for each in (*data["pictures"], *several_data(design, "outputs", [2, 0], 1, 9)["pictures"]):
        large = surface_data(design, each["inputs"], each["output"], points=9)
        span = large["high"] - large["low"]
        assert np.allclose(np.array(each["z"], float), np.array(large["z"], float), atol=1e-3 * span + 1e-12)
        fired = np.array(large["fired"])
        assert (each["fired"] is None) == fired.all()
        assert each["fired"] is None or each["fired"] == fired.tolist()
    assert several_data(design, "one")["pictures"] == []
    (curve,) = several_data(design_of(grid(1, 1, 3, "trimf", 0, 1)), "outputs", points=5)["pictures"]
    assert curve["z"] == [0.5] * 5
    many = several_data(design_of(grid(10, 1, 2, "trimf", 0, 1)), "pairs", points=3)
    assert (len(many["pictures"]), many["left_out"]) == (36, 9)


def test_pictures_of_starts_show_what_changes():
    found = pictures(["grid", "wall-follower", "clusters"])
    assert [list(p) for p in found.values()] == [["curves"], ["surface"], ["surface"]]
    assert found["wall-follower"]["surface"]["output"] == 1  # the speed is the same over the first two inputs
    assert len(found["grid"]["curves"]) == 3


@pytest.mark.long
def test_a_new_design_from_tracking_drives_is_spread_evenly_and_its_small_surfaces_follow(tab, server):
    page = tab.page
    # The folder is empty: the page offers what else one can begin with. All by keyboard.
    page.locator(".restored").get_by_role("button", name="New from …").press("Enter")
    page.wait_for_selector(".start-card input:focus")
    card(page, "tracking").locator("input").focus()
    page.keyboard.press("ArrowRight")
    assert page.get_by_label("Name of the new file").input_value() == "wall-follower.fis"
    page.keyboard.press("ArrowLeft")
    assert page.get_by_label("Name of the new file").input_value() == "tracking.fis"
    page.wait_for_function(
        "document.querySelector('canvas[data-start=tracking]').style.width !== ''"  # its picture
    )
    page.get_by_label("Name of the new file").press("Enter")
    page.wait_for_url("**/?file=tracking.fis")
    page.wait_for_selector(".state.unsaved")
    assert not (server.folder / "tracking.fis").exists()  # but kept, as all unsaved work is
    kept = json.loads((server.folder / ".fuzzy-design" / "tracking.fis.json").read_text())
    assert "Name='tracking'" in kept["system"]
    page.get_by_role("tab", name="Try it").click()
    page.wait_for_selector("svg[aria-label*=path]")
    row = page.locator("tr", has_text="distance to the reference at the end [m]")
    assert 0 < float(row.locator("td").first.inner_text()) < 0.02  # it drove there
    # Terms spread evenly, and back.
    page.wait_for_selector(".fd-terms [role=slider]")
    page.get_by_role("button", name="alpha", exact=True).click()
    before = fields(page)
    page.get_by_label("number of terms to spread").fill("3")
    page.get_by_role("button", name="Spread evenly").click()
    until_terms(page, 3)
    assert page.locator(".said[role=status]").inner_text().startswith("Terms of alpha removed; ")
    page.keyboard.press("Control+z")
    until_terms(page, 5)
    assert fields(page) == before
    page.get_by_role("button", name="distance", exact=True).click()
    page.get_by_label("all terms as").select_option("gaussmf")
    page.wait_for_function(
        "[...document.querySelectorAll('.fd-list select')].every((select) => select.value === 'gaussmf')"
    )
    # Small surfaces
    page.get_by_role("tab", name="Surface").click()
    page.get_by_role("button", name="All pairs").click()
    page.wait_for_selector(".fd-multiple")
    assert page.locator(".fd-multiple").count() == 6
    seen = small(page)
    page.keyboard.press("Control+z")
    page.wait_for_function(
        """(seen) => [...document.querySelectorAll('.fd-multiple canvas')].some((c, k) => c.toDataURL() !== seen[k])""",
        arg=seen,
    )
    page.get_by_role("button", name="v over alpha, x_err").click()
    page.wait_for_selector(".fd-multiple[aria-pressed=true][aria-label='v over alpha, x_err']")
    assert page.get_by_label("first input").evaluate("(s) => s.selectedOptions[0].text") == "alpha"
    page.get_by_role("button", name="All outputs").click()
    page.wait_for_function("document.querySelectorAll('.fd-multiple').length === 2")
    # A slider of an input that is held moves the point.
    page.get_by_role("group", name="Other inputs").get_by_role("slider", name="distance").press("Home")
    page.wait_for_selector(".fd-held span:text('distance = 0 m')")


@pytest.mark.long
def test_what_cannot_be_made_is_said_and_nothing_is_overwritten(tab, server):
    page = tab.page
    write_fis(tipper(), server.folder / "taken.fis")
    menu(page, "New from …")
    card(page, "grid").click()
    for label, value in (("Inputs", "6"), ("Terms of each", "9")):
        page.get_by_role("spinbutton", name=label, exact=True).fill(value)
    page.get_by_role("button", name="Create").click()
    page.wait_for_selector(".new-from .problem:text('more than 2000')")
    page.get_by_role("spinbutton", name="Inputs").fill("1")
    page.get_by_label("Name of the new file").fill("taken.fis")
    page.get_by_role("button", name="Create").click()
    page.wait_for_selector(".new-from .problem:text('exists already')")
    page.get_by_label("Name of the new file").fill("../out")
    page.get_by_role("button", name="Create").click()
    page.wait_for_selector(".new-from .problem:text('begins with a dot')")
    card(page, "clusters").click()
    page.wait_for_selector(".start-columns .row")
    page.get_by_label("Name of the new file").fill("found")
    page.get_by_role("button", name="Create").click()
    page.wait_for_url("**/?file=found.fis")
    page.wait_for_selector(".state.unsaved")
    unit = page.get_by_label("unit", exact=True).element_handle()
    page.wait_for_function("(field) => field.value === 'm'", arg=unit)  # the panels are drawn after the header
    page.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    assert [v.name for v in read_fis(server.folder / "found.fis").outputs] == ["v"]
    assert read_fis(server.folder / "taken.fis") == tipper()


@pytest.mark.long
def test_anfis_learns_with_progress_and_is_stopped(tab):
    page = tab.page
    menu(page, "New from …")
    card(page, "anfis").click()
    page.wait_for_selector(".start-columns .row")
    for width, height in ((390, 844), (1100, 800)):
        page.set_viewport_size({"width": width, "height": height})
        create, form = (page.locator(f".new-from {part}").bounding_box() for part in ("button.first", "form"))
        assert create["y"] + create["height"] <= form["y"] + form["height"] <= height  # though there is more than fits
        assert page.locator(".new-from").evaluate("(box) => box.scrollHeight <= box.clientHeight")
    page.get_by_label("Epochs", exact=True).fill("2000")
    page.get_by_role("button", name="Create").click()
    page.wait_for_selector(".start-progress span:text('epoch')")
    page.get_by_role("button", name="Cancel").click()
    page.wait_for_function("!document.querySelector('dialog[open]')")
    menu(page, "New from …")
    page.get_by_label("Epochs", exact=True).fill("5")
    page.get_by_role("button", name="Create").click()
    page.wait_for_url("**/?file=anfis.fis")
    page.wait_for_selector(".state.unsaved")


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_dialog_and_small_surfaces_are_accessible_on_every_screen(tab, server, scheme):
    pytest.importorskip("axe_playwright_python", reason="axe-core comes with the extra test")
    from tests.fuzzy.plugins.designer.test_designer_everywhere import SCREENS, grave

    page = tab.page
    write_fis(packaged("tracking"), server.folder / "shipped.fis")
    tab.open(f"{server.url}?file=shipped.fis")
    page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    page.get_by_role("tab", name="Surface").click()
    page.get_by_role("button", name="All pairs").click()
    page.wait_for_selector(".fd-multiple")
    for width, height in SCREENS:
        page.set_viewport_size({"width": width, "height": height})
        rest(page)
        assert grave(page) == []
        menu(page, "New from …")
        card(page, "clusters").click()
        page.wait_for_selector(".start-columns .row")
        assert grave(page) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
