/* The camera's geometry: vectors, orbit, pan, dolly, fly. */

export const add = (a, b) => a.map((x, i) => x + b[i]);
export const subtract = (a, b) => a.map((x, i) => x - b[i]);
export const times = (a, factor) => a.map(x => x * factor);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = a => Math.hypot(...a);
export const unit = a => times(a, 1 / (length(a) || 1));

/* Turned about an axis of length 1 (Rodrigues). */
const turn = (v, axis, angle) => {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(times(v, c), times(cross(axis, v), s)), times(axis, dot(axis, v) * (1 - c)));
};

const upOf = camera => unit(camera.up);

/* Right, up and forward of the view. */
export const axes = camera => {
  const forward = unit(subtract(camera.target, camera.position));
  let right = cross(forward, upOf(camera));
  if (length(right) < 1e-6) right = cross(forward, Math.abs(forward[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
  right = unit(right);
  return { right, up: cross(right, forward), forward };
};

/* An arm turned to the side and upwards, no nearer to the pole than half a degree. */
const swing = (arm, camera, side, rise) => {
  const up = upOf(camera), { right } = axes(camera);
  const angle = Math.acos(Math.min(Math.max(dot(unit(arm), up), -1), 1)); // from the pole
  const margin = Math.PI / 360, wanted = Math.min(Math.max(angle - rise, margin), Math.PI - margin);
  const towards = dot(arm, axes(camera).forward) > 0 ? 1 : -1;
  return turn(turn(arm, right, towards * (angle - wanted)), up, side);
};

/* About the target. */
export const orbit = (camera, side, rise) =>
  ({ position: add(camera.target, swing(subtract(camera.position, camera.target), camera, side, rise)) });

/* About the camera. */
export const look = (camera, side, rise) =>
  ({ target: add(camera.position, swing(subtract(camera.target, camera.position), camera, side, rise)) });

/* By fractions of the view's height at the target. */
export const pan = (camera, x, y) => {
  const { right, up } = axes(camera), distance = length(subtract(camera.target, camera.position));
  const height = 2 * distance * Math.tan(camera.fov_y * Math.PI / 360);
  const shift = add(times(right, x * height), times(up, y * height));
  return { position: add(camera.position, shift), target: add(camera.target, shift) };
};

/* Towards the target: the distance times a factor, no nearer than nearest. */
export const dolly = (camera, factor, nearest) => {
  const arm = subtract(camera.position, camera.target);
  return { position: add(camera.target, times(unit(arm), Math.max(length(arm) * factor, nearest))) };
};

/* Right, up, forward in metres. */
export const fly = (camera, [x, y, z]) => {
  const { right, forward } = axes(camera);
  const shift = add(add(times(right, x), times(upOf(camera), y)), times(forward, z));
  return { position: add(camera.position, shift), target: add(camera.target, shift) };
};
