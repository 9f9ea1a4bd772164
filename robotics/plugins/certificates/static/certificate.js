// Certificate: what is proven of the rule base's own closed loop, its region over the errors, and simulated starts.
// From what robotics/plugins/certificates/panel.py hands over; the form is anywidget's.

import {
  axes,
  boxed,
  element,
  keepDrawn,
  keyed,
  line,
  offer,
  plot,
  put,
  said,
  say,
  scale,
  shape,
} from "../../../../fuzzy/plugins/designer/static/chart.js";
import { field, formStyled, panelForm, row } from "../../../../fuzzy/plugins/designer/static/form.js";
import { settingsSheet } from "../../../../fuzzy/plugins/designer/static/settings.js";

const NUMBERS = [
  ["Least speed [m/s]", "speed_low"],
  ["Greatest speed [m/s]", "speed_high"],
  ["Greatest curvature [1/m]", "curvature"],
  ["How fast v_r changes [m/s²]", "v_rate"],
  ["How fast ω_r changes [rad/s²]", "w_rate"],
  ["Period [s]", "period"],
  ["Latency [s]", "latency"],
  ["Noise of the position [m]", "position_noise"],
  ["Noise of the heading [rad]", "heading_noise"],
];
const PLANES = [
  ["X ahead [m]", "Y to the left [m]"],
  ["Y to the left [m]", "ψ heading error [rad]"],
];

export async function render({ model, el }) {
  await formStyled(import.meta.url, "./certificate.css");
  const form = panelForm(model, (note) => settings.node.after(note)),
    { get, fields } = form;
  const robot = form.list("Robot", "robot");
  const settings = settingsSheet([
    row(field("Robot", robot)),
    row(...NUMBERS.map(([label, name]) => field(label, form.number(label, name, { min: 0 })))),
  ]);
  const badge = element("p", { class: "ce-badge", role: "status" }),
    words = element("p", { class: "pn-said" });
  const pictures = PLANES.map((names) => plot(`Region and simulated errors: ${names.join(" over ")}`));
  const keys = element(
    "div",
    { class: "pn-keys" },
    keyed("ce-region", "no start within leaves it"),
    keyed("ce-end", "all come into it"),
    keyed("ce-error", "simulated starts"),
  );
  const views = element(
    "div",
    {},
    keys,
    element("div", { class: "pn-views" }, ...pictures.map((each) => element("div", {}, each))),
  );
  const root = element(
    "div",
    { class: "fd fd-panel fd-form fd-certificate" },
    settings.node,
    form.note,
    badge,
    words,
    views,
  );
  el.append(root);

  /** One plane of errors: the region, where all come to, and what simulated robots did. */
  function drawPlane(svg, names, outlines, errors) {
    const box = boxed(svg, 320);
    const reach = (k) => 1.15 * Math.max(...outlines[0].map((point) => Math.abs(point[k])));
    const x = scale(-reach(0), reach(0), box.left, box.right),
      y = scale(-reach(1), reach(1), box.bottom, box.top);
    const drawn = (points, kind) =>
      shape("path", {
        class: kind,
        d: line(
          points.map((point) => x(point[0])),
          points.map((point) => y(point[1])),
        ),
      });
    svg.replaceChildren(
      axes(box, x, y, names),
      ...errors.map((way) => drawn(way, "ce-error")),
      drawn(outlines[0], "ce-region"),
      drawn(outlines[1], "ce-end"),
    );
  }

  function draw() {
    const choice = get("choice"),
      answer = get("answer"),
      works = get("works");
    for (const [, name] of NUMBERS) fields[name].show(choice[name]);
    offer(
      robot,
      get("robots").map((name) => [name, name]),
      choice.robot,
    );
    settings.words([
      choice.robot,
      `${said(choice.speed_low)} to ${said(choice.speed_high)} m/s`,
      `curvature to ${said(choice.curvature)} 1/m`,
      choice.latency > 0 ? `${said(choice.latency)} s late` : "",
      choice.position_noise > 0 || choice.heading_noise > 0 ? "with noise" : "",
    ]);
    form.drawProblem();
    const certified = answer?.certified ?? false;
    put(root, { "aria-busy": works ? "true" : null });
    put(badge, { "data-certified": works || !answer ? null : String(certified) });
    say(badge, works ? "Working …" : !answer ? "No answer" : certified ? "Certified" : "Not certified");
    views.hidden = !certified;
    if (!certified) return say(words, answer?.why ? `${answer.why}.` : "");
    const [a, b, c] = answer.half_widths.map((each) => said(each, 2)),
      [p, q, r] = answer.end.map((each) => said(each, 2));
    say(
      words,
      `A robot that starts in the region, which reaches to X ±${a} m, Y ±${b} m, ψ ±${c} rad, stays in it and comes to ` +
        `X ±${p} m, Y ±${q} m, ψ ±${r} rad; the proven rate is ${said(answer.rate, 2)} 1/s. Of ${answer.starts} simulated starts on the ` +
        `boundary ${answer.left} left it. A longer search, robotics certify, may find a larger region and writes the file of the proof.`,
    );
    pictures.forEach((svg, k) => drawPlane(svg, PLANES[k], answer.outlines[k], answer.errors[k]));
  }

  return keepDrawn(model, ["choice", "answer", "works", "problem"], root, draw, settings.end);
}

export default { render };
