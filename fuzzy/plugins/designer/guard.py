"""Who may talk to the designer's server: pages that it served itself, on this machine, to whoever has its token.

A page of another site must not reach it, neither directly (its Origin tells) nor through a name that it makes point
to 127.0.0.1 (the Host tells). The browser is told in its turn to ask nobody else.

Another user of this machine can reach the port as well. So the address that is printed carries a token, as Jupyter's
does; the page that it leads to sets a cookie, and without one of the two nothing is answered.
"""

import hmac
from collections.abc import Iterable

from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

# Vue compiles its templates in the page: hence the 'unsafe-eval'. Nothing comes from or goes to another place.
_POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' {sockets}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Guard:
    """An ASGI application that passes on to ``app`` what comes from the designer's own pages, and answers 403 else.

    Args:
        app: The application.
        port: The port that it listens at.
        token: What a request must have, in its address (?token=...) or its cookie; "" asks for none.
    """

    def __init__(self, app: ASGIApp, port: int, token: str) -> None:
        self.app = app
        self.token = token
        self.cookie = f"fuzzy-design-{port}"  # a browser has one set of cookies for all ports
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
        request = HTTPConnection(scope)
        if not self.admits(request.headers, scope["type"] == "websocket", scope.get("method", "")):
            await _refuse(scope, receive, send, _FOREIGN)
            return
        asked = self._has_token(request.query_params.getlist("token"))
        if not asked and not self._has_token([request.cookies.get(self.cookie, "")]):
            await _refuse(scope, receive, send, _NO_TOKEN)
            return
        cookie = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
        more = [*self._headers, (b"set-cookie", cookie.encode())] if asked and self.token else self._headers

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*message.get("headers", []), *more]}
            await send(message)

        await self.app(scope, receive, send_guarded)

    def admits(self, given: Headers, socket: bool, method: str) -> bool:
        """Whether headers belong to a request by one of the designer's pages.

        A browser states the Origin of every web socket, so that one without is refused.
        """
        hosts = [host.lower() for host in given.getlist("host")]
        origins = [origin.lower() for origin in given.getlist("origin")]
        if len(hosts) != 1 or hosts[0] not in self.hosts or len(origins) > 1:
            return False
        if origins:
            # The very origin of this page: localhost is another one than 127.0.0.1.
            return origins[0] == f"http://{hosts[0]}"
        if socket:
            return False
        # An image or a script in a page elsewhere has no Origin, but the browser says so; a followed link is fine.
        sites, modes = given.getlist("sec-fetch-site"), given.getlist("sec-fetch-mode")
        followed = modes == ["navigate"] and method in ("GET", "HEAD")
        return all(site in ("same-origin", "none") for site in sites) or followed

    def _has_token(self, words: Iterable[str]) -> bool:
        """Is the token among ``words``? Takes as long for a wrong one as for the right one."""
        if not self.token:
            return True
        return any(hmac.compare_digest(word.encode(), self.token.encode()) for word in words)


_FOREIGN = "This server talks to its own pages only: open the address that it printed when it started."
_NO_TOKEN = (
    "This designer answers only whoever has its token. Open the address that <code>fuzzy design</code> printed in the "
    "terminal when it started; it ends in ?token=... and is another one after every start."
)


_PAGE = (
    '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Not answered – Fuzzy designer</title>'
    '<meta name="viewport" content="width=device-width"><meta name="color-scheme" content="light dark"></head>'
    "<body><main><h1>Not answered</h1><p>{}</p></main></body></html>\n"
)


async def _refuse(scope: Scope, receive: Receive, send: Send, sentence: str) -> None:
    if scope["type"] == "websocket":
        # Before the socket is accepted this is answered with 403.
        await send({"type": "websocket.close", "code": 1008, "reason": "not for you"})
        return
    await HTMLResponse(_PAGE.format(sentence), 403)(scope, receive, send)
