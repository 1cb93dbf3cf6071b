// SPDX-License-Identifier: Apache-2.0
// Functions that every page uses. Texts from files only ever become text nodes, so no name can be markup.
"use strict";

const data = JSON.parse(document.getElementById("data").textContent);

/** An element with attributes and children; children are nodes or texts. */
function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name === "style") Object.assign(node.style, value);
    else if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

function svg(tag, attributes, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes || {})) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

const isNumber = (value) => typeof value === "number" && Number.isFinite(value);
const listOf = (value) => (Array.isArray(value) ? value : []);

/** A number with about three digits and a prefix: 12.3 M. */
function short(value) {
  if (!isNumber(value)) return "unknown";
  const size = Math.abs(value);
  for (const [factor, name] of [[1e12, " T"], [1e9, " G"], [1e6, " M"], [1e3, " k"]])
    if (size >= factor) return (value / factor).toPrecision(3) + name;
  return Number.isInteger(value) ? String(value) : value.toPrecision(3);
}

function bytesText(value) {
  if (!isNumber(value)) return "unknown";
  for (const [factor, name] of [[1e9, "GB"], [1e6, "MB"], [1e3, "kB"]])
    if (value >= factor) return (value / factor).toPrecision(3) + " " + name;
  return value + " B";
}

function secondsText(value) {
  if (!isNumber(value)) return "unknown";
  if (value >= 3600) return Math.floor(value / 3600) + " h " + Math.round((value % 3600) / 60) + " min";
  if (value >= 120) return Math.floor(value / 60) + " min " + Math.round(value % 60) + " s";
  if (value >= 0.1 || value === 0) return value.toFixed(value >= 10 ? 1 : 2) + " s";
  return (1e3 * value).toPrecision(3) + " ms";
}

/** relMSE as the percentage that is its root: easier to read than 1e-4. */
const percentError = (relmse) => (isNumber(relmse) ? (100 * Math.sqrt(relmse)).toPrecision(3) + " %" : "unknown");

/** columns: [{name, number: true for figures, cell: row -> text or node}] */
function table(columns, rows, caption) {
  const side = (column) => (column.number ? { class: "number" } : {});
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    el("table", { "aria-label": caption },
      el("thead", {}, el("tr", {}, ...columns.map((c) => el("th", { scope: "col", ...side(c) }, c.name)))),
      el("tbody", {}, ...rows.map((row) => el("tr", {}, ...columns.map((c) => el("td", side(c), c.cell(row))))))));
}
