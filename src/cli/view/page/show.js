/* The display panel, automatic exposure and ranges, the legend, and the divider of the wipe. */

import { changeView } from "./bar.js";
import { ramps } from "./color.js";
import { clamp, find, make, number, shown } from "./dom.js";
import { numberControl } from "./controls.js";
import { makeNumber } from "./field.js";
import { sortedLuminances } from "./frame.js";
import { frameSize, place, toFrame, toWindow } from "./screen.js";
import { display, isPhoto, methodShown, on, referenceName, state } from "./state.js";

const canvas = find("#screen");
const CHOICES = ["curve", "channel"];
const CHANNEL_NAMES = { rgb: "luminance", r: "red", g: "green", b: "blue", luminance: "luminance" };

/* ---- automatic values ---- */

const shownFrame = () => state.frames[state.display.mode === "path" ? 1 : 0] ?? state.frames[0] ?? state.frames[1];

/* Up to 1, 2 or 5 times a power of ten. */
const roundUp = value => {
  const power = 10 ** Math.floor(Math.log10(value));
  return Number(([1, 2, 5, 10].find(step => step * power >= value) * power).toPrecision(1));
};

/* The 95th percentile of luminance at four fifths of the scale. */
const autoExposure = () => {
  const frame = shownFrame(), values = frame ? sortedLuminances(frame) : [];
  const high = values[Math.floor(0.95 * values.length)] || values.at(-1);
  if (high > 0) display({ exposure: clamp(Math.round(10 * Math.log2(0.8 / high)) / 10, -100, 100) });
};

/* From the darkest hundredth that is not black to the brightest, four decades at most. */
const autoFalse = () => {
  const frame = shownFrame(), values = frame ? sortedLuminances(frame).filter(value => value > 0) : [];
  if (values.length === 0) return;
  const high = Math.ceil(2 * Math.log10(values[Math.floor(0.998 * values.length)] || values.at(-1))) / 2;
  const low = Math.floor(2 * Math.log10(values[Math.floor(0.01 * values.length)])) / 2;
  display({ falseRange: [clamp(low, high - 4, high - 1), high] });
};

/* So that one pixel in fifty is beyond the scale. */
const autoDifference = () => {
  if (!state.frames[0] || !state.frames[1]) return false;
  const values = sortedLuminances(state.frames[0], state.frames[1]), high = values[Math.floor(0.98 * values.length)];
  if (high > 0) display({ differenceRange: roundUp(high) });
  return true;
};

export const autoAll = () => {
  if (state.display.mode === "difference") autoDifference();
  else if (state.display.look === "false") autoFalse();
  else autoExposure();
};

export const expose = stops => display({ exposure: clamp(Math.round(1e4 * stops) / 1e4, -100, 100) });

let rangedFalse = false, rangedDifference = false;
export const setLook = look => {
  display({ look });
  if (look === "false" && !rangedFalse) {
    autoFalse();
    rangedFalse = state.frames.some(Boolean);
  }
};

/* The first difference sets its own range, once both images are final or nearly. */
const rangeDifference = () => {
  if (state.display.mode === "difference" && !rangedDifference) rangedDifference = autoDifference();
};

export const setZoom = zoom => display({ zoom, center: [0.5, 0.5] });

/* ---- the legend ---- */

const drawRamp = ramp => {
  const ink = find("#legend canvas").getContext("2d"), row = ink.createImageData(256, 1);
  row.data.set(ramp);
  ink.putImageData(row, 0, 0);
};

const decade = power => Number.isInteger(power) ? `10${[...String(power)].map(c => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻").join("")}` : "";

/* Places 0..1 and words of whole decades; of two decades or less also of 2 and 5. */
const decades = (low, high) => {
  const steps = high - low <= 2 ? [1, 2, 5] : [1], ticks = [];
  for (let power = Math.floor(low); power <= high; ++power)
    for (const step of steps) {
      const at = (power + Math.log10(step) - low) / (high - low);
      if (at >= -1e-6 && at <= 1 + 1e-6) ticks.push([at, steps.length > 1 ? shown(step * 10 ** power, 1) : decade(power)]);
    }
  return ticks;
};

const refreshLegend = () => {
  const { mode, look, channel, falseRange: [low, high], differenceRange } = state.display;
  const legend = find("#legend"), signed = mode === "difference";
  legend.hidden = !signed && look !== "false";
  if (legend.hidden) return;
  drawRamp(signed ? ramps.difference : ramps.radiance);
  const ticks = signed ? [-1, -0.5, 0, 0.5, 1].map(t => [0.5 + t / 2, shown(t * differenceRange, 3)])
    : decades(low, high);
  legend.querySelector(".ticks").replaceChildren(...ticks.map(([at, text]) => {
    const tick = make("span", {}, text);
    tick.style.left = `${100 * at}%`;
    return tick;
  }));
  legend.querySelector("figcaption").textContent = signed
    ? `${methodShown()} − ${referenceName()}, ${CHANNEL_NAMES[channel]}, W m⁻² sr⁻¹` : `${CHANNEL_NAMES[channel]}, W m⁻² sr⁻¹`;
};

/* ---- the divider ---- */

const divider = find("#divider");

const refreshDivider = () => {
  const { mode, wipe } = state.display, wiping = mode === "wipe" && state.frames.some(Boolean);
  divider.hidden = !wiping;
  const [width, height] = frameSize(), [left, top] = toWindow(0, 0), [right, bottom] = toWindow(width, height);
  const box = [Math.max(left, 0), Math.max(top, 0), Math.min(right, canvas.clientWidth), Math.min(bottom, canvas.clientHeight)];
  divider.style.left = `${clamp(left + wipe * (right - left), box[0], box[2])}px`;
  divider.style.top = `${box[1]}px`;
  divider.style.height = `${box[3] - box[1]}px`;
  divider.setAttribute("aria-valuenow", Math.round(100 * wipe));
  const reference = referenceName();
  const names = { method: [methodShown(), ""], wipe: [methodShown(), reference], path: ["", reference],
    difference: [`${methodShown()} − ${reference}`, ""] }[mode];
  [find("#side-left"), find("#side-right")].forEach((side, i) => {
    const [method, path] = state.frames, about = names[i] && (i === 1 || mode === "difference");
    const stale = about && !isPhoto() && method && path && path.revision < method.revision;
    side.textContent = `${names[i]}${about && !path ? ", which has no image yet" : stale ? ", of the scene before" : ""}`;
    side.hidden = !names[i] || mode === "method";
    side.style.top = `${box[1] + 10}px`;
  });
  find("#side-left").style.left = `${box[0] + 10}px`;
  find("#side-right").style.right = `${canvas.clientWidth - box[2] + 10}px`;
};

const wipeTo = x => display({ wipe: clamp(x, 0, 1) });

const listenToDivider = () => {
  divider.addEventListener("pointerdown", event => divider.setPointerCapture(event.pointerId));
  divider.addEventListener("pointermove", event => {
    if (divider.hasPointerCapture(event.pointerId)) wipeTo(toFrame(event.clientX, event.clientY)[0] / frameSize()[0]);
  });
  divider.addEventListener("keydown", event => {
    const step = { ArrowLeft: -0.01, ArrowRight: 0.01 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    wipeTo(state.display.wipe + step * (event.shiftKey ? 10 : 1));
  });
};

/* ---- the panel ---- */

/* The size in the file, that of the window, and its half. */
const SIZES = [["file", "Scene"], ["window", "Window"], ["half", "Half of the window"]];
let sizeChoice = "file", fileSize = null;

const applySize = () => {
  const { width, height } = canvas, even = x => Math.max(16, Math.round(x / 2) * 2);
  const part = sizeChoice === "half" ? 0.5 : 1;
  const [w, h] = sizeChoice === "file" ? fileSize ?? [0, 0] : [even(part * width), even(part * height)];
  if (w > 0 && (w !== state.view.width || h !== state.view.height)) changeView({ width: w, height: h });
};

let sizeTimer = 0;
const followWindow = () => {
  if (sizeChoice === "file") return;
  clearTimeout(sizeTimer);
  sizeTimer = setTimeout(applySize, 200);
};

let exposure = null, lows = [], difference = null, exposureTimer = 0;

const refresh = () => {
  const { display: now } = state;
  for (const id of CHOICES) find(`#${id}`).value = now[id];
  find("#look").checked = now.look === "false";
  exposure.update(now.exposure, NaN);
  lows.forEach((field, i) => field.update(now.falseRange[i]));
  difference.update(now.differenceRange, NaN);
  find("#false-row").hidden = now.look !== "false" || now.mode === "difference";
  find("#difference-row").hidden = now.mode !== "difference";
  const zoom = find("#zoom"), known = [...zoom.options].some(option => option.value === String(now.zoom));
  zoom.options[zoom.options.length - 1].textContent = `${number(100 * place().zoom, 3)} %`;
  zoom.value = known ? String(now.zoom) : "";
  const [width, height] = frameSize();
  find("#size").options[0].textContent = sizeChoice === "file" ? `Scene, ${width} × ${height}` : "Scene";
  refreshLegend();
  refreshDivider();
};

export const start = () => {
  exposure = numberControl({ limits: { type: "number", minimum: -12, maximum: 12 }, name: "Exposure, stops", change: expose });
  find("#exposure-row").append(exposure.element);
  lows = [0, 1].map(i => makeNumber({ type: "number", minimum: -30, maximum: 30 }, ["lowest decade", "highest decade"][i], value => {
    const range = state.display.falseRange.map((old, at) => at === i ? value : old);
    if (range[1] > range[0]) display({ falseRange: range });
  }, { scrub: 0.5 }));
  find("#false-row").append(make("div", { class: "channels" }, ...lows.map(({ element }, i) =>
    make("label", { class: "channel" }, make("span", {}, ["from", "to"][i]), element))));
  difference = numberControl({ limits: { type: "number", exclusiveMinimum: 0, maximum: 1e9 }, name: "Range of the difference",
    change: value => display({ differenceRange: value }) });
  find("#difference-row").append(difference.element);
  for (const id of CHOICES) find(`#${id}`).addEventListener("change", event => display({ [id]: event.target.value }));
  find("#look").addEventListener("change", event => setLook(event.target.checked ? "false" : "color"));
  find("#auto").addEventListener("click", autoAll);
  find("#zoom").addEventListener("change", event => setZoom(Number(event.target.value)));
  find("#size").append(...SIZES.map(([value, text]) => make("option", { value }, text)));
  find("#size").addEventListener("change", event => {
    sizeChoice = event.target.value;
    applySize();
    refresh();
  });
  listenToDivider();
  on("display", names => {
    if (names.includes("mode")) rangeDifference();
    if (names.includes("exposure") && state.welcome?.remote && state.view.exposure !== state.display.exposure) { // JPEGs are made with it
      clearTimeout(exposureTimer);
      exposureTimer = setTimeout(() => changeView({ exposure: state.display.exposure }), 100);
    }
    refresh();
  });
  on("place", () => {
    followWindow();
    refresh();
  });
  on("frame", () => {
    rangeDifference();
    refreshDivider();
    if (place().zoom !== lastZoom) refresh();
    lastZoom = place().zoom;
  });
  on("view", refresh);
  refresh();
};
let lastZoom = 0;

on("server:welcome", ({ view, document: scene }) => {
  if (fileSize === null) {
    fileSize = [view?.width ?? 0, view?.height ?? 0];
    find("#size").closest(".row").hidden = isPhoto(); // which has its own
    display({ curve: view?.curve ?? "filmic", exposure: view?.exposure ?? scene.camera?.exposure ?? 0 });
  } else applySize();
});
