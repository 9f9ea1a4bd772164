// Data: a table of measured rows beside the design. From what fuzzy/plugins/designer/datapanel.py hands over.
import { element, keepDrawn, offer, say } from "./chart.js";
import { dataPictures } from "./datapictures.js";
import { columnField, described, fillColumns, tableFields } from "./datasource.js";
import { field, formStyled, group, panelForm } from "./form.js";
import { settingsSheet } from "./settings.js";

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
export async function render({ model, el }) {
  await formStyled(import.meta.url, "./datapictures.css");
  const mapping = element("div", { class: "pn-columns" });
  const form = panelForm(model, (note) => data.after(note), { columns: mapping }),
    { get, send, choose } = form;
  const { row, file, about, skip } = tableFields(
    form,
    "File of the folder",
    (name) => name && send({ do: "file", name }),
    () => ({ largest: get("largest"), larger: "use fuzzy evaluate for large tables" }),
  );
  const along = form.list("Time", "along"),
    alongField = field("Time", along);
  const data = group("Data", row, about, mapping, skip.node);
  const drawn = dataPictures({
    look: (row) => send({ do: "look", row }),
    output: (number) => choose("output", number),
  });
  const settings = settingsSheet([data]);
  const root = element("div", { class: "fd fd-panel fd-form fd-data" }, settings.node, form.note, drawn.node);
  let had = false; // a table
  settings.show(true);
  el.append(root);

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
    settings.words([table ? about.textContent : "Choose a table of measured rows"]);
    if (table && !had) settings.show(false); // its pictures are seen at once
    had = Boolean(table);
    mapping.hidden = !table;
    skip.show(get("lack"), choice.skip_bad);
    form.drawProblem();
    if (!table) return;
    const names = table.columns.map((c) => [c.name, described(c)]);
    const react = (name, value) => send({ do: "column", name, value });
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

  return keepDrawn(model, NAMES, root, draw, settings.end);
}

export default { render };
