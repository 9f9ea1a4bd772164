"""The designer's panel "Tree": what the whole answers with the design in its place, what it does not read, its page."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

import fuzzy
from fuzzy.plugins.trees.panel import TreeSession, shown_tree
from tests.browsers import run_apart
from tests.fuzzy.plugins.designer.conftest import browser as browser
from tests.fuzzy.plugins.designer.conftest import server as server
from tests.fuzzy.plugins.designer.module_page import ModulePage
from tests.fuzzy.plugins.designer.served import Watched
from tests.fuzzy.plugins.trees.test_tree import GRIP, SPEED, TREE

POINT = {"distance": 0.9, "wet": 0.2, "wear": 0.4}


@pytest.fixture
def folder(tmp_path):
    TREE.write(tmp_path / "car")
    return tmp_path.resolve()


def other(fis):
    """The same with the greatest answer halved."""
    rules = [str(rule) for rule in fis.rules]
    return fuzzy.Sugeno(fis.inputs, [fuzzy.Variable("friction", (0, 1), {"high": 0.5, "low": 0})], rules, fis.name)


def test_the_whole_answers_with_the_design_in_its_place(folder):
    for design, friction in ((GRIP, 0.3), (other(GRIP), 0.15)):
        found = shown_tree(folder, "car/grip.fis", fuzzy.format_fis(design), POINT)
        assert [v["value"] for v in found["outputs"]] == pytest.approx([(friction + 0.9) / 2])
        assert [v["name"] for v in found["inputs"]] == ["distance", "wet", "wear"]
        assert [(s["name"], s["file"], s["here"]) for s in found["systems"]] == [
            ("speed", "car/speed.fis", False),
            ("grip", "car/grip.fis", True),
        ]
        assert found["picture"].count("<svg") == 1


def test_nothing_outside_the_folder_is_read(folder, tmp_path_factory):
    away = tmp_path_factory.mktemp("away")
    fuzzy.write_fis(SPEED, away / "speed.fis")
    toml = folder / "car" / "tree.toml"
    for outside in (f"../../{away.name}/speed.fis", str(away / "speed.fis")):
        toml.write_text(f'[systems]\ngrip = "grip.fis"\nspeed = "{outside}"\n')
        with pytest.raises(fuzzy.errors.InputError, match="folder"):
            shown_tree(folder, "car/grip.fis", fuzzy.format_fis(GRIP), {})
    toml.write_text('[systems]\nspeed = "speed.fis"\n')
    with pytest.raises(fuzzy.errors.InputError, match="belongs to no tree"):
        shown_tree(folder, "car/grip.fis", fuzzy.format_fis(GRIP), {})
    toml.unlink()
    with pytest.raises(fuzzy.errors.InputError, match="there is no tree"):
        shown_tree(folder, "car/grip.fis", fuzzy.format_fis(GRIP), {})


class Bench:
    """A workbench without a page."""

    def __init__(self, folder: Any) -> None:
        self.traits: dict[str, Any] = {}
        path = folder / "car" / "grip.fis"
        self.document: Any = SimpleNamespace(folder=folder, path=path, design=SimpleNamespace(in_force=GRIP))
        self.on_change = self.on_close = lambda callback: None

    def widget(self, module: Any, **traits: Any) -> Any:
        assert module.is_file()
        self.traits.update(traits)
        return SimpleNamespace(update=self.traits.update, on_message=lambda callback: None)

    async def read(self, name: str, function: Any, *args: Any) -> Any:
        return await asyncio.to_thread(function, *args)


def test_a_session_follows_edits_and_points(folder):
    async def used():
        bench = Bench(folder)
        session = TreeSession(bench)
        await session._doing
        for name, value in POINT.items():
            await session.heard({"do": "point", "name": name, "value": value})
        first = bench.traits["outputs"][0]["value"]
        bench.document.design.in_force = other(GRIP)
        await session.changed()
        second = bench.traits["outputs"][0]["value"]
        await session.heard({"do": "point", "name": "friction", "value": 1})
        return first, second, bench.traits["problem"]["message"]

    first, second, refused = run_apart(used())
    assert (first, second) == pytest.approx((0.6, 0.525))
    assert "friction" in refused


def test_the_page_leads_to_the_other_systems_and_asks_at_a_point(browser, folder):
    module = ModulePage(browser.new_page(), sheet="fuzzy/plugins/designer/static/designer.css")
    found = shown_tree(folder, "car/grip.fis", fuzzy.format_fis(GRIP), POINT)
    module.render("fuzzy/plugins/trees/static/systems.js", {**found, "problem": None}, 700)
    page = module.page
    assert page.get_by_role("link").all_inner_texts() == ["speed: 4 rules"]
    assert page.get_by_role("link").get_attribute("href") == "/?file=car%2Fspeed.fis"
    assert page.get_by_role("listitem").all_inner_texts()[1] == "grip: 4 rules, which is edited here"
    assert page.get_by_role("status").inner_text() == "v = 0.6"
    assert page.locator("img").evaluate("node => node.decode().then(() => node.naturalWidth)") > 100
    assert page.get_by_role("spinbutton").count() == 3
    page.get_by_role("spinbutton", name="wet").fill("0.5")
    page.keyboard.press("Enter")
    assert module.sent() == [{"do": "point", "name": "wet", "value": 0.5}]
    module.give(outputs=[found["outputs"][0] | {"value": None}], problem={"message": "no", "field": "wet"})
    assert page.get_by_role("status").inner_text() == "v = none"
    assert page.get_by_role("alert").inner_text() == "no"
    assert page.evaluate("document.documentElement.scrollWidth") <= 700
    assert module.problems == []
    assert module.leave() == (0, 0)


@pytest.mark.long
def test_the_tab_shows_the_tree_of_the_file(browser, server):
    TREE.write(server.folder / "car")
    tab = Watched(browser.new_context(viewport={"width": 1400, "height": 1000}), server)
    page = tab.open(f"{server.address}&file=car/grip.fis")
    page.get_by_role("radio", name="Tree").click()
    page.get_by_text("v = 0.5").wait_for()
    assert page.get_by_role("link", name="speed: 4 rules").get_attribute("href").endswith("?file=car%2Fspeed.fis")
    assert tab.wrong == []
