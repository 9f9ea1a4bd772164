// Small surfaces beside the large one, a click on which makes it the large one; and sliders of the inputs that are held.
import { element, labelled, put, quantity, rounded, say } from "./chart.js";
import { levelsOf, fieldOf } from "./field.js";
import { inks, paintSmall } from "./smallsurface.js";

const WIDE = 124,
  HIGH = 78; // px of a picture

/** The small surfaces: a part with a `draw(several, design, large, point)`; `choose({inputs, output})` is told a click. */
export function smallMultiples(choose) {
  const list = element("div", { class: "fd-multiples-list" }),
    note = element("p", { class: "fd-left-out" }),
    node = element("div", { class: "fd-multiples", role: "group", "aria-label": "Small surfaces" }, list, note);
  const cards = [];

  function card() {
    const canvas = element("canvas", { "aria-hidden": "true" }),
      caption = element("span"),
      own = { picture: null };
    const button = element("button", { class: "fd-multiple", onclick: () => choose(own.picture) }, canvas, caption);
    button.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
      const to = step && cards[cards.findIndex((each) => each.node === button) + step];
      if (to) (event.preventDefault(), to.node.focus());
    });
    return Object.assign(own, { node: button, canvas, caption });
  }

  function draw(several, { inputs, outputs }, large, point) {
    const pictures = (several?.pictures ?? []).filter(
      (each) => outputs[each.output] && each.inputs.every((i) => inputs[i]),
    );
    node.hidden = !pictures.length;
    if (node.hidden) return;
    while (cards.length < pictures.length) {
      cards.push(card());
      list.append(cards.at(-1).node);
    }
    for (const extra of cards.splice(pictures.length)) extra.node.remove();
    const colours = inks(node),
      numbers = (n) => Array.from({ length: n }, (_, k) => k);
    const fields = pictures.map(({ z, fired }) => {
      const flat = Array.isArray(z[0]);
      return {
        x: numbers(flat ? z[0].length : z.length),
        y: flat ? numbers(z.length) : null,
        z,
        fired: fired ?? (flat ? z.map((row) => row.map(() => true)) : z.map(() => true)),
      };
    });
    // One output over several pairs has one scale, several outputs have each their own.
    const levels = several.mode === "pairs" ? levelsOf(fields.map(fieldOf)) : null;
    pictures.forEach((picture, k) => {
      const each = cards[k],
        axes = picture.inputs.map((i) => inputs[i]);
      each.picture = { inputs: picture.inputs, output: picture.output };
      const share = (v, i) => (point[picture.inputs[i]] - v.low) / (v.high - v.low || 1);
      paintSmall(each.canvas, fields[k], WIDE, HIGH, colours, { levels, at: axes.map(share) });
      const over = axes.map((v) => v.name).join(", ");
      say(each.caption, several.mode === "pairs" ? over : outputs[picture.output].name);
      const now =
        picture.output === large.output && [...picture.inputs].sort().join() === [...large.inputs].sort().join();
      put(each.node, {
        "aria-pressed": String(now),
        "aria-label": `${outputs[picture.output].name} over ${over}`,
        title: `${outputs[picture.output].name} over ${over}`,
      });
    });
    say(note, several.left_out ? `${several.left_out} more have no room here.` : "");
  }
  return { node, draw };
}

/** Sliders of inputs: a part with a `draw(design, places, point)`; `move(input, value, pressed)` and `release()` are told. */
export function heldInputs(move, release) {
  const node = element("div", { class: "fd-held", role: "group", "aria-label": "Other inputs" });
  const rows = [];

  function row() {
    const own = { place: 0, low: 0, high: 1 };
    const input = element("input", { type: "range", min: 0, max: 200, step: 1 }),
      text = element("span");
    input.addEventListener("input", () =>
      move(own.place, rounded(own.low + (Number(input.value) / 200) * (own.high - own.low), own.low, own.high), true),
    );
    for (const event of ["change", "blur"]) input.addEventListener(event, release);
    return Object.assign(own, { node: element("label", {}, text, input), input, text });
  }

  function draw({ inputs }, places, point) {
    node.hidden = !places.length;
    while (rows.length < places.length) {
      rows.push(row());
      node.append(rows.at(-1).node);
    }
    for (const extra of rows.splice(places.length)) extra.node.remove();
    places.forEach((place, k) => {
      const each = rows[k],
        v = inputs[place];
      Object.assign(each, { place, low: v.low, high: v.high });
      const at = String(Math.round((200 * (point[place] - v.low)) / (v.high - v.low || 1)));
      if (each.input.value !== at) each.input.value = at;
      const words = quantity(point[place], v);
      say(each.text, `${v.name} = ${words}`);
      put(each.input, { "aria-label": labelled(v), "aria-valuetext": words });
    });
  }
  return { node, draw };
}
