/* Which camera there is, and moving it by mouse, wheel and keys. */

import { find, isTyping } from "./dom.js";
import { isFresh, moveCamera } from "./edit.js";
import { dolly, fly, length, look, orbit, pan, subtract } from "./orbit.js";
import { near } from "./path.js";
import { zoomAbout } from "./screen.js";
import { emit, isPhoto, on, state } from "./state.js";
import { notice } from "./status.js";

const canvas = find("#screen");
let home = null, drag = null, held = new Set(), speed = 1, wheelEnd = 0;

const FIXED = "A photograph has no camera to move. The wheel zooms into it.";

/* The diagonal of what there is, m. */
const extent = () => {
  const box = state.welcome?.extent, size = box ? length(subtract(box[1], box[0])) : 0;
  return size > 0 && Number.isFinite(size) ? size : 1;
};

/* In metres. */
const cameraIn = ({ camera = {}, meters_per_unit: unit = 1, up_axis = "y" }) => {
  const z = up_axis === "z";
  return {
    position: (camera.position ?? (z ? [0, -5, 0] : [0, 0, 5])).map(x => x * unit),
    target: (camera.target ?? [0, 0, 0]).map(x => x * unit),
    up: camera.up ?? (z ? [0, 0, 1] : [0, 1, 0]), fov_y: camera.fov_y ?? 40,
  };
};

/* True if the camera may be that of a glTF file, which the document does not tell. */
const isElsewhere = ({ camera = {}, geometry = [] }) => !camera.position && !camera.target &&
  [camera, ...geometry].some(({ file }) => /\.gl(tf|b)$/i.test(file ?? ""));

/* All of the scene, from the side that cameras have by default. */
const overview = () => {
  const box = state.welcome.extent ?? [[-1, -1, -1], [1, 1, 1]], target = box[0].map((x, i) => (x + box[1][i]) / 2);
  const up = state.document.up_axis === "z" ? [0, 0, 1] : [0, 1, 0], away = up[2] ? [0, -1.5, 0] : [0, 0, 1.5];
  return { position: target.map((x, i) => x + away[i] * extent()), target, up, fov_y: 40 };
};

/* As the server says, or else as the document does; a photograph has none that could move. */
const cameraOf = message => isPhoto() ? null : structuredClone(message.view?.camera ??
  (isElsewhere(state.document) ? state.camera ?? overview() : cameraIn(state.document)));

on("server:welcome", message => {
  state.camera = cameraOf(message);
  if (state.camera === null) {
    canvas.title = FIXED;
    canvas.setAttribute("aria-label", `The image. ${FIXED}`);
    return;
  }
  home ??= state.original.camera?.position ? cameraIn(state.original) : structuredClone(state.camera);
  emit("camera");
});

/* Another client, an undo, or a value typed into the panel. */
const follow = message => {
  if (drag !== null) return;
  const camera = cameraOf(message);
  if (camera === null || near(camera, state.camera)) return;
  state.camera = camera;
  emit("camera");
};
on("camera-document", () => follow({}));
on("scene", message => {
  if (!isFresh("camera") && message.changed?.some(path => path.startsWith("camera"))) follow(message);
});

export const goHome = () => {
  if (home !== null) moveCamera(structuredClone(home));
};

/* ---- the mouse ---- */

const begin = event => {
  if (isPhoto() && !event.shiftKey) notice(FIXED);
  if (state.camera === null || drag !== null) return;
  const kind = event.button === 2 ? "look" : event.button === 1 || event.shiftKey ? "pan" : "orbit";
  drag = { kind, x: event.clientX, y: event.clientY, moved: false, button: event.button, id: event.pointerId };
  canvas.setPointerCapture(event.pointerId);
  if (kind === "look") flyOn(performance.now());
};

const move = event => {
  if (drag === null || event.pointerId !== drag.id) return;
  const dx = event.clientX - drag.x, dy = event.clientY - drag.y, height = canvas.clientHeight || 1;
  if (!drag.moved && Math.hypot(dx, dy) < 3) return;
  Object.assign(drag, { x: event.clientX, y: event.clientY, moved: true });
  if (drag.kind === "orbit") moveCamera(orbit(state.camera, -dx * Math.PI / height, dy * Math.PI / height), true);
  else if (drag.kind === "pan") moveCamera(pan(state.camera, -dx / height, dy / height), true);
  else moveCamera(look(state.camera, -dx * 1.5 / height, -dy * 1.5 / height), true);
};

const end = event => {
  if (drag === null || event.pointerId !== drag.id) return;
  const { moved } = drag;
  drag = null;
  held.clear();
  if (moved) moveCamera({}, false);
};

/* The distance by the wheel; a pause ends the movement. */
const roll = event => {
  event.preventDefault();
  const lines = event.deltaY * (event.deltaMode === 1 ? 1 : event.deltaMode === 2 ? 10 : 1 / 40);
  if (event.ctrlKey || isPhoto()) {
    zoomAbout(1.1 ** -lines, event.clientX, event.clientY);
    return;
  }
  if (drag?.kind === "look") {
    speed = Math.min(Math.max(speed * 1.15 ** -lines, 1e-3), 1e3);
    return;
  }
  if (state.camera === null) return;
  moveCamera(dolly(state.camera, 1.05 ** lines, 1e-4 * extent()), true);
  clearTimeout(wheelEnd);
  wheelEnd = setTimeout(() => moveCamera({}, false), 200);
};

/* ---- keys ---- */

const FLIGHT = { KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0] };

/* While the right button is down, keys fly: a fifth of the scene in a second, with shift five times as fast. */
let flown = 0;
const flyOn = now => {
  if (drag?.kind !== "look") return;
  requestAnimationFrame(flyOn);
  const seconds = Math.min(Math.max(now - flown, 0), 100) / 1000;
  flown = now;
  const keys = [...held].filter(code => code in FLIGHT);
  if (keys.length === 0) return;
  const step = 0.2 * extent() * speed * seconds * (held.has("Shift") ? 5 : 1);
  const way = [0, 1, 2].map(i => keys.reduce((sum, code) => sum + FLIGHT[code][i], 0) * step);
  drag.moved = true;
  moveCamera(fly(state.camera, way), true);
};

export const isFlying = () => drag?.kind === "look";

const STEP = Math.PI / 36;
const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/* Arrows orbit, with shift they pan; plus and minus dolly. Returns whether the key is one of these. */
export const pressCamera = event => {
  if (state.camera === null) return false;
  const arrow = arrows[event.key];
  if (arrow && event.shiftKey) moveCamera(pan(state.camera, 0.05 * arrow[0], 0.05 * arrow[1]), true);
  else if (arrow) moveCamera(orbit(state.camera, STEP * arrow[0], STEP * arrow[1]), true);
  else if (event.key === "+" || event.key === "=") moveCamera(dolly(state.camera, 1 / 1.1, 1e-4 * extent()), true);
  else if (event.key === "-") moveCamera(dolly(state.camera, 1.1, 1e-4 * extent()), true);
  else return false;
  clearTimeout(wheelEnd);
  wheelEnd = setTimeout(() => moveCamera({}, false), 250);
  return true;
};

export const start = () => {
  canvas.addEventListener("pointerdown", event => {
    if (event.button > 2) return;
    if (event.button === 1) event.preventDefault();
    begin(event);
  });
  canvas.addEventListener("pointermove", move);
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, end);
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", roll, { passive: false });
  window.addEventListener("keydown", event => {
    if (!isFlying() || isTyping(event.target)) return;
    held.add(event.key === "Shift" ? "Shift" : event.code);
    if (event.code in FLIGHT) event.preventDefault();
  });
  window.addEventListener("keyup", event => held.delete(event.key === "Shift" ? "Shift" : event.code));
  window.addEventListener("blur", () => held.clear());
};
