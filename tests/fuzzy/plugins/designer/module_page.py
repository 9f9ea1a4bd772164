"""A page that shows one ES module of the designer, with an anywidget model that is the test's."""

from pathlib import Path
from typing import Any

from fuzzy.figures.palette import stylesheet

ROOT = Path(__file__).parents[4]
HERE = "http://127.0.0.1/"
PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>module</title>
<link rel="icon" href="data:,"><meta name="viewport" content="width=device-width"><style>%s</style>%s
<style>body { margin: 0; padding: 12px; background: Canvas; color-scheme: light dark }</style></head>
<body><main id="here"></main><script type="module">
// The other side of the model is the function "python", if the test has one; held = true keeps its answers back.
class Model {
  constructor(traits) {
    this.traits = traits; this.hands = new Map(); this.sent = []; this.held = false;
    this.asked = 0;  // messages that Python has yet to answer
  }
  get(name) { return this.traits[name]; }
  set(name, value) { this.traits[name] = value; for (const f of [...(this.hands.get(`change:${name}`) ?? [])]) f(); }
  save_changes() {}
  on(event, f) {
    if (!this.hands.has(event)) this.hands.set(event, new Set());
    this.hands.get(event).add(f);
  }
  off(event, f) { this.hands.get(event)?.delete(f); }
  take(traits) {
    Object.assign(this.traits, traits);
    for (const [name, value] of Object.entries(traits)) this.set(name, value);
  }
  async send(content) {
    this.sent.push(structuredClone(content));
    if (this.held || !window.python) return;
    this.asked++;
    try {
      this.take(await window.python(content));
    } finally {
      this.asked--;
    }
  }
}
const drawn = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
window.give = (news) => (window.model.take(news), drawn());
window.leave = () => {
  window.end?.();
  const left = [...(window.model?.hands.values() ?? [])].reduce((sum, set) => sum + set.size, 0);
  window.end = window.model = null;
  return [document.getElementById("here").childElementCount, left];
};
window.show = async (url, traits, css = "") => {
  window.leave();
  const module = await import(url);
  document.getElementById("sheet")?.remove();
  document.head.append(Object.assign(document.createElement("style"), { id: "sheet", textContent: css }));
  window.model = new Model(traits);
  window.end = await module.default.render({ model: window.model, el: document.getElementById("here") });
  await drawn();
};
window.ready = true;
</script></body></html>"""


class ModulePage:
    """The page; ``problems`` gets console errors, exceptions and requests for anything but the project's modules."""

    def __init__(self, page: Any, sheet: str | None = None) -> None:
        self.page = page
        self.problems: list[str] = []
        self._page = PAGE % (stylesheet(), f'<link rel="stylesheet" href="{sheet}">' if sheet else "")
        page.on("console", lambda m: self.problems.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.route("**/*", self._serve)
        page.goto(HERE)
        page.wait_for_function("window.ready")

    def _serve(self, route: Any) -> None:
        url = route.request.url
        name = url.removeprefix(HERE)
        if url == HERE:
            route.fulfill(body=self._page, content_type="text/html")
        elif url.startswith(HERE) and Path(name).suffix in (".js", ".css") and (ROOT / name).is_file():
            route.fulfill(path=ROOT / name)
        else:
            self.problems.append(f"request to {url}")
            route.abort()

    def render(self, module: str, traits: dict[str, Any], width: int = 800) -> None:
        """Show the module at this path of the project."""
        self.page.set_viewport_size({"width": width, "height": 900})
        self.page.evaluate("([url, traits]) => window.show(url, traits)", [f"{HERE}{module}", traits])

    def render_text(self, code: str, css: str, traits: dict[str, Any]) -> None:
        """Show a module that is a text, with its style sheet, as notebooks do."""
        self.page.set_viewport_size({"width": 900, "height": 900})
        self.page.evaluate(
            """([code, css, traits]) => window.show(
              URL.createObjectURL(new Blob([code], { type: "text/javascript" })), traits, css)""",
            [code, css, traits],
        )

    def give(self, **news: Any) -> None:
        """New values of traits, drawn."""
        self.page.evaluate("(news) => window.give(news)", news)

    def sent(self) -> list[dict[str, Any]]:
        """What the module has sent since the last :meth:`forget`."""
        messages: list[dict[str, Any]] = self.page.evaluate("window.model.sent")
        return messages

    def forget(self) -> None:
        """What was sent is of no interest any more."""
        self.page.evaluate("window.model.sent.length = 0")

    def leave(self) -> tuple[int, int]:
        """Take the module away: how many elements and how many listeners it left behind."""
        elements, listeners = self.page.evaluate("window.leave()")
        return elements, listeners
