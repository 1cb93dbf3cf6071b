// SPDX-License-Identifier: Apache-2.0
// Charts of a render: its error over time, bars of seconds, rays by bounce, and the timeline.
"use strict";

const COLOURS = ["--c0", "--c1", "--c2", "--c3", "--c4", "--c5", "--c6", "--c7"].map((name) => "var(" + name + ")");
const colourOf = (index) => COLOURS[index % COLOURS.length];

/** About `count` round numbers from low to high. */
function ticks(low, high, count) {
  const rough = (high - low) / count, power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((s) => s >= rough) || power;
  const list = [];
  for (let at = Math.ceil(low / step) * step; at <= high + 1e-9 * step; at += step) list.push(Number(at.toPrecision(12)));
  return list;
}

/** Powers of ten between two values; with their halves and fifths where that leaves few; ticks of equal steps where that does. */
function logTicks(low, high) {
  for (const parts of [[1], [1, 2, 5]]) {
    const list = [];
    for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); ++e)
      for (const part of parts) list.push(part * Math.pow(10, e));
    const inside = list.filter((value) => value >= low && value <= high);
    if (inside.length > 2) return inside;
  }
  return ticks(low, high, 4);
}

/**
 * Draws the root of a relMSE, in percent on a logarithmic axis, over seconds.
 * points: [{at, value, low, high}], by time; low and high may be missing
 */
function errorChart(points) {
  const width = 640, height = 260, left = 64, right = 16, top = 12, bottom = 34;
  const root = (value) => 100 * Math.sqrt(Math.max(value, 1e-16));
  const ends = points.flatMap((p) => [p.value, p.low, p.high]).filter((v) => isNumber(v) && v > 0).map(root);
  if (ends.length === 0) return el("p", { class: "soft" }, "Nothing is known of the error: it takes two samples per pixel.");
  const low = Math.min(...ends) / 1.15, high = Math.max(...ends) * 1.15;
  const end = Math.max(...points.map((p) => p.at), 1e-6);
  const x = (at) => left + (at / end) * (width - left - right);
  const y = (value) => top + (1 - Math.log(root(value) / low) / Math.log(high / low)) * (height - top - bottom);
  const whole = points.filter((p) => isNumber(p.low) && isNumber(p.high));
  const chart = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "predicted error over time" });
  for (const at of ticks(0, end, 6)) {
    chart.append(svg("line", { class: "axis", x1: x(at), x2: x(at), y1: top, y2: height - bottom }),
      svg("text", { x: x(at), y: height - bottom + 16, "text-anchor": "middle" }, String(at)));
  }
  for (const value of logTicks(low, high)) {
    const square = Math.pow(value / 100, 2);
    chart.append(svg("line", { class: "axis", x1: left, x2: width - right, y1: y(square), y2: y(square) }),
      svg("text", { x: left - 6, y: y(square) + 4, "text-anchor": "end" }, Number(value.toPrecision(2)) + " %"));
  }
  chart.append(svg("text", { x: width - right, y: height - 4, "text-anchor": "end" }, "seconds"));
  if (whole.length > 1) {
    const path = [...whole.map((p) => [x(p.at), y(p.high)]), ...whole.slice().reverse().map((p) => [x(p.at), y(p.low)])];
    chart.append(svg("polygon", { points: path.map((p) => p.join(",")).join(" "), fill: "var(--c0)", opacity: "0.22" }));
  }
  chart.append(svg("polyline", { points: points.map((p) => x(p.at) + "," + y(p.value)).join(" "), fill: "none", stroke: "var(--c0)", "stroke-width": "2" }));
  for (const p of points) {
    const words = secondsText(p.at) + ": " + percentError(p.value) +
      (isNumber(p.low) ? " (95 %: " + percentError(p.low) + " to " + (isNumber(p.high) ? percentError(p.high) : "unknown") + ")" : "");
    if (points.length === 1 && isNumber(p.low) && isNumber(p.high))
      chart.append(svg("line", { x1: x(p.at), x2: x(p.at), y1: y(p.low), y2: y(p.high), stroke: "var(--c0)", opacity: "0.5", "stroke-width": "6" }));
    chart.append(svg("circle", { cx: x(p.at), cy: y(p.value), r: points.length > 60 ? 1.5 : 3, fill: "var(--c0)" }, svg("title", {}, words)));
  }
  return chart;
}

/** rows: [{name, value, text, colour}] */
function bars(rows) {
  const most = Math.max(...rows.map((row) => row.value), 1e-12);
  return el("div", { class: "bars" }, ...rows.flatMap((row) => [
    el("span", {}, row.name),
    el("div", { class: "bar", style: { width: 100 * row.value / most + "%", background: row.colour || colourOf(0) } }),
    el("span", { class: "value" }, row.text)]));
}

/** One bar of several parts with a legend. parts: [{name, value, text}] */
function stack(parts) {
  const sum = parts.reduce((total, part) => total + part.value, 0) || 1;
  return el("div", {},
    el("div", { class: "stack", "aria-hidden": "true" }, ...parts.map((part, i) =>
      el("div", { style: { width: 100 * part.value / sum + "%", background: colourOf(i) }, title: part.name + ": " + part.text }))),
    el("ul", { class: "legend" }, ...parts.map((part, i) =>
      el("li", {}, el("i", { style: { background: colourOf(i) } }), part.name + " " + part.text))));
}

/** Pairs of columns by depth: paths and shadow rays. */
function bounceChart(bounces) {
  const width = 640, height = 190, left = 52, bottom = 34, top = 8;
  const most = Math.max(...bounces.flatMap((b) => [b.paths, b.shadow_rays]).filter(isNumber), 1);
  const step = (width - left) / bounces.length, y = (value) => top + (1 - value / most) * (height - top - bottom);
  const chart = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "paths and shadow rays by depth" });
  for (const value of ticks(0, most, 4))
    chart.append(svg("line", { class: "axis", x1: left, x2: width, y1: y(value), y2: y(value) }),
      svg("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, short(value).replace(".00", "")));
  bounces.forEach((bounce, i) => {
    [[bounce.paths, 0, "paths"], [bounce.shadow_rays, 1, "shadow rays"]].forEach(([value, colour, name]) => {
      if (!isNumber(value)) return;
      chart.append(svg("rect", { x: left + (i + 0.14 + 0.36 * colour) * step, width: 0.34 * step, y: y(value),
        height: height - bottom - y(value), fill: colourOf(colour) },
      svg("title", {}, "depth " + bounce.depth + ": " + short(value) + " " + name)));
    });
    chart.append(svg("text", { x: left + (i + 0.5) * step, y: height - bottom + 16, "text-anchor": "middle" }, String(bounce.depth)));
  });
  chart.append(svg("text", { x: width, y: height - 4, "text-anchor": "end" }, "depth of the path"));
  return chart;
}

/** Seconds of stages, stacked by depth. times: of timeByDepth() in report.js */
function depthChart(times) {
  const width = 640, height = 190, left = 52, bottom = 34, top = 8;
  const sumOf = (at) => at.parts.reduce((sum, part) => sum + part.value, 0);
  const most = Math.max(...times.map(sumOf), 1e-9), step = (width - left) / times.length;
  const y = (value) => top + (1 - value / most) * (height - top - bottom);
  const chart = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "estimated time of the stages by depth" });
  for (const value of ticks(0, most, 4))
    chart.append(svg("line", { class: "axis", x1: left, x2: width, y1: y(value), y2: y(value) }),
      svg("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, secondsText(value)));
  times.forEach((at, i) => {
    let below = 0;
    at.parts.forEach((part, k) => {
      chart.append(svg("rect", { x: left + (i + 0.2) * step, width: 0.6 * step, y: y(below + part.value), height: y(below) - y(below + part.value), fill: colourOf(k) },
        svg("title", {}, "depth " + at.depth + ", " + part.name + ": about " + secondsText(part.value))));
      below += part.value;
    });
    chart.append(svg("text", { x: left + (i + 0.5) * step, y: height - bottom + 16, "text-anchor": "middle" }, String(at.depth)));
  });
  chart.append(svg("text", { x: width, y: height - 4, "text-anchor": "end" }, "depth of the path"));
  return el("div", { class: "chart" }, chart, el("ul", { class: "legend" }, ...times[0].parts.map((part, k) =>
    el("li", {}, el("i", { style: { background: colourOf(k) } }), part.name))));
}

/** The spans of every track over time. */
function timelineChart(timeline) {
  const width = 1120, row = 16, gap = 26, left = 4;
  const tracks = listOf(timeline.tracks), end = Math.max(timeline.end_s, 1e-9);
  const height = 26 + tracks.reduce((sum, track) => sum + gap + row * listOf(track.rows).length, 0);
  const x = (at) => left + (at / end) * (width - 2 * left);
  const chart = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "timeline of the render" });
  for (const at of ticks(0, end, 10))
    chart.append(svg("line", { class: "axis", x1: x(at), x2: x(at), y1: 0, y2: height - 20 }),
      svg("text", { x: Math.min(x(at), width - 30), y: height - 6 }, at + " s"));
  const hues = new Map();
  let y = 0;
  for (const track of tracks) {
    chart.append(svg("text", { x: left, y: y + 17 }, String(track.name)));
    y += gap - 4;
    for (const spans of listOf(track.rows)) {
      for (const [begin, until, name] of spans) {
        const words = String(timeline.names[name]);
        if (!hues.has(words)) hues.set(words, colourOf(hues.size));
        const wide = Math.max(x(until) - x(begin), 0.6);
        chart.append(svg("rect", { x: x(begin), y, width: wide, height: row - 2, fill: hues.get(words) },
          svg("title", {}, words + ": " + secondsText(until - begin) + " at " + secondsText(begin))));
        if (wide > 7 * words.length + 8)
          chart.append(svg("text", { x: x(begin) + 4, y: y + row - 5, style: "fill: var(--card); font-size: 11px; pointer-events: none" }, words));
      }
      y += row;
    }
    y += 4;
  }
  return chart;
}
