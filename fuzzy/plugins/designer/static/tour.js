// A tour of five steps for who has never seen a rule base: each points at a part of the page, asks for something small
// and notices it. Model: "design", "point", and "example": is the file one that comes with the package? Then the tour
// opens by itself, once; the list of keys opens it again (the event "fd-tour").
import { element, put, say, watch } from "./chart.js";

const SEEN = "fuzzyfleet-tour"; // in the browser's storage
// What each points at (`at`, behind the tab `tab`), what there can be focused (`part`), and what changes when it is done
const STEPS = [
  {
    title: "A term is a curve",
    text: "It says how true a word is of a number: from 0, not at all, to 1, entirely.",
    ask: "Drag a round handle of a curve. With keys: an arrow on the handle.",
    tab: "Memberships",
    at: ".fd-terms .fd-plot",
    part: ".fd-grip",
    changes: "terms",
  },
  {
    title: "A rule is a sentence",
    text: "If its words are true, it proposes its result, and the truer they are, the more it counts.",
    ask: "Switch a rule off with the switch before it.",
    tab: "Rules",
    at: ".fd-rules .fd-sheet",
    part: "[role=switch]",
    changes: "rules",
  },
  {
    title: "The result of all rules",
    text: "The picture shows the output for each pair of inputs; the red lines cross at the point that is looked at.",
    ask: "Drag a red line. With keys: an arrow on it.",
    tab: "Surface",
    at: ".fd-surface .fd-main",
    part: "[role=slider]",
    changes: "point",
  },
  {
    title: "Why it is so",
    text: "Here stand the rules that fire at the point, how strongly, and what each proposes.",
    ask: "Take the tick from “only what fires”: the others come, too.",
    at: ".shell-why",
    part: "label:not([hidden]) > input",
    changes: "all",
  },
  {
    title: "Back, save, improve",
    text:
      "Save writes the file, History has every edit. Improve, below the pictures, learns from data or by trying. " +
      "All that you did here can be taken back.",
    ask: "Press Undo.",
    at: ".shell-header .tools",
    part: "[aria-label^=Undo]",
    changes: "redo",
  },
];

const told = () => {
  try {
    return localStorage.getItem(SEEN) !== null;
  } catch {
    return true; // a browser that keeps nothing would show it again and again
  }
};
const within = (value, least, most) => Math.max(least, Math.min(value, most));

export function render({ model, el }) {
  let at = -1, // the step that is shown; none
    before = null, // what there was when it began
    done = false,
    from = null; // what had the focus before the tour
  const count = element("p", { class: "tour-count" }),
    title = element("h2", { tabindex: -1, id: "tour-title" }),
    text = element("p"),
    ask = element("p", { class: "tour-ask" }),
    noticed = element("p", { class: "tour-noticed", role: "status" });
  const act = (words, onclick) => element("button", { onclick }, words);
  const there = act("Take me there", () => part()?.focus()),
    back = act("Back", () => show(at - 1)),
    next = act("Next", () => show(at + 1));
  const card = element(
    "section",
    { class: "tour", role: "dialog", "aria-labelledby": title.id, hidden: true },
    element("div", { class: "tour-head" }, count, put(act("×", leave), { "aria-label": "Leave the tour" })),
    title,
    text,
    ask,
    noticed,
    element("div", { class: "tour-acts" }, there, back, next),
  );
  el.append(card);
  const target = () => [...document.querySelectorAll(STEPS[at]?.at)].find((node) => node.checkVisibility());
  const part = () => target()?.querySelector(STEPS[at].part);

  function now() {
    const design = model.get("design");
    return {
      terms: JSON.stringify([...design.inputs, ...design.outputs].map((variable) => variable.terms)),
      rules: JSON.stringify(design.rules),
      point: JSON.stringify(model.get("point")),
      all: document.querySelector(".shell-why label:not([hidden]) > input")?.checked,
      redo: design.redo,
    };
  }

  function show(step) {
    if (step >= STEPS.length) return leave();
    [at, before, done] = [step, now(), false];
    const { title: name, text: words, ask: wish, tab } = STEPS[at];
    const button = [...document.querySelectorAll("[role=tab]")].find((node) => node.textContent.trim() === tab);
    if (button?.getAttribute("aria-selected") !== "true") button?.click();
    say(count, `Step ${at + 1} of ${STEPS.length}`);
    say(title, name);
    say(text, words);
    say(ask, wish);
    say(noticed, "");
    say(next, at === STEPS.length - 1 ? "Finish" : "Next");
    put(next, { class: null });
    put(back, { hidden: at ? null : "" });
    put(card, { hidden: null });
    title.focus({ preventScroll: true });
    led = null;
    place();
  }

  function leave() {
    if (at < 0) return;
    at = -1;
    put(card, { hidden: "" });
    mark(null);
    (from.isConnected && from !== document.body
      ? from
      : document.querySelector(".shell-header [title*=tour]")
    )?.focus();
  }

  let marked = null,
    led = null; // what was brought into sight
  function mark(node) {
    if (marked !== node) marked?.removeAttribute("data-tour");
    node?.setAttribute("data-tour", "");
    marked = node;
  }
  // Beside what it points at, where there is room; the style sheet puts it at the foot of a narrow screen.
  function place() {
    if (at < 0) return;
    const node = target();
    mark(node ?? null);
    if (node && led !== node)
      (led = node).scrollIntoView({ block: innerWidth < 900 ? "start" : "nearest", inline: "center" });
    if (!node) return;
    const { left, right, top, bottom } = node.getBoundingClientRect(),
      { offsetWidth: width, offsetHeight: height } = card,
      gap = 14;
    const x = right + gap + width < innerWidth ? right + gap : left - gap - width > 0 ? left - gap - width : left,
      beside = x !== left,
      y = beside ? top : bottom + gap + height < innerHeight ? bottom + gap : top - gap - height;
    card.style.left = `${within(x, gap, innerWidth - width - gap)}px`;
    card.style.top = `${within(y, gap, innerHeight - height - gap)}px`;
  }

  function notice() {
    if (at < 0 || done) return;
    const { changes } = STEPS[at],
      after = now();
    if (after[changes] === before[changes]) return;
    done = true;
    say(noticed, at === STEPS.length - 1 ? "✓ Done. That was all." : "✓ Done. Look what has changed, then go on.");
    put(next, { class: "first" });
  }

  function begin() {
    try {
      localStorage.setItem(SEEN, "1");
    } catch {
      // it is shown again only when it is asked for
    }
    from = document.activeElement;
    show(0);
  }
  function onKey(event) {
    if (event.key !== "Escape" || at < 0 || event.defaultPrevented) return;
    if (document.querySelector("dialog[open]")) return;
    event.preventDefault();
    leave();
  }
  const end = watch(model, ["design", "point"], notice);
  document.addEventListener("change", notice);
  document.addEventListener("keydown", onKey);
  document.addEventListener("fd-tour", begin);
  const placing = setInterval(place, 250); // tabs are built while it stands there, and the page is scrolled
  if (model.get("example") && !told()) begin();
  return () => {
    end();
    clearInterval(placing);
    document.removeEventListener("change", notice);
    document.removeEventListener("keydown", onKey);
    document.removeEventListener("fd-tour", begin);
    mark(null);
    card.remove();
  };
}

export default { render };
