/* Controls of single values. Each takes {limits, name, change} and gives {element, update(value, reference), wide}:
 * change(value, moving) on the user's part, update on the document's. */

import { hexOf, rgbOf } from "./color.js";
import { make, number, tidy } from "./dom.js";
import { makeNumber, makeSlider } from "./field.js";
import { range } from "./schema.js";

const makeColor = (name, change) => {
  const input = make("input", { type: "color", "aria-label": name });
  input.addEventListener("input", () => change(rgbOf(input.value), true));
  input.addEventListener("change", () => change(rgbOf(input.value), false));
  return input;
};

export const numberControl = ({ limits, name, change }) => {
  const slider = makeSlider(limits, name, (value, moving) => {
    field.update(value);
    change(value, moving);
  });
  const field = makeNumber(limits, name, (value, moving) => {
    slider.update(value, NaN);
    change(value, moving);
  });
  return {
    element: make("div", { class: "pair" }, slider.element, field.element),
    update: (value, reference) => {
      slider.update(value, reference);
      field.update(value);
    },
  };
};

/* One number for all channels, or three. The slider is of the largest, and keeps the colour. */
export const amountControl = ({ limits, name, change, spatial = false }) => {
  let rgb = [0, 0, 0], split = false, reference = NaN;
  const relative = !(range(limits)[1] <= 1), signed = range(limits)[0] < 0, whole = limits.type === "integer";
  const letters = spatial ? "xyz" : "RGB";
  const topOf = values => Math.max(...values);
  const send = moving => {
    refresh();
    change(split ? rgb.map(x => tidy(x, 5)) : tidy(rgb[0], 5), moving);
  };
  const scaleTo = (value, moving) => {
    const top = topOf(rgb);
    rgb = signed || !(top > 0) ? [value, value, value] : rgb.map(x => whole ? Math.max(1, Math.round(x * value / top)) : x * value / top);
    send(moving);
  };
  const slider = makeSlider(limits, name, scaleTo), field = makeNumber(limits, name, scaleTo);
  const color = makeColor(`${name}, colour`, (picked, moving) => {
    const top = relative ? (topOf(rgb) || 1) / (topOf(picked) || 1) : 1;
    rgb = picked.map(x => x * top);
    split = true;
    send(moving);
  });
  const fields = [0, 1, 2].map(c => makeNumber(limits, `${name}, ${letters[c]}`, (value, moving) => {
    rgb[c] = value;
    send(moving);
  }));
  const toggle = make("button", { type: "button", class: "split", "aria-label": `${name}: three values`, click: () => {
    split = !split;
    if (!split) rgb = rgb.map(() => signed ? rgb.reduce((a, b) => a + b) / 3 : topOf(rgb));
    send(false);
  } }, letters);
  const channels = make("div", { class: "channels" },
    ...fields.map(({ element }, c) => make("label", { class: "channel" }, make("span", {}, letters[c]), element)));
  const refresh = () => {
    const top = signed ? rgb.reduce((a, b) => a + b) / 3 : topOf(rgb);
    slider.update(top, reference);
    field.update(top);
    fields.forEach((one, c) => one.update(rgb[c]));
    if (!color.hidden) color.value = hexOf(rgb, relative);
    channels.hidden = !split;
    toggle.setAttribute("aria-pressed", split);
  };
  color.hidden = signed || spatial;
  return {
    element: make("div", { class: "amount" },
      make("div", { class: "pair" }, slider.element, field.element, color, toggle), channels),
    update: (value, other) => {
      split = Array.isArray(value);
      rgb = split ? [...value] : [value, value, value];
      reference = Array.isArray(other) ? topOf(other) : other;
      refresh();
    },
  };
};

/* A number that the method may choose itself. */
/* A number, or a word in its place: auto. */
export const autoControl = ({ limits, name, change, word = "auto" }) => {
  let own = typeof limits.default === "number" ? limits.default : Math.max(range(limits)[0], 1);
  const inner = numberControl({ limits, name, change: (value, moving) => {
    own = value;
    change(value, moving);
  } });
  const box = make("input", { type: "checkbox", "aria-label": `${name}: ${word}`,
    change: () => change(box.checked ? word : own, false) }), text = make("span", {}, word);
  return {
    element: make("div", { class: "auto" }, make("label", { class: "check" }, box, text), inner.element),
    update: (value, reference) => {
      box.checked = typeof value === "string";
      text.textContent = box.checked ? value : word;
      inner.element.hidden = box.checked;
      if (!box.checked) own = value;
      inner.update(own, typeof reference === "number" ? reference : NaN);
    },
  };
};

export const checkControl = ({ name, change }) => {
  const box = make("input", { type: "checkbox", "aria-label": name, change: () => change(box.checked, false) });
  return { element: make("div", { class: "pair" }, box), update: value => box.checked = value };
};

export const selectControl = ({ limits, name, change }) => {
  const select = make("select", { "aria-label": name, change: () => change(select.value, false) },
    ...limits.enum.map(word => make("option", { value: word }, String(word).replaceAll("_", " "))));
  return { element: make("div", { class: "pair" }, select), update: value => select.value = value };
};

export const textControl = ({ name, change }) => {
  const input = make("input", { type: "text", "aria-label": name, spellcheck: "false", class: "text",
    change: () => change(input.value, false) });
  return {
    element: make("div", { class: "pair" }, input),
    update: value => {
      if (document.activeElement !== input) input.value = value ?? "";
    },
  };
};

/* Two to four numbers, such as positions and sizes. */
export const numbersControl = ({ limits, name, change, count, step }) => {
  let values = [];
  const letters = count === 2 ? ["1", "2"] : ["x", "y", "z", "w"];
  const fields = Array.from({ length: count }, (_, i) => makeNumber(limits, `${name}, ${letters[i]}`, (value, moving) => {
    values = values.map((old, at) => at === i ? value : old);
    change(values, moving);
  }, { scrub: step }));
  return {
    element: make("div", { class: "channels" }, ...fields.map(({ element }, i) =>
      make("label", { class: "channel" }, make("span", {}, count === 2 ? "" : letters[i]), element))),
    update: next => {
      values = [...next];
      fields.forEach((field, i) => field.update(values[i]));
    },
  };
};

/* A value that no other control is for, as JSON text. */
export const jsonControl = ({ name, change }) => {
  let last = "";
  const input = make("input", { type: "text", class: "text code", "aria-label": name, spellcheck: "false", change: () => {
    try {
      const value = JSON.parse(input.value);
      input.removeAttribute("aria-invalid");
      change(value, false);
    } catch {
      input.setAttribute("aria-invalid", "true");
    }
  } });
  return {
    element: make("div", { class: "pair" }, input),
    update: value => {
      last = JSON.stringify(value) ?? "";
      if (document.activeElement !== input) input.value = last;
    },
  };
};

export const describeRange = limits => {
  const [low, high] = range(limits);
  if (!Number.isFinite(low) && !Number.isFinite(high)) return "";
  const open = limits.exclusiveMinimum !== undefined, shut = limits.exclusiveMaximum !== undefined;
  const from = open ? limits.exclusiveMinimum : low, to = shut ? limits.exclusiveMaximum : high;
  return `${open ? "above " : ""}${number(from)} … ${shut ? "below " : ""}${number(to)}`;
};
