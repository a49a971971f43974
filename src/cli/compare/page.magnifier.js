
/* ---- the magnifier ---- */

const lensReach = 5;

const drawLens = (lens, image) => {
  const side = 2 * lensReach + 1, ink = lens.getContext("2d");
  const source = painted(image, view.left === image ? view.right : view.left);
  ink.clearRect(0, 0, side, side);
  ink.drawImage(source, view.x - lensReach, view.y - lensReach, side, side, 0, 0, side, side);
};

const ratio = (a, b) => b !== 0 ? number(a / b, 4) : a === 0 ? "1" : "–";

const rowsAt = () => {
  const at = view.y * columns + view.x, { left, right } = view;
  const pair = value => [left, right].map(image => covers(image, view.x, view.y) ? value(image) : NaN);
  return [...["R", "G", "B"].map((name, c) => [name, ...pair(image => valueAt(image, c, at))]),
    ["luminance", ...pair(image => luminanceAt(image, at))]];
};

const drawMagnifier = () => {
  const { left, right } = view, k = report.shrink;
  const cell = (a, b) => [number(a, 4), number(b, 4), ratio(b, a)];
  find("#lens-left-name").textContent = left.name;
  find("#lens-right-name").textContent = right.name;
  find("#place").textContent = `x ${view.x * k}, y ${view.y * k} of ${report.width} × ${report.height}`;
  find("#values").replaceChildren(...rowsAt().map(([name, a, b]) =>
    make("tr", {}, make("th", { scope: "row" }, name), ...cell(a, b).map(text => make("td", {}, text)))));
  drawLens(find("#lens-left"), left);
  drawLens(find("#lens-right"), right);
  Object.assign(find("#spot").style, {
    left: 100 * (view.x + 0.5) / columns + "%", top: 100 * (view.y + 0.5) / rows + "%",
    width: 100 / columns + "%", height: 100 / rows + "%",
  });
};

/* Words of a screen reader after a key. */
const sayReading = () => {
  const [, , , [, a, b]] = rowsAt();
  find("#reading").textContent =
    `${find("#place").textContent}: luminance ${number(a)} in ${view.left.name}, ${number(b)} in ${view.right.name}`;
};

const moveTo = (x, y) => {
  view.x = Math.min(Math.max(x, 0), columns - 1);
  view.y = Math.min(Math.max(y, 0), rows - 1);
  if (view.right.halves !== null && view.left.halves !== null) drawMagnifier();
};
