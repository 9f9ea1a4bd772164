"""The designer's server without a browser: who may ask, what may be read, work beside the page, notebooks' modules."""

import asyncio
import importlib
import os
import re
import socket
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from fuzzy.commands.application import main
from fuzzy.errors import InputError
from fuzzy.esmodule import ModuleError
from fuzzy.files.fisfile import FisFileError, format_fis, read_fis, write_fis
from fuzzy.membership import Triangle
from fuzzy.plugins.designer import autosave, panel
from fuzzy.plugins.designer.figures import DESIGN_FIGURES, figure_bytes
from fuzzy.plugins.designer.folder import LARGEST_FILE, FolderError, open_folder, read_bytes
from fuzzy.plugins.designer.guard import Guard
from fuzzy.plugins.designer.modules import Modules
from fuzzy.plugins.designer.open_documents import MamdaniFileError, OpenDocuments
from fuzzy.plugins.designer.panel import PagePart, Workbench, find_panels
from fuzzy.plugins.designer.server import ServerError, bound_socket, token_of
from fuzzy.plugins.designer.workers import DesignerWorkers, TimedWorkers, WorkError
from fuzzy.plugins.mamdani.likeness import mamdani_difference, read_mamdani_original
from fuzzy.system import Sugeno, Variable
from tests.browsers import run_apart
from tests.fuzzy.plugins.designer import served

CORPUS = Path(__file__).parents[3] / "data" / "fis-corpus"


def small(name="small"):
    terms = {"low": Triangle(-1, 0, 1), "high": Triangle(0, 1, 2)}
    rules = ["if x is low then y is a", "if x is high then y is b"]
    return Sugeno([Variable("x", (0, 1), terms)], [Variable("y", (0, 1), {"a": 0.0, "b": 1.0})], rules, name=name)


# Who may ask


def asked(headers, kind="http", method="GET", token="", query=""):
    """What the guard lets through (True) or the status and headers of its answer."""
    passed, answers = [], []

    async def app(scope, receive, send):
        passed.append(scope)
        if scope["type"] == "http":
            await send({"type": "http.response.start", "status": 200, "headers": []})

    async def send(message):
        answers.append(message)

    named = [(n.encode(), v.encode()) for n, v in headers]
    scope = {"type": kind, "method": method, "path": "/", "query_string": query.encode(), "headers": named}
    run_apart(Guard(app, 8080, token)(scope, None, send))
    return bool(passed), answers


OWN = ("host", "127.0.0.1:8080")


@pytest.mark.parametrize(
    ("headers", "http", "websocket"),
    [
        ([OWN], True, False),
        ([OWN, ("origin", "http://127.0.0.1:8080")], True, True),
        ([("host", "LOCALHOST:8080"), ("origin", "http://localhost:8080")], True, True),
        ([("host", "localhost:8080"), ("origin", "http://127.0.0.1:8080")], False, False),
        ([], False, False),
        ([OWN, OWN], False, False),
        ([("host", "127.0.0.1")], False, False),
        ([("host", "127.0.0.1:8080.evil.example")], False, False),
        ([("host", "evil.example:8080"), ("origin", "http://evil.example:8080")], False, False),
        ([OWN, ("origin", "http://127.0.0.1:8081")], False, False),
        ([OWN, ("origin", "null")], False, False),
        ([OWN, ("sec-fetch-site", "same-origin")], True, False),
        ([OWN, ("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "no-cors")], False, False),
        ([OWN, ("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")], True, False),
    ],
)
def test_guard(headers, http, websocket):
    passed, answers = asked(headers)
    assert passed == http
    assert answers[0]["status"] == (200 if http else 403)
    passed, answers = asked(headers, "websocket")
    assert passed == websocket
    assert websocket or answers[0]["type"] == "websocket.close"


FOLLOWED = [OWN, ("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")]


@pytest.mark.parametrize("method", ["GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS"])
def test_a_followed_link_asks_and_changes_nothing(method):
    assert asked(FOLLOWED, method=method)[0] == (method in ("GET", "HEAD"))


WORD = "a-word-that-nobody-guesses"


@pytest.mark.parametrize(
    ("query", "cookie", "passed"),
    [
        ("", "", False),
        (f"token={WORD}", "", True),
        (f"file=a.fis&token={WORD}", "", True),
        ("token=", "", False),
        ("token=" + WORD[:-1], "", False),
        (f"token={WORD}x", "", False),
        ("token=%ff%00\u00e4", "", False),
        ("&".join(["a=1"] * 200), "", False),
        ("", f"fuzzy-design-8080={WORD}", True),
        ("", f"other=1; fuzzy-design-8080={WORD}; more=2", True),
        ("token=wrong", f"fuzzy-design-8080={WORD}", True),
        ("", f"fuzzy-design-8081={WORD}", False),
        ("", "fuzzy-design-8080=wrong", False),
        ("", f"token={WORD}", False),
        ("", "\u00e4=\u00e4; ;;=", False),
    ],
)
def test_without_the_token_nothing_is_answered(query, cookie, passed):
    headers = [OWN, ("origin", "http://127.0.0.1:8080"), *([("cookie", cookie)] if cookie else [])]
    for kind, method in (("http", "GET"), ("http", "POST"), ("websocket", "GET")):
        let, answers = asked(headers, kind, method, WORD, query)
        assert let == passed
        if kind == "websocket":
            assert passed or answers[0]["type"] == "websocket.close"
            continue
        assert answers[0]["status"] == (200 if passed else 403)
        told = [v.decode() for n, v in answers[0]["headers"] if n == b"set-cookie"]
        wanted = (
            [f"fuzzy-design-8080={WORD}; Path=/; HttpOnly; SameSite=Strict"] if f"token={WORD}" in query[-40:] else []
        )
        assert told == (wanted if passed else [])
        assert passed or "printed in the terminal" in answers[1]["body"].decode()
        assert passed or WORD not in str(answers)


def test_a_token_of_a_foreign_page_does_not_help():
    assert not asked([OWN, ("origin", "http://evil.example")], token=WORD, query=f"token={WORD}")[0]


def test_the_token_is_random_or_the_environments():
    first, second = token_of(None), token_of(None)
    assert first != second
    assert min(len(first), len(second)) >= 32  # 24 random bytes
    assert token_of(WORD) == WORD
    assert token_of("") == ""
    for weak in ("short", "with blank in it", "a" * 300, "täglich-ein-neues"):
        with pytest.raises(ServerError, match="FUZZYFLEET_TOKEN"):
            token_of(weak)


def test_the_browser_is_told_to_ask_nobody_else():
    _, [answer] = asked([OWN])
    policy = dict(answer["headers"])[b"content-security-policy"].decode()
    hosts = set(re.findall(r"//([^ ;]+)", policy))
    assert hosts == {"127.0.0.1:8080", "localhost:8080"}
    assert "default-src 'none'" in policy
    assert "*" not in policy


def test_connections_that_ask_nothing_are_closed_and_others_are_not(tmp_path, monkeypatch):
    sooner = "import fuzzy.plugins.designer.server as s; s._SILENT = 1.0; "
    monkeypatch.setattr(served, "START", sooner + served.START)
    server = served.Server(tmp_path)
    host = f"127.0.0.1:{server.port}"
    half = f" HTTP/1.1\r\nHost: {host}\r\nCookie: fuzzy-design-{server.port}={served.TOKEN}\r\n".encode()
    connections = [socket.create_connection(("127.0.0.1", server.port), timeout=20) for _ in range(4)]
    nothing, part, whole, page = connections
    part.sendall(b"GET /" + half)
    whole.sendall(b"GET /nowhere" + half + b"\r\n")
    page.sendall(b"GET /_nicegui_ws/socket.io/?EIO=4&transport=websocket" + half)
    page.sendall(b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n")
    page.sendall(f"Sec-WebSocket-Key: {16 * 'A'}AAAAAA==\r\nOrigin: http://{host}\r\n\r\n".encode())
    assert whole.recv(1000).startswith(b"HTTP/1.1 404")
    assert page.recv(1000).startswith(b"HTTP/1.1 101")
    assert [nothing.recv(1), part.recv(1)] == [b"", b""]
    page.settimeout(0.5)
    with pytest.raises(TimeoutError):
        list(iter(lambda: page.recv(1000), b""))
    for each in connections:
        each.close()
    assert server.end() == (0, "")


def test_port():
    taken = socket.socket()
    taken.bind(("127.0.0.1", 0))
    taken.listen()
    port = taken.getsockname()[1]
    with pytest.raises(ServerError, match=f"127.0.0.1:{port}"):
        bound_socket(port)
    first, second = bound_socket(None), bound_socket(None)
    assert first.getsockname()[0] == second.getsockname()[0] == "127.0.0.1"
    assert first.getsockname()[1] != second.getsockname()[1]
    for each in (taken, first, second):
        each.close()


# What may be read


def test_folder(tmp_path):
    inner, outer = tmp_path / "inner", tmp_path / "outer.fis"
    (inner / "deep" / "deeper" / "deepest").mkdir(parents=True)
    (inner / ".hidden").mkdir()
    for path in (outer, inner / "b.fis", inner / "deep" / "A.FIS", inner / ".hidden" / "c.fis"):
        write_fis(small(), path)
    write_fis(small(), inner / "deep" / "deeper" / "deepest" / "d.fis")
    (inner / "folder.fis").mkdir()
    (inner / "link.fis").symlink_to(outer)
    (inner / "way").symlink_to(tmp_path)
    (inner / "own.fis").symlink_to(inner / "b.fis")
    (inner / "ring.fis").symlink_to(inner / "ring.fis")
    folder = open_folder(inner)
    assert folder.files() == ["b.fis", "deep/A.FIS", "own.fis"]
    assert folder.inside("deep/new.fis") == inner / "deep" / "new.fis"
    assert folder.inside("own.fis") == inner / "b.fis"
    assert folder.read("deep/A.FIS") == small()
    bad = ["link.fis", "way/outer.fis", "../outer.fis", str(outer), "ring.fis", "folder.fis", ".hidden/c.fis", "b.txt"]
    for name in [
        *bad,
        "",
        "a\0.fis",
        "deep\\A.fis",
        "C:b.fis",
        "deep//A.fis",
        "./b.fis",
        "a" * 400 + ".fis",
        "Con.fis",
        "aux/a.fis",
        "a\u202egpj.fis",
    ]:
        with pytest.raises(FolderError):
            folder.inside(name)
    for name in (
        "a?b.fis",
        'a"b.fis',
        "a<b>.fis",
        "a|b.fis",
        "a*.fis",
        "CONIN$.fis",
        "conout$.fis",
        "a /b.fis",
        "a./b.fis",
    ):
        with pytest.raises(FolderError, match="Windows"):
            folder.inside(name)
    (inner / "what?.fis").touch()  # one that is there can be opened
    assert folder.inside("what?.fis") == inner / "what?.fis"
    with pytest.raises(FolderError, match="no file"):
        folder.read("missing.fis")
    (inner / "large.fis").write_bytes(b" " * (LARGEST_FILE + 1))
    with pytest.raises(FolderError, match="2 MB"):
        folder.read("large.fis")
    with pytest.raises(FolderError, match="no folder"):
        open_folder(outer)


def test_upload_is_read_with_line_and_warnings():
    text = format_fis(small("größe"))
    assert read_bytes(text.encode(), "a.fis")[:4] == (small("größe"), (), (), ())
    fis, _, (warning,), *_ = read_bytes(text.encode("latin-1"), "a.fis")
    assert fis.name == "größe"
    assert "not UTF-8" in warning
    with pytest.raises(FisFileError, match=r"a\.fis:\d+: "):
        read_bytes(text.replace("NumRules=2", "NumRules=3").encode(), "a.fis")
    for data in (b"", b"\0" * 100, bytes(range(256)), text.encode("utf-16")):
        with pytest.raises(FisFileError):
            read_bytes(data, "a.fis")


def test_modules(tmp_path):
    modules = Modules()
    import fuzzy

    static = os.path.dirname(fuzzy.__file__)  # noqa: PTH120
    assert modules.file("fuzzy", "plugins/designer/static/chart.js").samefile(
        f"{static}/plugins/designer/static/chart.js"
    )
    for path in (
        "plugins/designer/server.py",
        "../pyproject.toml",
        "plugins/designer/static",
        "plugins/designer/none.js",
        "",
        "\0.js",
    ):
        assert modules.file("fuzzy", path) is None
    assert modules.file("os", "path.js") is None
    package = tmp_path / "other"
    package.mkdir()
    for name in ("__init__.py", "a.js"):
        (package / name).touch()
    (package / "link.js").symlink_to(__file__)
    assert modules.url(package / "a.js") == "/modules/other/a.js"
    assert modules.file("other", "a.js") == package / "a.js"
    assert modules.file("other", "link.js") is None


# Documents that tabs share


def test_desk(tmp_path):
    write_fis(small(), tmp_path / "a.fis")

    async def work():
        opened = OpenDocuments(open_folder(tmp_path))
        first, other = opened.document("a.fis"), opened.document("b.fis")
        assert opened.document("a.fis") is first
        first.apply({"edit": "rename", "name": "changed"})
        assert opened.document("a.fis").saved is False
        # Kept soon, in a thread, not when the process ends.
        async with asyncio.timeout(20):
            while not any("changed" in path.read_text() for path in tmp_path.glob(".fuzzy-design/*.json")):
                await asyncio.sleep(0.01)
        opened.arrive(other)
        opened.save(other)
        with pytest.raises(FolderError, match="another tab"):
            opened.save(first, "b.fis", overwrite=True)
        opened.leave(other)
        opened.save(first, "b.fis", overwrite=True)
        assert opened.document("b.fis") is first
        with pytest.raises(FolderError):
            opened.save(first, "../c.fis")
        opened.close()

    run_apart(work())
    assert read_fis(tmp_path / "b.fis").name == "changed"
    assert read_fis(tmp_path / "a.fis") == small()


def never():
    threading.Event().wait()


def test_a_file_that_takes_too_long_is_given_up_and_the_next_one_is_read(tmp_path):
    write_fis(small(), tmp_path / "a.fis")

    async def work():
        opened = OpenDocuments(open_folder(tmp_path))
        assert (await opened.read("a.fis"))[:4] == (small(), (), (), ())
        worker = opened._reader
        worker._limit = 0.05
        with pytest.raises(InputError, match=r"^too late$"):
            await worker.run("too late", never)
        worker._limit = 60
        document, again = await asyncio.gather(opened.opened("a.fis"), opened.opened("a.fis"))
        assert document is again
        with pytest.raises(InputError, match="missing"):
            await opened.read("missing.fis")
        with pytest.raises(InputError, match=r"b\.fis:1: "):
            await opened.read_upload(b"x", "b.fis")
        opened.close()

    run_apart(work())


def test_a_mamdani_file_is_offered_as_a_sugeno_system_of_another_name(tmp_path):
    (tmp_path / "old.fis").write_bytes((CORPUS / "m02_auvsl_rgator.fis").read_bytes())
    write_fis(small(), tmp_path / "old-sugeno.fis")

    async def work():
        opened = OpenDocuments(open_folder(tmp_path))
        with pytest.raises(MamdaniFileError, match=r"old\.fis is a Mamdani system.*old-sugeno-2\.fis") as caught:
            await opened.opened("old.fis")
        assert "v is low: the set trimf [7.5 22.5 30] became the constant 20, its centroid" in caught.value.changes
        fitted = await opened.opened("old-fitted.fis", "old.fis", "planes")
        original = read_mamdani_original(tmp_path / "old.fis")
        assert not isinstance(caught.value.forms, str)
        forms = {form.fit: form.offs for form in caught.value.forms}
        for fit, fis in (("", original.as_sugeno()[0]), ("planes", fitted.design.system)):
            for off, found in zip(forms[fit], mamdani_difference(original, fis), strict=True):
                assert (off.output, off.span) == (found.output, np.ptp(fis[found.output].universe))
                assert (off.greatest, off.root_mean_square) == pytest.approx((found.greatest, found.root_mean_square))
        assert sum(off.root_mean_square for off in forms["planes"]) < sum(off.root_mean_square for off in forms[""])
        document = await opened.opened(caught.value.free, "old.fis")
        assert document.design.system.name == "controller"
        assert "old.fis was a Mamdani system" in document.notes[0]
        assert not document.saved
        opened.save(document)
        assert (await opened.read("old.fis")).system == document.design.system  # to compare with
        with pytest.raises(InputError, match="Mamdani"):
            opened.folder.read("old.fis")
        opened.close()

    run_apart(work())
    assert read_fis(tmp_path / "old-sugeno-2.fis")["v"].terms["low"].value == 20
    assert (tmp_path / "old.fis").read_bytes() == (CORPUS / "m02_auvsl_rgator.fis").read_bytes()
    assert read_fis(tmp_path / "old-sugeno.fis") == small()


def test_what_a_page_cannot_show_is_refused_with_the_limit(tmp_path, monkeypatch):
    def many(inputs=1, terms=1, rules=1):
        functions = {f"t{n}": Triangle(0, 1, 2) for n in range(terms)}
        variables = [Variable(f"x{n}", (0, 1), functions) for n in range(inputs)]
        rule = " and ".join(f"x{n} is t0" for n in range(inputs))
        return Sugeno(variables, [Variable("y", (0, 1), {"a": 0.0})], [f"if {rule} then y is a"] * rules)

    for name, most in (("_MOST_VARIABLES", 3), ("_MOST_TERMS", 4), ("_MOST_RULES", 5), ("_MOST_CLAUSES", 6)):
        monkeypatch.setattr(f"fuzzy.plugins.designer.folder.{name}", most)
    for large, told in (
        (many(inputs=4), "4 inputs; the designer shows at most 3"),
        (many(terms=5), "5 terms of 'x0'; the designer shows at most 4"),
        (many(rules=6), "6 rules; the designer shows at most 5"),
        (many(inputs=3, rules=3), "9 clauses in its rules; the designer shows at most 6"),
    ):
        with pytest.raises(FolderError, match=rf"a\.fis: {told}"):
            read_bytes(format_fis(large).encode(), "a.fis")
        write_fis(large, tmp_path / "a.fis")
        with pytest.raises(FolderError, match=told):
            OpenDocuments(open_folder(tmp_path)).document("a.fis")


def test_a_document_that_nobody_touched_is_forgotten(tmp_path):
    async def work():
        opened = OpenDocuments(open_folder(tmp_path))
        begun = opened.document("begun.fis", small())
        for name in ("a.fis", "b.fis", "begun.fis"):
            document = opened.document(name)
            opened.arrive(document)
            opened.arrive(document)
            opened.leave(document)
            assert opened.document(name) is document
            if name == "b.fis":
                document.apply({"edit": "rename", "name": "changed"})
                touched = document
            opened.leave(document)
        assert opened.document("b.fis") is touched
        assert opened.document("begun.fis") is begun  # no file and no address tells what it began with
        assert len(opened._documents) == 2
        opened.close()

    run_apart(work())


def test_work_that_cannot_be_kept_is_told_until_it_can(tmp_path, monkeypatch, capsys):
    write_fis(small(), tmp_path / "a.fis")
    monkeypatch.setattr("fuzzy.plugins.designer.open_documents.AUTOSAVE", 0.01)
    monkeypatch.setattr("fuzzy.plugins.designer.open_documents.AGAIN", 0.01)
    told, tried, full = [], [], True

    def write(file, design, base):
        tried.append(design.system.name)
        if full:
            raise OSError(28, "No space left on device")
        return written(file, design, base)

    written = autosave.write
    monkeypatch.setattr(autosave, "write", write)

    async def work():
        nonlocal full
        opened = OpenDocuments(open_folder(tmp_path))
        document = opened.document("a.fis")
        opened.arrive(document, lambda: told.append(document.unkept))
        for name in ("once", "twice"):
            document.apply({"edit": "rename", "name": name})
            while tried.count(name) < 2:  # the first has been dealt with then
                await asyncio.sleep(0.005)
        assert len(told) == 1
        assert told[0].endswith("a.fis.json: No space left on device")
        full = False
        while len(told) < 2:
            await asyncio.sleep(0.005)
        assert told[1] is None
        opened.close()

    run_apart(work())
    assert capsys.readouterr().err.count("No space left on device") == 1  # once, and not at every edit
    assert "twice" in (tmp_path / ".fuzzy-design" / "a.fis.json").read_text()


def test_designs_that_no_file_has_yet_are_listed(tmp_path):
    write_fis(small(), tmp_path / "a.fis")
    folder = open_folder(tmp_path)
    kept = tmp_path / ".fuzzy-design"
    kept.mkdir()
    for name in ("a.fis.json", "new.fis.json", "new.fis.0123456789abcdef.json", "other.txt"):
        (kept / name).write_text("{}")
    assert folder.unsaved(folder.files()) == ["new.fis"]


def test_a_hidden_panel_rests(tmp_path):
    write_fis(small(), tmp_path / "a.fis")
    calls, said = [], []

    async def slow():
        calls.append("shown")

    def refuse():
        raise InputError("not like this")

    async def work():
        opened = OpenDocuments(open_folder(tmp_path))
        bench = Workbench(opened.document("a.fis"), opened.workers, Modules().url, lambda *what: said.append(what))
        place = PagePart(shown=False)
        with bench.building(place):
            bench.on_change(lambda: calls.append("hidden"))
        bench.on_change(slow)
        bench.on_change(refuse)
        bench.on_close(lambda: calls.append("closed"))
        await bench.changed()
        assert (calls, said) == (["shown"], [("not like this", True)])
        assert place.missed
        place.shown = True
        await bench.changed(place)
        assert calls == ["shown", "hidden"]
        await bench.close()
        await bench.changed()
        assert calls == ["shown", "hidden", "closed"]

    run_apart(work())


def test_what_follows_the_hand_comes_before_the_rest_of_the_page(tmp_path, monkeypatch):
    write_fis(small(), tmp_path / "a.fis")
    calls = []

    async def work():
        opened = OpenDocuments(open_folder(tmp_path))
        bench = Workbench(opened.document("a.fis"), opened.workers, Modules().url, lambda *what: None)
        run = asyncio.Event()

        async def follow():
            await run.wait()
            calls.append("run")

        bench.on_change(lambda: calls.append("rest"), later=True)
        bench.on_change(follow)
        asyncio.get_running_loop().call_later(0.01, run.set)
        monkeypatch.setattr(panel, "HEAD_START", 60.0)
        await bench.changed()
        assert calls == ["run", "rest"]
        # A run that takes long does not hold the page up.
        run.clear()
        monkeypatch.setattr(panel, "HEAD_START", 0.0)
        changed = asyncio.create_task(bench.changed())
        while len(calls) < 3:
            await asyncio.sleep(0)
        assert calls[2] == "rest"
        run.set()
        await changed
        assert calls[3] == "run"

    run_apart(work())


def test_panels_are_found(monkeypatch):
    from importlib import metadata

    group = "fuzzyfleet.designer"
    points = [
        metadata.EntryPoint("late", f"{__name__}:LATE", group),
        metadata.EntryPoint("early", f"{__name__}:Early", group),
        metadata.EntryPoint("gone", "no_such_package_at_all:panel", group),
    ]
    monkeypatch.setattr(metadata, "entry_points", lambda group: points)
    panels, missing = find_panels()
    assert [panel.title for panel in panels] == ["Early", "Late"]
    assert len(missing) == 1
    assert "'gone'" in missing[0]


class Early:
    title, order = "Early", 1

    def build(self, bench):
        pass


class Late(Early):
    title, order = "Late", 2


LATE = Late()


# Work beside the page


def refused(word):
    raise InputError(f"no {word}")


def failed():
    raise KeyError("bug")


def unsendable():
    return lambda: None


def ended():
    os._exit(3)


def test_workers():
    async def work():
        workers = DesignerWorkers(1)
        own = await workers.run(os.getpid)
        assert own != os.getpid()
        assert await workers.run(os.getpid) == own
        with pytest.raises(InputError, match=r"^no way$"):
            await workers.run(refused, "way")
        for bug in (failed, unsendable):
            with pytest.raises(WorkError):
                await workers.run(bug)
        # The page's loop goes on while a worker works.
        turns, task = 0, asyncio.ensure_future(workers.run(sum, range(10_000_000)))
        while not task.done():
            turns += 1
            await asyncio.sleep(0)
        assert turns > 10
        assert task.result() == 49_999_995_000_000
        with pytest.raises(WorkError, match="ended"):
            await workers.run(ended)
        assert await workers.run(os.getpid) not in (own, os.getpid())  # a new one
        workers.close()
        workers.close()

    run_apart(work())


def until_there(path):
    while not path.exists():
        time.sleep(0.01)
    return path.name


def test_a_slow_file_keeps_no_other_waiting(tmp_path):
    async def read():
        opened = OpenDocuments(open_folder(tmp_path))
        slow = asyncio.ensure_future(opened.reading("slow.py", until_there, tmp_path / "go"))
        fis = await opened.read_upload(format_fis(small()).encode(), "other.fis")
        assert fis.system.rules == small().rules
        assert not slow.done()
        (tmp_path / "go").touch()
        assert await slow == "go"
        opened.close()

    async def give_up():
        workers = TimedWorkers(0.0)
        with pytest.raises(InputError, match=r"^late$"):
            await workers.run("late", until_there, tmp_path / "never")
        workers.close()

    run_apart(read())
    run_apart(give_up())


def test_what_a_process_loads_first_is_not_the_files_time(tmp_path, monkeypatch):
    (tmp_path / "slow_to_load.py").write_text(
        "import multiprocessing, time\n"
        "if multiprocessing.parent_process() is not None:\n"
        "    time.sleep(4)\n"
        "def done():\n"
        "    return 'done'\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    function = importlib.import_module("slow_to_load").done

    async def read():
        workers = TimedWorkers(3.0)
        assert await workers.run("late", function) == "done"
        workers.close()

    run_apart(read())


def test_figures():
    for kind in DESIGN_FIGURES:
        assert figure_bytes(small(), kind, "svg", [0.5], [0], 0).startswith(b"<?xml")
    with pytest.raises(InputError, match="png"):
        figure_bytes(small(), "surface", "gif", [0.5], [0], 0)
    with pytest.raises(InputError, match="memberships"):
        figure_bytes(small(), "secrets", "png", [0.5], [0], 0)


# The command


def test_command_says_what_is_wrong(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.fis").write_bytes(b"\0")
    (tmp_path / "elsewhere").mkdir()
    for arguments, told in (
        (["bad.fis"], "bad.fis"),
        (["nowhere/x.fis"], "no folder"),
        (["x.txt"], ".fis"),
        (["x.fis", "--folder", "elsewhere/none"], "no folder"),
        (["bad.fis", "--folder", "elsewhere"], "not in the folder"),
        (["x.fis", "--port", "70000"], "port"),
    ):
        assert main(["design", *arguments, "--no-browser"]) == 2
        out, err = capsys.readouterr()
        assert told in err
        assert out == ""
        assert "Traceback" not in err
    taken = socket.socket()
    taken.bind(("127.0.0.1", 0))
    taken.listen()
    assert main(["design", "x.fis", "--no-browser", "--port", str(taken.getsockname()[1])]) == 2
    assert "another --port" in capsys.readouterr().err
    taken.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.fis", "elsewhere"]


def test_without_the_extra(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "nicegui", None)
    assert main(["design", str(tmp_path / "x.fis")]) == 2
    assert "the designer needs NiceGUI: pip install 'nicegui>=" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "anywidget", None)
    from fuzzy.plugins.designer.notebook import editor

    with pytest.raises(ModuleError, match="pip install 'anywidget>="):
        editor(small())
