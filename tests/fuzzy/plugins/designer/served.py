"""``fuzzy design`` in a process of its own, a design for it, and tabs that note whatever goes wrong."""

import os
import random
import re
import signal
import socket
import subprocess
import sys

from fuzzy.membership import Triangle
from fuzzy.system import Constant, Sugeno, Variable

PATIENCE = 60_000  # ms that a condition may take on a loaded machine; nothing waits longer than it must
TOKEN = "the-token-of-the-tests"
START = "import sys; from fuzzy.commands.application import main; sys.exit(main(sys.argv[1:]))"


def tipper():
    """Two inputs whose rules overlap, so that a moved vertex moves surface and bars."""
    service = {"poor": Triangle(-4, 0, 5), "good": Triangle(0, 5, 10), "superb": Triangle(5, 10, 14)}
    food = {"bad": Triangle(-6, 0, 7), "tasty": Triangle(3, 10, 16)}
    tip = {"low": Constant(5.0), "middle": Constant(15.0), "high": Constant(25.0)}
    rules = [
        "if service is poor and food is bad then tip is low",
        "if service is good then tip is middle",
        "if service is superb and food is tasty then tip is high",
    ]
    inputs = [Variable("service", (0, 10), service), Variable("food", (0, 10), food)]
    return Sugeno(inputs, [Variable("tip", (0, 30), tip, "%")], rules, name="tipper")


def free_port():
    """A port that neither a designer beside this one takes, from 8080 on, nor a browser, from 32768 on."""
    ports = random.Random(os.getpid())
    while True:
        port = ports.randrange(10_000, 32_768)
        with socket.socket() as tried:
            if tried.connect_ex(("127.0.0.1", port)) != 0:
                return port


class Server:
    """``fuzzy design`` in a process of its own, which can be killed and started again at the same address."""

    def __init__(self, folder):
        self.folder, self.port = folder, free_port()
        self.start()

    def start(self):
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "NICEGUI"))}
        environment["FUZZYFLEET_TOKEN"] = TOKEN
        self.process = subprocess.Popen(
            [sys.executable, "-c", START, "design", "tipper.fis", "--port", str(self.port), "--no-browser"],
            cwd=self.folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        said = self.process.stdout.readline()
        found = re.search(r"(http://127\.0\.0\.1:\d+/)\?token=(\S+) ", said)
        assert found, said + self.process.stderr.read()
        assert found[2] == TOKEN
        self.address = found[0].strip()  # as it is printed; the browser has the cookie once it has been there
        self.url = found[1]

    def end(self, how=signal.SIGINT):
        self.process.send_signal(how)
        _, problems = self.process.communicate(timeout=60)
        return self.process.returncode, problems


class Watched:
    """A browser tab that notes console errors, exceptions and requests to anywhere but the server."""

    def __init__(self, context, server):
        self.page, self.wrong, self.forgiven = context.new_page(), [], False
        self.page.set_default_timeout(PATIENCE)
        self.page.on("console", lambda m: self.note(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.note(str(error)))
        self.page.on("request", lambda request: self.request(request.url, server))
        self.page.on("websocket", lambda socket: self.request(socket.url, server))

    def note(self, text):
        if not self.forgiven:
            self.wrong.append(text)

    def request(self, url, server):
        if not url.startswith((server.url, f"ws://127.0.0.1:{server.port}/", "data:", "blob:", "about:")):
            self.wrong.append(f"request to {url}")

    def open(self, url):
        self.page.goto(url)
        self.page.wait_for_selector(".shell-header[data-ready]")
        self.page.wait_for_selector(".fd-terms [role=slider]")
        return self.page
