// Films play while a mouse points at them; a tap, a click, Enter or the space bar starts and stops
// them. Without this script they have the browser's buttons, which cover a third of so small a film.
document.addEventListener("DOMContentLoaded", () => {
  for (const film of document.querySelectorAll(".task video")) {
    const play = () => film.play().catch(() => {}); // a pause before it began is no fault
    const turn = () => (film.paused ? play() : film.pause());
    film.removeAttribute("controls");
    film.tabIndex = 0;
    film.addEventListener("pointerenter", (event) => event.pointerType === "mouse" && play());
    film.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && film.pause());
    film.addEventListener("click", turn);
    film.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      turn();
    });
  }
});
