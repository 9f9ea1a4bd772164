// The settings of a view as one line above its pictures, which opens as a sheet over them; and figures as chips.
import { element, put, refill, said, say } from "./chart.js";

/**
 * A line that opens a sheet with `content`: {node, words(parts), show(on), end()}. Escape closes it, and a press elsewhere
 * unless it says what is wrong.
 * `beside` stands behind the line, in sight all the time.
 */
export function settingsSheet(content, beside = null) {
  const told = element("span", { class: "pn-line-words" });
  const summary = element("summary", {}, told, element("span", { class: "pn-line-edit" }, "Settings ✎"));
  const node = element("details", { class: "pn-line" }, summary, element("div", { class: "pn-sheet" }, ...content));
  const line = element("div", { class: "pn-settings" }, node, beside);
  const shut = (focus) => {
    node.open = false;
    if (focus) summary.focus();
  };
  node.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !node.open || event.defaultPrevented) return;
    event.preventDefault();
    shut(true);
  });
  const outside = (event) => {
    const wrong = node.querySelector(".pn-problem:not([hidden])");
    if (node.open && !wrong && !node.contains(event.target)) shut(false);
  };
  document.addEventListener("pointerdown", outside);
  return {
    node: line,
    words: (parts) => say(told, parts.filter(Boolean).join(" · ")),
    show: (on) => (node.open = on),
    end: () => document.removeEventListener("pointerdown", outside),
  };
}

/** Figures in sight while one drags: {node, update(rows)}; a row is {title, unit, before, now, larger}. */
export function chips(label) {
  const node = element("div", { class: "pn-chips", role: "group", "aria-label": label });
  const figure = (value) => (typeof value === "number" ? said(value, 3) : (value ?? "–"));
  function chip({ title, unit, before, now, larger }) {
    const [old, fresh] = [figure(before), figure(now)];
    const differs = before !== undefined && old !== fresh;
    const better =
      differs && typeof now === "number" && (typeof before !== "number" || now < before !== Boolean(larger));
    const sign = differs ? (better ? "better" : "worse") : "same";
    const text = differs ? `${old} → ${fresh}` : fresh;
    const whole = `${title}: ${text}${unit && unit !== "1" ? ` ${unit}` : ""}${differs ? `, ${sign}` : ""}`;
    return element(
      "span",
      { class: `pn-chip pn-${sign}`, title: whole },
      element("span", { class: "pn-chip-name" }, title),
      element("span", { class: "pn-chip-value", "aria-label": whole }, text),
    );
  }
  function update(rows) {
    put(node, { hidden: rows.length ? null : "" });
    refill(node, ...rows.map(chip));
  }
  return { node, update };
}
