/* Values in a document by paths such as media[0].density.noise.seed. */

const parts = path => (path.match(/[^.[\]]+/g) ?? []).map(part => /^\d+$/.test(part) ? Number(part) : part);

export const join = (path, key) => typeof key === "number" ? `${path}[${key}]` : path === "" ? key : `${path}.${key}`;

export const get = (document, path) =>
  parts(path).reduce((value, part) => value === undefined || value === null ? undefined : value[part], document);

/* Sets a value, makes missing objects on the way; undefined removes the key. */
export const put = (document, path, value) => {
  const way = parts(path), last = way.pop();
  let at = document;
  for (const part of way) {
    if (at[part] === undefined || at[part] === null || typeof at[part] !== "object") {
      if (value === undefined) return;
      at[part] = {};
    }
    at = at[part];
  }
  if (value === undefined) delete at[last];
  else at[last] = value;
};

export const same = (a, b) => {
  if (a === b) return true;
  if (typeof a !== "object" || typeof b !== "object" || a === null || b === null || Array.isArray(a) !== Array.isArray(b))
    return false;
  const keys = Object.keys(a);
  return keys.length === Object.keys(b).length && keys.every(key => same(a[key], b[key]));
};

/* The same but for the last digits of numbers, which a change of units may change. */
export const near = (a, b) => {
  if (typeof a === "number" && typeof b === "number") return Math.abs(a - b) <= 1e-5 * Math.max(Math.abs(a), Math.abs(b), 1e-6);
  if (typeof a !== "object" || typeof b !== "object" || !a || !b) return a === b;
  const keys = Object.keys({ ...a, ...b });
  return Array.isArray(a) === Array.isArray(b) && keys.every(key => near(a[key], b[key]));
};

export const copy = value => value === undefined ? undefined : structuredClone(value);

/* Keys and kinds without the values: where two documents agree in it, the same controls show both. */
export const shape = value => {
  if (Array.isArray(value))
    return value.length > 0 && value.every(item => typeof item === "number") ? `n${value.length}` : `[${value.map(shape)}]`;
  if (value !== null && typeof value === "object")
    return `{${Object.keys(value).sort().map(key => `${key}:${shape(value[key])}`)}}`;
  return typeof value;
};
