// The control surface: bands, relief or curve, with two sections through the current point that are dragged.
import {
  button,
  choices,
  clamp,
  element,
  endOf,
  heightLeft,
  labelled,
  offer,
  put,
  rounded,
  said,
  say,
  shape,
  watch,
  whenSized,
} from "./chart.js";
import { drag, hold, stepped } from "./dragging.js";
import { difference, fieldOf, levelsOf } from "./field.js";
import { paintRelief } from "./relief.js";
import { contourPicture } from "./contour.js";
import { heldInputs, smallMultiples } from "./multiples.js";
import { sectionChart } from "./section.js";

export function render({ model, el }) {
  const root = element("div", { class: "fd fd-surface" }),
    place = hold((message) => model.send(message));
  const own = `fd${Math.random().toString(36).slice(2)}`,
    dark = window.matchMedia("(prefers-color-scheme: dark)");
  const state = { view: "contour", compare: "second", turn: -0.6, lift: 0.5 };
  const design = () => model.get("design"),
    point = () => place.value("point", model.get("point") ?? model.get("surface")?.fixed);

  // Controls
  const ask = (change) => {
    const { inputs, output } = model.get("surface"),
      wanted = { look: "surface", inputs, output, ...change };
    model.send(wanted);
  };
  const first = choices("first input", [], "", (value) => {
    const [, b] = model.get("surface").inputs;
    ask({
      inputs:
        b === undefined
          ? [Number(value)]
          : b === Number(value)
            ? [b, model.get("surface").inputs[0]]
            : [Number(value), b],
    });
  });
  const second = choices("second input", [], "", (value) => {
    const [a] = model.get("surface").inputs;
    ask({ inputs: value === "" ? [a] : [a, Number(value)] });
  });
  const output = choices("output", [], "", (value) => ask({ output: Number(value) }));
  const compare = choices(
    "other design",
    [
      ["second", "both"],
      ["difference", "difference"],
      ["off", "hidden"],
    ],
    "second",
    (value) => {
      state.compare = value;
      paint();
    },
  );
  const views = [
    ["contour", "Contour"],
    ["3d", "3-D"],
  ].map(([name, text]) =>
    element(
      "button",
      {
        class: "fd-tab",
        "data-view": name,
        onclick: () => {
          state.view = name;
          paint();
        },
      },
      text,
    ),
  );
  const modes = [
    ["one", "One"],
    ["outputs", "All outputs"],
    ["pairs", "All pairs"],
  ].map(([mode, text]) =>
    element(
      "button",
      {
        class: "fd-tab",
        "data-mode": mode,
        onclick: () => model.send({ look: "several", mode }),
      },
      text,
    ),
  );
  const several = element("div", { class: "fd-tabs", role: "group", "aria-label": "Surfaces" }, ...modes);
  const multiples = smallMultiples((chosen) => ask(chosen)),
    held = heldInputs(
      (i, value, pressed) => move([[i, value]], pressed),
      () => place.release(),
    );
  const field = (text, select) =>
    element("label", { class: "fd-choice" }, element("span", { "aria-hidden": "true" }, text), select);
  const compareField = field("other design", compare),
    secondField = field("against", second),
    tabs = element("div", { class: "fd-tabs", role: "group", "aria-label": "View" }, ...views);
  const relief = element("canvas", { tabindex: 0, role: "img", class: "fd-relief" });
  const note = element("p", { class: "fd-note" });
  const reset = button(
    null,
    "return to the first view",
    () => {
      state.turn = -0.6;
      state.lift = 0.5;
      paint();
    },
    "Reset view",
  );

  function move(change, pressed) {
    const now = [...point()],
      { inputs } = design();
    for (const [i, value] of change)
      now[i] = clamp(rounded(value, inputs[i].low, inputs[i].high), inputs[i].low, inputs[i].high);
    if (JSON.stringify(now) === JSON.stringify(point())) return;
    place.take("point", now, { look: "point", point: now }, model.get("point"), pressed);
    paint();
  }

  // The crosshair: a line for each input, and both together anywhere else in the picture.
  const cross = ["x", "y"].map((axis, k) => {
    const node = shape(
      "g",
      { class: "fd-point", role: "slider", tabindex: 0, "data-axis": axis },
      shape("line", { class: "fd-reach-line" }),
      shape("line", { class: "fd-cross" }),
      shape("path"),
    );
    drag(node, {
      start() {
        node.focus();
      },
      move: (event) => at(event, [k]),
      end: () => place.release(),
    });
    node.addEventListener("keydown", (event) => {
      const i = model.get("surface").inputs[k],
        { low, high } = design().inputs[i],
        to = stepped(event, point()[i], low, high);
      if (to !== null) move([[i, to]], false);
    });
    return node;
  });
  const picture = contourPicture(cross),
    flat = picture.node,
    over = picture.svg;
  const sections = [0, 1].map(() => sectionChart(own, cross));
  for (const node of [flat, relief, sections[0].node]) put(node, { "data-glance": "" });
  const main = element("div", { class: "fd-main" }, flat, relief, note),
    aside = element("div", { class: "fd-sections" }, ...sections.map(({ node }) => node));
  const area = element("div", { class: "fd-split" }, main, aside);
  root.append(
    element(
      "div",
      { class: "fd-bar" },
      field("output", output),
      field("over", first),
      secondField,
      tabs,
      compareField,
      reset,
      several,
    ),
    held.node,
    multiples.node,
    area,
  );
  el.append(root);
  let x = null,
    y = null;
  const at = (event, which) => {
    const places = model.get("surface").inputs,
      own = places.length > 1 ? over : sections[0].svg,
      area = own.getBoundingClientRect();
    const px = [event.clientX - area.left, event.clientY - area.top];
    move(
      which.map((k) => [places[k], (k ? y : x).value(px[k])]),
      true,
    );
  };
  drag(over, {
    start: (event) => {
      at(event, [0, 1]);
    },
    move: (event) => at(event, [0, 1]),
    end: () => place.release(),
  });
  let grip = null;
  drag(relief, {
    start(event) {
      grip = [event.clientX, event.clientY, state.turn, state.lift];
      relief.focus();
    },
    move(event) {
      turn(grip[2] - (event.clientX - grip[0]) * 0.01, grip[3] + (event.clientY - grip[1]) * 0.01);
    },
  });
  relief.addEventListener("keydown", (event) => {
    const by = event.shiftKey ? 0.35 : 0.07,
      step = { ArrowLeft: [by, 0], ArrowRight: [-by, 0], ArrowUp: [0, -by], ArrowDown: [0, by] }[event.key];
    if (!step) return;
    event.preventDefault();
    turn(state.turn + step[0], state.lift + step[1]);
  });
  function turn(to, lift) {
    state.turn = to;
    state.lift = clamp(lift, 0.05, 1.5);
    paint();
  }

  // A surface is read once, however often the point on it moves.
  const read = new WeakMap();
  function fieldOnce(surface) {
    if (!read.has(surface)) read.set(surface, fieldOf(surface));
    return read.get(surface);
  }
  let pair = [];
  function apartOnce(now, other) {
    if (pair[0] !== now || pair[1] !== other) pair = [now, other, difference(now, other)];
    return pair[2];
  }

  function theme() {
    const style = getComputedStyle(root),
      read = (name) => style.getPropertyValue(name).trim();
    return {
      ink: read("--ff-ink"),
      quiet: read("--ff-quiet"),
      line: read("--ff-line"),
      paper: read("--ff-paper"),
      hatch: read("--ff-hatch"),
      mark: read("--ff-mark"),
      other: read("--ff-other"),
    };
  }

  function paint() {
    const surface = model.get("surface"),
      room = area.clientWidth;
    if (!surface || room < 160) {
      root.classList.toggle("fd-empty", !surface);
      return;
    }
    root.classList.remove("fd-empty");
    const { inputs, outputs } = design(),
      names = inputs.map((v, i) => [String(i), v.name]),
      [a, b] = surface.inputs,
      out = outputs[surface.output];
    if (!out || !inputs[a]) return;
    offer(first, names, a);
    offer(second, [["", "none: a curve"], ...names.filter(([i]) => Number(i) !== a)], b ?? "");
    offer(
      output,
      outputs.map((v, j) => [String(j), v.name]),
      surface.output,
    );
    secondField.hidden = inputs.length < 2;
    const mode = model.get("several")?.mode ?? null; // a notebook has the large one only
    several.hidden = mode === null || (outputs.length < 2 && inputs.length < 3);
    for (const each of modes) {
      put(each, { "aria-pressed": String(each.dataset.mode === mode) });
      each.hidden = { outputs: outputs.length < 2, pairs: inputs.length < 3 }[each.dataset.mode] ?? false;
    }
    const all = inputs.map((_, i) => i);
    held.draw(design(), mode === "pairs" ? all : all.filter((i) => i !== a && i !== b), point());
    multiples.draw(model.get("several"), design(), surface, point());
    const compared = model.get("compared"),
      other = compared?.surface && state.compare !== "off" ? fieldOnce(compared.surface) : null,
      now = fieldOnce(surface),
      apart = other ? apartOnce(now, other) : null;
    compareField.hidden = !compared;
    const differs = state.compare === "difference" && apart !== null,
      drawn = differs ? apart : now,
      old = !differs && apart ? other : null;
    const title = differs ? { ...out, name: `${out.name} − ${compared.name}'s` } : out,
      levels = levelsOf(old ? [drawn, old] : [drawn], differs),
      map = differs ? "difference" : "viridis";
    const wide = room >= 760 && now.flat,
      width = wide ? Math.floor(room * 0.56) : room;
    root.classList.toggle("fd-wide", wide);
    tabs.hidden = !now.flat;
    reset.hidden = !now.flat || state.view !== "3d";
    for (const view of views) put(view, { "aria-pressed": String(view.dataset.view === state.view) });
    flat.hidden = !now.flat || state.view !== "contour";
    relief.hidden = !now.flat || state.view !== "3d";
    const above = [room, mode, state.view, compareField.hidden, held.node.childElementCount],
      tall = heightLeft(area, above.join());
    const scene = {
      drawn,
      old,
      levels,
      map,
      title,
      width,
      tall,
      colours: theme(),
      a: inputs[a],
      b: inputs[b],
      at: [point()[a], point()[b]],
    };
    if (!flat.hidden) [x, y] = picture.draw(scene);
    if (!relief.hidden) {
      const names = [labelled(scene.a), labelled(scene.b), labelled(title)];
      paintRelief(relief, drawn, state, {
        width,
        height: clamp(Math.min(width * 0.72, tall), 200, 460),
        levels,
        map,
        names,
        point: scene.at,
        theme: scene.colours,
        second: old,
      });
      put(relief, {
        "aria-label": `Surface of ${title.name} over ${scene.a.name} and ${scene.b.name}, from ${said(levels[0])} to ${said(levels.at(-1))}; drag or arrow keys turn it`,
      });
    }
    const gap = drawn.fired.some((v) => !v),
      words = [
        gap ? `hatched: no rule fires` : "",
        old ? `${flat.hidden ? "grey" : "dashed"}: ${compared.name}` : "",
        compared && state.compare !== "off" && !apart ? "the other design has different axes here" : "",
      ];
    say(note, words.filter(Boolean).join("; "));
    const each = wide ? room - width - 24 : room;
    x = sections[0].draw(scene, "x", each) ?? x;
    sections[1].node.hidden = !now.flat;
    if (now.flat) sections[1].draw(scene, "y", each);
  }

  const ends = [
    watch(model, ["design", "surface", "several", "compared", "point"], () => {
      place.settle("point", model.get("point"));
      paint();
    }),
    whenSized(area, paint),
  ];
  dark.addEventListener("change", paint);
  return endOf(root, ...ends, () => dark.removeEventListener("change", paint), place.drop, picture.drop);
}

export default { render };
