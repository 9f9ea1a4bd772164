// The pictures and tables that are in sight, each to be saved as it looks (SVG, PDF, PNG) or copied as numbers. Model:
// "stem", with which the files' names begin.
import { element, numbersOf, put } from "./chart.js";

const DENSITY = 3; // pixels of a PNG for one of the screen
const LOOKS = [
  "fill",
  "fill-opacity",
  "stroke",
  "stroke-width",
  "stroke-opacity",
  "stroke-dasharray",
  "stroke-linecap",
  "stroke-linejoin",
  "opacity",
  "display",
  "visibility",
  "font-family",
  "font-size",
  "font-weight",
  "text-anchor",
  "dominant-baseline",
];

/** A drawing as an SVG file: with the looks that style sheets give it, on the paper of the page. */
function fileOf(svg) {
  const { width, height } = svg.getBoundingClientRect(),
    copy = svg.cloneNode(true);
  const pairs = [
    [svg, copy],
    ...[...svg.querySelectorAll("*")].map((node, k) => [node, copy.querySelectorAll("*")[k]]),
  ];
  for (const [node, twin] of pairs) {
    const looks = getComputedStyle(node);
    twin.setAttribute("style", LOOKS.map((name) => `${name}: ${looks.getPropertyValue(name)}`).join("; "));
  }
  put(copy, { xmlns: "http://www.w3.org/2000/svg", width, height });
  if (!copy.hasAttribute("viewBox")) copy.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const [x, y, w, h] = copy.getAttribute("viewBox").split(/[\s,]+/);
  const paper = document.createElementNS("http://www.w3.org/2000/svg", "rect");
  put(paper, { x, y, width: w, height: h, fill: getComputedStyle(document.body).backgroundColor });
  copy.prepend(paper);
  return { copy, text: new XMLSerializer().serializeToString(copy), width, height };
}

async function pngOf(svg) {
  const { text, width, height } = fileOf(svg),
    image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await image.decode();
  const canvas = element("canvas", { width: Math.round(DENSITY * width), height: Math.round(DENSITY * height) });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}

/** Print a drawing alone, on a page of its size: the browser's dialog saves it as PDF, in which lines stay lines. */
function printed(svg) {
  const { copy, width, height } = fileOf(svg),
    page = element("div", { class: "shell-printed" }, copy),
    sheet = element("style");
  sheet.textContent = `@media print { @page { size: ${width}px ${height + 1}px; margin: 0 } }`;
  document.body.append(page, sheet);
  window.addEventListener("afterprint", () => [page, sheet].forEach((node) => node.remove()), { once: true });
  window.print();
}

/** Numbers as a text for a spreadsheet: [[name, ...values], ...] by columns. */
function tabled(columns) {
  const rows = Math.max(...columns.map((column) => column.length));
  return Array.from({ length: rows }, (_, k) => columns.map((column) => column[k] ?? "").join("\t")).join("\n");
}
const rowsOf = (table) =>
  [...table.rows].map((row) => [...row.cells].map((cell) => cell.innerText.replace(/\s+/g, " ").trim()).join("\t"));

function save(blob, name) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export function render({ model, el }) {
  const button = element("button", { "aria-haspopup": "dialog", onclick: open }, "Pictures …");
  const root = element("div", { class: "shell-pictures-root" }, button);
  el.append(root);
  const told = element("span", { role: "status" });

  const seen = (node) => node.getClientRects().length > 0;
  const named = (node) => node.getAttribute("aria-label") ?? node.caption?.textContent ?? "Table";
  function found() {
    const among = [...document.querySelectorAll(".shell-view.shell-shown, .shell-why")];
    const all = (what) => among.flatMap((place) => [...place.querySelectorAll(what)]).filter(seen);
    const drawn = all("svg[aria-label]").filter((svg) => svg.getBoundingClientRect().height > 60);
    return [...drawn, ...all("table")];
  }
  const file = (name, ending) => {
    const words = name.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-");
    return `${model.get("stem")}-${words.slice(0, 40).replace(/^-|-$/g, "")}.${ending}`;
  };
  async function copied(text) {
    try {
      await navigator.clipboard.writeText(text);
      told.textContent = "The numbers are on the clipboard.";
    } catch {
      save(new Blob([text], { type: "text/tab-separated-values" }), file("numbers", "tsv"));
      told.textContent = "The numbers are saved: this browser gives no clipboard.";
    }
  }
  function line(node) {
    const name = named(node),
      act = (words, what) => element("button", { "aria-label": `${words}: ${name}`, onclick: what }, words);
    const acts = [];
    if (node.localName === "svg") {
      const svg = () => save(new Blob([fileOf(node).text], { type: "image/svg+xml" }), file(name, "svg"));
      acts.push(
        act("SVG", svg),
        act("PDF …", () => printed(node)),
        act("PNG", async () => save(await pngOf(node), file(name, "png"))),
      );
      if (numbersOf.has(node)) acts.push(act("Copy the numbers", () => copied(tabled(numbersOf.get(node)))));
    } else acts.push(act("Copy the numbers", () => copied(rowsOf(node).join("\n"))));
    return element("li", {}, element("span", {}, name), element("span", { class: "shell-pictures-acts" }, ...acts));
  }
  function open() {
    const box = element("dialog", { class: "shell-pictures", "aria-label": "Pictures and tables in sight" });
    const close = element("button", { onclick: () => box.close() }, "Close");
    told.textContent = "";
    const note = "PDF opens the browser's printing: choose to save. File, Export a figure draws for a paper.";
    box.replaceChildren(
      element("h2", {}, "Pictures and tables in sight"),
      element("ul", {}, ...found().map(line)),
      element("p", { class: "note" }, note),
      element("div", { class: "buttons" }, told, close),
    );
    box.addEventListener("close", () => box.remove());
    root.append(box);
    box.showModal();
  }
  return () => root.remove();
}

export default { render };
