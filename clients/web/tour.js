// The page in three steps, for a first visit: a strip above the pictures that
// takes no focus and covers nothing; once it is gone, this browser does not
// show it again, unless it is asked for.

const KEY = "pelagos-tour";
const STEPS = [
  ["Look around", "Drag a picture, or use the arrow keys when it is chosen; " +
    "Ctrl and the wheel, or + and −, zoom. F fills the screen, where the " +
    "wheel zooms alone.", "#views"],
  ["Change the sea", "Beside the pictures: scenes and presets, wind, weather, " +
    "time of day. The picture follows at once, for everybody who watches.",
  "#aside"],
  ["Put ships on it", "On the plan, choose a shape, press “Add by a click”, and " +
    "click its place. P makes the plan large.", "#plan-box", "#add"],
];

let strip = null;

function step(index) {
  const [title, text, target, needed] = STEPS[index];
  strip.querySelector(".tour-count").textContent =
    `${index + 1} of ${STEPS.length}`;
  strip.querySelector("strong").textContent = title;
  strip.querySelector(".tour-text").textContent = text;
  strip.querySelector("[data-to=back]").disabled = index === 0;
  strip.querySelector("[data-to=next]").textContent =
    index + 1 < STEPS.length ? "Next" : "Done";
  document.querySelectorAll(".tour-target").forEach((node) =>
    node.classList.remove("tour-target"));
  document.querySelector(target)?.classList.add("tour-target");
  strip.dataset.step = index;
  if (needed) { // below the fold of a small window
    document.querySelector(needed)?.scrollIntoView({ block: "nearest" });
  }
}

function end() {
  localStorage.setItem(KEY, "seen");
  document.querySelectorAll(".tour-target").forEach((node) =>
    node.classList.remove("tour-target"));
  const within = strip.contains(document.activeElement);
  strip.remove();
  strip = null;
  removeEventListener("keydown", onKey, true);
  if (within) {
    document.querySelector(".tile")?.focus({ preventScroll: true });
  }
}

// Escape ends it from anywhere but where it has another meaning.
function onKey(event) {
  const open = document.fullscreenElement ||
    document.querySelector(".tile.filled, dialog[open]") ||
    event.target.closest?.("input, select, textarea, canvas");
  if (event.key === "Escape" && !open) {
    event.stopPropagation();
    end();
  }
}

export function showTour(again = false) {
  if (strip || (!again && localStorage.getItem(KEY))) {
    return;
  }
  strip = document.createElement("section");
  strip.id = "tour";
  strip.className = "tour";
  strip.setAttribute("aria-label", "Introduction");
  strip.innerHTML = `<span class="tour-count"></span>
    <p aria-live="polite"><strong></strong> <span class="tour-text"></span></p>
    <span class="tour-buttons">
      <button class="button" type="button" data-to="back">Back</button>
      <button class="button" type="button" data-to="next"></button>
      <button class="button" type="button" data-to="end"
              title="Do not show this again (Esc)">Skip</button></span>`;
  strip.addEventListener("click", (event) => {
    const { to } = event.target.dataset;
    const at = Number(strip.dataset.step);
    if (to === "end" || (to === "next" && at + 1 === STEPS.length)) {
      end();
    } else if (to) {
      step(at + (to === "next" ? 1 : -1));
    }
  });
  addEventListener("keydown", onKey, true);
  document.querySelector(".deck").before(strip);
  step(0);
  if (again) {
    strip.querySelector("[data-to=next]").focus();
  }
}
