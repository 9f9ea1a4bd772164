"""Who may talk to the designer's server: pages that it served itself, on this machine.

A page of another site must not reach it, neither directly (its Origin tells) nor through a name that it makes point
to 127.0.0.1 (the Host tells). The browser is told in its turn to ask nobody else.
"""

from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from typing import Any

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

# Vue compiles its templates in the page: hence the 'unsafe-eval'. Nothing comes from or goes to another place.
_POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' {sockets}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Guard:
    """An ASGI application that passes on to ``app`` what comes from the designer's own pages, and answers 403 else."""

    def __init__(self, app: App, port: int) -> None:
        self.app = app
        self.hosts = (f"127.0.0.1:{port}", f"localhost:{port}")
        self.origins = tuple(f"http://{host}" for host in self.hosts)
        policy = _POLICY.format(sockets=" ".join(f"ws://{host}" for host in self.hosts))
        self._headers = [
            (b"content-security-policy", policy.encode()),
            (b"x-frame-options", b"DENY"),
            (b"x-content-type-options", b"nosniff"),
            (b"referrer-policy", b"no-referrer"),
            (b"cross-origin-opener-policy", b"same-origin"),
            (b"cross-origin-resource-policy", b"same-origin"),
        ]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or web socket."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        if not self.admits(scope["headers"], scope["type"] == "websocket"):
            await _refuse(scope, send)
            return

        async def send_guarded(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*message.get("headers", []), *self._headers]}
            await send(message)

        await self.app(scope, receive, send_guarded)

    def admits(self, headers: Iterable[tuple[bytes, bytes]], socket: bool = False) -> bool:
        """Whether headers, with names in lower case, belong to a request by one of the designer's pages.

        A browser states the Origin of every web socket, so that one without is refused.
        """
        given: dict[bytes, list[str]] = {}
        for name, value in headers:
            given.setdefault(name, []).append(value.decode("latin-1").strip().lower())
        hosts, origins = given.get(b"host", []), given.get(b"origin", [])
        if len(hosts) != 1 or hosts[0] not in self.hosts or len(origins) > 1:
            return False
        if origins:
            # The very origin of this page: localhost is another one than 127.0.0.1.
            return origins[0] == f"http://{hosts[0]}"
        if socket:
            return False
        # An image or a script in a page elsewhere has no Origin, but the browser says so; a followed link is fine.
        sites, modes = given.get(b"sec-fetch-site", []), given.get(b"sec-fetch-mode", [])
        return all(site in ("same-origin", "none") for site in sites) or modes == ["navigate"]


async def _refuse(scope: Scope, send: Send) -> None:
    if scope["type"] == "websocket":
        # Before the socket is accepted this is answered with 403.
        await send({"type": "websocket.close", "code": 1008, "reason": "foreign origin"})
        return
    body = b"This server talks to its own pages only: open the address that it printed when it started.\n"
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": b"" if scope["method"] == "HEAD" else body})
