/* Changes of the scene's document and of the camera: at once here, then in the server; undone and redone. */

import { perFrame } from "./dom.js";
import { ask, send } from "./link.js";
import { copy, get, near, put, same } from "./path.js";
import { emit, on, state } from "./state.js";

const MERGE = 700;   // ms within which changes of the same values are one step
const SETTLE = 5000; // ms after which the server's document is taken although it has not echoed a change
const STEPS = 500;

const past = [], future = [];
let open = null;                // the step that a drag adds to
const fresh = new Map();        // own changes that the server may not have echoed yet: path to time
const queued = new Map();       // changes of the next message

/* ---- to the server ---- */

/* A refused change goes back to what the server has. */
const refuse = (changes, error) => {
  for (const { path } of changes) {
    fresh.delete(path);
    put(state.document, path, copy(get(state.served, path)));
  }
  emit("document");
  emit("trouble", { text: error.message, path: changes[0]?.path });
};

const transmit = moving => {
  if (queued.size === 0) return;
  const changes = [...queued].map(([path, value]) => ({ path, value: value === undefined ? null : value }));
  queued.clear();
  ask({ type: "set", changes, moving }).catch(error => {
    if (error.refused) refuse(changes, error);
  });
};
const transmitSoon = perFrame(() => transmit(true));

const apply = (changes, moving) => {
  const now = performance.now();
  for (const { path, value } of changes) {
    put(state.document, path, copy(value));
    fresh.set(path, now);
    queued.delete(path); // the order is that of the last change
    queued.set(path, value);
  }
  if (moving) transmitSoon();
  else transmit(false);
  emit("document");
  if (changes.some(({ path }) => path.startsWith("camera"))) emit("camera-document");
};

const transmitCamera = moving => send({ type: "camera", ...state.camera, moving });
const transmitCameraSoon = perFrame(() => transmitCamera(cameraMoves));
let cameraMoves = false;

const applyCamera = (camera, moving) => {
  state.camera = camera;
  cameraMoves = moving;
  fresh.set("camera", performance.now());
  const unit = state.document.meters_per_unit ?? 1;
  state.document.camera ??= {};
  for (const key of ["position", "target"])
    state.document.camera[key] = camera[key].map(x => Number((x / unit).toPrecision(7)));
  if (!same(camera.fov_y, state.document.camera.fov_y ?? 40)) state.document.camera.fov_y = camera.fov_y;
  if (moving) transmitCameraSoon();
  else transmitCamera(false);
  emit("camera");
};

/* ---- steps ---- */

const keyOf = changes => changes.map(({ path }) => path).join("|");

/* Adds to the step that is open, or begins one. undo: what brings the state back; redo: what brings it again. */
const record = (key, undo, redo, moving) => {
  const now = performance.now(), last = past.at(-1);
  if (last && last.key === key && (open === last || now - last.time < MERGE) && future.length === 0) {
    Object.assign(last, { redo, time: now });
  } else {
    past.push({ key, undo, redo, time: now });
    if (past.length > STEPS) past.shift();
    future.length = 0;
  }
  open = moving ? past.at(-1) : null;
  emit("history");
};

/* Changes values of the document: [{path, value}], undefined removes. moving: more changes of these follow at once. */
export const edit = (changes, moving = false) => {
  if (state.document === null) return;
  const before = changes.map(({ path }) => ({ path, value: copy(get(state.document, path)) }));
  record(keyOf(changes), { changes: before }, { changes: copy(changes) }, moving);
  apply(changes, moving);
};

/* Moves the camera: position, target, up in metres, fov_y. */
export const moveCamera = (changes, moving = false) => {
  if (state.camera === null) return;
  const camera = { ...state.camera, ...changes };
  record("camera", { camera: state.camera }, { camera }, moving);
  applyCamera(camera, moving);
};

const take = step => {
  if (step.camera) applyCamera(step.camera, false);
  else apply(step.changes, false);
};

export const undo = () => {
  const step = past.pop();
  if (!step) return;
  future.push(step);
  open = null;
  take(step.undo);
  emit("history");
};

export const redo = () => {
  const step = future.pop();
  if (!step) return;
  past.push(step);
  step.time = 0;
  take(step.redo);
  emit("history");
};

/* True if the server has not yet echoed a change. */
export const isFresh = path => fresh.has(path);

export const canUndo = () => past.length > 0;
export const canRedo = () => future.length > 0;

/* ---- from the server ---- */

/* The server's document with own changes that are younger than its echo. */
const adopt = served => {
  const now = performance.now(), mine = state.document;
  state.served = served;
  state.document = copy(served);
  for (const [path, time] of fresh) {
    const value = get(mine, path), echoed = near(get(served, path), value);
    if (open === null && (echoed || now - time > SETTLE)) fresh.delete(path);
    if (fresh.has(path) || echoed) put(state.document, path, copy(value));
  }
  clearTimeout(settling);
  if (fresh.size > 0) settling = setTimeout(settle, SETTLE);
};
let settling = 0;
const settle = () => {
  adopt(state.served);
  emit("document");
};

const asDocument = value => typeof value === "string" ? JSON.parse(value) : value;

on("server:welcome", message => {
  const again = state.welcome !== null && same(state.original, asDocument(message.original ?? message.document));
  Object.assign(state, { welcome: message, served: asDocument(message.document) });
  state.document = copy(state.served);
  state.original = asDocument(message.original ?? (again ? state.original : message.document));
  fresh.clear();
  open = null;
  if (!again) past.length = future.length = 0;
  emit("history");
});

on("server:scene", message => {
  adopt(asDocument(message.document));
  emit("scene", message);
  emit("document");
});
