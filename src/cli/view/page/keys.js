/* The keyboard, and the list of its keys. */

import { chooseMethod, methodNames, nextTheme, setCompare, setMode, togglePanels, togglePause } from "./bar.js";
import { goHome, isFlying, pressCamera } from "./camera.js";
import { find, isTyping, make } from "./dom.js";
import { redo, undo } from "./edit.js";
import { saveScene, savePng, stepFrame, togglePlay } from "./keep.js";
import { movePin, togglePin, unpin } from "./probe.js";
import { autoAll, expose, setLook, setZoom } from "./show.js";
import { display, isPhoto, state } from "./state.js";

const CURVES = ["filmic", "srgb", "reinhard", "linear"];
const channel = name => () => display({ channel: state.display.channel === name ? "rgb" : name });

/* Groups of keys: the key, what it does in words, and what it does. */
const KEYS = {
  "What is shown": [
    ["o", "auto: the method that suits the view", () => chooseMethod("auto")],
    ["m", "the method alone", () => setMode("method")],
    ["w", "wipe: method left, path right", () => setMode(state.display.mode === "wipe" ? "method" : "wipe")],
    ["p", "path alone", () => setMode(state.display.mode === "path" ? "method" : "path")],
    ["d", "difference: method minus path", () => setMode(state.display.mode === "difference" ? "method" : "difference")],
    ["c", "path in the background, on or off", () => setCompare(!state.view.compare)],
    [" ", "pause or go on", togglePause],
  ],
  Display: [
    ["[", "exposure down by a third of a stop", () => expose(state.display.exposure - 1 / 3)],
    ["]", "exposure up by a third of a stop", () => expose(state.display.exposure + 1 / 3)],
    ["a", "exposure or range from the image", autoAll],
    ["k", "the next curve", () => display({ curve: CURVES[(CURVES.indexOf(state.display.curve) + 1) % CURVES.length] })],
    ["v", "false colour", () => setLook(state.display.look === "false" ? "color" : "false")],
    ["r", "red alone", channel("r")],
    ["g", "green alone", channel("g")],
    ["b", "blue alone", channel("b")],
    ["l", "luminance alone", channel("luminance")],
    ["n", "mark pixels that are no numbers", () => display({ markers: !state.display.markers })],
    ["f", "fit the window", () => setZoom(0)],
    ["0", "1:1", () => setZoom(1)],
    ["i", "pin the probe or free it; arrows move it", togglePin],
  ],
  Scene: [
    ["Home", "the file's camera", goHome],
    [",", "the frame before", () => stepFrame(-1)],
    [".", "the next frame", () => stepFrame(1)],
    ["y", "play the frames or stop", togglePlay],
    ["s", "save a PNG of what is shown", savePng],
  ],
  Page: [
    ["h", "panels on or off", togglePanels],
    ["t", "dark, light, as the system", nextTheme],
    ["?", "this list", () => openHelp()],
  ],
};
const actions = new Map(Object.values(KEYS).flat().map(([key, , action]) => [key, action]));

/* The rest of the list. */
const MORE = {
  "What is shown": [["1 … 9", "the method of that number"]],
  Scene: [["Ctrl Z", "undo"], ["Ctrl Shift Z", "redo"], ["Ctrl S", "save the scene"]],
  Page: [["Esc", "free the probe, close"]],
  Camera: [["drag, arrows", "orbit about the target"], ["Shift + drag", "pan; also the middle button, Shift + arrows"],
    ["wheel, + −", "dolly"], ["right + drag", "look around; with W A S D Q E fly, with Shift faster, by the wheel set the speed"]],
  Mouse: [["Ctrl + wheel", "zoom into the image"], ["Shift + click", "pin the probe"], ["drag a number", "change it"]],
};

/* A photograph has neither camera nor methods nor frames. */
const SCENES_ALONE = new Set(["o", "c", "Home", ",", ".", "y", "1 … 9", "Camera"]);
const OF_PHOTOS = {
  m: "the image through the medium", w: "wipe: through the medium left, the photograph right", p: "the photograph alone",
  d: "difference: what the medium adds or takes", "Ctrl S": "save the medium", "Ctrl + wheel": "zoom into the image; also the wheel alone",
};
const suits = key => !isPhoto() || !SCENES_ALONE.has(key);

export const openHelp = () => {
  const dialog = find("#keys");
  if (dialog.open) {
    dialog.close();
    return;
  }
  const nameOf = key => key === " " ? "Space" : key.length === 1 ? key.toUpperCase() : key;
  const row = ([key, words]) => make("div", {}, make("dt", {}, make("kbd", {}, nameOf(key))), make("dd", {}, isPhoto() && OF_PHOTOS[key] || words));
  const titles = [...new Set([...Object.keys(KEYS), ...Object.keys(MORE)])].filter(suits);
  const listOf = title => [...MORE[title] ?? [], ...KEYS[title] ?? []].filter(([key]) => suits(key)).map(row);
  const headed = title => isPhoto() && title === "Scene" ? "Photograph" : title;
  dialog.replaceChildren(make("h2", {}, "Keys"), make("div", { class: "columns" }, ...titles.map(title =>
    make("dl", {}, make("h3", {}, headed(title)), ...listOf(title)))),
  make("form", { method: "dialog" }, make("button", { autofocus: true }, "Close")));
  dialog.showModal();
};

const pressWithControl = event => {
  const key = event.key.toLowerCase();
  if (key === "z") (event.shiftKey ? redo : undo)();
  else if (key === "y") redo();
  else if (key === "s") saveScene();
  else return false;
  return true;
};

/* True if an element takes this key itself. */
const takes = (element, key) => {
  if (isTyping(element)) return true;
  const widget = element.closest?.("button, summary, a, input, [role=slider], [role=application]");
  return Boolean(widget) && [" ", "Enter"].includes(key) || element.matches?.("input[type=range]") && key.startsWith("Arrow");
};

const pinMoves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

const press = event => {
  if (event.defaultPrevented || isFlying()) return;
  if ((event.ctrlKey || event.metaKey) && !event.altKey) {
    if (!(isTyping(event.target) && event.key.toLowerCase() !== "s") && pressWithControl(event)) event.preventDefault();
    return;
  }
  if (event.altKey || find("#keys").open && event.key !== "?" || takes(event.target, event.key)) return;
  const digit = /^[1-9]$/.test(event.key) ? Number(event.key) : 0, pinned = pinMoves[event.key];
  const action = actions.get(event.key.length === 1 ? event.key.toLowerCase() : event.key);
  if (digit > 0) chooseMethod(methodNames()[digit - 1]);
  else if (event.key === "Escape") unpin();
  else if (action) action();
  else if (!(pinned && movePin(...pinned)) && !pressCamera(event)) return;
  event.preventDefault();
};

/* A menu that was used by the mouse gives the keyboard back. */
const releaseMenus = () => {
  let pointed = false;
  window.addEventListener("pointerdown", () => pointed = true, true);
  window.addEventListener("keydown", () => pointed = false, true);
  window.addEventListener("change", event => {
    if (pointed && event.target instanceof HTMLSelectElement) event.target.blur();
  });
};

export const start = () => {
  window.addEventListener("keydown", press);
  releaseMenus();
  find("#help").addEventListener("click", openHelp);
};
