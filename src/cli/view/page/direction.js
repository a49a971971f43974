/* The editor of a direction: a pad of azimuth and elevation of where the light comes from, and both as numbers. */

import { clamp, make, makeSvg } from "./dom.js";
import { makeNumber } from "./field.js";
import { state } from "./state.js";

const WIDTH = 200, HEIGHT = 100;

const isZUp = () => state.document?.up_axis === "z";

/* Degrees: azimuth about the up axis from +x, counter-clockwise seen from above; elevation above the horizon. */
const anglesOf = ([x, y, z]) => {
  const [a, b, up] = isZUp() ? [-x, -y, -z] : [-x, z, -y];
  return [Math.atan2(b, a) * 180 / Math.PI, Math.atan2(up, Math.hypot(a, b)) * 180 / Math.PI];
};
const directionOf = ([azimuth, elevation]) => {
  const turn = azimuth * Math.PI / 180, rise = elevation * Math.PI / 180;
  const a = Math.cos(rise) * Math.cos(turn), b = Math.cos(rise) * Math.sin(turn), up = Math.sin(rise);
  return (isZUp() ? [-a, -b, -up] : [-a, -up, b]).map(x => Number(x.toFixed(5)) + 0);
};

export const directionControl = ({ name, change }) => {
  let angles = [0, 0];
  const dot = makeSvg("circle", { r: 6, class: "sun" });
  const across = makeSvg("path", { class: "cross" });
  const grid = [1, 2, 3].map(i => `M${i * WIDTH / 4} 0V${HEIGHT}`).join("");
  const pad = makeSvg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "pad", tabindex: 0, role: "application",
    "aria-label": `${name}: arrow keys turn it` },
    makeSvg("rect", { class: "ground", x: 0, y: HEIGHT / 2, width: WIDTH, height: HEIGHT / 2 }),
    makeSvg("path", { class: "grid", d: `M0 ${HEIGHT / 2}H${WIDTH}${grid}` }), across, dot);
  const send = moving => {
    refresh();
    change(directionOf(angles), moving);
  };
  const fields = [["azimuth", 180], ["elevation", 90]].map(([word, most], i) =>
    makeNumber({ type: "number", minimum: -most, maximum: most }, `${name}, ${word}`, (value, moving) => {
      angles[i] = value;
      send(moving);
    }, { scrub: 1 }));
  const refresh = () => {
    const x = (angles[0] / 360 + 0.5) * WIDTH, y = (0.5 - angles[1] / 180) * HEIGHT;
    dot.setAttribute("cx", x);
    dot.setAttribute("cy", y);
    across.setAttribute("d", `M${x} 0V${HEIGHT}M0 ${y}H${WIDTH}`);
    fields.forEach((field, i) => field.update(Number(angles[i].toFixed(2))));
  };
  const follow = (event, moving) => {
    const box = pad.getBoundingClientRect();
    angles = [(clamp((event.clientX - box.left) / box.width, 0, 1) - 0.5) * 360,
      (0.5 - clamp((event.clientY - box.top) / box.height, 0, 1)) * 180];
    send(moving);
  };
  pad.addEventListener("pointerdown", event => {
    if (event.button !== 0) return;
    pad.setPointerCapture(event.pointerId);
    follow(event, true);
  });
  pad.addEventListener("pointermove", event => {
    if (pad.hasPointerCapture(event.pointerId)) follow(event, true);
  });
  pad.addEventListener("pointerup", event => follow(event, false));
  pad.addEventListener("keydown", event => {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    const step = event.shiftKey ? 15 : 2;
    angles = [(angles[0] + way[0] * step + 540) % 360 - 180, clamp(angles[1] + way[1] * step, -90, 90)];
    send(false);
  });
  return {
    element: make("div", { class: "direction" }, pad, make("div", { class: "channels" },
      ...fields.map(({ element }, i) => make("label", { class: "channel" }, make("span", {}, ["azimuth", "elevation"][i]), element, "°")))),
    update: value => {
      angles = anglesOf(value);
      refresh();
    },
  };
};
