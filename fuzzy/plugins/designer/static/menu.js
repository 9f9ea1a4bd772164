// A button that opens a menu; pointer and keys as every menu has them.
import { element, put } from "./chart.js";

let count = 0; // ids must differ on a page

/**
 * A menu under a button: {node, button, end}. `entries` are [text, act]; `upwards`: it opens above the button.
 */
export function menuOf(label, entries, kind = "", upwards = false) {
  const id = `shell-menu-${++count}`;
  const menu = element("div", { role: "menu", id, "aria-label": label, hidden: true });
  const button = element(
    "button",
    { class: kind, "aria-haspopup": "menu", "aria-expanded": "false", "aria-controls": id },
    `${label} ${upwards ? "▴" : "▾"}`,
  );
  const node = element("span", { class: upwards ? "menu upwards" : "menu" }, button, menu);
  for (const [text, act] of entries) {
    menu.append(element("button", { role: "menuitem", tabindex: "-1", onclick: () => (toggle(false), act()) }, text));
  }
  function toggle(open) {
    menu.hidden = !open;
    put(button, { "aria-expanded": String(open) });
    if (open) menu.firstChild.focus();
    else if (menu.contains(document.activeElement)) button.focus();
  }
  button.addEventListener("click", () => toggle(menu.hidden));
  button.addEventListener("keydown", (event) => {
    if (event.key === "ArrowDown") (event.preventDefault(), toggle(true));
  });
  menu.addEventListener("keydown", (event) => {
    const all = [...menu.children],
      at = all.indexOf(document.activeElement);
    const to = {
      ArrowDown: (at + 1) % all.length,
      ArrowUp: (at + all.length - 1) % all.length,
      Home: 0,
      End: all.length - 1,
    }[event.key];
    if (to !== undefined) (event.preventDefault(), all[to].focus());
    else if (event.key === "Escape") (event.preventDefault(), event.stopPropagation(), toggle(false));
    else if (event.key === "Tab") toggle(false);
  });
  const onOutside = (event) => {
    if (!menu.hidden && !node.contains(event.target)) toggle(false);
  };
  document.addEventListener("pointerdown", onOutside);
  return { node, button, end: () => document.removeEventListener("pointerdown", onOutside) };
}
