// A small picture of the view that was last looked at, under what is being edited on a narrow screen: a copy of the
// element that a view marks with data-glance, made anew whenever that one is drawn. The style sheet shows it.
import { element, framed, put, say } from "./chart.js";

const TALL = 150; // px of the picture

/** A copy of what is drawn: an SVG as it is, with names of its own, and a canvas by its pixels. */
function copied(marked) {
  const all = (node) => [node, ...node.querySelectorAll("*")];
  const copy = marked.cloneNode(true),
    drawn = all(marked);
  for (const [k, node] of all(copy).entries()) {
    if (node.localName === "canvas" && node.width) node.getContext("2d").drawImage(drawn[k], 0, 0);
    for (const { name, value } of [...node.attributes])
      if (name === "id") node.id = `${value}-glance`;
      else if (value.startsWith("url(#")) node.setAttribute(name, value.replace(")", "-glance)"));
  }
  copy.removeAttribute("data-glance");
  return copy;
}

export function render({ el }) {
  const picture = element("div", { class: "shell-glance-picture", inert: true });
  const title = element("span", {});
  const fold = element("button", { "aria-expanded": "true", onclick: () => show(picture.hidden) });
  const go = element("button", { onclick: () => view()?.scrollIntoView({ block: "start" }) }, "Go there");
  const root = element(
    "div",
    { class: "shell-glance-box" },
    element("div", { class: "shell-glance-bar" }, title, go, fold),
    picture,
  );
  el.append(root);
  const look = [...document.querySelectorAll(".shell-group")].at(-1); // the views stand behind the editors
  const view = () => look?.querySelector(".shell-view.shell-shown");
  let shown = el.getClientRects().length > 0; // asked anew when its size changes: asking lays the whole page out
  const marked = () =>
    [...(view()?.querySelectorAll("[data-glance]") ?? [])].find((node) => node.getClientRects().length);

  function show(on) {
    picture.hidden = !on;
    put(fold, { "aria-expanded": String(on) });
    say(fold, on ? "Hide" : "Show");
    paint();
  }
  function paint() {
    if (!shown) return; // the screen is wide
    const source = marked(),
      name = look?.querySelector("[role=tab][aria-selected=true]")?.textContent ?? "";
    say(title, name);
    root.hidden = !source;
    if (picture.hidden || !source) return;
    const { width, height } = source.getBoundingClientRect();
    if (!width || !height) return;
    const share = Math.min(TALL / height, picture.clientWidth / width),
      copy = copied(source);
    Object.assign(copy.style, { width: `${width}px`, height: `${height}px` });
    // What it looks like stands under the classes of its module.
    const frame = element("div", { class: source.closest(".fd, .fleet-player")?.className ?? "" }, copy);
    Object.assign(frame.style, {
      position: "absolute",
      left: `${(picture.clientWidth - share * width) / 2}px`,
      top: 0,
      width: `${width}px`,
      transform: `scale(${share})`,
      transformOrigin: "0 0",
    });
    picture.style.height = `${share * height}px`;
    picture.replaceChildren(frame);
  }

  const { soon, end } = framed(paint);
  const changes = new MutationObserver(() => shown && soon()),
    sizes = new ResizeObserver(([{ contentRect }]) => {
      shown = contentRect.width > 0;
      soon();
    });
  if (look) changes.observe(look, { subtree: true, childList: true, attributes: true, characterData: true });
  sizes.observe(el);
  // A canvas changes without an event; while something is played or turned it is looked at ten times a second.
  const ticking = setInterval(() => shown && marked()?.matches("canvas, :has(canvas)") && soon(), 100);
  show(true);
  return () => {
    end();
    clearInterval(ticking);
    changes.disconnect();
    sizes.disconnect();
    root.remove();
  };
}

export default { render };
