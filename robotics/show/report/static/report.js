// What report.html.j2 and paper.html.j2 do: enlarge a figure, open what is folded, fold the contents on narrow screens.

const enlarged = document.getElementById("enlarged");
addEventListener("click", (event) => {
  const picture = event.target.closest?.(".enlarge")?.querySelector("img");
  if (picture) {
    const copy = picture.cloneNode();
    copy.loading = "eager";
    enlarged.querySelector(".scroll").replaceChildren(copy);
    enlarged.showModal();
  } else if (event.target === enlarged) {
    enlarged.close();
  }
});

// A link leads into folded parts too
function openTarget() {
  const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  const inside = target.querySelector(":scope > details");
  if (inside) inside.open = true;
  for (let at = target.closest("details"); at; at = at.parentElement.closest("details")) at.open = true;
  target.scrollIntoView();
}
addEventListener("hashchange", openTarget);
openTarget();

const contents = document.querySelector(".contents > details");
const wide = matchMedia("(min-width: 75rem)");
const fold = () => {
  contents.open = wide.matches;
};
wide.addEventListener("change", fold);
fold();
contents.addEventListener("click", (event) => {
  if (event.target.closest("a") && !wide.matches) contents.open = false;
});

// On paper everything is open but the players
let opened = [];
addEventListener("beforeprint", () => {
  opened = [...document.querySelectorAll("details:not([open]):not(.film)")];
  for (const details of opened) details.open = true;
});
addEventListener("afterprint", () => {
  for (const details of opened) details.open = false;
});
