// The terms of an output: constants as markers to drag on an axis, linear consequents as bars from lowest to highest.
import {
  axes,
  clamp,
  color,
  cut,
  element,
  labelled,
  put,
  quantity,
  rounded,
  said,
  scale,
  shape,
  widthOf,
} from "./chart.js";
import { drag, gesture, pressing, stepped } from "./dragging.js";

const ROW = 28; // px, a term's

/** The lowest and highest value of a consequent over the inputs' universes. */
export function reach(term, inputs) {
  if (term.type === "constant") return [term.parameters[0], term.parameters[0]];
  let low = term.parameters.at(-1),
    high = low;
  inputs.forEach((input, i) => {
    const ends = [term.parameters[i] * input.low, term.parameters[i] * input.high];
    low += Math.min(...ends);
    high += Math.max(...ends);
  });
  return [low, high];
}

/** The value of a consequent at a point. */
export const consequent = (term, point) =>
  term.type === "constant"
    ? term.parameters[0]
    : point.reduce((sum, value, i) => sum + term.parameters[i] * value, term.parameters.at(-1));

/** The chart of an output; hands as membershipChart's. view has besides the inputs, the point and the output's value. */
export function consequentChart(hands) {
  const svg = shape("svg", { class: "fd-chart", role: "group" });
  const back = shape("g"),
    rows = shape("g");
  svg.append(back, rows);
  const key = pressing(),
    grips = new Map();
  let view = null,
    x;
  const pixel = (event) => event.clientX - svg.getBoundingClientRect().left;
  const tidy = (value) => rounded(value, ...x.ends);
  const named = (name) => view.variable.terms.find((term) => term.name === name);

  svg.addEventListener("click", (event) => {
    const name = event.target.closest("[data-term]")?.dataset.term;
    if (name !== undefined) hands.select(name);
  });

  function grip(name) {
    const node = shape(
      "g",
      { class: "fd-grip", role: "slider", tabindex: 0 },
      shape("circle", { r: 16, class: "fd-reach" }),
      shape("path", { class: "fd-dot", d: "M-7 0L0 -7L7 0L0 7z" }),
    );
    let held = null;
    drag(node, {
      start(event) {
        hands.select(name);
        // The axis stays as it is while a marker is dragged on it.
        held = {
          name: gesture(),
          before: named(name).parameters,
          scale: x,
          off: pixel(event) - x(named(name).parameters[0]),
        };
        node.focus();
      },
      move(event) {
        hands.move(name, [tidy(held.scale.value(pixel(event) - held.off))], held.name, true);
      },
      end(_, cancelled) {
        if (cancelled) hands.move(name, held.before, held.name, true);
        held = null;
        hands.release();
      },
    });
    node.addEventListener("keydown", (event) => {
      const to = stepped(event, named(name).parameters[0], view.variable.low, view.variable.high);
      if (to !== null) hands.move(name, [tidy(to)], key(event), false);
    });
    node.addEventListener("focus", () => hands.select(name));
    return { node, held: () => held };
  }

  function draw(next) {
    view = next;
    const { variable, width, inputs } = view,
      held = [...grips.values()].map((each) => each.held()).find((each) => each);
    const words =
      Math.min(width * 0.32, Math.max(40, ...variable.terms.map(({ name }) => widthOf(name, 13, 600)))) + 12;
    const box = { left: words + 10, right: width - 64, top: 12, bottom: 18 + Math.max(1, variable.terms.length) * ROW };
    const others = view.compared?.terms ?? [],
      reached = [...variable.terms, ...others].flatMap((term) => reach(term, inputs)),
      ends = [variable.low, variable.high, ...reached].filter(Number.isFinite);
    const low = Math.min(...ends),
      high = Math.max(...ends),
      room = (high - low || 1) * 0.03;
    x = held ? held.scale : scale(low - room, high + room, box.left, box.right);
    put(svg, {
      width,
      height: box.bottom + 50,
      viewBox: `0 0 ${width} ${box.bottom + 50}`,
      "aria-label": `Consequents of ${variable.name}`,
    });
    const band = shape("rect", {
      x: x(variable.low),
      y: box.top,
      width: Math.max(1, x(variable.high) - x(variable.low)),
      height: box.bottom - box.top,
      class: "fd-universe",
    });
    back.replaceChildren(band, axes(box, x, scale(0, 1, 0, 1), [labelled(variable), null], []));
    const kept = new Set(),
      children = [];
    variable.terms.forEach((term, i) => {
      const py = box.top + 3 + (i + 0.5) * ROW,
        [from, to] = reach(term, inputs),
        own = consequent(term, view.point);
      const group = shape("g", {
        "data-term": term.name,
        class: term.name === view.selected ? "fd-label fd-bold" : "fd-label",
      });
      group.append(
        shape("rect", {
          x: 0,
          y: py - ROW / 2,
          width,
          height: ROW,
          class: term.name === view.selected ? "fd-chosen" : "fd-reach",
        }),
      );
      group.append(
        shape(
          "text",
          { x: words, y: py + 4, "text-anchor": "end" },
          cut(term.name, words - 4, 13, 600),
          shape("title", {}, term.name),
        ),
      );
      group.append(shape("line", { x1: box.left, x2: box.right, y1: py, y2: py, class: "fd-grid" }));
      const old = view.compared?.terms.find(({ name }) => name === term.name);
      if (old) {
        const [a, b] = reach(old, inputs);
        group.append(
          shape("path", { d: `M${x(a)} ${py - 10}V${py + 10}M${x(b)} ${py - 10}V${py + 10}`, class: "fd-compared" }),
        );
      }
      if (term.type === "linear") {
        group.append(
          shape("line", { x1: x(from), x2: x(to), y1: py, y2: py, class: "fd-reachbar", style: `stroke: ${color(i)}` }),
        );
        group.append(
          shape(
            "circle",
            { cx: x(own), cy: py, r: 4.5, style: `fill: ${color(i)}` },
            shape("title", {}, `${quantity(own, variable)} at the current point`),
          ),
        );
      }
      group.append(
        shape(
          "text",
          { x: width - 4, y: py + 4, "text-anchor": "end", class: "fd-tick" },
          said(own, 3, variable.high - variable.low),
        ),
      );
      children.push(group);
      if (term.type !== "constant") return;
      kept.add(term.name);
      if (!grips.has(term.name)) grips.set(term.name, grip(term.name));
      const { node } = grips.get(term.name),
        value = term.parameters[0];
      put(node, {
        transform: `translate(${clamp(x(value), 0, width)} ${py})`,
        style: `--grip: ${color(i)}`,
        "data-handle": term.name,
        "aria-label": `${term.name}: value`,
        "aria-valuenow": value,
        "aria-valuemin": Math.min(variable.low, value),
        "aria-valuemax": Math.max(variable.high, value),
        "aria-valuetext": quantity(value, variable),
      });
    });
    if (view.value !== null && Number.isFinite(view.value)) {
      const px = x(view.value);
      children.push(
        shape(
          "line",
          { x1: px, x2: px, y1: box.top, y2: box.bottom, class: "fd-result" },
          shape("title", {}, `output ${quantity(view.value, variable)}`),
        ),
      );
    }
    rows.replaceChildren(...children);
    for (const [name, { node }] of grips) {
      if (!kept.has(name)) {
        node.remove();
        grips.delete(name);
      } else if (node.parentNode !== svg) svg.append(node);
    }
  }

  return { node: element("div", { class: "fd-plot" }, svg), draw };
}
