"""The designer's server: a NiceGUI application on 127.0.0.1 that serves one folder."""

import asyncio
import contextlib
import logging
import os
import socket
import sys
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from fuzzy.designer.document import Document, DocumentError
from fuzzy.designer.folder import LARGEST_FILE, MOST_RULES, Folder, FolderError, read_bytes
from fuzzy.designer.guard import Guard
from fuzzy.designer.workers import WorkError, Workers
from fuzzy.errors import InputError

if TYPE_CHECKING:
    from fastapi import Request

HOST = "127.0.0.1"
PORT = 8080
AUTOSAVE = 0.25  # s between two autosaves of a document while it is being dragged


class Desk:
    """The documents of a folder that are open. All browser tabs with one file look at one document."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.workers = Workers()
        self._documents: list[Document] = []
        self._tabs: dict[int, int] = {}  # how many look at a document, by its id
        self._waiting: set[int] = set()  # documents that were autosaved just now

    def document(self, name: str) -> Document:
        """The document of the file ``name``, which need not exist yet.

        Raises FolderError, DocumentError or FisFileError for what cannot be opened.
        """
        path = self.folder.inside(name)
        for document in self._documents:
            if document.path == path:
                return document
        if path.is_file() and path.stat().st_size > LARGEST_FILE:
            raise FolderError(f"{name!r} is larger than {LARGEST_FILE / 1e6:g} MB")
        document = Document(path, self.folder.path)
        if len(document.design.lines) > MOST_RULES:
            raise FolderError(f"{name}: {len(document.design.lines)} rules; the designer shows at most {MOST_RULES}")
        document.listen(lambda: self._autosave_soon(document))
        self._documents.append(document)
        return document

    def arrive(self, document: Document) -> None:
        """A browser tab looks at the document."""
        self._tabs[id(document)] = self._tabs.get(id(document), 0) + 1

    def leave(self, document: Document) -> None:
        """It does no more."""
        self._tabs[id(document)] -= 1

    def save(self, document: Document, name: str | None = None, overwrite: bool = False) -> None:
        """Save the document, under another name if one is given. Raises FolderError, DocumentError, OSError."""
        path = document.path if name is None else self.folder.inside(name)
        for other in [d for d in self._documents if d is not document and d.path == path]:
            if self._tabs.get(id(other), 0) > 0:
                raise FolderError(f"{name!r} is open in another tab; close that one first, or take another name")
            self._autosave(other)
            self._documents.remove(other)
        document.save(None if name is None else path, overwrite=overwrite)

    def close(self) -> None:
        """Write what is not saved beside the files, and end the workers."""
        for document in self._documents:
            self._autosave(document)
        self.workers.close()

    def _autosave_soon(self, document: Document) -> None:
        """Write now, and during a drag four times a second: whatever happens, at most that much is lost."""
        if id(document) not in self._waiting:
            self._waiting.add(id(document))
            self._autosave(document)
            asyncio.get_running_loop().call_later(AUTOSAVE, self._autosave_again, document)

    def _autosave_again(self, document: Document) -> None:
        self._waiting.discard(id(document))
        self._autosave(document)

    def _autosave(self, document: Document) -> None:
        try:
            document.autosave()
        except DocumentError as error:
            print(f"fuzzy design: {error}", file=sys.stderr)


class Modules:
    """The ES modules and style sheets that pages may load: those of packages whose modules are shown."""

    def __init__(self) -> None:
        self._roots: dict[str, Path] = {}
        self.url(Path(__file__))

    def url(self, file: Path) -> str:
        """Where pages find a file of an installed package: /modules/PACKAGE/PATH IN THE PACKAGE."""
        file = file.resolve()
        root = file.parent
        # Folders of modules need not be packages themselves: the topmost package counts.
        packages = [folder for folder in file.parents if (folder / "__init__.py").is_file()]
        root = packages[-1] if packages else root
        self._roots[root.name] = root
        return f"/modules/{quote(root.name)}/{quote(file.relative_to(root).as_posix())}"

    def file(self, package: str, path: str) -> Path | None:
        """The file for such an address; None where no page may have it."""
        root = self._roots.get(package)
        if root is None or "\0" in path:
            return None
        file = (root / path).resolve()
        allowed = file.suffix in (".js", ".css") and file.is_relative_to(root) and file.is_file()
        return file if allowed else None


def bound_socket(port: int | None) -> socket.socket:
    """A socket on 127.0.0.1 at ``port``; None takes 8080 or the next free one. Raises FolderError if it is taken."""
    for candidate in range(PORT, PORT + 50) if port is None else [port]:
        found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        if os.name != "nt":  # elsewhere it means "also where another one listens"
            found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((HOST, candidate))
            # Listening already now: a second designer that starts at this moment finds the port taken.
            found.listen(128)
        except OSError as error:
            found.close()
            if port is not None:
                raise ServerError(f"cannot listen at {HOST}:{port}: {error.strerror}; choose another --port") from None
        else:
            found.set_inheritable(False)
            return found
    raise ServerError(f"no port from {PORT} to {PORT + 49} is free; choose another with --port")


class UploadSizeError(FolderError):
    """An upload of more than 2 MB."""


class ServerError(InputError):
    """The server cannot start as it was told to."""


def serve(
    folder: Folder, name: str, port: int | None = None, browser: bool = True, said: Callable[[str], None] = print
) -> None:
    """Serve the designer until it is interrupted; ``name`` is the file of the folder that the first page shows.

    ``said`` gets the address when the server listens. Raises ServerError where it cannot listen, and what opening
    the file raises.
    """
    desk = Desk(folder)
    desk.document(name)  # what is wrong with the file is said here, before anything starts
    listening = bound_socket(port)
    number = listening.getsockname()[1]
    url = f"http://{HOST}:{number}/"
    try:
        server = _server(desk, name, number)

        def started() -> None:
            said(f"The designer of {folder.name(desk.document(name).path)} is at {url} (Ctrl-C ends it).")
            sys.stdout.flush()
            if browser:
                webbrowser.open(url)

        server.config.app.app.state.started = started
        with contextlib.suppress(KeyboardInterrupt):
            server.run(sockets=[listening])
    finally:
        listening.close()
        desk.close()


def _server(desk: Desk, name: str, port: int) -> Any:
    import uvicorn
    from fastapi import FastAPI
    from nicegui import app as pages
    from nicegui import ui

    from fuzzy.designer.page import build_page

    modules = Modules()
    logging.getLogger("nicegui").setLevel(logging.ERROR)  # a mistyped address is no event

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> Any:
        asyncio.get_running_loop().call_soon(app.state.started)
        yield

    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan)
    _add_routes(app, desk, modules)

    @ui.page("/")
    async def designer(file: str = "") -> None:
        await build_page(desk, modules, file or name)

    ui.run_with(
        app,
        title="Fuzzy designer",
        favicon="📈",
        dark=None,
        language="en-US",
        binding_refresh_interval=None,
        reconnect_timeout=60.0,
        tailwind=False,
        show_welcome_message=False,
    )
    pages.on_exception(_report)
    config = uvicorn.Config(
        Guard(app, port), log_level="warning", server_header=False, timeout_graceful_shutdown=2, ws_max_size=4_000_000
    )
    return uvicorn.Server(config)


def _report(error: Exception) -> None:
    # A bug: NiceGUI logs it with its traceback; the page goes on with the last good design.
    print(f"fuzzy design: {type(error).__name__}: {error}", file=sys.stderr)


def _add_routes(app: Any, desk: Desk, modules: Modules) -> None:
    from fastapi import Request
    from fastapi.responses import FileResponse, JSONResponse, Response

    types = {".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8"}

    @app.get("/modules/{package}/{path:path}")
    def module(package: str, path: str) -> Response:
        file = modules.file(package, path)
        if file is None:
            return JSONResponse({"problem": "there is no such module"}, 404)
        return FileResponse(file, media_type=types[file.suffix], headers={"Cache-Control": "no-cache"})

    @app.post("/upload")
    async def upload(request: Request, file: str, name: str) -> Response:
        try:
            return JSONResponse(await _uploaded(request, desk, file, name))
        except UploadSizeError as error:
            return JSONResponse({"problem": str(error)}, 413)
        # A file that makes no system is no error of the page's: an answer like any other.
        except (InputError, WorkError) as error:
            return JSONResponse({"problem": str(error)})
        except OSError as error:
            return JSONResponse({"problem": error.strerror or str(error)})


async def _uploaded(request: "Request", desk: Desk, file: str, name: str) -> dict[str, Any]:
    """Put the uploaded system in the place of the document's, as one edit."""
    document = desk.document(file)
    name = "".join(c for c in name.replace("\\", "/").rpartition("/")[2] if c.isprintable())[:100] or "the upload"
    too_large = UploadSizeError(f"{name} is larger than {LARGEST_FILE / 1e6:g} MB, the most that can be uploaded")
    length = request.headers.get("content-length", "0")
    if not length.isdecimal() or int(length) > LARGEST_FILE:
        raise too_large
    data = b""
    async for part in request.stream():
        data += part
        if len(data) > LARGEST_FILE:
            raise too_large
    # A large file takes seconds to read; a worker takes a second to start.
    large = len(data) > 100_000
    fis, warned = await desk.workers.run(read_bytes, data, name) if large else read_bytes(data, name)
    document.replace(fis, f"upload {name}")
    return {"said": f"{name} is on the page; undo brings the old design back." + "".join(f" {w}." for w in warned)}
