"""The designer end to end: a real server process, a real browser with a real mouse and keyboard."""

import http.client
import itertools
import json
import os
import random
import re
import signal
import socket
import time
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from fuzzy.files.fisfile import read_fis, write_fis
from fuzzy.plugins.designer.document import Document
from fuzzy.system import Sugeno
from tests.browsers import drag, rest
from tests.fuzzy.plugins.designer.served import PATIENCE, TOKEN, Server, Watched, tipper

pytest.importorskip("nicegui", reason="the designer needs the extra design")


@pytest.fixture
def folder(server):
    return server.folder


@pytest.fixture(scope="module")
def context(browser):
    context = browser.new_context(viewport={"width": 1600, "height": 1000}, accept_downloads=True)
    yield context
    context.close()


@pytest.fixture(scope="module")
def first_tab(context, server):
    tab = Watched(context, server)
    tab.open(server.address)
    assert tab.page.url == server.url  # the token does not stay in the address
    return tab


@pytest.fixture
def tab(first_tab, folder, server):
    """The tab, with the design as the file was written first."""
    page = first_tab.page
    page.set_viewport_size({"width": 1600, "height": 1000})
    first_tab.open(server.url)  # a test before may have left another file, variable or small picture
    write_fis(tipper(), folder / "tipper.fis")
    page.evaluate("document.querySelector('.said[role=status]').textContent = ''")
    menu(page, "Revert to the saved file")
    page.wait_for_selector(".said[role=status]:text('the saved file is shown again')")
    page.wait_for_selector(".state:not(.unsaved)")
    page.get_by_role("tab", name="Memberships").click()  # a drawer may be open
    page.wait_for_selector(".fd-viewer")
    yield first_tab
    assert first_tab.wrong == []


def menu(page, entry):
    page.get_by_role("button", name="File ▾").click()
    page.get_by_role("menuitem", name=entry).click()


PIXELS = """() => [...document.querySelectorAll(".fd-surface canvas")].map((c) => c.toDataURL()).join("")
  + [...document.querySelectorAll(".fd-surface path")].map((p) => p.getAttribute("d")).join("")"""


def pixels(page):
    """What stands on the surface's canvas or in its drawing, as one text."""
    return page.evaluate(PIXELS)


def until_changed(page, show, before):
    page.wait_for_function(f"(before) => ({show})() !== before", arg=before)


WORDS = """() => document.querySelector(".fd-viewer").innerText"""


def foot(page):
    return page.get_by_role("slider", name="poor: right foot")


def test_mouse_moves_a_vertex_and_everything_follows_and_undo_restores_the_bytes(tab, folder):
    page, before = tab.page, (folder / "tipper.fis").read_bytes()
    words = page.evaluate(WORDS)
    drag(page, foot(page), (60, 0), release=True)
    until_changed(page, WORDS, words)
    page.wait_for_selector(".state.unsaved")
    at = float(foot(page).get_attribute("aria-valuenow"))
    assert at > 5.2
    page.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    saved = read_fis(folder / "tipper.fis")["service"].terms["poor"]
    assert (saved.a, saved.b, saved.c) == (-4, 0, pytest.approx(at, rel=1e-6))
    # The surface, in its own tab, follows too.
    page.get_by_role("tab", name="Surface").click()
    page.wait_for_selector(".fd-surface")
    page.wait_for_function("document.querySelector('.fd-surface').clientHeight > 100")
    seen = pixels(page)
    drag(page, foot(page), (-80, 0), release=True)
    page.wait_for_function("() => !document.querySelector('.state').innerText.startsWith('saved')")
    until_changed(page, PIXELS, seen)
    # A drag is one edit.
    page.keyboard.press("Control+z")
    page.wait_for_selector(".state:not(.unsaved)")
    page.get_by_role("button", name="Undo").click()
    page.wait_for_selector(".state.unsaved")
    page.keyboard.press("Control+s")
    page.wait_for_selector(".state:not(.unsaved)")
    assert (folder / "tipper.fis").read_bytes() == before


def test_keyboard_moves_a_vertex_and_reaches_the_tabs_and_the_menu(tab):
    page = tab.page
    words, at = page.evaluate(WORDS), float(foot(page).get_attribute("aria-valuenow"))
    foot(page).focus()
    page.keyboard.press("Shift+ArrowRight")
    until_changed(page, WORDS, words)
    assert float(foot(page).get_attribute("aria-valuenow")) == pytest.approx(at + 0.5)
    page.keyboard.press("Control+z")
    page.wait_for_selector(".state:not(.unsaved)")
    page.keyboard.press("Control+Shift+Z")
    page.wait_for_selector(".state.unsaved")
    page.get_by_role("tab", name="Surface").focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_selector("[role=tab][aria-selected=true]:text('Data')")
    page.wait_for_function("document.activeElement.innerText === 'Data'")
    page.get_by_role("button", name="File ▾").focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("End")
    assert page.evaluate("document.activeElement.innerText") == "Revert to the saved file"
    page.keyboard.press("Enter")
    page.wait_for_selector(".state:not(.unsaved)")


COUNTED = """() => {
  const later = window.setTimeout, held = [];
  // Keys that are a second apart, as on a busy machine, would be several edits.
  const clock = Object.getOwnPropertyDescriptor(Event.prototype, "timeStamp"), now = performance.now();
  Object.defineProperty(Event.prototype, "timeStamp", { ...clock, get: () => now });
  let design;
  window.designs = 0;
  Object.defineProperty((window.fuzzyfleetShared ??= {}), "design", {
    configurable: true, get: () => design, set: (value) => ((design = value), (window.designs += 1)) });
  // What waits for the page to have drawn a state is kept waiting.
  Object.defineProperty(document, "hidden", { configurable: true, get: () => true });
  window.setTimeout = (f, ms, ...more) => (ms === 100 ? held.push(f) : later(f, ms, ...more));
  window.release = () => {
    window.setTimeout = later;
    Object.defineProperty(Event.prototype, "timeStamp", clock);
    delete document.hidden;
    held.forEach((f) => f());
  };
}"""


def test_states_that_a_newer_one_overtakes_are_not_sent(tab, folder):
    page = tab.page
    handle = page.get_by_role("slider", name="poor: right foot")
    page.evaluate(COUNTED)
    for _ in range(20):
        handle.press("ArrowLeft")
    page.evaluate("window.release()")
    page.wait_for_function("window.fuzzyfleetShared.design?.inputs[0].terms[0].parameters[2] === 4")  # from 5, by 0.05
    assert 0 < page.evaluate("window.designs") < 10
    page.keyboard.press("Control+z")
    page.wait_for_selector(".state:not(.unsaved)")
    assert page.evaluate("window.fuzzyfleetShared.design.inputs[0].terms[0].parameters[2]") == 5


def test_a_removal_is_told_and_undone_and_findings_lead_to_their_places(tab):
    page = tab.page
    check = page.get_by_role("button", name=re.compile("^Check"))
    page.get_by_role("treeitem", name="food").first.focus()
    page.keyboard.press("Delete")
    told = page.locator(".shell-header .said").filter(has_text="food removed; 2 rules changed.")
    told.wait_for()
    page.wait_for_selector(".state.unsaved")
    told.get_by_role("button", name="Undo").click()
    page.wait_for_selector(".state:not(.unsaved)")
    told.wait_for(state="detached")  # there is nothing left to undo
    # Another input is to be named at once, whatever tab is shown; no rule asks for it, which is found by itself.
    page.get_by_role("tab", name="Rules").click()
    page.get_by_role("button", name="Add input").click()
    page.wait_for_function("document.activeElement.value === 'input3'")
    page.keyboard.type("noise")
    page.keyboard.press("Enter")
    page.get_by_role("treeitem", name="noise").first.wait_for()
    page.get_by_role("button", name=re.compile(r"^Check \d+$")).click()
    finding = page.get_by_role("listitem").filter(has_text="no rule asks for the input noise")
    finding.get_by_role("button", name="noise").click()
    page.wait_for_function("document.activeElement.value === 'noise'")
    check.click()
    # The keys of the page, by a key; not where one types.
    check.press("?")
    dialog = page.get_by_role("dialog", name="Keys")
    assert "removes it, in the rules too" in dialog.inner_text()
    dialog.get_by_role("button", name="Close").click()
    page.locator("dialog").wait_for(state="detached")
    skip = page.get_by_role("link", name="Skip to the views")
    skip.focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.innerText") == "Function"
    page.get_by_role("tab", name="Memberships").click()


def test_a_dragged_row_of_the_matrix_is_one_edit_and_a_new_range_tells_what_it_leaves(tab):
    page = tab.page
    page.get_by_role("tab", name="Rules").click()
    page.locator(".fd-rules [data-view=matrix]").click()
    page.get_by_role("radio", name="high", exact=True).click()
    boxes = [page.locator(f"[data-cell='0,{column}']").bounding_box() for column in (0, 1)]
    page.mouse.move(boxes[0]["x"] + 20, boxes[0]["y"] + 20)
    page.mouse.down()
    page.mouse.move(boxes[1]["x"] + 20, boxes[1]["y"] + 20, steps=4)
    page.mouse.up()
    page.wait_for_selector(".state.unsaved")
    page.get_by_role("button", name="Undo: fill 2 cells of tip").wait_for()
    assert page.locator("[data-cell='0,1']").get_attribute("data-term") == "high"
    page.locator("[data-cell='0,1']").focus()
    page.keyboard.press("Control+z")
    page.wait_for_selector(".state:not(.unsaved)")  # both, and the same bytes as the file's
    page.locator(".fd-rules [data-view=sentences]").click()
    page.get_by_role("tab", name="Memberships").click()
    page.locator(".fd-terms .fd-tab.fd-output").click()
    high = page.get_by_role("spinbutton", name="to, the highest value")
    high.fill("20")
    high.press("Enter")
    page.get_by_role("group", name="Terms in the new range").get_by_role("button", name="Keep").click()
    told = page.locator(".shell-header .said").filter(has_text="high of tip lies outside its new range now, in 1 rule.")
    told.wait_for()
    page.get_by_role("button", name=re.compile(r"^Check 1$")).wait_for()
    told.get_by_role("button", name="Undo").click()
    page.wait_for_selector(".state:not(.unsaved)")
    page.locator(".fd-terms .fd-tab").first.click()


def edits(page):
    """The list of edits, the newest first, and the place of the present one."""
    rows = page.locator(".fd-edits button").all()
    names = [row.evaluate("(node) => node.lastChild.textContent") for row in rows]
    return names, [k for k, row in enumerate(rows) if row.get_attribute("aria-current") == "step"]


def until_present(page, place):
    page.wait_for_selector(f".fd-edits li:nth-child({place + 1}) button[aria-current=step]")


def test_the_history_leads_anywhere_and_follows_other_tabs(tab, context, server):
    page = tab.page
    page.get_by_role("button", name="History", exact=True).click()
    page.wait_for_selector(".fd-edits button")
    begun = len(edits(page)[0])  # the tests share a document
    for k in range(3):
        field = page.get_by_label("system's name", exact=True)
        field.fill(f"name {k}")
        field.press("Enter")
        page.wait_for_function(f"window.fuzzyfleetShared?.design?.name === 'name {k}'")
    page.wait_for_function(
        "(count) => document.querySelectorAll('.fd-edits button').length === count", arg=min(begun + 3, 101)
    )
    names, present = edits(page)
    assert (names[:3], present) == ([f"rename to name {k}" for k in (2, 1, 0)], [0])
    page.locator(".fd-edits button").nth(3).click()  # three undos at once
    until_present(page, 3)
    page.wait_for_selector(".state:not(.unsaved)")
    assert edits(page)[0] == names  # nothing is lost
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    until_present(page, 1)
    page.wait_for_function("window.fuzzyfleetShared.design.name === 'name 1'")
    # Another tab with the design shows the same, and is followed.
    other = Watched(context, server)
    second = other.open(server.url)
    second.get_by_role("button", name="History", exact=True).click()
    until_present(second, 1)
    assert edits(second)[0] == names
    second.locator(".fd-edits button").nth(0).click()
    until_present(page, 0)
    page.get_by_role("button", name="Undo").click()
    until_present(second, 1)
    assert other.wrong == []
    second.close()
    page.get_by_role("tab", name="Memberships").click()


def test_a_snapshot_is_kept_compared_renamed_downloaded_removed_and_brought_back(tab, folder, server, context):
    page, before = tab.page, (folder / "tipper.fis").read_bytes()
    drag(page, foot(page), (60, 0), release=True)
    page.wait_for_selector(".state.unsaved")
    menu(page, "Take a snapshot")
    page.wait_for_selector(".said[role=status]:text('move poor” is kept; History lists all')")
    page.get_by_role("button", name="History", exact=True).click()
    page.wait_for_selector(".fd-shot")
    assert re.fullmatch(r"\d\d:\d\d:\d\d, move poor", page.locator(".fd-shot-name").inner_text())
    assert page.get_by_role("img", name="tip over service and food").locator("path").count() > 3
    page.locator(".fd-shot [data-action=rename]").click()
    page.keyboard.type("wider")
    page.keyboard.press("Enter")
    page.wait_for_selector(".fd-shot-name:text-is('wider')")
    page.get_by_role("button", name="Undo", exact=False).first.click()
    page.wait_for_selector(".state:not(.unsaved)")
    page.get_by_label("Name of a snapshot").fill("as saved")
    page.keyboard.press("Enter")
    page.wait_for_selector(".fd-shot:nth-child(2)")
    page.get_by_role("button", name="Compare wider").click()
    page.wait_for_selector("[aria-pressed=true][aria-label='Compare wider']")
    page.wait_for_selector(".fd-viewer")
    page.get_by_role("tab", name="Memberships").click()
    page.wait_for_selector(".fd-terms .fd-compared")
    page.get_by_role("button", name="History", exact=True).click()
    page.get_by_role("button", name="Compare wider").click()
    page.wait_for_selector("[aria-pressed=false][aria-label='Compare wider']")
    with page.expect_download() as download:
        page.get_by_role("button", name="Download wider").click()
    assert download.value.suggested_filename == "tipper-wider.fis"
    wider = read_fis(download.value.path())
    assert wider["service"].terms["poor"].c > 5.2
    page.get_by_role("button", name="Open wider").click()
    page.wait_for_selector(".fd-edits button[aria-current]:has-text('open the snapshot wider')")
    page.keyboard.press("Control+s")
    page.wait_for_selector(".state:not(.unsaved)")
    assert read_fis(folder / "tipper.fis") == wider
    page.keyboard.press("Control+z")
    page.wait_for_selector(".state.unsaved")
    page.keyboard.press("Control+s")
    page.wait_for_selector(".state:not(.unsaved)")
    assert (folder / "tipper.fis").read_bytes() == before
    page.get_by_role("button", name="Remove wider").click()
    page.locator(".fd-shot").filter(has_text="wider").wait_for(state="detached")
    page.locator(".fd-shot-removed").get_by_role("button", name="Undo").click()
    page.wait_for_selector(".fd-shot:nth-child(2)")
    # One that is damaged costs nothing else; the others stand there for whoever comes later.
    (folder / ".fuzzy-design" / "tipper.fis.snapshots" / f"{0:016x}.json").write_text('{"format": 1')
    other = Watched(context, server)
    second = other.open(server.url)
    second.get_by_role("button", name="History", exact=True).click()
    second.wait_for_selector(".fd-shot-damaged:has-text('0000000000000000.json is damaged and is no snapshot')")
    assert {name.inner_text() for name in second.locator(".fd-shot-name").all()} == {"wider", "as saved"}
    assert other.wrong == []
    second.close()
    page.get_by_role("tab", name="Memberships").click()


def test_c_code_is_a_zip_of_what_the_command_writes(tab):
    page = tab.page

    def export(written):
        menu(page, "Export C code")
        dialog = page.get_by_role("dialog")
        assert dialog.get_by_label("Written are").input_value() == ""
        dialog.get_by_label("Numbers").select_option("q16.16")
        dialog.get_by_label("Written are").select_option(label=written)
        dialog.get_by_role("button", name="Export").click()

    for written, word in (("The rules themselves", "rule_end"), ("A table of 33", "33 x 33 points")):
        with page.expect_download() as download:
            export(written)
        assert download.value.suggested_filename == "tipper-c.zip"
        with zipfile.ZipFile(download.value.path()) as archive:
            assert archive.namelist() == ["tipper.h", "tipper.c"]
            assert "int32_t" in archive.read("tipper.h").decode()
            assert word in archive.read("tipper.c").decode()


@pytest.mark.long
def test_all_pictures_are_one_zip_and_drawing_can_be_stopped(tab):
    page = tab.page

    def export(ending):
        menu(page, "Export a figure")
        dialog = page.get_by_role("dialog")
        dialog.get_by_label("Figure").select_option("all")
        dialog.get_by_label("Format").select_option(ending)
        dialog.get_by_role("button", name="Export").click()

    with page.expect_download() as download:
        export("svg")
    assert download.value.suggested_filename == "tipper-figures.zip"
    with zipfile.ZipFile(download.value.path()) as archive:
        names = archive.namelist()
        # README.txt, terms, the viewer, the structure, the rule matrix, a surface
        assert len(names) == 1 + (2 + 1) + 1 + 1 + 1 + 1
        assert "The point: service = 5, food = 5." in archive.read("README.txt").decode()
        assert all(b"<svg" in archive.read(name) for name in names[1:])
    export("pdf")
    page.locator(".said").get_by_role("button", name="Stop").click()
    page.wait_for_selector(".said[role=status]:text('no more pictures are drawn')")


def test_a_second_tab_follows_on_a_narrow_screen(tab, context, server):
    other = Watched(context, server)
    second = other.page
    second.set_viewport_size({"width": 390, "height": 800})
    other.open(server.url)
    drag(tab.page, foot(tab.page), (40, 0), release=True)
    tab.page.wait_for_selector(".state.unsaved")
    at = foot(tab.page).get_attribute("aria-valuenow")
    second.wait_for_function(
        "(at) => [...document.querySelectorAll('[role=slider]')].some((s) => "
        "s.ariaLabel === 'poor: right foot' && s.ariaValueNow === at)",
        arg=at,
    )
    assert second.evaluate("document.documentElement.scrollWidth") <= 390
    assert not second.get_by_role("complementary", name="System").is_visible()
    second.get_by_role("button", name="System").click()
    second.get_by_role("complementary", name="System").wait_for()
    second.get_by_role("tab", name="Surface").click()
    second.wait_for_selector(".fd-surface")
    assert second.evaluate("document.documentElement.scrollWidth") <= 390
    second.get_by_role("button", name="Undo").click()
    tab.page.wait_for_selector(".state:not(.unsaved)")
    assert other.wrong == []
    second.close()


def test_uploads(tab, tmp_path):
    page = tab.page
    bad = tmp_path / "bad.fis"
    bad.write_text("[System]\nName='x'\nType='sugeno'\nNumInputs=oops\n")
    with page.expect_file_chooser() as chooser:
        menu(page, "Upload")
    chooser.value.set_files(bad)
    alert = page.get_by_role("alert").filter(has_text="bad.fis:4")
    alert.wait_for()
    assert "NumInputs" in alert.inner_text()
    assert page.locator(".state").inner_text() == "saved"  # the last good system stays
    good = tmp_path / "odd.fis"
    name = "`${alert(1)}</script><b>'"[:-1]
    fis = tipper()
    write_fis(Sugeno(fis.inputs, fis.outputs, fis.rules[:2], name=name), good)
    with page.expect_file_chooser() as chooser:
        menu(page, "Upload")
    chooser.value.set_files(good)
    page.wait_for_selector(".state.unsaved")
    assert page.get_by_role("button", name="Undo: upload odd.fis").count() == 1
    page.reload()  # the odd name is in the page itself then
    page.wait_for_selector(".shell-header[data-ready]")
    page.wait_for_selector(".fd-terms [role=slider]")
    assert name in [field.input_value() for field in page.locator(".fd-tree input").all()]


def test_files_stay_in_the_folder(tab, folder):
    page, before = tab.page, {path.name for path in folder.glob("*.fis")}
    for name, told in (
        ("../outside", "begins with a dot"),
        ("a/../../outside", "begins with a dot"),
        ("tipper2", None),
    ):
        menu(page, "Save as")
        page.get_by_role("dialog").get_by_role("textbox").fill(name)
        page.keyboard.press("Enter")
        if told is None:
            page.wait_for_function("document.title.includes('tipper2.fis')")
        else:
            # Under the field, which can be mended at once
            page.get_by_role("dialog").get_by_role("alert").filter(has_text=told).wait_for()
            field = page.get_by_role("dialog").get_by_role("textbox")
            assert told in page.locator(f"#{field.get_attribute('aria-describedby')}").inner_text()
            assert field.get_attribute("aria-invalid") == "true"
            assert field.input_value() == name
            page.keyboard.press("Escape")
    page.wait_for_url("**tipper2.fis")
    assert {path.name for path in folder.glob("*.fis")} == before | {"tipper2.fis"}
    assert not (folder.parent / "outside.fis").exists()
    with page.expect_download() as download:
        menu(page, "Download")
    assert Path(download.value.path()).read_bytes() == (folder / "tipper2.fis").read_bytes()
    with page.expect_download() as download:
        menu(page, "Export a figure")
        page.get_by_role("dialog").get_by_role("combobox", name="Figure").select_option("surface")
        page.get_by_role("dialog").get_by_role("combobox", name="Format").select_option("pdf")
        page.get_by_role("button", name="Export", exact=True).click()
    assert download.value.suggested_filename == "tipper2-surface.pdf"
    assert Path(download.value.path()).read_bytes().startswith(b"%PDF")


ERRORS = """() => [...document.querySelectorAll(".shell-shown table td")].map((cell) => cell.innerText).join(" ")"""


def test_the_robot_follows_the_design(tab, server, folder):
    """The metrics of the closed loop change with a vertex, and are back after undo."""
    from importlib.resources import files

    text = (files("robotics") / "data" / "rulebases" / "tracking.fis").read_text(encoding="utf-8")
    (folder / "tracking.fis").write_text(text, encoding="utf-8")
    page = tab.open(f"{server.url}?file=tracking.fis")
    page.get_by_role("tab", name="Try it").click()
    # Three columns: this design, the file's and the nonlinear law's, each run in a worker.
    page.wait_for_function("() => document.querySelectorAll('.shell-shown thead th').length === 4")
    before = page.evaluate(ERRORS)
    page.get_by_role("treeitem", name="Far", exact=False).get_by_text("Far", exact=True).first.click()
    drag(page, page.get_by_role("slider", name="Far: peak"), (90, 0), release=True)
    until_changed(page, ERRORS, before)
    page.keyboard.press("Control+z")
    page.wait_for_selector(".state:not(.unsaved)")
    page.wait_for_function(f"(before) => ({ERRORS})() === before", arg=before)
    tab.open(server.url)


def answer(server, path="/", method="GET", body=None, **headers):
    """The status of a request with the given headers in the place of a browser's own."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    own = {"Host": f"127.0.0.1:{server.port}", "Cookie": f"fuzzy-design-{server.port}={TOKEN}"}
    connection.request(method, path, body, {name: value for name, value in (own | named).items() if value is not None})
    reply = connection.getresponse()
    text = reply.read().decode()
    connection.close()
    return reply.status, text


SOCKET = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13"}
SOCKET_PATH = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"


def test_foreign_hosts_and_origins_are_refused(server):
    own, at = f"http://127.0.0.1:{server.port}", "/modules/fuzzy/plugins/designer/static/chart.js"
    assert answer(server, at)[0] == 200
    assert answer(server, at, Origin=own)[0] == 200
    foreign = [
        {"Host": "evil.example"},
        {"Host": f"evil.example:{server.port}"},
        {"Host": "127.0.0.1:1"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": f"https://127.0.0.1:{server.port}"},
        {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"},
    ]
    for headers in foreign:
        assert answer(server, at, **headers)[0] == 403, headers
        assert answer(server, "/upload?file=tipper.fis&name=x", "POST", b"", **headers)[0] == 403, headers
    key = {"Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ=="}
    for headers in ({}, *foreign[:6]):
        assert answer(server, SOCKET_PATH, **SOCKET, **key, **headers)[0] == 403, headers
    # Without an upgrade the same path is a request like the others.
    assert answer(server, SOCKET_PATH.replace("websocket", "polling"), Origin="http://evil.example")[0] == 403


def test_without_the_token_nothing_is_answered(server, browser):
    at = "/modules/fuzzy/plugins/designer/static/chart.js"
    for path in ("/", "/?file=tipper.fis", at, SOCKET_PATH.replace("websocket", "polling"), "/?token=wrong"):
        status, text = answer(server, path, Cookie=None)
        assert status == 403
        assert "printed in the terminal" in text
    assert answer(server, f"{at}?token={TOKEN}", Cookie=None)[0] == 200
    assert answer(server, "/upload?file=tipper.fis&name=x", "POST", b"", Cookie=None)[0] == 403
    key = {"Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==", "Origin": server.url.rstrip("/")}
    assert answer(server, SOCKET_PATH, **SOCKET, **key, Cookie=None)[0] == 403
    stranger = browser.new_context()
    page = stranger.new_page()
    assert page.goto(server.url).status == 403
    assert stranger.cookies() == []
    assert page.goto(server.address).status == 200
    [cookie] = stranger.cookies()
    assert (cookie["name"], cookie["value"]) == (f"fuzzy-design-{server.port}", TOKEN)
    assert cookie["httpOnly"]
    assert cookie["sameSite"] == "Strict"
    stranger.close()


def test_a_mamdani_file_is_opened_as_a_sugeno_system(tab, server, folder):
    corpus = Path(__file__).parents[3] / "data" / "fis-corpus"
    old = (corpus / "m02_auvsl_rgator.fis").read_bytes()
    (folder / "old.fis").write_bytes(old)
    page = tab.page
    page.goto(f"{server.url}?file=old.fis")
    page.get_by_role("heading", name="old.fis is a Mamdani system").wait_for()
    page.get_by_text("became the constant 20, its centroid").wait_for()

    def late(route):  # what the page has to say waits until it can be shown
        page.wait_for_timeout(500)
        route.continue_()

    page.route("**/header.js*", late)
    page.get_by_role("link", name="Open with constants at the centroids").click()
    page.get_by_text("old.fis was a Mamdani system").first.wait_for()  # which is said for some seconds
    page.unroute("**/header.js*")
    page.wait_for_selector(".fd-terms [role=slider]")
    page.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    assert read_fis(folder / "old-sugeno.fis")["v"].terms["low"].value == 20
    assert (folder / "old.fis").read_bytes() == old
    tab.open(server.url)


@pytest.mark.long
def test_work_that_cannot_be_kept_is_said_on_the_page(tab, server, folder):
    page, kept = tab.page, folder / ".fuzzy-design"
    if kept.exists():
        kept.rename(folder / "aside")
    kept.write_text("no folder")
    drag(page, foot(page), (30, 0), release=True)
    page.wait_for_selector(".unkept:not(:empty)")
    assert "nsaved work cannot be kept in" in page.locator(".unkept").inner_text()
    kept.unlink()
    page.wait_for_selector(".unkept:empty", state="attached")  # tried again, without another edit
    assert (kept / "tipper.fis.json").exists()
    tab.forgiven = True  # the browser complains, rightly, that the server is gone
    said = f"fuzzy design: unsaved work cannot be kept in {kept / 'tipper.fis.json'}: File exists\n"
    assert server.end() == (0, said)
    server.start()
    page.wait_for_selector(".restored:not(:empty)")  # the page comes back by itself
    tab.forgiven = False


@pytest.mark.long
def test_work_older_than_the_file_is_chosen_on_the_page(tab, server, folder):
    file = folder / "older.fis"
    write_fis(read_fis(folder / "tipper.fis"), file)
    document = Document(file)
    document.apply({"edit": "rename", "name": "mine"})
    document.autosave()
    kept = folder / ".fuzzy-design" / "older.fis.json"
    ended = json.loads(kept.read_text()) | {"pid": 999_999_999}  # as of a process that was killed
    kept.write_text(json.dumps(ended))
    write_fis(replace(read_fis(file), name="theirs"), file)
    later = time.time() + 3600
    os.utime(file, (later, later))
    page = tab.open(f"{server.url}?file=older.fis")
    banner = page.locator(".restored[role=status]")
    assert "The file has changed since your unsaved work" in banner.inner_text()
    banner.get_by_role("button", name="Compare both").click()
    page.wait_for_selector("[data-compared^='unsaved work']", state="attached")
    banner.get_by_role("button", name="Take my work").click()
    page.wait_for_selector(".state.unsaved")
    page.wait_for_selector(".restored[role=status]:empty", state="attached")
    page.get_by_role("button", name="Save", exact=True).click()
    page.wait_for_selector(".state:not(.unsaved)")
    assert read_fis(file).name == "mine"
    tab.open(server.url)


@pytest.mark.long
def test_a_new_design_is_saved_under_the_name_that_one_gives_it(tab, server, folder):
    page = tab.open(f"{server.url}?file=untitled.fis")
    page.get_by_label("system's name").fill("my tips")
    page.get_by_label("system's name").press("Enter")
    page.wait_for_selector(".state.unsaved")
    page.keyboard.press("Control+s")
    box = page.get_by_role("dialog")
    box.get_by_role("textbox").fill("tips")
    box.get_by_role("button", name="Save").click()
    page.wait_for_selector(".state:not(.unsaved)")
    assert read_fis(folder / "tips.fis").name == "my tips"
    assert not (folder / "untitled.fis").exists()
    page.get_by_label("system's name").fill("tips")  # now it has a name: nothing is asked
    page.get_by_label("system's name").press("Enter")
    page.wait_for_selector(".state.unsaved")
    page.keyboard.press("Control+s")
    page.wait_for_selector(".state:not(.unsaved)")
    assert read_fis(folder / "tips.fis").name == "tips"
    tab.open(server.url)


def test_paths_and_sizes_are_limited(server, folder):
    (folder / "secret.txt").write_text("hidden")
    for path in (
        "/modules/fuzzy/plugins/designer/server.py",
        "/modules/fuzzy/../pyproject.toml",
        "/modules/fuzzy/%2e%2e/%2e%2e/pyproject.toml",
        "/modules/os/path.js",
        "/secret.txt",
    ):
        assert answer(server, path)[0] == 404, path
    status, text = answer(server, "/?file=../../etc/passwd")
    assert status == 200
    assert "cannot be opened" in text
    status, text = answer(server, "/upload?file=tipper.fis&name=big.fis", "POST", b"x" * 2_000_001)
    assert status == 413
    assert "2 MB" in text
    status, text = answer(server, "/upload?file=../x.fis&name=a.fis", "POST", b"[System]")
    assert (status, "problem" in text) == (200, True)


def test_the_server_listens_on_this_machine_only(server):
    import psutil

    listening = [c.laddr for c in psutil.Process(server.process.pid).net_connections() if c.status == "LISTEN"]
    assert [(a.ip, a.port) for a in listening] == [("127.0.0.1", server.port)]


@pytest.mark.long
def test_after_a_kill_the_design_is_back(tab, server, folder):
    page, before = tab.page, (folder / "tipper.fis").read_bytes()
    drag(page, foot(page), (60, 0), release=True)
    page.wait_for_selector(".state.unsaved")
    at = foot(page).get_attribute("aria-valuenow")
    kept = folder / ".fuzzy-design" / "tipper.fis.json"
    for _ in range(PATIENCE // 20):  # it is written within a quarter of a second
        if kept.exists() and at[:6] in kept.read_text():
            break
        page.wait_for_timeout(20)
    tab.forgiven = True  # the browser complains, rightly, that the server is gone
    assert server.end(signal.SIGKILL)[0] == -signal.SIGKILL
    # What nobody hears would be lost: the page says so in the middle of its top, and takes nothing.
    lost = page.get_by_role("alert").filter(has_text="does not answer")
    lost.wait_for()
    box = lost.bounding_box()
    assert box["y"] < 100
    assert box["x"] + box["width"] / 2 == pytest.approx(800, abs=20)
    grip = page.locator("[aria-label='poor: right foot']")
    drag(page, grip, (-60, 0), release=True)
    for keys in ("Tab", "x", "Control+z", "ArrowRight"):
        page.keyboard.press(keys)
    assert grip.get_attribute("aria-valuenow") == at
    assert page.locator(".fd :focus").count() == 0
    server.start()
    page.wait_for_selector(".restored:not(:empty)")  # the page comes back by itself
    assert not page.locator(".shell").evaluate("shell => shell.inert")
    assert page.locator(".shell-lost:not(:empty)").count() == 0
    tab.forgiven = False
    assert foot(page).get_attribute("aria-valuenow") == at
    assert (folder / "tipper.fis").read_bytes() == before
    page.get_by_role("button", name="Undo").click()
    page.wait_for_selector(".state:not(.unsaved)")


HANDLES = """() => [...document.querySelectorAll(".fd-terms [role=slider]")].map((handle) =>
  `${handle.getAttribute("aria-label")} ${handle.getAttribute("aria-valuenow")}`).join()"""


@pytest.mark.parametrize("kills", [pytest.param(6, marks=pytest.mark.long), pytest.param(20, marks=pytest.mark.scale)])
def test_of_kills_at_random_moments_none_loses_more_than_the_edit_in_flight(tab, server, folder, kills):
    """Edits by keys and by the mouse, the last one followed by SIGKILL after 0 to 0.4 s, half of them in mid-drag."""
    page, moments, kept = tab.page, random.Random(38), folder / ".fuzzy-design" / "tipper.fis.json"
    lost = 0
    for _ in range(kills):
        handles = page.locator(".fd-terms [role=slider]:visible")
        for _ in range(moments.randrange(1, 4)):  # edits of which each is kept before the next
            before, shown = kept.read_bytes() if kept.exists() else b"", page.evaluate(HANDLES)
            handles.nth(moments.randrange(handles.count())).press(moments.choice(["ArrowLeft", "ArrowRight"]))
            if page.evaluate(HANDLES) == shown:
                continue  # against its neighbour
            for _ in range(PATIENCE // 20):
                if kept.exists() and kept.read_bytes() != before:
                    break
                page.wait_for_timeout(20)
        possible = [page.evaluate(HANDLES)]
        if moments.random() < 0.5:
            foot(page).press(moments.choice(["ArrowLeft", "ArrowRight"]))
            possible.append(page.evaluate(HANDLES))
        else:
            box = foot(page).bounding_box()
            x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
            page.mouse.move(x, y)
            page.mouse.down()
            for step in range(moments.randrange(1, 12)):
                page.mouse.move(x + moments.choice([-3, 3]) * (step + 1), y)
                page.evaluate("() => new Promise(requestAnimationFrame)")
                possible.append(page.evaluate(HANDLES))
        tab.forgiven = True
        page.wait_for_timeout(1000 * moments.uniform(0, 0.4))
        server.end(signal.SIGKILL)
        page.mouse.up()
        page.evaluate("window.beforeTheKill = true")
        server.start()
        page.wait_for_function("() => !window.beforeTheKill")  # the page comes back by itself
        page.wait_for_selector(".restored:not(:empty)")
        page.wait_for_selector(".fd-terms [role=slider]")
        tab.forgiven = False
        back = page.evaluate(HANDLES)
        assert back in possible
        lost += back != possible[-1]
    assert lost < kills  # what is written at once is mostly there
    page.get_by_role("button", name="Undo").click()


@pytest.mark.long
def test_a_request_that_is_cut_off_by_ctrl_c_is_no_error(tmp_path):
    write_fis(tipper(), tmp_path / "tipper.fis")
    server = Server(tmp_path)
    with socket.create_connection(("127.0.0.1", server.port)) as half:
        head = "POST /upload?file=tipper.fis&name=a.fis HTTP/1.1"
        lines = [head, f"Host: 127.0.0.1:{server.port}", f"Origin: {server.url.rstrip('/')}", "Content-Length: 100"]
        lines += [f"Cookie: fuzzy-design-{server.port}={TOKEN}"]
        half.sendall("\r\n".join([*lines, "", "[System]"]).encode())  # and no more
        # So it has read what came before
        assert answer(server, "/modules/fuzzy/plugins/designer/static/chart.js")[0] == 200
        assert server.end() == (0, "")


SIDES = """() => [".shell-group:has(.fd-terms)", ".shell-group:last-child"].map((each) => {
  const { left, right, top, bottom } = document.querySelector(each).getBoundingClientRect();
  return { left, right, top, bottom };
})"""
GLANCE = """() => document.querySelector(".shell-glance-picture path.fd-section")?.getAttribute("d") ?? null"""


def test_what_one_looks_at_stays_in_sight(tab):
    """Beside what is edited from 900 px, in a small picture below it on narrower screens."""
    page = tab.page
    assert page.get_by_role("main").count() == 1
    levels = page.evaluate("[...document.querySelectorAll('h1, h2, h3')].map((each) => Number(each.localName[1]))")
    assert levels[0] == 1
    assert max(b - a for a, b in itertools.pairwise(levels)) <= 1
    page.get_by_role("tab", name="Surface").click()
    page.get_by_label("second input").select_option("")
    page.wait_for_selector(".fd-sections path.fd-section")
    for width, height in ((1600, 1000), (1093, 614), (900, 800)):
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("scrollTo(0, 0)")
        edit, look = page.evaluate(SIDES)
        assert edit["right"] <= look["left"], width
        assert look["bottom"] <= height
        assert page.locator(".fd-tree").is_visible() == (width == 1600)
        page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
        rest(page)
        assert page.get_by_role("tab", name="Surface").bounding_box()["y"] < 150, width  # it does not scroll away
    page.evaluate("scrollTo(0, 0)")
    page.set_viewport_size({"width": 900, "height": 420})  # a view that is taller than the window scrolls by itself
    view = "document.querySelector('.shell-group:last-child .shell-shown')"
    page.wait_for_function(f"{view}.scrollHeight > {view}.clientHeight")
    assert page.evaluate(SIDES)[1]["bottom"] <= 420
    page.set_viewport_size({"width": 900, "height": 800})
    page.get_by_role("button", name="System").click()
    assert page.locator(".fd-tree").is_visible()
    page.get_by_role("button", name="System").click()

    for width, height in ((800, 1000), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("scrollTo(0, 0)")
        page.wait_for_function(f"({GLANCE})() !== null")
        picture = page.locator(".shell-glance-picture").bounding_box()
        chart = page.locator(".fd-terms svg").first.bounding_box()
        assert chart["y"] + chart["height"] <= picture["y"] + 5
        assert picture["y"] + picture["height"] <= height
        before = page.evaluate(GLANCE)
        drag(page, foot(page), (-25, 0), release=True)
        until_changed(page, GLANCE, before)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.get_by_role("button", name="Hide").click()
    assert not page.locator(".shell-glance-picture").is_visible()
    page.get_by_role("button", name="Show", exact=True).click()
    page.get_by_role("button", name="Go there").click()
    assert page.locator(".shell-view .fd-surface").bounding_box()["y"] < 400
    page.get_by_label("second input").select_option("food")


def test_the_table_of_rules_scrolls_beside_the_view(tab):
    page = tab.page
    page.get_by_role("tab", name="Rules").click()
    page.get_by_role("button", name="Table", exact=True).click()
    sheet, view = page.locator(".fd-sheet"), page.locator(".fd-viewer")
    for width in (1600, 900):
        page.set_viewport_size({"width": width, "height": 1000})
        at, beside = sheet.bounding_box(), view.bounding_box()
        assert at["x"] + at["width"] <= beside["x"], width
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert sheet.evaluate("sheet => sheet.scrollWidth > sheet.clientWidth")
    # Headings stand over their columns, and the rule's number stays while one scrolls sideways.
    sheet.evaluate("sheet => sheet.scrollLeft = 200")
    heads, cells = (page.locator(f"{row} .fd-cells > *").all() for row in (".fd-headings", ".fd-rule:first-child"))
    for head, cell in zip(heads, cells, strict=True):
        assert head.bounding_box()["x"] == pytest.approx(cell.bounding_box()["x"], abs=1)
    assert page.locator(".fd-rule:first-child .fd-switch").bounding_box()["x"] >= sheet.bounding_box()["x"] - 1
    # A label that were a cell would name its field no more.
    assert page.locator("label[role]").count() == 0
    assert page.locator(".fd-rule:first-child > [role=cell] > label > input[type=checkbox]").count() == 1
    page.get_by_role("button", name="Sentences").click()
    page.get_by_role("tab", name="Memberships").click()


@pytest.mark.long
def test_sigterm_ends_the_workers_and_leaves_nothing_behind(tmp_path):
    """It left "5 leaked semaphore objects"."""
    import psutil

    write_fis(tipper(), tmp_path / "tipper.fis")
    server = Server(tmp_path)
    read = answer(server, "/upload?file=tipper.fis&name=a.fis", "POST", (tmp_path / "tipper.fis").read_bytes())
    assert read[0] == 200
    assert "said" in read[1]
    workers = psutil.Process(server.process.pid).children(recursive=True)
    assert workers
    assert server.end(signal.SIGTERM) == (128 + signal.SIGTERM, "")
    assert not psutil.wait_procs(workers, timeout=30)[1]  # orphans are told by a pipe that closes, and then end
    assert list((tmp_path / ".fuzzy-design").glob("*.json")) == []  # nothing that the file does not hold


def test_a_purpose_shows_what_fits_and_is_kept(tab, server):
    """Function, Loop, Robot: found, changed, kept over a reload; each offers its own views and ways to improve."""
    page = tab.page

    def offered():
        shown = page.locator("#shell-look [role=tab]:not(.shell-unfit)").all_inner_texts()
        page.get_by_role("button", name="Improve").click()
        ways = page.get_by_role("menuitem").all_inner_texts()
        page.keyboard.press("Escape")
        return shown, [way.rpartition(": ")[2] for way in ways]

    purpose = page.get_by_role("radiogroup", name="What the rule base is for")
    assert purpose.get_by_role("radio", checked=True).inner_text() == "Function"
    assert offered() == (["Surface", "Data"], ["Train"])
    purpose.get_by_role("radio", checked=True).focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_selector("[role=tab][aria-selected=true]:text('Step response')")
    assert offered() == (["Step response", "Surface"], ["Tune the loop", "Train"])
    tab.open(server.url)
    page.wait_for_selector("[role=radio][aria-checked=true]:text('Loop')")
    purpose.get_by_role("radio", name="Robot").click()
    page.wait_for_selector("[role=tab][aria-selected=true]:text('Try it')")
    assert offered() == (["Try it", "Certificate", "Surface"], ["Train", "Tune"])
    purpose.get_by_role("radio", name="Function").click()
    page.wait_for_selector("[role=tab][aria-selected=true]:text('Surface')")


def test_drawers_lie_over_the_editor_and_give_the_focus_back(tab):
    page = tab.page
    page.get_by_role("button", name="Improve").click()
    page.get_by_role("menuitem", name="From data: Train").click()
    drawer = page.get_by_role("region", name="Train")
    drawer.get_by_label("Start from").wait_for()
    page.wait_for_function("document.activeElement.ariaLabel === 'Close Train'")
    assert not page.locator(".fd-terms").is_visible()
    assert page.locator(".fd-surface").is_visible()  # the canvas stays in sight
    page.keyboard.press("Escape")
    page.wait_for_function("document.activeElement.innerText === 'Improve ▴'")
    assert page.locator(".fd-terms").is_visible()
    check = page.locator(".shell-badge")
    check.click()
    page.get_by_role("region", name="Check").get_by_text("Nothing is wrong with the rules.").wait_for()
    page.get_by_role("button", name="Close Check").click()
    page.wait_for_function("document.activeElement.innerText === 'Check ✓'")
    page.get_by_role("button", name="History", exact=True).click()
    page.get_by_role("region", name="History").wait_for()
    page.get_by_role("tab", name="Rules").click()  # a tab closes a drawer too
    page.wait_for_selector(".fd-rules")
    assert not page.get_by_role("region", name="History").is_visible()
    page.get_by_role("tab", name="Memberships").click()


def test_why_says_what_counts_and_can_be_folded_and_enlarged(tab):
    page = tab.page
    why = page.get_by_role("region", name="Why")
    assert re.match(r"Rule \d counts most, \d+ %: if ", why.locator(".fd-because").inner_text())
    surface, words = page.locator(".fd-surface"), why.get_by_role("region", name="Explanation")
    assert not words.is_visible()
    page.get_by_role("button", name="Enlarge why").click()
    words.wait_for()
    assert not surface.is_visible()
    page.get_by_role("button", name="Enlarge why").click()
    surface.wait_for()
    page.get_by_role("button", name="Fold why").click()
    why.locator(".fd-viewer").wait_for(state="hidden")
    page.get_by_role("button", name="Fold why").click()
    why.locator(".fd-viewer").wait_for()


@pytest.mark.parametrize(("width", "height"), [(1600, 1000), (1100, 800)])
def test_the_first_picture_is_in_sight(tab, server, folder, width, height):
    """Of each purpose, without scrolling: the whole picture, and why below it, also with many inputs above it."""
    from importlib.resources import files

    from fuzzy.plugins.designer.starts.control import rule_table

    text = (files("robotics") / "data" / "rulebases" / "tracking.fis").read_text(encoding="utf-8")
    (folder / "tracking.fis").write_text(text, encoding="utf-8")
    write_fis(rule_table("pid", 3), folder / "pid.fis")
    page = tab.page
    page.set_viewport_size({"width": width, "height": height})
    for file, purpose, view, picture in (
        ("tipper.fis", "Function", "contour", ".fd-surface .fd-bands svg"),
        ("pid.fis", "Loop", "", ".fd-step svg.pn-plot:has(path.st-design)"),
        ("tracking.fis", "Robot", "", ".fd-tryout svg.pn-plot:has(path[data-run=tried])"),
        ("tracking.fis", "Function", "contour", ".fd-surface .fd-bands svg"),
        ("tracking.fis", "Function", "3d", ".fd-surface canvas.fd-relief"),
    ):
        if file not in page.url:
            tab.open(f"{server.url}?file={file}")
        page.get_by_role("radio", name=purpose).click()
        if view:
            page.locator(f".fd-surface .fd-tab[data-view='{view}']").click()
        first = page.locator(picture).first
        first.wait_for()
        rest(page)
        box, why = first.bounding_box(), page.get_by_role("region", name="Why").bounding_box()
        assert box["height"] > 150, file
        if file == "tracking.fis":  # its strongest rule is the first, and not hidden by the head
            assert page.locator(".shell-why .fd-scroll").evaluate("(rules) => rules.scrollTop") == 0
        assert box["y"] + box["height"] <= why["y"] + 1, (file, purpose, view)
        assert why["y"] + why["height"] <= height, file
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    tab.open(server.url)


def test_pictures_in_sight_are_saved_as_they_look_and_copied_as_numbers(tab, server, folder):
    """An SVG with its own looks, a PNG at three times the screen's pixels, and the numbers behind the curves."""
    from io import BytesIO
    from xml.etree import ElementTree

    from PIL import Image

    from fuzzy.plugins.designer.starts.control import rule_table

    write_fis(rule_table("pi", 5), folder / "pi.fis")
    page = tab.open(f"{server.url}?file=pi.fis")
    page.wait_for_selector(".fd-step tbody tr")
    page.get_by_role("button", name="Pictures …").click()
    dialog = page.get_by_role("dialog", name="Pictures and tables in sight")
    named = dialog.locator("li > span:first-child").all_inner_texts()
    assert {"Output over time", "Control over time", "Table"} <= {*named}
    with page.expect_download() as download:
        dialog.get_by_role("button", name="SVG: Output over time").click()
    assert download.value.suggested_filename == "pi-output-over-time.svg"
    root = ElementTree.parse(download.value.path()).getroot()
    width, height = float(root.get("width")), float(root.get("height"))
    curves = [each for each in root.iter("{http://www.w3.org/2000/svg}path") if "stroke: rgb(0" in each.get("style")]
    assert curves  # the design's blue, which stands in a style sheet on the page
    with page.expect_download() as download:
        dialog.get_by_role("button", name="PNG: Output over time").click()
    picture = Image.open(BytesIO(Path(download.value.path()).read_bytes()))
    assert picture.size == (round(3 * width), round(3 * height))
    assert len(picture.convert("RGB").resize((60, 40)).getcolors(2400)) > 4  # something is drawn on it
    page.evaluate("window.print = () => {}")  # what would open the browser's dialog
    dialog.get_by_role("button", name="PDF …: Output over time").click()
    pdf = page.pdf(prefer_css_page_size=True)
    (size,) = re.findall(rb"/MediaBox ?\[0 0 ([\d.]+) ([\d.]+)\]", pdf)  # a page, of the picture's size
    assert [float(side) for side in size] == pytest.approx([0.75 * width, 0.75 * (height + 1)], abs=1.0)
    assert b"/Subtype /Image" not in pdf  # lines stay lines
    page.wait_for_selector(".shell-printed", state="detached")
    page.evaluate("navigator.clipboard.writeText = (text) => { window.copied = text; return Promise.resolve(); }")
    dialog.get_by_role("button", name="Copy the numbers: Output over time").click()
    dialog.get_by_text("The numbers are on the clipboard.").wait_for()
    rows = [line.split("\t") for line in page.evaluate("window.copied").splitlines()]
    assert rows[0] == ["time [s]", "output y, design", "output y, PID"]
    from fuzzy import step_response
    from fuzzy.plugins.loop.keptloop import kept_settings, step_arguments, transfer_of

    settings = kept_settings("{}")
    done = step_response(rule_table("pi", 5), transfer_of(settings), **step_arguments(settings))
    assert [float(row[1]) for row in rows[1:]] == pytest.approx(done.output.tolist())
    dialog.get_by_role("button", name="Copy the numbers: Table").click()
    page.wait_for_function("window.copied.startsWith('Figure\\tdesign')")
    dialog.get_by_role("button", name="Close").click()
    tab.open(server.url)
