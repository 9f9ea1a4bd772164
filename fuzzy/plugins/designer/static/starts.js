// The dialog "New from": what a new design can begin with, in groups, its options, and the name of the new file.
// Python's messages: { starts: { list, unusable, tables } }, { start_pictures: { name: { surface } | { curves } | null } },
// { start_columns: { file, columns, problem } }, { start_progress: { share, said } }, { begun }, { start_refused }.
import { inks, paintCurves, paintSmall } from "./smallsurface.js";

const WIDE = 132,
  HIGH = 84; // px of a picture

/**
 * The dialog's two functions: `open()`, and `hear(message)` of Python. `parts` are the header's: where dialogs stand
 * (`host`), `make`, `dialog`, `select`, `send`, `files()`, `go(name)`.
 */
export function startsDialog({ host, make, dialog, select, send, files, go }) {
  let box = null, // while it is open
    known = null,
    chosen = null,
    table = null, // the columns of the chosen table
    busy = false;
  const pictures = new Map();
  const list = make("div", { class: "starts", role: "radiogroup", "aria-label": "What it begins with" });
  const options = make("div", { class: "start-options", role: "group", "aria-label": "Options" });
  const name = make("input", { type: "text", autocomplete: "off", spellcheck: "false", required: true });
  const nameRow = make("label", { class: "row" }, make("span", {}, "Name of the new file"), name);
  const why = make("p", { class: "problem", role: "alert" });
  const bar = make("progress", { max: 1, value: 0, "aria-label": "How far it is" });
  const progress = make("p", { class: "start-progress", role: "status", hidden: true }, bar, make("span"));
  const fields = new Map(); // of the chosen start, by the option's name: a function that gives the value
  let own = null; // the name that was proposed: one that was typed stays

  function open() {
    why.textContent = "";
    busy = false;
    progress.hidden = true;
    list.replaceChildren(make("p", { class: "note" }, "What there is, is being looked up …"));
    options.replaceChildren();
    nameRow.hidden = true;
    box = dialog(host, "New from", [list, options, nameRow, progress, why], "Create", create, true);
    box.classList.add("wide", "new-from");
    const cancel = box.querySelector(".buttons button");
    cancel.addEventListener("click", () => busy && send({ do: "start_stop" }), true);
    box.addEventListener("close", () => {
      if (busy) send({ do: "start_stop" });
      box = null;
    });
    if (known) show();
    send({ do: "starts" });
  }

  function show() {
    const groups = new Map();
    for (const start of known.list) {
      if (!groups.has(start.group)) groups.set(start.group, []);
      groups.get(start.group).push(start);
    }
    list.replaceChildren(
      ...[...groups].flatMap(([group, starts]) => [
        make("h3", {}, group),
        make("div", { class: "start-cards" }, ...starts.map(card)),
      ]),
      ...known.unusable.map((sentence) => make("p", { class: "note" }, sentence)),
    );
    for (const each of known.list) paint(each.name);
    const first = known.list.find((start) => start.name === chosen?.name) ?? known.list[0];
    const active = document.activeElement;
    if (first) choose(first, active !== name && !options.contains(active));
  }

  function card(start) {
    const radio = make("input", { type: "radio", name: "start", value: start.name, onchange: () => choose(start) });
    const canvas = make("canvas", { width: WIDE, height: HIGH, "aria-hidden": "true", "data-start": start.name });
    return make(
      "label",
      { class: "start-card" },
      radio,
      canvas,
      make("span", { class: "start-title" }, start.title),
      make("span", { class: "start-sentence" }, start.sentence),
    );
  }

  function paint(start) {
    const canvas = list.querySelector(`canvas[data-start="${CSS.escape(start)}"]`),
      picture = pictures.get(start);
    if (!canvas || !picture) return;
    if (picture.surface) paintSmall(canvas, picture.surface, WIDE, HIGH, inks(host));
    else paintCurves(canvas, picture.curves, WIDE, HIGH, inks(host));
  }

  function choose(start, focus = false) {
    const again = chosen?.name === start.name && options.childElementCount > 0;
    chosen = start;
    const radio = [...list.querySelectorAll("input[type=radio]")].find((each) => each.value === start.name);
    if (radio) radio.checked = true;
    if (focus) radio?.focus();
    why.textContent = "";
    nameRow.hidden = false;
    if (!again) {
      fields.clear();
      table = null;
      options.replaceChildren(...start.options.filter(({ kind }) => kind !== "columns").map(field));
      if (start.options.some(({ kind }) => kind === "columns")) options.append(columnRows());
    }
    if (name.value === "" || name.value === own) name.value = own = free(start.name.replaceAll("/", "-"));
  }

  function free(stem) {
    const taken = new Set(files().map((file) => file.toLowerCase()));
    let count = 1,
      file = `${stem}.fis`;
    while (taken.has(file.toLowerCase())) file = `${stem}-${++count}.fis`;
    return file;
  }

  function field(option) {
    if (option.kind === "choice") {
      const { field, row } = select(option.title, option.values, option.value);
      fields.set(option.name, () => field.value);
      return row;
    }
    if (option.kind === "file") {
      if (!known.tables.length) {
        fields.set(option.name, () => "");
        return make("p", { class: "note" }, `${option.title}: this folder has no ${option.ending} file.`);
      }
      const { field, row } = select(option.title, Object.fromEntries(known.tables.map((file) => [file, file])));
      const read = () => send({ do: "start_columns", file: field.value });
      fields.set(option.name, () => field.value);
      field.addEventListener("change", () => ((table = null), showColumns(), read()));
      read();
      return row;
    }
    const input = make("input", {
      type: "number",
      value: option.value,
      min: option.low,
      max: option.high,
      step: option.whole ? 1 : "any",
      required: true,
    });
    fields.set(option.name, () => input.value);
    const text = option.unit ? `${option.title} [${option.unit}]` : option.title;
    return make("label", { class: "row" }, make("span", {}, text), input);
  }

  // Which column is which: one list a column, of the options that are columns.
  const rows = make("div", { class: "start-columns", role: "group", "aria-label": "Columns of the table" });
  function columnRows() {
    showColumns();
    return rows;
  }
  function showColumns() {
    const roles = chosen.options.filter(({ kind }) => kind === "columns");
    for (const role of roles) fields.delete(role.name);
    if (!table) return rows.replaceChildren();
    if (table.problem) return rows.replaceChildren(make("p", { class: "problem", role: "alert" }, table.problem));
    const usable = table.columns.map((column, k) => [column, k]).filter(([column]) => column.usable);
    const choices = {
      "": "not used",
      ...Object.fromEntries(roles.map((role) => [role.name, role.title.toLowerCase()])),
    };
    const selects = table.columns.map(({ title }, k) => {
      const last = usable.at(-1)?.[1] === k,
        mine = usable.some(([, at]) => at === k);
      const { field, row } = select(title, choices, mine ? roles[last ? roles.length - 1 : 0].name : "");
      field.disabled = !mine;
      return { field, row };
    });
    // By numbers: a title may hold a comma.
    for (const role of roles)
      fields.set(role.name, () =>
        selects
          .map(({ field }, k) => (field.value === role.name ? k + 1 : null))
          .filter((k) => k !== null)
          .join(","),
      );
    rows.replaceChildren(...selects.map(({ row }) => row));
  }

  function create() {
    if (!chosen || busy) return;
    why.textContent = "";
    const values = Object.fromEntries([...fields].map(([key, value]) => [key, value()]));
    const file = name.value.trim();
    busy = true;
    settle();
    send({
      do: "start_make",
      start: chosen.name,
      options: values,
      name: /\.fis$/i.test(file) ? file : `${file}.fis`,
    });
  }

  function settle() {
    if (!box) return;
    box.querySelector("button.first").disabled = busy;
    bar.removeAttribute("value");
    progress.hidden = !busy;
    progress.lastChild.textContent = busy ? "It is being made …" : "";
  }

  function hear(message) {
    if (message.starts) {
      known = message.starts;
      if (box && !busy) show();
    } else if (message.start_pictures) {
      for (const [start, picture] of Object.entries(message.start_pictures)) {
        pictures.set(start, picture);
        if (box) paint(start);
      }
    } else if (message.start_columns && box && chosen && fields.get("file")?.() === message.start_columns.file) {
      table = message.start_columns;
      showColumns();
    } else if (message.start_progress && busy) {
      bar.value = message.start_progress.share;
      progress.lastChild.textContent = message.start_progress.said;
    } else if (message.start_refused !== undefined) {
      busy = false;
      settle();
      why.textContent = `${message.start_refused[0].toUpperCase()}${message.start_refused.slice(1)}`;
      name.setAttribute("aria-invalid", String(/\.fis/.test(message.start_refused)));
    } else if (message.begun !== undefined) {
      busy = false;
      box?.close();
      go(message.begun);
    }
  }
  return { open, hear };
}
