/* The pixel probe: exact linear radiance under the pointer, or at a pinned pixel. */

import { luminance } from "./color.js";
import { find, fixed, make, number } from "./dom.js";
import { valueAt } from "./frame.js";
import { frameSize, toFrame, toWindow } from "./screen.js";
import { isPhoto, methodShown, on, referenceName, state } from "./state.js";

const canvas = find("#screen"), card = find("#probe"), pin = find("#pin");
let hovered = null, pinned = null;

/* R, G, B and luminance of a channel at a pixel of the full frame, or null. */
export const probe = (x, y, channel) => {
  const frame = state.frames[channel];
  if (frame === null || x < 0 || y < 0 || x >= frame.fullWidth || y >= frame.fullHeight) return null;
  const rgb = valueAt(frame, x, y);
  return { r: rgb[0], g: rgb[1], b: rgb[2], luminance: luminance(rgb), exact: frame.halves !== null };
};

const NAMES = ["R", "G", "B", "luminance"];
const rowOf = (found, word) => make("tr", {}, make("th", { scope: "row" }, word),
  ...[found.r, found.g, found.b, found.luminance].map(value => make("td", {}, `${found.exact ? "" : "≈"}${fixed(value)}`)));

const refresh = () => {
  const at = pinned ?? hovered, both = state.view.compare || isPhoto() || state.display.mode !== "method";
  const found = at === null ? [] : [probe(...at, 0), both ? probe(...at, 1) : null];
  card.hidden = !found.some(Boolean);
  if (card.hidden) {
    pin.toggleAttribute("hidden", true);
    return;
  }
  const [method, path] = found, rows = [];
  if (method) rows.push(rowOf(method, methodShown() || "method"));
  if (path) rows.push(rowOf(path, referenceName()));
  if (method && path) rows.push(make("tr", { class: "ratio" }, make("th", { scope: "row" }, "ratio"),
    ...["r", "g", "b", "luminance"].map(key => make("td", {}, path[key] !== 0 ? number(method[key] / path[key], 4) : "–"))));
  card.firstChild.replaceChildren(make("thead", {}, make("tr", {},
    make("th", {}, `${at[0]}, ${at[1]}`), ...NAMES.map(name => make("th", { scope: "col" }, name)))),
    make("tbody", {}, ...rows));
  card.lastChild.textContent = `W m⁻² sr⁻¹, ${pinned ? "pinned; Esc frees it" : "Shift+click pins"}`;
  pin.toggleAttribute("hidden", pinned === null);
  if (pinned !== null) {
    const [x, y] = toWindow(pinned[0] + 0.5, pinned[1] + 0.5);
    pin.style.left = `${x}px`;
    pin.style.top = `${y}px`;
  }
};

const pixelAt = event => {
  const [width, height] = frameSize(), [x, y] = toFrame(event.clientX, event.clientY).map(Math.floor);
  return x >= 0 && y >= 0 && x < width && y < height ? [x, y] : null;
};

export const unpin = () => {
  if (pinned === null) return false;
  pinned = null;
  refresh();
  return true;
};

/* By keys: the pixel under the pointer, or the middle. */
export const togglePin = () => {
  if (unpin()) return;
  const [width, height] = frameSize();
  pinned = hovered ?? [width >> 1, height >> 1];
  refresh();
};

/* A pinned pixel moves by keys. */
export const movePin = (x, y) => {
  if (pinned === null) return false;
  const [width, height] = frameSize();
  pinned = [Math.min(Math.max(pinned[0] + x, 0), width - 1), Math.min(Math.max(pinned[1] + y, 0), height - 1)];
  refresh();
  return true;
};

export const start = () => {
  canvas.addEventListener("pointermove", event => {
    hovered = pixelAt(event);
    refresh();
  });
  canvas.addEventListener("pointerleave", () => {
    hovered = null;
    refresh();
  });
  let down = null;
  canvas.addEventListener("pointerdown", event => down = [event.clientX, event.clientY]);
  canvas.addEventListener("click", event => {
    if (!event.shiftKey || down === null || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 3) return;
    pinned = pixelAt(event);
    refresh();
  });
  for (const event of ["frame", "display", "place", "view"]) on(event, refresh);
};
