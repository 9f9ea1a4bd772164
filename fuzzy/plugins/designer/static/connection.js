// While the server does not answer, the page takes no edits, which it would lose, and says so.

const SENTENCE =
  "The designer's server does not answer. Nothing can be edited until it is back; then this page goes on by itself.";

/** Watch NiceGUI's own notice of a lost connection, in whose place this stands. Gives what ends the watching. */
export function watchConnection() {
  const notice = document.getElementById("popup"),
    shell = document.querySelector(".shell"),
    told = document.createElement("p");
  if (!notice || !shell) return () => {};
  told.className = "shell-lost";
  told.setAttribute("role", "alert");
  document.body.append(told);
  let focused = null;
  const show = () => {
    const lost = notice.getAttribute("aria-hidden") === "false";
    if (lost === shell.inert) return;
    if (lost) focused = document.activeElement;
    shell.inert = lost;
    told.textContent = lost ? SENTENCE : "";
    if (!lost) focused?.focus();
  };
  const watching = new MutationObserver(show);
  watching.observe(notice, { attributes: true });
  show();
  return () => {
    watching.disconnect();
    told.remove();
  };
}
