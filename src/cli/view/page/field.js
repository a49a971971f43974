/* Number fields and sliders: what all numeric controls are made of. */

import { clamp, make, number, tidy } from "./dom.js";
import { range } from "./schema.js";

/* To a whole number, or to a multiple of what the schema says. */
const roundTo = ({ multipleOf = 1 }, value) => multipleOf * Math.round(value / multipleOf);

/* The scale of a slider: place 0..1 to value and back. A range of three decades or more is logarithmic, around a value where
 * it has no natural ends; 0 lies at the very left where it is allowed. */
export const scaleOf = (limits, around) => {
  const [low, high] = range(limits), whole = limits.type === "integer";
  const round = value => clamp(whole ? roundTo(limits, value) : tidy(value), low, high);
  if (low < 0 && high - low < 1e4) // such as g, stops and angles
    return { toValue: t => round(low + t * (high - low)), toPlace: v => (v - low) / (high - low) };
  if (low < 0) {
    const reach = Math.max(Math.abs(around) * 2, 1);
    const from = clamp(around - reach, low, high), to = clamp(around + reach, low, high);
    return { toValue: t => round(from + t * (to - from)), toPlace: v => clamp((v - from) / (to - from), 0, 1) };
  }
  const tiny = low === Number.MIN_VALUE;
  if (high <= 1000 && (low <= 0 || tiny || high / low < 1000))
    return { toValue: t => round(low + t * (high - low)), toPlace: v => (v - low) / (high - low) };
  const middle = around > 0 ? around : 1;
  let bottom = Math.max(low > 0 && !tiny ? low : 0, middle / 100), top = Math.min(high, middle * 100);
  if (whole) [bottom, top] = [Math.max(low, 1, Math.floor(middle / 32)), Math.min(high, Math.max(32, 32 * middle))];
  const decades = Math.log(top / bottom), zero = low <= 0 ? 0.02 : 0;
  return {
    toValue: t => t < zero / 2 && zero > 0 ? 0 : round(bottom * Math.exp(decades * clamp((t - zero) / (1 - zero), 0, 1))),
    toPlace: v => v < bottom && zero > 0 ? (v > 0 ? zero : 0) : clamp(zero + (1 - zero) * Math.log(v / bottom) / decades, 0, 1),
  };
};

/* A slider. change(value, moving) is called while it moves and once when it rests. */
export const makeSlider = (limits, name, change) => {
  let scale = null, around = NaN, value = 0, moving = false;
  const input = make("input", { type: "range", min: 0, max: 1, step: "any", "aria-label": name });
  const place = () => {
    input.value = scale.toPlace(value);
    input.style.setProperty("--at", `${100 * input.value}%`);
    input.setAttribute("aria-valuetext", number(value));
  };
  const rescale = at => {
    around = at;
    scale = scaleOf(limits, at);
  };
  input.addEventListener("input", () => {
    moving = true;
    value = scale.toValue(Number(input.value));
    input.style.setProperty("--at", `${100 * input.value}%`);
    input.setAttribute("aria-valuetext", number(value));
    change(value, true);
  });
  input.addEventListener("change", () => {
    moving = false;
    change(value, false);
  });
  input.addEventListener("keydown", event => { // steps of the arrow keys are of the scale, not of "any"
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageUp: 10, PageDown: -10 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const from = Number(input.value), by = Math.sign(step) * Math.abs(step) * (event.shiftKey ? 0.1 : 1) * 0.01;
    let next = scale.toValue(clamp(from + by, 0, 1));
    if (limits.type === "integer" && next === value) next = clamp(value + Math.sign(step) * (limits.multipleOf ?? 1), ...range(limits));
    value = next;
    place();
    change(value, false);
  });
  return {
    element: input,
    /* reference: what a scale without natural ends lies around. */
    update: (next, reference) => {
      value = next;
      if (moving) return;
      const wanted = reference > 0 ? reference : next;
      if (!(around > 0) || scale === null || next > 0 && (next > 100 * around || next < around / 100)) rescale(wanted || next);
      place();
    },
  };
};

/* A field for a number. Arrow keys step, with shift by ten; dragging it sideways with the mouse scrubs. */
export const makeNumber = (limits, name, change, { scrub = 0 } = {}) => {
  let value = 0, drag = null, typed = false;
  const input = make("input", { type: "text", inputmode: "decimal", spellcheck: "false", autocomplete: "off", "aria-label": name });
  const bounds = range(limits), whole = limits.type === "integer";
  const show = () => {
    typed = false;
    input.value = Number.isFinite(value) ? number(value, 5) : "";
  };
  const set = (next, moving) => {
    value = clamp(whole ? roundTo(limits, next) : next, ...bounds);
    show();
    change(value, moving);
  };
  const stepOf = () => whole ? limits.multipleOf ?? 1 : scrub || 10 ** Math.floor(Math.log10(Math.abs(value) || 1) - 1);
  const accept = () => {
    typed = false;
    const next = Number(input.value.trim().replace("−", "-").replace(",", "."));
    if (input.value.trim() === "" || !Number.isFinite(next)) show();
    else if (next !== Number(number(value, 5))) set(next, false);
  };
  input.addEventListener("input", () => typed = true);
  input.addEventListener("change", accept);
  input.addEventListener("keydown", event => {
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (way !== undefined) {
      event.preventDefault();
      set(tidy(value + way * stepOf() * (event.shiftKey ? 10 : 1), 6), false);
    } else if (event.key === "Escape") {
      show();
      input.blur();
    } else if (event.key === "Enter") {
      accept();
      input.blur();
    }
  });
  input.addEventListener("focus", () => input.select());
  input.addEventListener("pointerdown", event => {
    if (event.button === 0 && document.activeElement !== input) drag = { x: event.clientX, from: value, moved: false };
  });
  input.addEventListener("pointermove", event => {
    if (drag === null || event.buttons !== 1) return;
    const distance = event.clientX - drag.x;
    if (!drag.moved && Math.abs(distance) < 4) return;
    if (!drag.moved) {
      input.setPointerCapture(event.pointerId);
      drag.step = stepOf();
      drag.moved = true;
    }
    set(tidy(drag.from + Math.round(distance / 2) * drag.step, 6), true);
  });
  const rest = () => {
    if (drag?.moved) {
      change(value, false);
      input.blur();
    }
    drag = null;
  };
  for (const kind of ["pointerup", "pointercancel"]) input.addEventListener(kind, rest);
  return {
    element: input,
    update: next => {
      value = next;
      if (!typed) show();
    },
  };
};
