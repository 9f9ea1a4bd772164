"""A type-2 file in the designer, end to end: a real server and a real browser."""

import pytest

import fuzzy
from tests.browsers import drag, rest
from tests.fuzzy.plugins.designer.served import Watched, tipper

pytest.importorskip("nicegui", reason="the designer needs the extra design")
pytestmark = pytest.mark.long


def test_the_footprint_is_drawn_edited_undone_and_saved(browser, server):
    file, foot = server.folder / "two.fis", "[data-footprint=poor]"
    fuzzy.write_fis(fuzzy.to_type2(tipper(), {"service": {"good": (0.1, 0.3)}}, 0.8), file)
    before = file.read_bytes()
    context = browser.new_context(viewport={"width": 1600, "height": 1000})
    tab = Watched(context, server)
    tab.open(server.address)
    page = tab.open(f"{server.url}?file=two.fis")
    titles = page.locator("[role=tab]").all_inner_texts()
    assert "Surface" in titles
    assert not {"Data", "Train", "Step response", "Tune"} & set(titles)  # which would show the upper system
    assert page.locator("[data-footprint]").count() == 3
    assert page.get_by_role("spinbutton", name="right lag of good").input_value() == "0.3"
    shape = page.locator(foot).get_attribute("d")

    def edited(field, value):
        seen = page.locator(foot).get_attribute("d")
        page.get_by_role("spinbutton", name=field).fill(value)
        page.keyboard.press("Enter")
        page.wait_for_function("([at, d]) => document.querySelector(at).getAttribute('d') !== d", arg=[foot, seen])

    edited("lower scale of poor", "0.5")
    edited("lag of poor", "0.25")
    page.wait_for_selector(".state.unsaved")
    service = page.get_by_role("spinbutton", name="now, the current value")
    service.fill("1")
    page.keyboard.press("Enter")
    # poor 0.8 and from 0.5 (0.8 − 0.25)/0.75 on; bad 2/7 and 0.8 · 2/7: 0.37 · 0.229 to 0.8 · 0.286
    page.wait_for_selector(".fd-viewer :text('0.08–0.23')")
    page.wait_for_selector(".fd-words:text('the middle of the type-reduced set')", state="attached")
    page.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    assert fuzzy.read_type2(file).lower["service"]["poor"] == fuzzy.Lower(0.5, 0.25)
    # What makes no lower function is refused under its field.
    scale = page.get_by_role("spinbutton", name="lower scale of poor")
    scale.fill("1.5")
    page.keyboard.press("Enter")
    page.wait_for_selector(":text('must lie in (0, 1]')")
    page.keyboard.press("Escape")
    drag(page, page.get_by_role("slider", name="poor: right foot"), (60, 0), release=True)
    page.wait_for_selector(".state.unsaved")
    undo = page.get_by_role("button", name="Undo")
    while undo.get_attribute("aria-disabled") == "false":  # quick edits of one term are one step
        undo.click(force=True)  # it may have been the last step meanwhile
        rest(page)
    page.wait_for_function("([at, d]) => document.querySelector(at).getAttribute('d') === d", arg=[foot, shape])
    page.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    rest(page)
    assert file.read_bytes() == before
    assert tab.wrong == []
    context.close()


def test_a_page_has_the_panels_of_what_its_file_becomes(browser, server):
    tab = Watched(browser.new_context(), server)
    tab.open(server.address)
    page = tab.page
    panel = page.locator("[role=tab]:text-is('Step response')")
    panel.wait_for(state="attached")
    fuzzy.write_fis(fuzzy.to_type2(tipper()), server.folder / "tipper.fis")
    page.get_by_role("button", name="File ▾").click()
    page.get_by_role("menuitem", name="Revert to the saved file").click()
    panel.wait_for(state="detached")
    page.wait_for_selector("[data-footprint]")
    page.get_by_role("button", name="Undo").click()
    panel.wait_for(state="attached")
    page.wait_for_selector("[data-footprint]", state="detached")
    assert tab.wrong == []
    tab.page.context.close()
