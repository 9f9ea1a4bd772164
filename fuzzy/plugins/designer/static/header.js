// The designer's header: the file and its state, undo and redo, saving, the menu of the file with its dialogs, what is
// said to the designer, and the keys that work everywhere. Model: "design" and "shell" ({ file, files, compared,
// largest, restored, aside, unkept, unnamed }) and "keys"
// ([key, where, what]); Python's messages: { say, problem }, { say, undo }, { say, stop }, { ask, then }, { moved },
// { saved }, { refused }: of "Save as"; those of the dialog "New from" stand in starts.js.

import { watchConnection } from "./connection.js";
import { element as make } from "./chart.js";
import { menuOf } from "./menu.js";
import { historyKeys } from "../../../static/keys.js";

const MAC = /Mac|iPhone|iPad/.test(navigator.platform);
const key = (letters) => (MAC ? `⌘${letters.replace("Shift+", "⇧")}` : `Ctrl+${letters}`);
const withEnding = (name) => (/\.fis$/i.test(name) ? name : `${name}.fis`);
const address = (name) => `${location.pathname}?file=${encodeURIComponent(name)}`;
const FIGURES = {
  memberships: "Membership functions",
  rules: "Rule viewer at the point",
  structure: "Structure",
  surface: "Surface",
  all: "All pictures, as a zip for a paper",
};
const FORMATS = { svg: "SVG", pdf: "PDF", png: "PNG" };
const NUMBERS = {
  double: "double",
  float: "float: a unit for it, such as a Cortex-M4F",
  "q16.16": "Q16.16: fixed point, no floating point at run time",
};
// A Map keeps this order; an object's whole numbers would stand before all else.
const TABLES = new Map([
  ["", "The rules themselves"],
  [17, "A table of 17 points an input"],
  [33, "A table of 33"],
  [65, "A table of 65"],
]);
const SHOWN = 7000, // ms that a sentence stays; a problem stays until it is put away
  UNDOABLE = 15000; // ms that what can be undone stays, unless it has been undone or another edit was made

// Where a "?" is typed
const TYPED = "input:not([type=checkbox]):not([type=range]), textarea, select, [contenteditable]";

let count = 0; // ids must differ between pages' headers; nothing else is kept

function select(label, options, chosen = null) {
  const field = make(
    "select",
    { "aria-label": label },
    ...[...(options instanceof Map ? options : Object.entries(options))].map(([value, text]) =>
      make("option", { value, selected: value === chosen }, text),
    ),
  );
  return { field, row: make("label", { class: "row" }, make("span", {}, label), field) };
}

/** A dialog with a heading; `done` is called when its first button is pressed or Enter is. It may stay open. */
function dialog(host, heading, rows, accept, done, stays = false) {
  const id = `shell-dialog-${++count}`;
  const box = make("dialog", { "aria-labelledby": id });
  const form = make("form", {
    onsubmit: (event) => {
      event.preventDefault();
      if (!stays) box.close();
      done();
    },
  });
  const buttons = make("div", { class: "buttons" }, make("button", { onclick: () => box.close() }, "Cancel"));
  if (accept) buttons.append(make("button", { type: "submit", class: "first" }, accept));
  form.append(make("h2", { id }, heading), ...rows, buttons);
  box.append(form);
  // The field that had the focus gets it back by itself; what was shown goes.
  box.addEventListener("close", () => box.remove());
  host.append(box);
  box.showModal();
  return box;
}

/** A field for the name of a file. */
const nameField = (more) =>
  make("input", { type: "text", autocomplete: "off", spellcheck: "false", required: true, ...more });

function render({ model, el }) {
  el.classList.add("shell-header");
  const send = (content) => model.send(content);
  const shell = () => model.get("shell");

  // What is said ---------------------------------------------------------------------------------------------
  const status = make("div", { role: "status", "aria-live": "polite", class: "said" });
  const alertText = make("span");
  const alert = make(
    "div",
    { role: "alert", class: "said problem", hidden: true },
    alertText,
    make("button", { "aria-label": "Close this message", onclick: () => (alert.hidden = true) }, "×"),
  );
  const undoButton = make("button", { onclick: () => send({ do: "undo" }) }, "Undo"),
    stopButton = make("button", { onclick: () => send({ do: "stop" }) }, "Stop");
  let saving = null; // the dialog "Save as" while it is open
  let timer = 0,
    undoable = null; // the name of the edit that the sentence shown speaks of
  function quiet() {
    const had = status.contains(document.activeElement);
    status.replaceChildren();
    undoable = null;
    if (had) undo.focus();
  }
  function say(text, problem = false, edit = null, stop = false) {
    if (problem) {
      alertText.textContent = text;
      alert.hidden = false;
      return;
    }
    alert.hidden = true;
    status.replaceChildren(text, ...(edit === null ? [] : [undoButton]), ...(stop ? [stopButton] : []));
    undoable = edit;
    clearTimeout(timer);
    timer = setTimeout(quiet, edit === null ? SHOWN : UNDOABLE);
  }

  // Dialogs --------------------------------------------------------------------------------------------------
  function openFile() {
    const { file, files, unsaved = [] } = shell();
    const list = make("ul", { class: "files" });
    for (const name of [...files, ...unsaved]) {
      const text = unsaved.includes(name) ? `${name} (not saved yet)` : name;
      list.append(
        make("li", {}, make("a", { href: address(name), "aria-current": name === file ? "page" : null }, text)),
      );
    }
    const name = nameField({ placeholder: "name.fis" });
    const rows = [
      make("p", {}, files.length ? "Files of this folder:" : "This folder has no .fis files yet."),
      list,
      make("label", { class: "row" }, make("span", {}, "New file"), name),
      make("button", { onclick: () => (box.close(), newFrom()) }, "New from …"),
    ];
    const box = dialog(el, "Open", rows, "Create", () => location.assign(address(withEnding(name.value.trim()))));
    list.querySelector("a")?.focus();
  }

  // A new design asks for its name.
  function store() {
    if (shell().unnamed !== null) saveAs();
    else send({ do: "save" });
  }

  function saveAs() {
    const name = nameField({ value: shell().unnamed ?? shell().file });
    const id = `shell-refused-${++count}`,
      why = make("p", { class: "problem", role: "alert", id });
    const box = dialog(
      el,
      "Save as",
      [make("label", { class: "row" }, make("span", {}, "File in this folder"), name), why],
      "Save",
      () => send({ do: "save_as", name: withEnding(name.value.trim()) }),
      true, // until Python has answered
    );
    saving = {
      close: () => box.close(),
      refused(text) {
        why.textContent = text;
        for (const [attribute, value] of [
          ["aria-invalid", "true"],
          ["aria-describedby", id],
        ])
          name.setAttribute(attribute, value);
        name.focus();
      },
    };
    box.addEventListener("close", () => (saving = null));
    name.select();
  }

  function compare() {
    const { file, files, compared } = shell();
    const others = Object.fromEntries([
      ["", "nothing"],
      ...files.filter((name) => name !== file).map((name) => [name, name]),
    ]);
    others[file] = `${file} as it was saved`;
    const choice = select("Compare with", others, compared ?? "");
    const rows = [choice.row, make("p", { class: "note" }, "The other design is drawn dashed and grey.")];
    dialog(el, "Compare", rows, "Compare", () => send({ do: "compare", name: choice.field.value || null }));
  }

  function exportFigure() {
    const kind = select("Figure", FIGURES),
      format = select("Format", FORMATS);
    dialog(el, "Export a figure", [kind.row, format.row], "Export", () => {
      say("The figure is being drawn …");
      send({ do: "export", kind: kind.field.value, format: format.field.value });
    });
  }

  function exportC() {
    const number = select("Numbers", NUMBERS),
      written = select("Written are", TABLES),
      note = make("p", { class: "note" }, "A header and a source of C99 for a microcontroller, as a zip.");
    dialog(el, "Export C code", [number.row, written.row, note], "Export", () =>
      send({ do: "c-code", number: number.field.value, table: Number(written.field.value) || null }),
    );
  }

  function showKeys() {
    const row = (tag, cells) =>
      make("tr", {}, ...cells.map((text) => make(tag, tag === "th" ? { scope: "col" } : {}, text)));
    const table = make(
      "table",
      { class: "keys" },
      make("thead", {}, row("th", ["key", "where", "what it does"])),
      make("tbody", {}, ...model.get("keys").map((cells) => row("td", cells))),
    );
    const tour = make(
      "button",
      { onclick: () => (box.close(), document.dispatchEvent(new Event("fd-tour"))) },
      "New to rule bases? A tour of five steps",
    );
    const box = dialog(el, "Keys", [tour, table], null, () => {});
    box.classList.add("wide");
    const close = box.querySelector(".buttons button");
    close.textContent = "Close";
    close.focus();
    box.scrollTop = 0;
  }

  const chooser = make("input", {
    type: "file",
    accept: ".fis,.txt",
    hidden: true,
    "aria-label": "File to upload",
    onchange: upload,
  });
  async function upload() {
    const [file] = chooser.files;
    chooser.value = "";
    if (!file) return;
    const { largest } = shell(); // bytes; the server refuses more too
    if (file.size > largest)
      return say(`${file.name} is larger than ${largest / 1e6} MB, the most that can be uploaded.`, true);
    const query = new URLSearchParams({ file: shell().file, name: file.name });
    try {
      const reply = await fetch(`/upload?${query}`, {
        method: "POST",
        body: file,
        headers: { "Content-Type": "application/octet-stream" },
      });
      const { said, problem } = await reply.json();
      say(problem ?? said, problem !== undefined);
    } catch {
      say(`${file.name} could not be uploaded: the server does not answer.`, true);
    }
  }

  let starts = null; // the dialog "New from", loaded when it is first asked for
  async function newFrom() {
    try {
      starts ??= (await import("./starts.js")).startsDialog({
        host: el,
        make,
        dialog,
        select,
        send,
        files: () => shell().files,
        go: (name) => location.assign(address(name)),
      });
    } catch {
      return say("What there is to begin with cannot be shown: the server does not answer.", true);
    }
    starts.open();
  }

  function ask({ ask: question, accept, then }) {
    dialog(el, "Are you sure?", [make("p", {}, question)], accept, () => send(then));
  }

  // The menu -------------------------------------------------------------------------------------------------
  const entries = [
    ["Open or new …", openFile],
    ["New from …", newFrom],
    ["Save as …", saveAs],
    ["Upload a .fis file …", () => chooser.click()],
    ["Download the .fis file", () => send({ do: "download" })],
    ["Take a snapshot", () => send({ do: "snapshot" })],
    ["Compare with …", compare],
    ["Export a figure …", exportFigure],
    ...(shell().writesC ? [["Export C code …", exportC]] : []),
    ["Revert to the saved file", () => send({ do: "discard" })],
  ];
  const menu = menuOf("File", entries, "file");

  // The bar --------------------------------------------------------------------------------------------------
  const name = make("span", { class: "name" }),
    state = make("span", { class: "state" });
  const worded = (wish, sign, word, more) =>
    make("button", { onclick: () => send({ do: wish }), ...more }, sign, make("span", { class: "word" }, ` ${word}`));
  const undo = worded("undo", "↶", "Undo"),
    redo = worded("redo", "↷", "Redo"),
    title = "History: all edits, and snapshots",
    past = worded("history", "◷", "History", { "aria-label": "History", title });
  const save = make("button", { class: "first", title: key("S"), onclick: store }, "Save");
  // On a narrow screen the tree is a menu: the style sheet shows it while data-tree is "open".
  const tree = make(
    "button",
    {
      class: "tree-button",
      "aria-expanded": "false",
      "aria-controls": "shell-tree",
      onclick: () => {
        const open = el.dataset.tree !== "open";
        el.dataset.tree = open ? "open" : "";
        tree.setAttribute("aria-expanded", String(open));
      },
    },
    "System",
  );
  const restored = make("div", { class: "restored", role: "status" });
  const unkept = make("div", { class: "restored unkept", role: "alert" });
  el.append(
    make(
      "div",
      { class: "bar" },
      make("h1", {}, name, " ", state),
      make(
        "div",
        { class: "tools", role: "toolbar", "aria-label": "Design" },
        tree,
        undo,
        redo,
        past,
        save,
        menu.node,
        make(
          "button",
          {
            "aria-label": "Keys ?",
            title: "a tour, and all keys (?)",
            "aria-haspopup": "dialog",
            onclick: showKeys,
          },
          make("span", { class: "word" }, "Keys "),
          "?",
        ),
      ),
    ),
    restored,
    unkept,
    chooser,
    status,
    alert,
  );

  function show() {
    const design = model.get("design"),
      { file, compared } = shell();
    name.textContent = file;
    state.textContent = design.saved ? "saved" : "not saved";
    state.classList.toggle("unsaved", !design.saved);
    for (const [button, what, label, letters] of [
      [undo, design.undo, "Undo", "Z"],
      [redo, design.redo, "Redo", "Shift+Z"],
    ]) {
      // Not "disabled": a button that loses the focus while one undoes step by step is lost for the keyboard.
      button.setAttribute("aria-disabled", String(!what));
      button.title = what ? `${label}: ${what} (${key(letters)})` : `Nothing to ${label.toLowerCase()}`;
      button.setAttribute("aria-label", what ? `${label}: ${what}` : label);
    }
    if (undoable !== null && undoable !== design.undo) quiet();
    document.title = `${design.saved ? "" : "• "}${file} – Fuzzy designer`;
    el.dataset.compared = compared ?? "";
  }

  function showRestored() {
    const when = shell().restored;
    restored.replaceChildren();
    if (shell().aside.length) return chooseWork(shell().aside[0]);
    const empty = !shell().files.length && !(shell().unsaved ?? []).length;
    if (!when && empty && !model.get("design").undo) offerStarts();
    if (!when) return;
    restored.append(
      make("span", {}, `Unsaved work of ${when} has been restored.`),
      make("button", { onclick: () => send({ do: "discard" }) }, "Revert to the saved file"),
      make("button", { onclick: () => restored.replaceChildren() }, "Keep it"),
    );
  }

  // The file was changed by somebody else while work on it was not saved: both stay until one is chosen.
  function chooseWork(when) {
    const choose = (which, words) => make("button", { onclick: () => send({ do: "choose", which }) }, words);
    restored.append(
      make("span", {}, `The file has changed since your unsaved work of ${when}; the file is shown.`),
      choose("work", "Take my work"),
      choose("compare", "Compare both"),
      choose("file", "Keep the file, forget my work"),
    );
  }

  // An empty folder: a small new system stands there, and there are better things to begin with.
  function offerStarts() {
    restored.append(
      make("span", {}, "This folder has no .fis files yet: a small new system stands here."),
      make("button", { "aria-haspopup": "dialog", onclick: newFrom }, "New from …"),
      make("button", { onclick: () => restored.replaceChildren() }, "Keep this one"),
    );
  }

  // Keys -----------------------------------------------------------------------------------------------------
  const steps = historyKeys(document);
  function onKey(event) {
    if (event.altKey || el.querySelector("dialog[open]")) return;
    if (event.key === "?" && !event.target.matches?.(TYPED)) {
      event.preventDefault();
      return void showKeys();
    }
    if (!(event.ctrlKey || event.metaKey)) return;
    const wish = event.key.toLowerCase() === "s" && !event.shiftKey ? "save" : steps.wished(event);
    if (wish === null) return;
    // While nobody answers it would come to nothing.
    if (!el.closest("[inert]")) {
      if (wish === "save") store();
      else send({ do: wish });
    }
    event.preventDefault();
  }
  document.addEventListener("keydown", onKey);

  const unwatch = watchConnection();
  const onMessage = (message) => {
    starts?.hear(message);
    if (message.say !== undefined) say(message.say, message.problem, message.undo ?? null, message.stop);
    if (message.saved || message.ask !== undefined) saving?.close();
    if (message.refused !== undefined) saving ? saving.refused(message.refused) : say(message.refused, true);
    if (message.ask !== undefined) ask(message);
    if (message.focus === "history") past.focus();
    if (message.moved !== undefined) history.replaceState(null, "", address(message.moved));
  };
  let shown; // the times of the unsaved work that was told last
  const onShell = () => {
    show();
    const told = [shell().restored, ...shell().aside].join();
    if (told !== shown) showRestored();
    else if (shell().files.length && !shown) restored.replaceChildren(); // no empty folder any more
    shown = told;
    const problem = shell().unkept;
    const loss = "Until that works again, what is not saved in the file is lost when the designer ends.";
    if (problem) unkept.replaceChildren(make("span", {}, `${problem[0].toUpperCase()}${problem.slice(1)}. ${loss}`));
    else unkept.replaceChildren();
  };
  model.on("change:design", show);
  model.on("change:shell", onShell);
  model.on("msg:custom", onMessage);
  onShell();
  // The cookie does what the token in the address did; it need not stand in the history.
  const here = new URLSearchParams(location.search);
  if (here.has("token")) {
    here.delete("token");
    history.replaceState(null, "", location.pathname + (here.size ? `?${here}` : ""));
  }

  return () => {
    clearTimeout(timer);
    model.off("change:design", show);
    model.off("change:shell", onShell);
    model.off("msg:custom", onMessage);
    menu.end();
    document.removeEventListener("keydown", onKey);
    steps.end();
    unwatch();
  };
}

export default { render };
