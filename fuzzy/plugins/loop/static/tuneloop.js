// Tune the loop: what may move, at what cost, the cost as it falls, and the figures before and after.
// From what fuzzy/plugins/loop/tunepanel.py hands over; the form is anywidget's.

import {
  axes,
  boxed,
  element,
  heldLine,
  keepDrawn,
  plot,
  put,
  said,
  say,
  scale,
  shape,
} from "../../designer/static/chart.js";
import { acts, checkBox, field, formStyled, group, panelForm, row } from "../../designer/static/form.js";

const PARTS = {
  factors: "scale factors",
  memberships: "memberships",
  consequents: "consequents",
  weights: "weights of rules",
  choices: "which consequent a rule takes",
  rules: "rules may be left out",
};
const NUMBERS = [
  ["ISE", "ise"],
  ["Overshoot", "overshoot"],
  ["Variation of u", "variation"],
];
const SHOWN = [
  ["overshoot", "overshoot", "%"],
  ["settling_time", "settling time", "s"],
  ["ise", "ISE", ""],
  ["variation", "variation of u", ""],
];
const RUNNING = ["starting", "searching", "stopping"];

export async function render({ model, el }) {
  await formStyled(import.meta.url);
  const form = panelForm(model, (note) => root.prepend(note), { leads: true }),
    { get, choose, fields, number, act } = form;
  const boxes = get("parts").map((part) => {
    const box = checkBox(PARTS[part] ?? part, () =>
      choose(
        "move",
        get("parts").filter((_, k) => boxes[k].input.checked),
      ),
    );
    return box;
  });
  fields.move = boxes[0].input;
  const moving = group("What may move", row(...boxes.map(({ node }) => node)));
  const least = { min: 0 };
  const priced = group(
    "Cost: weights, against the PID's figures and 10 % of overshoot",
    row(...NUMBERS.map(([label, name]) => field(label, number(label, name, least)))),
  );
  const spread = field("The plant may differ by [%]", number("The plant may differ by [%]", "spread", least));
  const start = act("Start", "start", "pn-main"),
    stop = act("Stop", "stop"),
    discard = act("Discard", "discard");
  const searching = group(
    "Search",
    row(
      spread,
      field("Evaluations", number("Evaluations", "evaluations", { min: 1, step: 1 })),
      field("Seed", number("Seed", "seed", { min: 0, step: 1 })),
    ),
  );
  const bar = element("progress", { "aria-label": "Evaluations done", max: 1, value: 0 });
  const state = element("p", { class: "pn-said", role: "status" });
  const curve = plot();
  const root = element(
    "div",
    { class: "fd fd-panel fd-form" },
    form.note,
    moving,
    priced,
    searching,
    acts([start, stop, discard], bar, state),
    element("div", { class: "pn-views" }, curve),
  );
  el.append(root);

  function draw() {
    const choice = get("choice"),
      p = get("progress"),
      running = RUNNING.includes(p.state);
    get("parts").forEach((part, k) => (boxes[k].input.checked = choice.move.includes(part)));
    for (const [name, input] of Object.entries(fields)) input.show?.(choice[name]);
    for (const set of [moving, priced]) for (const control of set.querySelectorAll("input")) control.disabled = running;
    start.disabled = running;
    stop.disabled = !running || p.state === "stopping";
    discard.disabled = !p.undecided;
    put(bar, { max: Math.max(1, p.of) });
    bar.value = p.evaluations ?? 0;
    bar.hidden = !running;
    const words = [];
    if (p.state === "starting") words.push("starting …");
    if (p.state === "stopping") words.push("stopping after this generation …");
    if (p.evaluations) words.push(`${p.evaluations} of ${p.of} evaluations`);
    if (p.curve) words.push(`cost ${said(p.curve[0], 3)} → ${said(p.curve.at(-1), 3)}`);
    if (p.after)
      for (const [name, title, unit] of SHOWN)
        words.push(`${title} ${said(p.before[name], 3)} → ${said(p.after[name], 3)} ${unit}`.trim());
    if (p.words) words.push(p.words);
    say(state, words.join(" · "));
    form.drawProblem();
    curve.parentElement.hidden = !p.curve;
    if (!p.curve) return;
    const box = boxed(curve, 240),
      [first, last] = [p.curve[0], p.curve.at(-1)],
      room = Math.max(first - last, 0.02 * first) * 0.12;
    const x = scale(0, Math.max(2, running ? p.of : p.curve.length), box.left, box.right),
      y = scale(Math.max(0, last - room), first + room, box.bottom, box.top);
    curve.replaceChildren(
      axes(box, x, y, ["evaluations", "cost, best so far"]),
      shape("path", {
        d: heldLine(
          p.curve.map((_, k) => x(k + 1)),
          p.curve.map(y),
        ),
        style: "stroke: var(--ff-c0); stroke-width: 2; fill: none",
      }),
    );
    put(curve, { "aria-label": `Cost over the evaluations. ${state.textContent}` });
  }

  return keepDrawn(model, ["choice", "progress", "problem"], root, draw);
}

export default { render };
