// SPDX-License-Identifier: Apache-2.0
// This file paints the view's picture, and draws a path over it.
"use strict";

const canvas = document.getElementById("canvas"), overlay = document.getElementById("overlay");
const LEAST_ERROR = 1e-4, MOST_ERROR = 10;  // relative errors at the ends of the scale of colours

/** frame: what is known of the picture; linear: three values a pixel; size: of the whole picture in pixels */
function paint(frame, linear, exposure, tone, size) {
  canvas.width = frame.width;
  canvas.height = frame.height;
  const context = canvas.getContext("2d"), pixels = context.createImageData(frame.width, frame.height);
  const layer = frame.layer;
  if (["picture", "denoised", "lights"].includes(layer)) expose(linear, pixels.data, exposure, tone);
  else if (layer === "albedo") expose(linear, pixels.data, 0, "none");
  else if (layer === "normal") fillPlain(linear, pixels.data);
  else if (layer === "depth") {
    const [near, far] = depths(linear);
    fillHeat(linear, pixels.data, (v) => (v > 0 ? 1 - (v - near) / Math.max(far - near, 1e-12) : 0));
    showLegend(near.toPrecision(3) + " m", far.toPrecision(3) + " m", true);
  } else {
    fillHeat(linear, pixels.data, (v) => (v > 0 ? Math.log(v / LEAST_ERROR) / Math.log(MOST_ERROR / LEAST_ERROR) : 0));
    showLegend(100 * LEAST_ERROR + " %", 100 * MOST_ERROR + " % of the pixel's value", false);
  }
  document.getElementById("legend").hidden = layer !== "depth" && layer !== "error";
  context.putImageData(pixels, 0, 0);
  fit(size);
}

/** The least and the greatest of the depths that are known. */
function depths(linear) {
  let near = Infinity, far = 0;
  for (const value of linear) {
    if (value > 0) near = Math.min(near, value);
    far = Math.max(far, value);
  }
  return near < Infinity ? [near, far] : [0, 0];
}

function fillPlain(linear, pixels) {
  for (let i = 0, k = 0; i < linear.length; i += 3, k += 4) {
    for (let c = 0; c < 3; ++c) pixels[k + c] = 255 * linear[i + c];
    pixels[k + 3] = 255;
  }
}

/** share: value -> 0 to 1 on the scale of colours */
function fillHeat(linear, pixels, share) {
  for (let i = 0, k = 0; i < linear.length; i += 3, k += 4) {
    pixels.set(heat(share(linear[i])), k);
    pixels[k + 3] = 255;
  }
}

function showLegend(low, high, reversed) {
  const gradient = reversed ? heatGradient().replace("to right", "to left") : heatGradient();
  document.getElementById("legend").replaceChildren(el("span", {}, low), el("i", { style: { background: gradient } }), el("span", {}, high));
}

/** Gives the canvas the largest size that fits, whatever the number of its pixels is. */
function fit([width, height]) {
  const box = document.getElementById("picture").getBoundingClientRect();
  const scale = Math.min(box.width / width, box.height / height);
  canvas.style.width = Math.floor(width * scale) + "px";
  canvas.style.height = Math.floor(height * scale) + "px";
  const at = canvas.getBoundingClientRect();
  Object.assign(overlay.style, { width: canvas.style.width, height: canvas.style.height, left: at.left - box.left + "px", top: at.top - box.top + "px" });
}

/** Draws a path: lines between its vertices, and a dot at each that is a surface. x, y: of its pixel */
function drawPath(path, x, y, [width, height]) {
  overlay.setAttribute("viewBox", "0 0 " + width + " " + height);
  overlay.replaceChildren();
  const radius = Math.max(width, height) / 160, seen = path.vertices.map((v, i) => (i === 1 && v.distance !== null ? [x + 0.5, y + 0.5] : v.pixel));
  for (let i = 1; i + 1 < seen.length; ++i) {
    const [a, b] = [seen[i], seen[i + 1]];
    if (!a || !b) continue;
    for (const [stroke, wide] of [["#fff", 0.8], ["#d9361e", 0.4]])
      overlay.append(svg("line", { x1: a[0], y1: a[1], x2: b[0], y2: b[1], stroke, "stroke-width": wide * radius }));
  }
  path.vertices.forEach((v, i) => {
    if (i > 0 && seen[i] && v.distance !== null)
      overlay.append(svg("circle", { cx: seen[i][0], cy: seen[i][1], r: radius, fill: "#d9361e", stroke: "#fff", "stroke-width": 0.4 * radius }));
  });
}

/** The vertices in words. radius: of the scene */
function pathWords(path, radius) {
  const figures = (values) => values.map((v) => Number(v.toPrecision(3))).join(", ");
  const place = (v) => decimals(v, 1e-3 * radius).join(", ");
  const words = path.vertices.slice(1).map((v) => (v.distance === null ? "leaves the scene" : v.distance.toPrecision(4) + " m, to (" + place(v.point) + ")"));
  words.push("brings radiance " + figures(path.radiance));
  if (path.light_paths.some((v) => v > 0)) words.push("light paths bring " + figures(path.light_paths));
  return words.map((text) => el("li", {}, text));
}
