// The form of a panel: fields that send what is chosen as {do: "choose", name, value}, and what was refused under them.
import { choices, element, sayUnder, styled, takes } from "./chart.js";

/** Put the style sheets of a panel with a form into the page, and its own beside the module at `base`. */
export const formStyled = (base, ...sheets) =>
  Promise.all([styled(import.meta.url, "./panel.css", "./form.css"), styled(base, ...sheets)]);

/** A field with its name above it. */
export const field = (text, control, kind = null) =>
  element("label", { class: kind }, element("span", {}, text), control);

export const row = (...children) => element("div", { class: "pn-row" }, ...children);

/** What begins and ends the work, and how far it is: always in sight below the form. */
export const acts = (buttons, ...progress) => element("div", { class: "pn-acts" }, row(...buttons), ...progress);

/** Fields that belong together, under a title. */
export const group = (title, ...children) => element("fieldset", {}, element("legend", {}, title), ...children);

/** A box to tick, and its words: {node, input}; react(on). */
export function checkBox(text, react) {
  const input = element("input", { type: "checkbox", onchange: () => react(input.checked) });
  return { node: element("label", { class: "pn-check" }, input, element("span", {}, text)), input };
}

/**
 * The form over a panel's `model`. What was refused, there or here, stands under the field that asked for it;
 * `home(note, field)` puts the note where it belongs if there is none. With `leads` the page scrolls to the note, which
 * may be far from the button; `columns` is the box of columnField's lists, if there is one; `chosen(name, value)` hears
 * of what is sent.
 */
export function panelForm(model, home, { leads = false, columns = null, chosen = () => {} } = {}) {
  const fields = {}, // by name: what a refusal of that name stands under
    note = element("p", { class: "pn-problem", role: "alert", hidden: true });
  let refused = null; // what this side refuses: { message, input }
  const get = (name) => model.get(name) ?? null;
  const send = (content) => model.send(content);
  const choose = (name, value) => {
    chosen(name, value);
    send({ do: "choose", name, value });
  };

  /** Refuse here what Python never hears of; an empty message says that all is well. */
  function refuse(message, input) {
    refused = message ? { message, input } : null;
    drawProblem();
  }

  function drawProblem() {
    const { message = "", field: name = null, column = null, input = null } = refused ?? get("problem") ?? {};
    const list = column === null ? null : [...columns.querySelectorAll("select")].find((each) => each.name === column);
    const fresh = message !== "" && message !== note.textContent;
    sayUnder(note, message, input ?? (column === null ? fields[name] : list), (node) => home(node, name));
    if (fresh) for (let box = note.closest("details"); box; box = box.parentElement.closest("details")) box.open = true;
    if (leads && fresh) note.scrollIntoView({ block: "nearest" });
  }

  /**
   * A field for a number. `factor` is what it shows of a unit of the value; where it may be empty, which is null, `empty`
   * says what that means. What it does not take is said, and not sent. show(value) leaves alone what is being typed.
   */
  function number(label, name, attributes = {}, { factor = 1, empty = null, react = (v) => choose(name, v) } = {}) {
    const input = element("input", {
      type: "number",
      step: "any",
      placeholder: empty,
      "aria-label": label,
      ...attributes,
    });
    input.addEventListener("change", () => {
      const lacks = input.value === "" && !input.validity.badInput && empty !== null,
        right = lacks || (input.value !== "" && input.checkValidity());
      if (right) react(lacks ? null : Number(input.value) / factor);
      refuse(right ? "" : takes(input, input.ariaLabel), input);
    });
    input.show = (value) => {
      if (document.activeElement === input) return;
      const shown = value === null || factor === 1 ? value : Number((value * factor).toPrecision(6));
      if (shown === null) input.value = "";
      else if (input.value === "" || Number(input.value) !== shown) input.value = shown;
    };
    if (name) fields[name] = input;
    return input;
  }

  /** A list of which one is chosen; its options are offered when they are known. */
  const list = (label, name, of = (value) => value) =>
    (fields[name] = choices(label, [], "", (value) => choose(name, of(value))));

  /** A box to tick, as checkBox() makes it. */
  function check(text, name) {
    const made = checkBox(text, (on) => choose(name, on));
    fields[name] = made.input;
    return made;
  }

  /** A button for a wish of the page. */
  const act = (text, wish, kind = null) => element("button", { class: kind, onclick: () => send({ do: wish }) }, text);

  return { get, send, choose, fields, note, refuse, drawProblem, number, list, check, act };
}
