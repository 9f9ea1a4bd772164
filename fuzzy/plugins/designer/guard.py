"""Who may talk to the designer's server: pages that it served itself, on this machine, to whoever has its token.

A page of another site must not reach it, neither directly (its Origin tells) nor through a name that it makes point
to 127.0.0.1 (the Host tells). The browser is told in its turn to ask nobody else.

Another user of this machine can reach the port as well. So the address that is printed carries a token, as Jupyter's
does; the page that it leads to sets a cookie, and without one of the two nothing is answered.
"""

import hmac
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Headers = dict[bytes, list[str]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

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

    def __init__(self, app: App, port: int, token: str) -> None:
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
        given = _given(scope["headers"])
        if not self.admits(given, scope["type"] == "websocket", scope.get("method", "")):
            await _refuse(scope, send, _FOREIGN)
            return
        asked = self._has_token(_query_tokens(scope))
        if not asked and not self._has_token(self._cookies(given)):
            await _refuse(scope, send, _NO_TOKEN)
            return
        cookie = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
        more = [*self._headers, (b"set-cookie", cookie.encode())] if asked and self.token else self._headers

        async def send_guarded(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*message.get("headers", []), *more]}
            await send(message)

        await self.app(scope, receive, send_guarded)

    def admits(self, given: Headers, socket: bool, method: str) -> bool:
        """Whether headers, with names in lower case, belong to a request by one of the designer's pages.

        A browser states the Origin of every web socket, so that one without is refused.
        """
        hosts = [host.lower() for host in given.get(b"host", [])]
        origins = [origin.lower() for origin in given.get(b"origin", [])]
        if len(hosts) != 1 or hosts[0] not in self.hosts or len(origins) > 1:
            return False
        if origins:
            # The very origin of this page: localhost is another one than 127.0.0.1.
            return origins[0] == f"http://{hosts[0]}"
        if socket:
            return False
        # An image or a script in a page elsewhere has no Origin, but the browser says so; a followed link is fine.
        sites, modes = given.get(b"sec-fetch-site", []), given.get(b"sec-fetch-mode", [])
        followed = modes == ["navigate"] and method in ("GET", "HEAD")
        return all(site in ("same-origin", "none") for site in sites) or followed

    def _has_token(self, words: Iterable[str]) -> bool:
        """Is the token among ``words``? Takes as long for a wrong one as for the right one."""
        if not self.token:
            return True
        return any(hmac.compare_digest(word.encode(), self.token.encode()) for word in words)

    def _cookies(self, given: Headers) -> list[str]:
        found = []
        for header in given.get(b"cookie", []):
            try:
                cookies = SimpleCookie(header)
            except CookieError:
                continue
            if self.cookie in cookies:
                found.append(cookies[self.cookie].value)
        return found


def _given(headers: Iterable[tuple[bytes, bytes]]) -> Headers:
    given: Headers = {}
    for name, value in headers:
        given.setdefault(name, []).append(value.decode("latin-1").strip())
    return given


def _query_tokens(scope: Scope) -> list[str]:
    try:
        return parse_qs(scope.get("query_string", b"").decode("ascii"), max_num_fields=100).get("token", [])
    except ValueError:  # also of bytes that no address has
        return []


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


async def _refuse(scope: Scope, send: Send, sentence: str) -> None:
    if scope["type"] == "websocket":
        # Before the socket is accepted this is answered with 403.
        await send({"type": "websocket.close", "code": 1008, "reason": "not for you"})
        return
    body = _PAGE.format(sentence).encode()
    headers = [(b"content-type", b"text/html; charset=utf-8"), (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": b"" if scope["method"] == "HEAD" else body})
