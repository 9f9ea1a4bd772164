"""What stands before a design: wrong files, Mamdani systems, and a tour for who has never seen a rule base."""

from pathlib import Path

import pytest

import fuzzy
from fuzzy.files.examples import write_examples
from fuzzy.files.fisfile import format_fis, read_fis
from tests.browsers import drag
from tests.fuzzy.plugins.designer.served import PATIENCE, TOKEN, Watched, tipper

pytest.importorskip("nicegui", reason="the designer needs the extra design")
CORPUS = Path(__file__).parents[3] / "data" / "fis-corpus"


@pytest.fixture
def tab(browser, server):
    """A tab of its own, on a screen of a phone's width where the test asks for it."""
    context = browser.new_context(viewport={"width": 1600, "height": 1000})
    tab = Watched(context, server)
    tab.page.goto(f"{server.url}?token={TOKEN}")
    yield tab
    assert tab.wrong == []
    context.close()


def test_a_wrong_rule_is_marked_and_mended_where_it_stands(tab, server):
    text = format_fis(tipper())
    broken, page = server.folder / "broken.fis", tab.page
    lines = text.splitlines()
    lines[-1] = "3 2, 3 3 (1) : 1"
    broken.write_text("\n".join(lines) + "\n")
    before = broken.read_bytes()
    page.goto(f"{server.url}?file=broken.fis")
    field = page.get_by_role("textbox", name="rule 3", exact=True)
    field.wait_for()
    assert field.input_value() == lines[-1]
    page.get_by_text("expected 1 output terms, one for each output, got 2; a sentence").wait_for()
    page.wait_for_selector(".shell-badge:text('Check')")
    page.get_by_role("button", name="Save").click()
    page.get_by_text("rule 3 is not readable yet; mend or remove it, then save").first.wait_for()
    assert broken.read_bytes() == before
    field.fill("if service is superb and food is tasty then tip is high")
    field.press("Enter")
    page.wait_for_selector(".state.unsaved")
    page.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    assert read_fis(broken) == tipper()


def test_a_wrong_line_is_mended_before_the_file_opens(tab, server):
    text = format_fis(tipper())
    wrong, page = server.folder / "wrong.fis", tab.page
    wrong.write_text(text.replace("Range=[0 30]", "Range=[0 thirty]").replace("NumMFs=2", "NumMFs=few"))
    before = wrong.read_bytes()
    page.goto(f"{server.url}?file=wrong.fis")
    line = page.locator(".mending-line")
    line.wait_for()
    page.get_by_text("NumMFs must be a number of things").wait_for()
    assert line.input_value() == "NumMFs=few"
    line.fill("NumMFs=2")
    page.get_by_role("button", name="Open with this line").click()
    page.get_by_text("expected a finite number, got 'thirty'").wait_for()
    assert page.evaluate("document.activeElement.value") == "Range=[0 thirty]"
    page.get_by_role("button", name="Leave the line out").click()
    page.get_by_text("has no Range").wait_for()
    line.fill("[Output1]\nRange=[0 30]")
    page.get_by_role("button", name="Open with this line").click()
    page.wait_for_selector(".state.unsaved", timeout=PATIENCE)
    assert wrong.read_bytes() == before
    page.reload()  # it is kept as unsaved work
    page.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    assert read_fis(wrong) == tipper()


def test_the_page_of_a_mamdani_system_says_how_far_its_forms_are_off_and_opens_the_fitted_one(tab, server):
    old, page = server.folder / "rgator.fis", tab.page
    old.write_bytes((CORPUS / "m02_auvsl_rgator.fis").read_bytes())
    page.goto(f"{server.url}?file=rgator.fis")
    page.get_by_text("points over the inputs").wait_for()
    original, constants = fuzzy.read_mamdani_original(old), fuzzy.read_mamdani(old).system
    planes = fuzzy.fit_to_mamdani(original, constants, "planes")
    for fis, name in ((constants, "constants at the centroids"), (planes, "planes over the inputs, fitted")):
        off = fuzzy.mamdani_difference(original, fis)[0]
        row = page.get_by_role("row").filter(has_text=f"Open with {name}").inner_text()
        assert f"{off.greatest:.1%}" in row
        assert f"{off.root_mean_square:.1%}" in row
    page.get_by_role("link", name="Open with planes over the inputs, fitted").click()
    page.wait_for_selector(".fd-terms [role=slider]")
    page.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    assert fuzzy.read_fis(server.folder / "rgator-sugeno.fis") == planes


@pytest.fixture
def example(server):
    """The address of a file that comes with the package."""
    folder = server.folder / "lesson"
    folder.mkdir(exist_ok=True)
    write_examples([("tipper", folder / "tipper.fis")], force=True)
    return f"{server.url}?file=lesson/tipper.fis"


def toured(page, step):
    page.get_by_text(f"Step {step} of 5").wait_for()
    page.wait_for_selector("[data-tour]")


@pytest.mark.long
@pytest.mark.parametrize("screen", [(1600, 1000), (390, 844)])
def test_the_tour_leads_by_keys_through_five_steps_notices_each_and_comes_once(tab, example, screen):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-core comes with the extra test")
    page = tab.page
    assert page.locator(".tour").is_hidden()  # another file than the example
    page.set_viewport_size({"width": screen[0], "height": screen[1]})
    page.emulate_media(reduced_motion="reduce")
    page.goto(example)
    for step, key in enumerate(("Shift+ArrowRight", "Space", "Shift+ArrowRight", "Space", "Enter"), 1):
        toured(page, step)
        assert page.evaluate("document.activeElement.id") == "tour-title"  # where a screen reader begins
        found = axe.Axe().run(page, context=".tour").response["violations"]
        assert [f"{rule['id']}: {rule['nodes'][0]['html']}" for rule in found] == []
        assert page.evaluate("document.documentElement.scrollWidth") <= screen[0]
        for button in page.locator(".tour button:visible").all():
            assert min(button.bounding_box()["height"], button.bounding_box()["width"]) >= 24
        page.wait_for_timeout(300)  # until what it points at stands still
        page.get_by_role("button", name="Take me there").press("Enter")
        assert page.locator(".tour-noticed").inner_text() == ""
        assert page.evaluate("document.activeElement.closest('[data-tour]') !== null")
        page.keyboard.press(key)
        page.get_by_text("✓ Done.").wait_for()
        page.locator(".tour-acts button").last.press("Enter")
    assert page.locator(".tour").is_hidden()
    assert page.locator("[data-tour]").count() == 0
    page.goto(example)
    page.wait_for_selector(".fd-terms [role=slider]")
    assert page.locator(".tour").is_hidden()


@pytest.mark.long
def test_the_tour_is_left_by_escape_and_opened_by_the_list_of_keys(tab, example):
    page = tab.page
    page.goto(example)
    toured(page, 1)
    page.keyboard.press("Escape")
    page.locator(".tour").wait_for(state="hidden")
    page.keyboard.press("?")
    page.get_by_role("button", name="A tour of five steps").click()
    toured(page, 1)
    handle = page.locator(".fd-terms .fd-grip").first
    drag(page, handle, (30, 0), release=True)
    page.get_by_text("✓ Done.").wait_for()
    page.get_by_role("button", name="Next").click()
    toured(page, 2)
    page.get_by_role("button", name="Back").click()
    toured(page, 1)
    page.get_by_role("button", name="Leave the tour").click()
    page.locator(".tour").wait_for(state="hidden")


@pytest.mark.long
@pytest.mark.parametrize("width", [1600, 390])
def test_marked_rules_and_what_is_offered_are_accessible_light_and_dark(tab, server, width):
    pytest.importorskip("axe_playwright_python", reason="axe-core comes with the extra test")
    from tests.fuzzy.plugins.designer.test_designer_everywhere import grave

    text, page = format_fis(tipper()), tab.page
    (server.folder / "marked.fis").write_text("\n".join([*text.splitlines()[:-1], "1 2 3"]))
    (server.folder / "lined.fis").write_text(text.replace("NumMFs=2", "NumMFs=few"))
    (server.folder / "sets.fis").write_bytes((CORPUS / "m02_auvsl_rgator.fis").read_bytes())
    page.set_viewport_size({"width": width, "height": 900})
    for name, shown in (("marked", ".fd-bad mark"), ("lined", ".mending-line"), ("sets", ".shell-forms")):
        page.goto(f"{server.url}?file={name}.fis")
        page.wait_for_selector(shown)
        page.wait_for_timeout(500)
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
            assert (name, scheme, grave(page)) == (name, scheme, [])
        assert page.evaluate("document.documentElement.scrollWidth") <= width
