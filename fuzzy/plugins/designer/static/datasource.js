// What panels that begin with a table share: an upload, which column is which, and rows that are left out.
import { choices, element, labelled, put, said, say } from "./chart.js";
import { field, row } from "./form.js";

const UPLOAD = "or upload a CSV file";
const PIECE = 200_000; // characters of an upload that travel together

/** The text of a file: UTF-8, or UTF-16 with a byte order mark. Throws where it is neither. */
async function textOf(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const [a, b] = bytes;
  const kind = a === 0xff && b === 0xfe ? "utf-16le" : a === 0xfe && b === 0xff ? "utf-16be" : "utf-8";
  return new TextDecoder(kind, { fatal: true }).decode(bytes);
}

/**
 * A field for a file that is sent in pieces: send({do: "piece", ...}). `limits()` gives {largest, larger}: bytes, and
 * what to do with more; `fail(sentence)` hears of a file that is refused here, `fail("")` that another one was chosen.
 */
function uploadField(label, limits, send, fail) {
  const upload = element("input", { type: "file", accept: ".csv,text/csv,text/plain", "aria-label": label });
  upload.addEventListener("change", async () => {
    const chosen = upload.files[0];
    if (!chosen) return;
    fail("");
    const { largest, larger } = limits();
    if (chosen.size > largest) {
      fail(`${chosen.name} is larger than ${largest / 1e6} MB; ${larger}`);
      return;
    }
    let text;
    try {
      text = await textOf(chosen);
    } catch {
      fail(`${chosen.name} is not text in UTF-8; save it as UTF-8, in Excel as CSV UTF-8`);
      return;
    }
    for (let at = 0, n = 0; at === 0 || at < text.length; at += PIECE, n++) {
      send({
        do: "piece",
        name: chosen.name,
        number: n,
        text: text.slice(at, at + PIECE),
        last: at + PIECE >= text.length,
      });
    }
    upload.value = "";
  });
  return upload;
}

/** A column as it is chosen: its name with the unit, and its range. */
export const described = (column) =>
  `${labelled(column)}, ${column.low === null ? "no numbers" : `${said(column.low, 3)} to ${said(column.high, 3)}`}`;

/** A list to choose for `name`. What is heard begins with what is read, so that it can be said too. */
export function columnField(name, text, what, options, chosen, react) {
  const select = choices(`${text}: ${what}`, options, chosen, (value) => react(name, value));
  return field(text, Object.assign(select, { name }));
}

/** Put other fields into the box of columns where `key` is another one; the list with the focus keeps it. */
export function fillColumns(box, key, make) {
  if (box.dataset.key === key) return;
  const focused = [...box.querySelectorAll("select")].indexOf(document.activeElement);
  box.dataset.key = key;
  box.replaceChildren(...make());
  if (focused >= 0) box.querySelectorAll("select")[focused]?.focus();
}

/** A box to tick that leaves out rows: {node, input, show(sentence, on)}; react(on). */
function omission(react) {
  const input = element("input", { type: "checkbox", onchange: () => react(input.checked) }),
    words = element("span"),
    node = element("label", { class: "pn-lack", hidden: true }, input, words);
  return {
    node,
    input,
    show(sentence, on) {
      node.hidden = !sentence;
      input.checked = on;
      say(words, `Leave out rows: ${sentence}`);
      put(input, { "aria-label": words.textContent });
    },
  };
}

/**
 * Where the table of a form comes from, called `label`, and rows that are left out: {row, file, about, skip}. take(value)
 * does what was chosen of the list `file`; `limits()` are those of an upload.
 */
export function tableFields(form, label, take, limits) {
  const file = choices(label, [], "", take),
    upload = uploadField(UPLOAD, limits, form.send, (text) => form.refuse(text, upload)),
    skip = omission((on) => form.choose("skip_bad", on));
  Object.assign(form.fields, { file, generate: file, piece: upload, skip_bad: skip.input });
  return { row: row(field(label, file), field(UPLOAD, upload)), file, about: element("p", { class: "pn-note" }), skip };
}
