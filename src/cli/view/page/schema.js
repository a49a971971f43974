/* The scene's JSON Schema, as far as panels need it. */

import { state } from "./state.js";

/* A schema with its $refs replaced; its own members stand before those of what it refers to. */
export const resolve = schema => {
  let found = schema ?? {};
  while (found.$ref !== undefined) {
    const { $ref, ...own } = found, name = $ref.split("/").pop(), target = state.welcome.schema.$defs[name];
    const description = [own.description, target.description].filter(Boolean).join(" ");
    found = { ...target, ...own, ...description && { description }, kind: found.kind ?? name };
  }
  return found;
};

const kindOf = value => value === null ? "null" : Array.isArray(value) ? "array" : typeof value;

/* True if a value can be of a schema, by its kind and its keys alone. */
const suits = (schema, value) => {
  const { type, const: only, enum: words, properties, required = [], minItems = 0, maxItems = Infinity, items } = schema;
  if (only !== undefined) return value === only;
  if (words !== undefined) return words.includes(value);
  const kind = kindOf(value);
  if (type === "integer" || type === "number") return kind === "number";
  if (type !== undefined && type !== kind) return false;
  if (kind === "array")
    return value.length >= minItems && value.length <= maxItems && value.every(item => suits(resolve(items), item));
  if (kind !== "object") return true;
  return required.every(key => key in value) && Object.keys(value).every(key => key in (properties ?? {})) &&
    Object.entries(properties ?? {}).every(([key, part]) => !(key in value) || part.const === undefined || part.const === value[key]);
};

export const variants = schema => (schema.anyOf ?? schema.oneOf ?? []).map(resolve);

/* The variant of a schema that a value is of, with what all variants share; the schema itself if it has none. */
export const variantOf = (schema, value) => {
  const found = variants(schema).find(variant => suits(variant, value));
  if (found === undefined) return schema;
  const { anyOf, oneOf, ...common } = schema;
  return { ...found, ...common, ...!common.description && found.description && { description: found.description } };
};

const isNumber = schema => schema.type === "number" || schema.type === "integer";
export const isTriple = schema => schema.type === "array" && schema.minItems === 3 && schema.maxItems === 3;

/* Triples that are no colours: along axes. */
const SPATIAL = /[Vv]oxels along|between voxels|^$/;

/* The control for a value: its kind, and the schema of its numbers. */
export const controlOf = (schema, value) => {
  const choices = variants(schema), numeric = choices.find(isNumber), triple = choices.find(isTriple);
  const plain = value === undefined ? schema : variantOf(schema, value);
  if (numeric && triple && (value === undefined || typeof value === "number" || suits(triple, value)))
    return { kind: "amount", limits: { ...numeric, default: schema.default }, spatial: SPATIAL.test(schema.description ?? "") };
  const word = choices.find(choice => choice.type === "string" && (choice.const ?? choice.enum?.[0]));
  if (numeric && word)
    return { kind: "auto", limits: { ...numeric, default: schema.default }, word: word.const ?? word.enum[0] };
  if (plain.enum) return { kind: "select", limits: plain };
  if (plain.type === "boolean") return { kind: "check", limits: plain };
  if (isNumber(plain)) return { kind: "number", limits: plain };
  if (plain.type === "string") return { kind: "text", limits: plain };
  if (plain.type === "array") {
    const items = resolve(plain.items);
    if (isNumber(items) && plain.maxItems <= 4)
      return { kind: schema.kind === "direction" ? "direction" : "numbers", limits: items, count: plain.maxItems };
    if (isNumber(items)) return { kind: "json", limits: plain };
    return { kind: "list", limits: plain };
  }
  if (plain.type === "object" || plain.properties) return { kind: "object", limits: plain };
  return numeric ? { kind: "number", limits: numeric } : { kind: "json", limits: plain };
};

/* The lowest and the highest value, a hair inside of bounds that are excluded. */
export const range = limits => {
  const whole = limits.type === "integer" ? 1 : 0;
  const inside = (bound, sign) => bound === undefined ? sign * -Infinity
    : bound + sign * (whole || (bound === 0 ? Number.MIN_VALUE : 1e-3 * Math.abs(bound)));
  return [limits.minimum ?? inside(limits.exclusiveMinimum, 1), limits.maximum ?? inside(limits.exclusiveMaximum, -1)];
};

const UNITS = [
  [/W m\^-2 sr\^-1/, "W m⁻² sr⁻¹"], [/W sr\^-1/, "W sr⁻¹"], [/W m\^-2/, "W m⁻²"], [/\b1\/m\b/, "1/m"], [/degrees/i, "°"],
  [/[Pp]ixels\./, "px"], [/distance in metres/, "m"], [/[Ss]tops/, "stops"], [/in units\.|^In units/, "units"],
];

/* The unit that a description names. */
export const unitOf = ({ description = "", type, items }) => {
  const named = /Unit: ([^.]+)\./.exec(description);
  if (named) return named[1];
  if (type === "boolean" || type === "string" || items?.type === "string") return "";
  return UNITS.find(([words]) => words.test(description))?.[1] ?? "";
};

const WORDS = {
  sigma_t: "Extinction σt", sigma_s: "Scattering σs", sigma_a: "Absorption σa", g: "Mean cosine g", spp: "Samples per pixel",
  fov_y: "Field of view", meters_per_unit: "Metres per unit", kelvin: "Temperatures, K",
  "fov-y": "Field of view", "depth-is": "Distances are", "no-normalise": "Not normalised", solar: "Solar irradiance", irradiance: "Irradiance E", intensity: "Intensity I",
};

/* A key in the field's words. */
export const label = (key, path = "") => /^(media\[\d+\]|medium)\.scale$/.test(path) ? "Density scale"
  : WORDS[key] ?? key.charAt(0).toUpperCase() + key.slice(1).replaceAll(/[-_]/g, " ");
