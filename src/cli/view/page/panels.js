/* The panels of the scene, generated from its schema and its document. */

import { amountControl, autoControl, checkControl, describeRange, jsonControl, numberControl, numbersControl, selectControl,
  textControl } from "./controls.js";
import { directionControl } from "./direction.js";
import { find, make } from "./dom.js";
import { edit } from "./edit.js";
import { coefficientRows, initial, titleOf } from "./kinds.js";
import { copy, get, join, same, shape } from "./path.js";
import { controlOf, label, resolve, unitOf, variantOf, variants } from "./schema.js";
import { isPhoto, methodShown, on, state } from "./state.js";
import { setTip } from "./tip.js";

const MAKERS = {
  number: numberControl, amount: amountControl, auto: autoControl, check: checkControl, select: selectControl,
  text: textControl, numbers: numbersControl, direction: directionControl, json: jsonControl,
};
const SHOWN_UNSET = new Set(["number", "amount", "auto", "check", "select", "direction"]);
const WIDE = new Set(["amount", "direction", "numbers", "json"]);

let rows = [];                 // what is shown: {path, element, control, fallback}
const opened = new Map();      // which groups the user has opened or closed, by path

/* ---- one value ---- */

const reset = path => edit([{ path, value: copy(get(state.original, path)) }]);

const refreshRow = row => {
  const value = get(state.document, row.path), original = get(state.original, row.path);
  const line = row.element.querySelector(".refused");
  if (!line.hidden && !same(value, row.refused)) line.hidden = true;
  row.control.update(value ?? copy(row.fallback), original ?? row.fallback);
  row.element.classList.toggle("changed", !same(value, original));
  row.element.classList.toggle("unset", value === undefined);
};

const stepOf = () => {
  const box = state.welcome.extent, unit = state.document.meters_per_unit ?? 1;
  const size = box ? Math.hypot(...box[1].map((x, i) => x - box[0][i])) / unit : 1;
  return 10 ** Math.floor(Math.log10(size > 0 && Number.isFinite(size) ? size / 100 : 0.01));
};

/* A row of a label, a control and a unit. take: what a change does; by default it sets the value. */
export const makeRow = (path, key, schema, { name = label(key, path), control = null, fallback = schema.default, take = null } = {}) => {
  const change = take ?? ((value, moving) => edit([{ path, value }], moving));
  const found = control ? { kind: "select", limits: {} } : controlOf(schema, get(state.document, path) ?? fallback);
  const made = control ?? MAKERS[found.kind]({ ...found, name, change, step: stepOf() });
  const text = make("span", { class: "name" }, name), unit = unitOf(schema);
  const element = make("div", { class: `row${WIDE.has(found.kind) ? " wide" : ""}`, "data-path": path },
    make("div", { class: "head" },
      make("button", { type: "button", class: "reset", "aria-label": `Reset ${name}`, click: () => reset(path) }, "↺"),
      text, make("span", { class: "unit" }, unit)),
    made.element, make("p", { class: "refused", role: "alert", hidden: true }));
  setTip(text, () => [path, schema.description, [describeRange(found.limits), unit].filter(Boolean).join(" "),
    schema.default === undefined ? "" : `Default: ${JSON.stringify(schema.default)}`]);
  const row = { path, element, control: made, fallback };
  rows.push(row);
  refreshRow(row);
  return element;
};

/* ---- groups ---- */

/* A part that opens; its contents are made when it does. */
const makeGroup = (path, title, open, fillIn, { remove = null, section = false } = {}) => {
  const body = make("div", { class: "body" });
  const summary = make("summary", {}, make("span", { class: "title" }, title));
  if (remove) summary.append(make("button", { type: "button", class: "remove", "aria-label": `Remove ${title}`, click: event => {
    event.preventDefault();
    remove();
  } }, "×"));
  const details = make("details", { class: section ? "section" : "group", "data-group": path }, summary, body);
  let filled = false;
  const fillOnce = () => {
    if (filled) return;
    filled = true;
    body.append(...fillIn());
  };
  details.open = opened.get(path) ?? open;
  if (details.open) fillOnce();
  details.addEventListener("toggle", () => {
    if (details.open) fillOnce();
    if (details.isConnected) opened.set(path, details.open);
  });
  return details;
};

/* Keys that are not there yet, in a menu. */
const makeAdder = (path, candidates) => {
  const usable = candidates.filter(([, schema]) => initial(schema) !== undefined);
  if (usable.length === 0) return null;
  const select = make("select", { class: "adder", "aria-label": "Add a key", change: () => {
    const [key, schema] = usable[select.selectedIndex - 1];
    edit([{ path: join(path, key), value: initial(schema) }]);
  } }, make("option", {}, "Add …"), ...usable.map(([key]) => make("option", {}, label(key))));
  return select;
};

/* The value of a key: a row, or a group of what is in it. */
const CLOSED = new Set(["noise", "bounds", "transform", "raw"]);
const makePart = (path, key, schema, value) => {
  const { kind, limits } = controlOf(schema, value), removable = { remove: () => edit([{ path, value: undefined }]) };
  const [inner] = Object.keys(limits.properties ?? {}), only = kind === "object" && Object.keys(limits.properties ?? {}).length === 1;
  if (only && value[inner] !== undefined && controlOf(resolve(limits.properties[inner]), value[inner]).kind === "object")
    return makeGroup(path, `${label(key)}: ${inner}`, false,
      () => makeObject(join(path, inner), variantOf(resolve(limits.properties[inner]), value[inner])), removable);
  if (kind === "object")
    return makeGroup(path, label(key), !CLOSED.has(key), () => makeObject(path, limits), schema.needed ? {} : removable);
  if (kind === "list") {
    const items = resolve(limits.items);
    return makeGroup(path, `${label(key)} (${value.length})`, false, () => value.map((item, i) =>
      makePart(join(path, i), limits.maxItems === 2 ? ["lower corner", "upper corner"][i] : `${i + 1}`, { ...items, needed: true }, item)));
  }
  return makeRow(path, key, schema);
};

/* All keys of an object: those it has, those whose default a control can show, and a menu of the others. */
export const makeObject = (path, schema, { skip = [], before = [], last = [] } = {}) => {
  const value = get(state.document, path) ?? {}, elements = [...before], candidates = [];
  const parts = Object.entries(schema.properties ?? {});
  for (const [key, part] of [...parts.filter(([key]) => !last.includes(key)), ...parts.filter(([key]) => last.includes(key))]) {
    const full = resolve(part);
    if (skip.includes(key) || full.const !== undefined) continue;
    const at = join(path, key);
    if (value[key] !== undefined)
      elements.push(makePart(at, key, { ...full, needed: schema.required?.includes(key) }, value[key]));
    else if (full.default !== undefined && SHOWN_UNSET.has(controlOf(full, full.default).kind)) elements.push(makeRow(at, key, full));
    else candidates.push([key, full]);
  }
  const adder = makeAdder(path, candidates);
  return adder ? [...elements, adder] : elements;
};

/* ---- sections ---- */

const schemaOf = key => resolve(state.welcome.schema.properties[key]);

const removeItem = (key, index) => {
  const next = copy(state.document[key]);
  next.splice(index, 1);
  edit([{ path: key, value: next }]);
};

const addItem = (key, schema) => {
  edit([{ path: key, value: [...copy(state.document[key] ?? []), initial(schema)] }]);
};

const makeItem = (key, item, index, count) => {
  const path = join(key, index), schema = variantOf(resolve(schemaOf(key).items), item);
  return makeGroup(path, titleOf(key, item, index), count <= 2, () => {
    const { skip = [], before = [] } = key === "media" ? coefficientRows(path, item, schema, makeRow) : {};
    return makeObject(path, schema, { skip, before, last: ["density", "bounds", "transform"] });
  }, { remove: () => removeItem(key, index) });
};

const makeList = (key, title) => {
  const items = state.document[key] ?? [], item = resolve(schemaOf(key).items), kinds = variants(item);
  const name = ({ properties, required = [] }) => {
    const type = properties.type?.const;
    if (type === undefined) return required[0];
    return type !== "environment" ? type : required.includes("sky") ? "sky" : "uniform environment";
  };
  const choices = (kinds.length > 0 ? kinds : [item]).filter(schema => initial(schema) !== undefined);
  return makeGroup(key, `${title}${items.length > 1 ? ` (${items.length})` : ""}`, items.length > 0, () => {
    const select = make("select", { class: "adder", "aria-label": `Add to ${title}`,
      change: () => addItem(key, choices[select.selectedIndex - 1]) },
      make("option", {}, { media: "Add a medium …", lights: "Add a light …", geometry: "Add a surface …" }[key]),
      ...choices.map(schema => make("option", {}, name(schema) ?? "medium")));
    return [...items.map((one, i) => makeItem(key, one, i, items.length)), select];
  }, { section: true });
};

/* The key of a method's options in render: cda has those of fld. */
const optionsOf = name => name === "cda" ? "fld" : name;

const makeMethod = () => {
  const name = methodShown(), method = state.welcome.methods.find(one => one.name === name), key = optionsOf(name);
  const options = method?.options ?? schemaOf("render").properties[key];
  const summary = make("p", { class: "note" }, method?.summary ?? "");
  return makeGroup("method", `Method: ${name}`, true, () => [summary,
    ...options ? makeObject(`render.${key}`, resolve(options)) : []], { section: true });
};

const makeScene = () => makeGroup("scene", "Scene", false, () =>
  [...makeObject("render", { properties: { spp: schemaOf("render").properties.spp, seed: schemaOf("render").properties.seed } }),
    ...["meters_per_unit", "up_axis", "frame"].map(key => makeRow(key, key, schemaOf(key)))], { section: true });

/* ---- a photograph: the medium, and the options of tyndall screen ---- */

const PHOTO_PARTS = {
  "Light around": ["environment", "balance"],
  Photograph: ["distance-channel", "distance-scale", "depth-is", "sky", "fov-y", "focal", "center"],
};

/* The options that the variant has, but for those of other parts. */
const screenKeys = () => {
  const { properties } = state.welcome.schema, variant = state.document.variant ?? properties.variant.default;
  const elsewhere = new Set(["medium", ...Object.values(PHOTO_PARTS).flat()]);
  return Object.keys(properties).filter(key => !elsewhere.has(key) && (properties[key]["x-variants"]?.includes(variant) ?? true));
};

const makeOptions = (title, open, keys) => makeGroup(title, title, open, () =>
  makeObject("", { properties: Object.fromEntries(keys.map(key => [key, schemaOf(key)])) }), { section: true });

const makePhoto = () => [
  makeGroup("medium", "Medium", true, () => {
    const schema = schemaOf("medium"), { skip, before } = coefficientRows("medium", state.document.medium, schema, makeRow);
    return makeObject("medium", schema, { skip, before });
  }, { section: true }),
  makeOptions("Light around", true, PHOTO_PARTS["Light around"]),
  makeOptions("Screen-space scattering", true, screenKeys()),
  makeOptions("Photograph", false, PHOTO_PARTS.Photograph)];

const makeParts = () => [makeList("media", "Media"), makeList("lights", "Lights"), makeMethod(), makeList("geometry", "Surfaces"),
  makeGroup("camera", "Camera", false, () => makeObject("camera", schemaOf("camera"), { skip: ["file", "name"] }), { section: true }),
  makeScene()];

const build = () => {
  const panel = find("#scene-panels"), focused = document.activeElement?.closest?.("[data-path]")?.dataset.path;
  const top = panel.scrollTop;
  rows = [];
  panel.replaceChildren(...isPhoto() ? makePhoto() : makeParts());
  panel.scrollTop = top;
  if (focused) panel.querySelector(`[data-path="${CSS.escape(focused)}"] :is(input, select)`)?.focus({ preventScroll: true });
};

let built = "";
const refresh = () => {
  if (state.document === null || state.welcome === null) return;
  const { render, ...rest } = state.document, { position, target, fov_y, ...camera } = rest.camera ?? {};
  const now = `${methodShown()} ${state.document.variant} ${shape({ ...rest, camera })} ${shape(render?.[optionsOf(methodShown())] ?? {})}`;
  if (now !== built) {
    built = now;
    build();
  } else rows.forEach(refreshRow);
};

/* A refusal is shown below its control until the next change; returns false where there is none. */
export const showRefusal = (path, text) => {
  const row = rows.find(one => one.path === path || path.startsWith(one.path));
  const line = row?.element.querySelector(".refused");
  if (!line) return false;
  line.replaceChildren(text, make("button", { type: "button", "aria-label": "Dismiss", click: () => line.hidden = true }, "×"));
  line.hidden = false;
  row.refused = copy(get(state.document, row.path));
  return true;
};

on("server:welcome", () => {
  built = "";
  refresh();
});
for (const event of ["document", "view"]) on(event, refresh);
on("camera", () => {
  for (const row of rows) if (row.path.startsWith("camera")) refreshRow(row);
});
