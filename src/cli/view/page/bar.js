/* The bar at the top: methods, what is shown, undo, pause, theme, panels. */

import { find, make } from "./dom.js";
import { canRedo, canUndo, redo, undo } from "./edit.js";
import { send } from "./link.js";
import { display, emit, isPhoto, methodShown, on, state } from "./state.js";

/* Asks the server for another view, and takes it for granted. */
export const changeView = changes => {
  Object.assign(state.view, changes);
  send({ type: "view", ...changes });
  emit("view");
};

/* Methods in the order of the keys 1 to 9. */
export const methodNames = () => (state.welcome?.methods ?? []).map(({ name }) => name);

export const chooseMethod = name => {
  if (name !== undefined && name !== state.view.method && !isPhoto()) changeView({ method: name });
};

export const setCompare = compare => {
  if (isPhoto()) return;
  changeView({ compare });
  if (!compare && state.display.mode !== "method") display({ mode: "method" });
};

/* A mode that needs the image of path starts it; a photograph is there. */
export const setMode = mode => {
  if (mode !== "method" && !state.view.compare && !isPhoto()) setCompare(true);
  display({ mode });
};

export const togglePause = () => changeView({ paused: !state.view.paused });

/* ---- theme and panels, kept in this browser ---- */

const THEMES = ["system", "dark", "light"];
const keep = (key, value) => {
  try {
    localStorage.setItem(`tyndall.${key}`, value);
  } catch { /* a browser that keeps nothing */ }
};
const kept = key => {
  try {
    return localStorage.getItem(`tyndall.${key}`);
  } catch {
    return null;
  }
};

export const setTheme = theme => {
  if (theme === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  find("#theme").title = `Theme: ${theme} (T)`;
  keep("theme", theme);
  emit("theme");
};
const themeNow = () => document.documentElement.dataset.theme ?? "system";
export const nextTheme = () => setTheme(THEMES[(THEMES.indexOf(themeNow()) + 1) % THEMES.length]);

export const showPanels = shown => {
  document.body.classList.toggle("bare", !shown);
  find("#hide").setAttribute("aria-pressed", shown);
  keep("panels", shown ? "1" : "0");
};
export const togglePanels = () => showPanels(document.body.classList.contains("bare"));

/* ---- the buttons ---- */

/* Of a group of radio buttons one is reached by Tab, the others by arrows. */
const check = (group, chosen) => {
  const buttons = [...group.querySelectorAll("button")], any = buttons.some(chosen);
  buttons.forEach((button, i) => {
    const checked = chosen(button);
    button.setAttribute("aria-checked", checked);
    button.tabIndex = checked || !any && i === 0 ? 0 : -1;
  });
};
const listenToArrows = group => group.addEventListener("keydown", event => {
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key], buttons = [...group.querySelectorAll("button")];
  if (!step) return;
  event.preventDefault();
  event.stopPropagation();
  const next = buttons[(buttons.indexOf(document.activeElement) + step + buttons.length) % buttons.length];
  next.focus();
  next.click();
});

const makeMethods = () => find("#methods").replaceChildren(
  ...[{ name: "auto", summary: "the method that suits the view" }, ...state.welcome.methods].map(({ name, summary }, i) =>
    make("button", { type: "button", role: "radio", "data-method": name, title: `${summary ?? name} (${i === 0 ? "O" : i})`,
      click: () => chooseMethod(name) }, ...i > 0 && i < 10 ? [make("kbd", {}, `${i}`)] : [], make("span", {}, name))));

/* A photograph has one method, and in the place of path itself. */
const PHOTO_MODES = {
  method: ["Through", "Through the medium (M)"], wipe: ["Wipe", "Through the medium left, the photograph right (W)"],
  path: ["Photograph", "The photograph alone (P)"], difference: ["Difference", "What the medium adds or takes (D)"],
};
const suitPhoto = () => {
  find("#methods").hidden = find("#compare").hidden = true;
  for (const button of find("#modes").children) [button.textContent, button.title] = PHOTO_MODES[button.dataset.mode];
};

const refresh = () => {
  const { compare, paused, method } = state.view;
  check(find("#methods"), button => button.dataset.method === method);
  for (const button of find("#methods").children)
    button.classList.toggle("chosen", method === "auto" && button.dataset.method === methodShown());
  const { expected } = state.view, automatic = find('#methods [data-method="auto"]');
  if (automatic !== null) automatic.title = "the method that suits the view (O)" + (method === "auto" && expected
    ? `: ${methodShown()}, about ${(100 * expected.error).toPrecision(2)} %, ${expected.seconds.toPrecision(2)} s` : "");
  check(find("#modes"), button => button.dataset.mode === state.display.mode);
  find("#compare").setAttribute("aria-pressed", compare);
  find("#pause").setAttribute("aria-pressed", paused);
  find("#pause").textContent = paused ? "▶" : "❚❚";
  find("#undo").disabled = !canUndo();
  find("#redo").disabled = !canRedo();
};

export const start = () => {
  const click = (id, action) => find(id).addEventListener("click", action);
  click("#compare", () => setCompare(!state.view.compare));
  for (const button of find("#modes").children) button.addEventListener("click", () => setMode(button.dataset.mode));
  click("#undo", undo);
  click("#redo", redo);
  click("#pause", togglePause);
  click("#theme", nextTheme);
  click("#hide", togglePanels);
  [find("#methods"), find("#modes")].forEach(listenToArrows);
  setTheme(kept("theme") ?? "system");
  showPanels(kept("panels") !== "0");
  for (const event of ["view", "display", "history"]) on(event, refresh);
};

let known = false;
on("server:welcome", message => {
  const mine = { method: state.view.method, compare: state.view.compare, paused: state.view.paused };
  Object.assign(state.view, message.view);
  find("#scene-name").textContent = message.name ?? "";
  document.title = `${message.name ? `${message.name} – ` : ""}Tyndall`;
  makeMethods();
  if (isPhoto()) suitPhoto();
  if (known) changeView(mine); // after a connection anew the view is what it was
  known = true;
  emit("view");
});
on("scene", ({ view }) => {
  if (!view) return;
  Object.assign(state.view, view);
  emit("view");
});
