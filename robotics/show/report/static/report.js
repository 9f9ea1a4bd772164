// What the pages of a report do: enlarge a figure, turn pages, open what is folded, fold the contents where it is narrow.

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

// One page is in sight, and the search of the browser looks into all. Without scripts, and on paper, all are there.
const pages = [...document.querySelectorAll("main > article")],
  heading = document.title;
function turnTo(page) {
  for (const each of pages) {
    if (each === page) each.removeAttribute("hidden");
    else each.setAttribute("hidden", "until-found");
  }
  const inside = (link) => page.matches(link.hash) || page.querySelector(link.hash);
  for (const link of document.querySelectorAll(".contents a"))
    if (inside(link)) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  const title = page !== pages[0] && page.querySelector("h2");
  document.title = title ? `${title.textContent} · ${heading}` : heading;
}
for (const each of pages) each.addEventListener("beforematch", () => turnTo(each));
if (pages.length) turnTo(pages[0]);

// A link leads into other pages and into folded parts
function openTarget() {
  const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const page = target ? target.closest("main > article") : pages[0];
  if (page) turnTo(page);
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
