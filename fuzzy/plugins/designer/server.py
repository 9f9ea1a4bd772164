"""The designer's server: a NiceGUI application on 127.0.0.1 that serves one folder."""

import asyncio
import contextlib
import logging
import os
import re
import secrets
import socket
import sys
import webbrowser
from typing import TYPE_CHECKING, Any

from fuzzy.errors import InputError, shortened
from fuzzy.files.fisfile import FisFileError, MamdaniError
from fuzzy.plugins.designer.folder import LARGEST_FILE, Folder, FolderError
from fuzzy.plugins.designer.guard import Guard
from fuzzy.plugins.designer.modules import Modules
from fuzzy.plugins.designer.open_documents import PATIENCE, OpenDocuments
from fuzzy.plugins.designer.workers import WorkError, set_imports_aside
from fuzzy.shell.interrupts import TERMINATED, exit_code
from fuzzy.system import Sugeno

if TYPE_CHECKING:
    from fastapi import Request

HOST = "127.0.0.1"
PORT = 8080
_SILENT = 20.0  # s that a connection may take until its first request has come
TOKEN = "FUZZYFLEET_TOKEN"  # the environment variable that sets the token; empty: none is asked for


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
    """A server that cannot start as it was told to."""


def token_of(environment: str | None) -> str:
    """The token of the server's address: what the environment variable says, or without one a new one at random.

    Raises ServerError for what cannot stand in an address, or is easily guessed.
    """
    if environment is None:
        return secrets.token_urlsafe(24)
    if environment and not re.fullmatch(r"[A-Za-z0-9_-]{8,200}", environment):
        raise ServerError(
            f"{TOKEN} must be 8 to 200 letters, digits, '-' and '_', or empty, which lets every user of this machine in"
        )
    return environment


def serve(
    folder: Folder,
    name: str,
    port: int | None = None,
    browser: bool = True,
    begin: Sugeno | None = None,
) -> None:
    """Serve the designer until it is interrupted.

    Args:
        folder: The folder that is served.
        name: The file of the folder that the first page shows.
        port: The port, by default 8080 or the next free one.
        browser: Whether the page is opened in the browser.
        begin: The system with which a file that does not exist begins, by default a small one.

    Raises ServerError where it cannot listen, and what opening the file raises.
    """
    token = token_of(os.environ.get(TOKEN))
    opened = OpenDocuments(folder)
    # What is wrong with the file is said here, before anything starts; a Mamdani system the page offers to convert, and
    # a wrong line to mend.
    try:
        opened.document(name, begin)
    except FisFileError as error:
        if error.line is None:
            raise
        if not isinstance(error, MamdaniError):
            print(f"fuzzy design: {error}\nThe page shows the line, to be mended.", file=sys.stderr)
    listening = bound_socket(port)
    number = listening.getsockname()[1]
    url = f"http://{HOST}:{number}/" + (f"?token={token}" if token else "")
    try:
        server = _server(opened, name, number, token)

        def started() -> None:
            set_imports_aside()
            print(f"The designer of {folder.name(folder.inside(name))} is at {url} (Ctrl-C ends it).", flush=True)
            if browser:
                webbrowser.open(url)

        server.config.app.app.state.started = started
        try:
            server.run(sockets=[listening])
        except KeyboardInterrupt:
            if exit_code() == TERMINATED:
                raise SystemExit(TERMINATED) from None
    finally:
        listening.close()
        opened.close()


def _server(opened: OpenDocuments, name: str, port: int, token: str) -> Any:
    import uvicorn
    from fastapi import FastAPI
    from nicegui import app as pages
    from nicegui import ui

    from fuzzy.plugins.designer.page import build_page

    modules = Modules()
    logging.getLogger("nicegui").setLevel(logging.ERROR)  # a mistyped address is no event

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> Any:
        asyncio.get_running_loop().call_soon(app.state.started)
        yield

    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan)
    _add_routes(app, opened, modules)

    @ui.page("/", response_timeout=2 * PATIENCE)  # a file that is read for so long is given up before
    async def designer(file: str = "", mamdani: str = "", fit: str = "") -> None:
        await build_page(opened, modules, file or name, mamdani, fit)

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
        Guard(app, port, token),
        http=_protocol(),
        log_level="warning",
        server_header=False,
        timeout_graceful_shutdown=2,
        ws_max_size=4_000_000,
        ws_per_message_deflate=False,  # to pack what stays on this machine takes longer than to send it
    )
    server = uvicorn.Server(config)
    # A request that is cut off because the designer is ended is no error.
    logging.getLogger("uvicorn.error").addFilter(lambda record: not server.should_exit)
    return server


def _protocol() -> Any:
    """uvicorn's HTTP, which would hold a connection for ever that asks nothing, or half of it."""
    from uvicorn.protocols.http.auto import AutoHTTPProtocol

    base: Any = AutoHTTPProtocol

    class Protocol(base):
        def connection_made(self, transport: asyncio.Transport) -> None:
            super().connection_made(transport)
            self.loop.call_later(_SILENT, self.end_if_silent)

        def end_if_silent(self) -> None:
            if self.cycle is None and self in self.connections:  # no request, and no websocket, which leaves these
                self.transport.close()

    return Protocol


def _report(error: Exception) -> None:
    # A bug: NiceGUI logs it with its traceback; the page goes on with the last good design.
    print(f"fuzzy design: {type(error).__name__}: {error}", file=sys.stderr)


def _add_routes(app: Any, opened: OpenDocuments, modules: Modules) -> None:
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
            return JSONResponse(await _uploaded(request, opened, file, name))
        except UploadSizeError as error:
            return JSONResponse({"problem": str(error)}, 413)
        # A file that makes no system is no error of the page's: an answer like any other.
        except (InputError, WorkError) as error:
            return JSONResponse({"problem": str(error)})
        except OSError as error:
            return JSONResponse({"problem": error.strerror or str(error)})


async def _uploaded(request: "Request", opened: OpenDocuments, file: str, name: str) -> dict[str, Any]:
    """Put the uploaded system in the place of the document's, as one edit."""
    document = await opened.opened(file)
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
    read = await opened.read_upload(data, name)
    document.replace(read.system, f"upload {name}")
    said = [f"{name} is on the page; undo brings the old design back", *read.warnings]
    said += [f"it was a Mamdani system: {shortened('; '.join(read.changes), 400)}"] if read.changes else []
    return {"said": "".join(f"{sentence}. " for sentence in said).rstrip()}
