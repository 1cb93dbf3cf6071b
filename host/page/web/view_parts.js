// SPDX-License-Identifier: Apache-2.0
// The controls of the view: sliders, choices and buttons, each with a label.
"use strict";

const controls = {};

/** A slider with its value beside it. text: value -> words; onInput gets the value */
function range(name, label, limits, text, onInput) {
  const [least, most, step, value] = limits;
  const output = el("output", { for: name }, text(value));
  const input = el("input", { type: "range", id: name, min: least, max: most, step, value,
    oninput: () => { show(Number(input.value)); onInput(Number(input.value)); } });
  const show = (v) => {
    output.textContent = text(v);
    input.setAttribute("aria-valuetext", text(v));
  };
  input.show = (v) => { input.value = v; show(v); };
  show(value);
  controls[name] = input;
  return el("div", { class: "row" }, el("label", { for: name }, label), input, output);
}

/** A drop-down list. options: [[value, text, true if it cannot be chosen]]; onChange gets the value */
function choice(name, label, options, onChange) {
  const select = el("select", { id: name, onchange: () => onChange(select.value) }, ...optionsOf(options));
  controls[name] = select;
  return el("div", { class: "row" }, el("label", { for: name }, label), select);
}

const optionsOf = (options) => options.map(([value, text, disabled]) => el("option", { value, disabled }, text));

/** Fills a list anew, and selects a value, which is added if it is not there. */
function fill(select, options, value) {
  const all = options.some(([v]) => v === value) ? options : [...options, [value, value]];
  const key = JSON.stringify(all);
  if (select.dataset.options !== key) select.replaceChildren(...optionsOf(all));
  select.dataset.options = key;
  select.value = value;
}

const button = (text, onclick, more) => el("button", { type: "button", onclick, ...more }, text);
const group = (title, ...parts) => el("fieldset", {}, el("legend", {}, title), ...parts);
const showRow = (control, shown) => { control.parentElement.hidden = !shown; };

const evText = (v) => (v > 0 ? "+" : "") + v.toFixed(1) + " EV";
