/* The panels' knowledge of media, lights and surfaces beyond the schema: titles, first values, the three forms of coefficients. */

import { selectControl } from "./controls.js";
import { edit } from "./edit.js";
import { get, join } from "./path.js";
import { resolve } from "./schema.js";
import { state } from "./state.js";

const fileName = path => path?.split("/").pop();

export const titleOf = (key, item, index) => {
  if (key === "media") return item.name || item.preset || `medium ${index + 1}`;
  if (key === "lights") {
    const kind = item.sky ? "sky" : item.file ? fileName(item.file) : item.type;
    return `${kind} ${index + 1}`;
  }
  return fileName(item.file) ?? `${["quad", "box", "sphere"].find(kind => kind in item) ?? "surface"} ${index + 1}`;
};

/* Middle and diagonal of the scene, in units. */
const sceneBox = () => {
  const unit = state.document.meters_per_unit ?? 1, box = state.welcome.extent ?? [[-1, -1, -1], [1, 1, 1]];
  const [low, high] = box.map(corner => corner.map(x => x / unit));
  const size = Math.hypot(...high.map((x, i) => x - low[i]));
  return { low, high, middle: low.map((x, i) => (x + high[i]) / 2), size: size > 0 && Number.isFinite(size) ? size : 1, unit };
};

const tidyAll = values => values.map(x => Number(x.toPrecision(3)));

/* First values by the names of keys, where a scene suggests them. */
const suggested = {
  direction: () => state.document.up_axis === "z" ? [-0.5, 0.4, -0.6] : [-0.5, -0.6, -0.4],
  position: () => {
    const { middle, high, size } = sceneBox(), up = state.document.up_axis === "z" ? 2 : 1;
    return tidyAll(middle.map((x, i) => i === up ? high[i] + 0.25 * size : x));
  },
  intensity: () => Number(((sceneBox().size * sceneBox().unit) ** 2).toPrecision(2)),
  irradiance: () => 1, radiance: () => 1, sky: () => ({}), temperature: () => undefined, noise: () => ({}),
  box: () => [tidyAll(sceneBox().low), tidyAll(sceneBox().high)],
  air: () => [tidyAll(sceneBox().low), tidyAll(sceneBox().high)],
  center: () => tidyAll(sceneBox().middle), radius: () => Number((0.2 * sceneBox().size).toPrecision(2)),
  origin: () => tidyAll(sceneBox().middle), u: () => [Number((0.3 * sceneBox().size).toPrecision(2)), 0, 0],
  v: () => state.document.up_axis === "z" ? [0, Number((0.3 * sceneBox().size).toPrecision(2)), 0]
    : [0, 0, Number((-0.3 * sceneBox().size).toPrecision(2))],
  rotate: () => [0, 0, 0], translate: () => [0, 0, 0], emission: () => undefined,
  phase: () => ({ type: "mie", diameter: 10 }),
};

/* A first value that a schema allows, or undefined where only the user can know one, such as a file. */
export const initial = (schema, key = "") => {
  const full = resolve(schema);
  if (full.const !== undefined) return full.const;
  if (full.title === undefined && full.properties?.sigma_t)
    return { bounds: suggested.box(), sigma_t: Number((1 / (sceneBox().size * sceneBox().unit)).toPrecision(1)), albedo: 0.9 };
  if (key in suggested && suggested[key]() !== undefined) return suggested[key]();
  if (full.default !== undefined) return structuredClone(full.default);
  if (full.anyOf || full.oneOf) {
    for (const choice of full.anyOf ?? full.oneOf) {
      const value = initial(choice, key);
      if (value !== undefined) return value;
    }
    return undefined;
  }
  if (full.enum) return full.enum[0];
  if (full.type === "boolean") return true;
  if (full.type === "number" || full.type === "integer") return Math.min(Math.max(1, full.minimum ?? 1), full.maximum ?? 1);
  if (full.type === "array" && full.maxItems <= 4) {
    const items = Array.from({ length: full.minItems }, () => initial(full.items));
    return items.includes(undefined) ? undefined : items;
  }
  if (full.type !== "object") return undefined;
  const value = {};
  for (const required of full.required ?? []) {
    value[required] = initial(full.properties[required], required);
    if (value[required] === undefined) return undefined;
  }
  return value;
};

/* ---- coefficients: exactly one of three forms ---- */

const FORMS = ["extinction, albedo", "scattering, absorption", "preset"];
const KEYS = [["sigma_t", "albedo"], ["sigma_s", "sigma_a"], ["preset", "visibility", "dilution"]];

const formOf = medium => medium.preset !== undefined ? 2 : medium.sigma_t !== undefined ? 0 : 1;

const each = (a, b, action) => {
  if (typeof a === "number" && typeof b === "number") return Number(action(a, b).toPrecision(5));
  const [p, q] = [a, b].map(x => typeof x === "number" ? [x, x, x] : x);
  return p.map((x, i) => Number(action(x, q[i]).toPrecision(5)));
};
const isConstant = value => typeof value === "number" || Array.isArray(value);

/* The coefficients of one form in another: the same where they are known. */
const convert = (medium, form) => {
  const { sigma_t = 1, albedo = 0.9, sigma_s = 0, sigma_a = 0 } = medium, from = formOf(medium);
  if (form === 2) return { preset: state.welcome.presets[0] };
  if (from === 2 || !isConstant(albedo)) return form === 0 ? { sigma_t: 1, albedo: 0.9 } : { sigma_s: 0.9, sigma_a: 0.1 };
  if (form === 1)
    return { sigma_s: each(sigma_t, albedo, (t, a) => t * a), sigma_a: each(sigma_t, albedo, (t, a) => t * (1 - a)) };
  return { sigma_t: each(sigma_s, sigma_a, (s, a) => s + a), albedo: each(sigma_s, sigma_a, (s, a) => s + a > 0 ? s / (s + a) : 0) };
};

const setForm = (path, form) => {
  const next = convert(get(state.document, path), form);
  edit(KEYS.flat().filter(key => key in next || get(state.document, join(path, key)) !== undefined)
    .map(key => ({ path: join(path, key), value: next[key] })));
};

/* Letters and digits count. */
const plain = name => name.toLowerCase().replace(/[^a-z0-9]/g, "");
const needsVisibility = name => ["fog", "haze"].includes(plain(name));

const setPreset = (path, name) => {
  const visibility = get(state.document, join(path, "visibility"));
  const through = Number((2 * sceneBox().size * sceneBox().unit).toPrecision(2));
  edit([{ path: join(path, "preset"), value: name },
    { path: join(path, "visibility"), value: needsVisibility(name) ? visibility ?? through : undefined },
    ...needsVisibility(name) ? [{ path: join(path, "dilution"), value: undefined }] : []]);
};

/* The rows that choose the form of a medium's coefficients, and the keys that do not belong to it. */
export const coefficientRows = (path, medium, schema, makeRow) => {
  const form = formOf(medium), { presets } = state.welcome;
  const chooser = selectControl({ limits: { enum: FORMS }, name: "Coefficients", change: word => setForm(path, FORMS.indexOf(word)) });
  const before = [makeRow(`${path}.*`, "coefficients", { description: "Coefficients are given in exactly one of these forms." },
    { control: { ...chooser, update: () => chooser.update(FORMS[form]) } })];
  const skip = KEYS.filter((_, i) => i !== form).flat();
  if (form === 2) {
    const known = presets.find(name => plain(name) === plain(medium.preset)) ?? medium.preset;
    const list = presets.includes(known) ? presets : [known, ...presets];
    const names = selectControl({ limits: { enum: list }, name: "Preset", change: name => setPreset(path, name) });
    before.push(makeRow(join(path, "preset"), "preset", resolve(schema.properties.preset),
      { control: { ...names, update: value => names.update(list.find(name => plain(name) === plain(value ?? "")) ?? value) } }));
    skip.push("preset");
    if (!needsVisibility(medium.preset)) skip.push("visibility");
    else skip.push("dilution");
  } else if (medium.transfer?.some(point => point.albedo !== undefined)) skip.push("albedo");
  return { skip, before };
};

/* True if a volume's file name has a place for the frame. */
export const hasFrames = document => JSON.stringify(document.media ?? []).includes("#");
