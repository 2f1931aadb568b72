// Asks a person for the server's token.

import { setToken } from "/api.js";

const dialog = document.getElementById("login");
const input = document.getElementById("login-token");
const error = document.getElementById("login-error");

// `why`: what the server said; calls `done` once there is another token.
export function askToken(why, done) {
  if (dialog.open) {
    return;
  }
  // The first time nobody has given a wrong one.
  error.hidden = !/wrong/.test(why);
  error.textContent = "That token is not the server's.";
  input.setAttribute("aria-invalid", String(!error.hidden));
  input.value = "";
  dialog.onsubmit = (event) => {
    event.preventDefault();
    const token = input.value.trim();
    if (/^[A-Za-z0-9\-._~+]{16,128}$/.test(token)) {
      setToken(token);
      dialog.close();
      done();
    } else {
      error.textContent =
        "A token has 16 to 128 letters, digits and - . _ ~ +";
      error.hidden = false;
      input.setAttribute("aria-invalid", "true");
    }
  };
  dialog.oncancel = (event) => event.preventDefault();
  dialog.showModal();
  input.focus();
}
