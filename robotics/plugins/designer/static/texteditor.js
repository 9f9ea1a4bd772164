// A text with line numbers that is edited in place: a scenario's or a robot's file, tried at every pause. What is not
// saved is kept in this browser until it is. From what TextDesk in robotics/plugins/designer/folderfiles.py hands over.

import { element, put, say } from "../../../../fuzzy/plugins/designer/static/chart.js";

const PAUSE = 300; // ms without a key before the text is tried
const KEPT = "fuzzyfleet-draft:"; // what the names of unsaved texts begin with in the browser's storage

/** The browser's storage, which may be closed to us. */
function stored(act) {
  try {
    return act(window.localStorage);
  } catch {
    return null;
  }
}

const keyOf = (what, name) => `${KEPT}${what}:${name}`;

/** The unsaved texts that this browser keeps, as [what, name]. */
export function unsavedTexts() {
  const keys = stored((store) => Object.keys(store)) ?? [];
  return keys.filter((key) => key.startsWith(KEPT)).map((key) => key.slice(KEPT.length).split(/:(.*)/s));
}

/** Throw an unsaved text away. */
export const forgetText = (what, name) => stored((store) => store.removeItem(keyOf(what, name)));

/** The editor: {node, update(editor), end()}; `send` takes the messages to the desk. */
export function textEditor(send) {
  const state = { copy: 0, timer: 0, lines: 0, given: null, naming: false };
  const title = element("h2", { class: "te-title" });
  const mark = element("span", { class: "te-mark" });
  const gutter = element("div", { class: "te-gutter", "aria-hidden": "true" });
  const area = element("textarea", {
    class: "te-text",
    wrap: "off",
    spellcheck: "false",
    autocomplete: "off",
    autocapitalize: "off",
    rows: 16,
  });
  const told = element("p", { class: "te-told", role: "status" });
  const go = element("button", { class: "tr-plain", onclick: () => toLine() }, "Go to the line");
  const button = (text, onclick) => element("button", { class: "tr-button", onclick }, text);
  const save = button("Save", () => {
    name(false);
    write();
  });
  const saveAs = button("Save as …", () => name(!state.naming));
  const revert = button("Revert", () => {
    forgetText(state.given.what, state.given.name);
    send({ do: "revert", what: state.given.what });
  });
  const overwrite = button("Overwrite", () => write({ overwrite: true }));
  const close = button("Close", () => {
    node.hidden = true;
    state.closed = true;
  });
  const newName = element("input", { type: "text", "aria-label": "Name of the new file in the folder" });
  const naming = element(
    "form",
    {
      class: "te-naming",
      hidden: true,
      onsubmit: (event) => {
        event.preventDefault();
        write();
      },
    },
    element("label", {}, "File in the folder ", newName),
    element("button", { type: "submit", class: "tr-button" }, "Save there"),
  );
  const node = element(
    "section",
    { class: "tr-editor", hidden: true, "aria-label": "Text editor" },
    element("div", { class: "te-head" }, title, mark, close),
    element("div", { class: "te-body" }, gutter, area),
    element("div", { class: "te-foot" }, told, go),
    element("div", { class: "te-buttons" }, save, saveAs, revert, overwrite),
    naming,
  );

  function name(open) {
    state.naming = open;
    naming.hidden = !open;
    if (!open) return;
    if (newName.value === "")
      newName.value = state.given.own ? "" : `my-${state.given.name.replace(/\.toml$/, "")}.toml`;
    newName.focus();
  }

  /** Save: what was typed last goes first. */
  function write(more = {}) {
    tell();
    const message = { do: "save", what: state.given.what, ...more };
    if (state.naming) {
      const wanted = newName.value.trim();
      message.name = wanted.toLowerCase().endsWith(".toml") ? wanted : `${wanted}.toml`;
    }
    send(message);
  }

  const tell = () => {
    clearTimeout(state.timer);
    state.timer = 0;
    send({ do: "text", what: state.given.what, text: area.value });
  };

  function toLine() {
    const { line } = state.given;
    const before = area.value.split("\n").slice(0, line - 1);
    const from = before.reduce((sum, each) => sum + each.length + 1, 0);
    area.focus();
    area.setSelectionRange(from, from + (area.value.split("\n")[line - 1] ?? "").length);
    area.scrollTop = (line - 4) * (area.scrollHeight / Math.max(1, state.lines));
  }

  function number() {
    const count = area.value.split("\n").length,
      wrong = state.given?.line ?? 0;
    if (count !== state.lines || wrong !== state.wrong) {
      const line = (k) => element("span", k === wrong ? { class: "te-wrong" } : {}, String(k));
      gutter.replaceChildren(...Array.from({ length: count }, (_, k) => line(k + 1)));
      Object.assign(state, { lines: count, wrong });
    }
    gutter.scrollTop = area.scrollTop;
  }

  area.addEventListener("scroll", () => (gutter.scrollTop = area.scrollTop));
  area.addEventListener("input", () => {
    const { what, name: file, text } = state.given;
    if (area.value === text) forgetText(what, file);
    else stored((store) => store.setItem(keyOf(what, file), JSON.stringify({ base: text, text: area.value })));
    number();
    say(mark, "edited");
    clearTimeout(state.timer);
    state.timer = setTimeout(tell, PAUSE);
  });

  /** Show another text, or what is said of this one. */
  function update(editor) {
    if (editor === null) {
      node.hidden = true;
      state.given = null;
      state.copy = 0;
      return;
    }
    const fresh = editor.copy !== state.copy || editor.what !== state.given?.what;
    const renamed = state.given !== null && state.given.name !== editor.name;
    if (!fresh && editor.own && (editor.saved || renamed)) {
      forgetText(editor.what, editor.name);
      forgetText(state.given.what, state.given.name);
      name(false);
      newName.value = "";
    }
    state.given = editor;
    if (fresh) {
      state.copy = editor.copy;
      node.hidden = false;
      area.value = editor.text;
      takeUp();
      area.scrollTop = 0;
    }
    say(title, `${editor.what === "robot" ? "Robot" : "Scenario"} ${editor.name}`);
    put(area, {
      "aria-label": `Text of the ${editor.what} ${editor.name}`,
      "aria-invalid": editor.message ? "true" : null,
    });
    const edited = area.value !== editor.text;
    say(mark, edited ? "edited" : editor.own ? "saved" : "not in this folder");
    const words = [editor.asks, editor.message || (edited ? "The text is valid; it is tried as it stands here." : "")];
    say(told, words.filter(Boolean).join(" "));
    put(told, { class: editor.message || editor.asks ? "te-told te-fault" : "te-told" });
    go.hidden = !editor.message || editor.line === null;
    overwrite.hidden = !editor.asks;
    revert.disabled = !edited;
    save.hidden = !editor.own;
    save.disabled = !edited && !editor.asks;
    number();
  }

  /** Put the text in that was typed here and never saved, if the file is still the one that it was made of. */
  function takeUp() {
    const { what, name: file, text } = state.given;
    const draft = stored((store) => JSON.parse(store.getItem(keyOf(what, file))));
    if (draft?.base !== text || draft.text === text) return;
    area.value = draft.text;
    tell();
  }

  return { node, update, open: () => (node.hidden = false), end: () => clearTimeout(state.timer) };
}
