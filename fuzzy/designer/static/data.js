// Data: a table of measured rows beside the design. From what fuzzy/designer/datapanel.py hands over.
import { choices, element, keepDrawn, offer, say, sayUnder, styled } from "./chart.js";
import { dataPictures } from "./datapictures.js";
import { columnField, described, field, fillColumns, omission, uploadField } from "./datasource.js";

const SHEETS = ["panel", "form", "datapictures"].map((name) => new URL(`./${name}.css`, import.meta.url).href);
const NAMES = [
  "sources",
  "table",
  "columns",
  "choice",
  "variables",
  "lack",
  "problem",
  "pictures",
  "points",
  "residual",
  "terms",
];
const FILE = "File of the folder",
  UPLOAD = "or upload a CSV file";

export async function render({ model, el }) {
  await styled(...SHEETS);
  const get = (name) => model.get(name) ?? null;
  const choose = (name, value) => model.send({ do: "choose", name, value });
  let refused = null; // what this side refuses: { message, field }

  const file = choices(FILE, [], "", (name) => name && model.send({ do: "file", name }));
  const upload = uploadField(
    UPLOAD,
    () => ({ largest: get("largest"), larger: "use fuzzy evaluate for large tables" }),
    (piece) => model.send(piece),
    (text) => {
      refused = text ? { message: text, field: "piece" } : null;
      drawProblem();
    },
  );
  const about = element("p", { class: "pn-note" }),
    mapping = element("div", { class: "pn-columns" });
  const along = choices("Time", [], "", (value) => choose("along", value)),
    alongField = field("Time", along);
  const skip = omission((on) => choose("skip_bad", on));
  const problem = element("p", { class: "pn-problem", role: "alert", hidden: true });
  const fields = { file, piece: upload, along, skip_bad: skip.input };
  const data = element(
    "fieldset",
    {},
    element("legend", {}, "Data"),
    element("div", { class: "pn-row" }, field(FILE, file), field(UPLOAD, upload)),
    about,
    mapping,
    skip.node,
  );
  const drawn = dataPictures({
    look: (row) => model.send({ do: "look", row }),
    output: (number) => choose("output", number),
  });
  const root = element("div", { class: "fd fd-panel fd-form fd-data" }, problem, data, drawn.node);
  el.append(root);

  function drawProblem() {
    const { message = "", field: at = null, column = null } = refused ?? get("problem") ?? {};
    const of = column === null ? fields[at] : [...mapping.querySelectorAll("select")].find((s) => s.name === column);
    sayUnder(problem, message, of, (note) => data.after(note));
  }

  function drawForm() {
    const table = get("table"),
      choice = get("choice"),
      columns = get("columns"),
      variables = get("variables");
    offer(file, [["", "choose …"], ...get("sources").map((name) => [name, name])], file.value);
    if (table && get("sources").includes(table.name)) file.value = table.name;
    say(
      about,
      table
        ? `${table.name}: ${table.rows} rows, ${table.columns.length} columns`
        : 'One row per sample below a header such as "speed [m/s]"; columns are found by the names of the variables. Outputs may be absent.',
    );
    mapping.hidden = !table;
    skip.show(get("lack"), choice.skip_bad);
    drawProblem();
    if (!table) return;
    const names = table.columns.map((c) => [c.name, described(c)]);
    const react = (name, value) => model.send({ do: "column", name, value });
    fillColumns(mapping, JSON.stringify([table, columns, variables]), () => [
      ...variables.map(({ key, kind, name }) =>
        columnField(key, `${name} (${kind})`, "its column", [["", "none"], ...names], columns[key] ?? "", react),
      ),
      alongField,
    ]);
    offer(along, [["", "number of the row"], ...names], choice.along);
  }

  function draw() {
    drawForm();
    const table = get("table"),
      choice = get("choice"),
      columns = get("columns"),
      variables = get("variables");
    const time = table?.columns.find(({ name }) => name === choice.along);
    const outputs = variables.filter(({ kind }) => kind === "output");
    drawn.draw({
      pictures: get("pictures"),
      points: get("points"),
      residual: get("residual"),
      terms: get("terms"),
      along: time ?? { name: "number of the row", unit: "" },
      outputs: outputs.map(({ name }, n) => [n, name]).filter(([n]) => columns[outputs[n].key]),
      looks: true,
    });
  }

  return keepDrawn(model, NAMES, root, draw);
}

export default { render };
