// Light or dark: as the address says, as a person chose here, as the system is.
// Before anything is drawn, so that nothing flashes.

const KEY = "pelagos-theme";
const system = matchMedia("(prefers-color-scheme: light)");
const given = new URLSearchParams(location.search).get("theme");

export const chosenTheme = () => localStorage.getItem(KEY) ?? "system";

export function showTheme() {
  const chosen = ["dark", "light"].includes(given) ? given : chosenTheme();
  const theme = chosen !== "system" ? chosen : system.matches ? "light" : "dark";
  document.documentElement.dataset.theme = theme;
  document.querySelector("meta[name=theme-color]").content =
    theme === "light" ? "#e9f1f5" : "#0a1722";
}

export function chooseTheme(theme) {
  localStorage.setItem(KEY, theme);
  showTheme();
}

system.addEventListener("change", showTheme);
showTheme();
