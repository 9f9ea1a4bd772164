// Several seeds at once: a strip with a button for each, and their runs as thin lines and as a band. From what
// robotics/plugins/designer/severalseeds.py hands over.

import { element, line, pixels, put, said, say, shape } from "../../../../fuzzy/plugins/designer/static/chart.js";

const SIGNS = {
  contact: "M2 2L10 10M2 10L10 2",
  stopped: "M2.5 2.5H9.5V9.5H2.5Z",
  refused: "M2 6H10M6 1A5 5 0 1 0 6.01 1",
};
const WORDS = { contact: "contact", stopped: "stopped", refused: "refused", done: "no contact" };

/** The sign of what ended a run early, or null. */
export function sign(state, size = 12) {
  if (!SIGNS[state]) return null;
  const path = shape("path", { d: SIGNS[state] });
  return shape(
    "svg",
    { class: "tr-sign", viewBox: "0 0 12 12", width: size, height: size, "aria-hidden": "true" },
    path,
  );
}

/** The strip of seeds: {node, update(seeds, round, count)}.
 *   pick(seed)   a hand chose a seed
 *   weigh()      it is asked what each rule is worth
 *   open(rule)   a hand chose a rule, by its number from 1
 */
export function seedStrip({ pick, weigh, open }) {
  const caption = element("p", { class: "se-caption" });
  const bar = element("progress", { max: 1, "aria-label": "Seeds that have been run" });
  const row = element("div", { class: "se-row", role: "group", "aria-label": "Seeds: one is drawn and played" });
  const asked = element("button", { class: "fd-button se-weigh", onclick: weigh }, "What is each rule worth?");
  const worth = element("ol", { class: "se-worth", "aria-label": "What is worse without each rule" });
  const node = element("div", { class: "tr-seeds", hidden: true }, caption, row, bar, asked, worth);
  row.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    const buttons = [...row.querySelectorAll("button")],
      at = buttons.indexOf(document.activeElement);
    if (!by || at < 0) return;
    event.preventDefault();
    buttons[(at + by + buttons.length) % buttons.length].focus();
  });

  function update(seeds, round, count) {
    node.hidden = count < 2;
    if (node.hidden) return;
    put(bar, { hidden: round !== null ? null : "", value: round?.of ? round.done / round.of : 0 });
    const weighed = seeds?.worth ?? [];
    put(asked, { hidden: weighed.length ? "" : null, disabled: seeds === null ? "" : null });
    worth.replaceChildren(...weighed.map(valued));
    if (seeds === null) {
      say(caption, `${count} seeds are run once the design rests; until then one.`);
      row.classList.add("se-stale");
      return;
    }
    row.classList.remove("se-stale");
    const { worst, shown, by, runs } = seeds;
    const told = runs.tried;
    const counts = ["contact", "stopped", "refused"].filter((state) => told[state]);
    const found =
      counts.map((state) => `${told[state]} ${WORDS[state]}`).join(", ") || "none touched, stopped or refused";
    const last = seeds.rows.find((each) => each.seed === worst)?.state;
    const how =
      { contact: "the first contact", stopped: "a robot was stopped", refused: "refused" }[last] ?? `by ${by}`;
    const why = shown === worst ? `the worst: ${how}` : `picked; the worst is seed ${worst}`;
    const all = told.refused === seeds.count ? "" : ` Drawn: seed ${shown} (${why}).`;
    say(caption, `${seeds.count} seeds of this design: ${found}.${all}`);
    const held = row.contains(document.activeElement) ? document.activeElement.dataset.seed : null;
    const values = seeds.rows.map((each) => (typeof each.value === "number" ? each.value : null));
    const sorted = values.filter((value) => value !== null).sort((a, b) => a - b);
    const rank = (value) => (value === null ? 1 : sorted.indexOf(value) / Math.max(1, sorted.length - 1));
    row.replaceChildren(...seeds.rows.map((each, k) => one(each, values[k], rank(values[k]), seeds)));
    if (held !== null) row.querySelector(`[data-seed="${held}"]`)?.focus();
  }

  /** A rule, and what is otherwise without it. */
  function valued({ rule, text, told, worse }) {
    const words = `${rule}: ${text}`;
    const lead = element("button", { title: words, onclick: () => open(rule) }, words);
    return element("li", { class: worse ? "se-worse" : "" }, lead, element("span", {}, `without it: ${told}`));
  }

  /** A seed's button; its bar is the higher, the worse its place among all. */
  function one(each, value, rank, { shown, worst, by }) {
    const amount = each.state === "refused" ? "" : `, ${by} ${value === null ? each.value : said(value, 3)}`;
    const name = `Seed ${each.seed}: ${WORDS[each.state]}${amount}${each.seed === worst ? ", the worst" : ""}`;
    const height = 2 + 12 * rank;
    const level = shape(
      "svg",
      { width: 14, height: 14, "aria-hidden": "true", class: "se-level" },
      shape("rect", { x: 2, width: 10, y: 14 - height, height }),
    );
    return element(
      "button",
      {
        class: `se-one se-${each.state}`,
        "data-seed": each.seed,
        "aria-pressed": each.seed === shown ? "true" : "false",
        "aria-label": name,
        title: name,
        tabindex: each.seed === shown ? 0 : -1,
        onclick: () => pick(each.seed),
      },
      element("span", {}, String(each.seed)),
      sign(each.state, 14) ?? level,
    );
  }

  return { node, update };
}

/** The paths of all seeds but the one that is drawn, thin; `colour` gives a robot's. */
export function bundle(seeds, x, y, colour = null) {
  const group = shape("g", { class: "tr-bundle" });
  for (const row of seeds?.rows ?? []) {
    (row.x ?? []).forEach((xs, i) => {
      const strong = colour !== null && row.seed === seeds.shown;
      const style = colour ? `stroke: ${colour(i)}` : null;
      const d = line(pixels(xs, x), pixels(row.y[i], y));
      const path = shape("path", { d, class: strong ? "tr-seed tr-strong" : "tr-seed", style, "data-seed": row.seed });
      if (strong || row.seed !== seeds.shown) group[strong ? "append" : "prepend"](path);
    });
  }
  return group;
}

/** The band between the least and the largest cross-track error of all seeds. */
export function band(seeds, x, y) {
  const rows = (seeds?.rows ?? []).filter((row) => row.cross_track);
  if (rows.length < 2) return "";
  const above = [],
    below = [];
  rows[0].time.forEach((time, k) => {
    const values = rows.map((row) => row.cross_track[0][k]).filter((value) => value !== null);
    if (!values.length) return;
    above.push(`${x(time).toFixed(2)} ${y(Math.max(...values)).toFixed(2)}`);
    below.unshift(`${x(time).toFixed(2)} ${y(Math.min(...values)).toFixed(2)}`);
  });
  return shape("path", { d: `M${[...above, ...below].join("L")}Z`, class: "tr-band" });
}
