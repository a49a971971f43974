/* Descriptions beside what the pointer or the focus is on. */

import { find, make } from "./dom.js";

let timer = 0;

const hide = () => {
  clearTimeout(timer);
  find("#tip").hidden = true;
};

const showAt = (element, lines) => {
  const tip = find("#tip"), box = element.getBoundingClientRect();
  tip.replaceChildren(...lines.filter(Boolean).map((line, i) => make("p", i === 0 ? { class: "code" } : {}, line)));
  tip.hidden = false;
  const { width, height } = tip.getBoundingClientRect();
  const left = Math.max(8, find("#panels").getBoundingClientRect().left - width - 8);
  tip.style.left = `${left}px`;
  tip.style.top = `${Math.max(8, Math.min(box.top - 4, window.innerHeight - height - 8))}px`;
};

/* lines: a function that gives the path and the sentences. */
export const setTip = (element, lines) => {
  element.addEventListener("pointerenter", () => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (element.isConnected) showAt(element, lines());
    }, 350);
  });
  element.addEventListener("pointerleave", hide);
};

window.addEventListener("pointerdown", hide, true);
window.addEventListener("keydown", hide, true);
window.addEventListener("wheel", hide, { capture: true, passive: true });
