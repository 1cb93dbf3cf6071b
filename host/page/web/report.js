// SPDX-License-Identifier: Apache-2.0
// The report of a render or of a batch. What a file does not say is left out, and what is wrong in it costs one section.
"use strict";

const main = document.getElementById("main");

function section(title, fill) {
  const id = "section-" + main.childElementCount;
  const node = el("section", { "aria-labelledby": id }, el("h2", { id }, title));
  try {
    const content = fill();
    if (!content) return;
    node.append(...[content].flat().filter((part) => part));
  } catch (error) {
    node.append(el("p", { class: "bad" }, "The file does not say this as eikon writes it: " + error.message));
  }
  main.append(node);
}

function facts(pairs) {
  return el("dl", { class: "facts" }, ...pairs.filter((pair) => pair).map(([name, value, more]) =>
    el("div", {}, el("dt", {}, name), el("dd", {}, value, more ? el("small", {}, " " + more) : null))));
}

/** Decodes a picture, given as a data URI, and returns its RGBA bytes, row by row from the top. */
async function pixelsOf(address) {
  const image = new Image();
  image.src = address;
  await image.decode();
  const canvas = el("canvas", { width: image.naturalWidth, height: image.naturalHeight });
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height).data;
}

async function linearOf(picture) {
  const pixels = await pixelsOf(picture.rgbe), count = picture.width * picture.height;
  const rgbe = new Uint8Array(4 * count);
  for (let i = 0; i < count; ++i) {
    for (let c = 0; c < 3; ++c) rgbe[4 * i + c] = pixels[4 * i + c];
    rgbe[4 * i + 3] = pixels[4 * (i + count)];
  }
  return fromRgbe(rgbe);
}

/** A canvas of a picture's size; the pixels of small ones are to be seen as squares. */
function canvasFor(picture, name) {
  return el("canvas", { width: picture.width, height: picture.height, role: "img", "aria-label": name, class: picture.width < 400 ? "coarse" : null });
}

function pictureFigure(picture, display) {
  const canvas = canvasFor(picture, "the rendered picture");
  const shown = el("output", {}, "");
  const start = isNumber(display.exposure) ? display.exposure : 0;
  const slider = el("input", { type: "range", id: "exposure", min: Math.min(-10, start - 5), max: Math.max(10, start + 5), step: 0.1, value: start });
  const tone = el("select", { id: "tone" }, ...TONES.map((name) => el("option", { value: name, selected: name === display.tone }, name)));
  const value = el("span", { class: "mono" });
  const context = canvas.getContext("2d");
  linearOf(picture).then((linear) => {
    const pixels = context.createImageData(picture.width, picture.height);
    const paint = () => {
      expose(linear, pixels.data, Number(slider.value), tone.value);
      context.putImageData(pixels, 0, 0);
      shown.textContent = (slider.value > 0 ? "+" : "") + Number(slider.value).toFixed(1) + " EV";
    };
    slider.addEventListener("input", paint);
    tone.addEventListener("change", paint);
    canvas.addEventListener("mousemove", (event) => {
      const [x, y] = pixelAt(event, canvas, picture), i = 3 * (y * picture.width + x);
      value.textContent = [x * picture.reduced, y * picture.reduced].join(", ") + ": " +
        [0, 1, 2].map((c) => linear[i + c].toPrecision(3)).join("  ");
    });
    paint();
    document.documentElement.dataset.painted = "picture";
  }).catch((error) => canvas.replaceWith(el("p", { class: "bad" }, "The picture cannot be shown: " + error.message)));
  return el("figure", {}, canvas,
    el("div", { class: "controls" }, el("label", { for: "exposure" }, "Exposure"), slider, shown, el("label", { for: "tone" }, "Tone curve"), tone),
    el("figcaption", {}, "Radiance, exposed here" + (picture.reduced > 1 ? `; ${picture.reduced} by ${picture.reduced} pixels of the image are one here` : "") + ". ", value));
}

function pixelAt(event, canvas, picture) {
  const box = canvas.getBoundingClientRect();
  const clamp = (value, most) => Math.min(Math.max(Math.floor(value), 0), most - 1);
  return [clamp((event.clientX - box.left) / box.width * picture.width, picture.width),
    clamp((event.clientY - box.top) / box.height * picture.height, picture.height)];
}

function errorFigure(picture) {
  const canvas = canvasFor(picture, "map of the relative error of each pixel");
  const value = el("span", { class: "mono" });
  const errorOf = (grey) => (grey === 0 ? "below 0.01 %" : (100 * Math.pow(10, grey / 51 - 4)).toPrecision(2) + " %");
  pixelsOf(picture.error).then((pixels) => {
    const context = canvas.getContext("2d"), out = context.createImageData(picture.width, picture.height);
    for (let i = 0; i < out.data.length; i += 4) {
      out.data.set(heat(pixels[i] / 255), i);
      out.data[i + 3] = 255;
    }
    context.putImageData(out, 0, 0);
    canvas.addEventListener("mousemove", (event) => {
      const [x, y] = pixelAt(event, canvas, picture);
      value.textContent = [x * picture.reduced, y * picture.reduced].join(", ") + ": " + errorOf(pixels[4 * (y * picture.width + x)]);
    });
  }).catch((error) => canvas.replaceWith(el("p", { class: "bad" }, "The map cannot be shown: " + error.message)));
  return el("figure", {}, canvas,
    el("div", { class: "ramp", style: { background: heatGradient() } }),
    el("div", { class: "ramp-labels", "aria-hidden": "true" }, ...["0.01 %", "0.1 %", "1 %", "10 %", "100 %", "1000 %"].map((text) => el("span", {}, text))),
    el("figcaption", {}, "Predicted relative standard error of each pixel. ", value));
}

function summary(stats) {
  const size = listOf(stats.size), range = listOf(stats.sample_range), interval = listOf(stats.relmse_interval);
  const seconds = stats.seconds || {};
  const known = isNumber(stats.relmse_predicted);
  return [
    facts([
      size.length === 2 ? ["Size", size.join(" × "), "pixels"] : null,
      range.length === 2 ? ["Samples per pixel", short(range[1] - range[0])] : null,
      ...(stats.settings && stats.settings.caustics ? [["Caustics", stats.settings.caustics]] : []),
      ["Predicted error", known ? percentError(stats.relmse_predicted) : "unknown",
        known && interval.length === 2 ? "95 %: " + percentError(interval[0]) + " to " + (isNumber(interval[1]) ? percentError(interval[1]) : "no upper end") : ""],
      ["Rendering", secondsText(seconds.render), "of " + secondsText(seconds.total)],
      ["Samples a second", short(stats.samples_per_second)],
      ["Rays a second", short(stats.rays_per_second)]]),
    stats.interrupted === true ? el("p", { class: "bad" }, "The render was interrupted: some samples are missing.") : null,
    stats.command ? el("p", { class: "command mono" }, stats.command) : null].filter((part) => part);
}

function errorOverTime(stats, timeline) {
  const counters = (timeline && timeline.counters) || {}, end = (stats.seconds || {}).total;
  const at = (name) => new Map(listOf(counters[name]));
  const low = at("predicted relMSE, low"), high = at("predicted relMSE, high");
  let points = listOf(counters["predicted relMSE"]).filter((p) => p[1] > 0)
    .map(([time, value]) => ({ at: time, value, low: low.get(time), high: high.get(time) }));
  if (points.length === 0 && isNumber(stats.relmse_predicted)) {
    const interval = listOf(stats.relmse_interval);
    points = [{ at: end || 1, value: stats.relmse_predicted, low: interval[0], high: interval[1] }];
  }
  if (points.length === 0) return null;
  return [el("p", { class: "soft" }, "The root of the predicted relMSE, with its 95 % confidence interval, over the seconds since the start. Half of the error takes about four times the samples."),
    el("div", { class: "chart" }, errorChart(points))];
}

// Returns a paragraph about what the pilot decided, or null if there was no pilot.
function pilotText(pilot) {
  if (!pilot) return null;
  const gain = (value) => (value > 0 ? " (predicted gain " + value.toFixed(2) + ")" : "");
  const parts = [];
  if (pilot.light_trial_paths > 0)
    parts.push(pilot.light_path_count > 0 ? short(pilot.light_path_count) + " light paths of each sample" + gain(pilot.light_path_gain)
      : "no light paths, as they would not pay");
  if (pilot.paths > 0) parts.push((pilot.roulette_depth > 0 ? "to guide paths" : "not to guide paths") + gain(pilot.gain));
  return el("p", { class: "soft" }, "A pilot" + (pilot.loaded ? ", made before," : "") + " decided: " + parts.join("; ") +
    ". A gain is how many times less the product of error and rays is.");
}

function whereTimeWent(stats) {
  const seconds = stats.seconds || {};
  const names = [["load", "load"], ["build", "pack and build"], ["compile", "compile"], ["upload", "upload"], ["render", "render"], ["write", "write"]];
  const parts = names.filter(([key]) => isNumber(seconds[key])).map(([key, name]) => ({ name, value: seconds[key], text: secondsText(seconds[key]) }));
  const pilot = stats.pilot;
  if (pilot && pilot.seconds > 0) parts.splice(2, 0, { name: "pilot", value: pilot.seconds, text: secondsText(pilot.seconds) });
  const rest = seconds.total - parts.reduce((sum, part) => sum + part.value, 0);
  if (rest > 0.001) parts.push({ name: "other", value: rest, text: secondsText(rest) });
  const devices = listOf(stats.devices), stages = listOf(stats.stages);
  return [stack(parts), pilotText(pilot), ...devices.map((device, i) => deviceParts(device, stages.filter((stage) => stage.device === i)))];
}

function deviceParts(device, stages) {
  const sum = stages.reduce((total, stage) => total + stage.seconds, 0) || 1, bounces = listOf(device.bounces);
  const rows = stages.filter((stage) => stage.seconds > 0).sort((a, b) => b.seconds - a.seconds).map((stage) => ({
    name: stage.stage, value: stage.seconds, text: secondsText(stage.seconds) + "  " + (100 * stage.seconds / sum).toFixed(1) + " %" +
      (stage.items > 0 ? "  " + short(stage.items / stage.seconds) + "/s" : "") }));
  return el("div", { class: "device" },
    el("h3", {}, "Device " + device.selector + ": " + device.name),
    el("p", { class: "soft" }, [device.driver, "tree as " + device.layout + " (" + device.layout_reason + ")", device.lanes + " lanes",
      "arithmetic " + device.arithmetic, short(device.samples) + " samples in " + device.units + " units", bytesText(device.device_bytes) + " of memory"].join(" · ")),
    el("div", { class: "pair" },
      el("div", {}, el("h3", { class: "soft" }, "Stages, of all bounces"), rows.length > 0 ? bars(rows) : el("p", {}, "It got no work.")),
      bounces.length > 0 ? el("div", {}, el("h3", { class: "soft" }, "Paths and shadow rays by depth"), bounceChart(bounces), bounceTable(bounces, timeByDepth(stages, bounces))) : null),
    bounces.length > 0 ? depthPart(timeByDepth(stages, bounces)) : null);
}

// By what the time of a stage is shared out among depths: the rays that it had there.
const STAGE_RAYS = { intersect: (b) => b.paths, shade: (b) => b.paths, shadow: (b) => b.shadow_rays, generate: (b) => (b.depth === 1 ? b.paths : 0) };

/** [{depth, parts: [{name, value}]}]: seconds of each stage at each depth, an estimate */
function timeByDepth(stages, bounces) {
  const known = stages.filter((stage) => STAGE_RAYS[stage.stage] && stage.seconds > 0).sort((a, b) => b.seconds - a.seconds);
  return bounces.map((bounce) => ({ depth: bounce.depth, parts: known.map((stage) => {
    const rays = STAGE_RAYS[stage.stage], sum = bounces.reduce((total, b) => total + rays(b), 0);
    return { name: stage.stage, value: sum > 0 ? stage.seconds * rays(bounce) / sum : 0 };
  }) }));
}

function depthPart(times) {
  if (times.every((at) => at.parts.length === 0)) return null;
  return el("div", { class: "depths" }, el("h3", { class: "soft" }, "Time by depth, estimated"),
    el("p", { class: "soft" }, "The measured time of each stage, shared out by the rays that it had at each depth."), depthChart(times));
}

function bounceTable(bounces, times) {
  const share = (part, whole) => (whole > 0 ? (100 * part / whole).toFixed(1) + " %" : "");
  return el("details", {}, el("summary", {}, "As a table"), table([
    { name: "depth", number: true, cell: (b) => String(b.depth) },
    { name: "paths", number: true, cell: (b) => short(b.paths) },
    { name: "shadow rays", number: true, cell: (b) => short(b.shadow_rays) },
    { name: "lanes full", number: true, cell: (b) => share(b.paths, b.lanes) },
    { name: "places full", number: true, cell: (b) => share(b.paths, b.slots) },
    { name: "time, estimated", number: true, cell: (b) => secondsText(times.find((at) => at.depth === b.depth).parts.reduce((sum, part) => sum + part.value, 0)) }], bounces, "rays by depth"));
}

function timelinePart(timeline) {
  if (!timeline || listOf(timeline.tracks).length === 0) return null;
  return [el("p", { class: "soft" }, "Spans too short to be drawn are joined under the name of the longest."),
    el("div", { class: "scroll" }, timelineChart(timeline))];
}

function featureTables(stats) {
  const all = listOf(stats.ledger);
  if (all.length === 0) return stats.features ? el("p", {}, stats.features) : null;
  const columns = [
    { name: "kind", cell: (entry) => String(entry.kind) },
    { name: "feature", cell: (entry) => el("span", { class: "mono" }, String(entry.name)) },
    { name: "because", cell: (entry) => String(entry.reason) }];
  const costs = [
    { name: "its stages here", number: true, cell: (entry) => ownStages(stats, entry.name) },
    { name: "per sample elsewhere", number: true, cell: (entry) => costElsewhere(entry.name) }];
  const out = all.filter((entry) => !entry.on);
  return [el("p", { class: "soft" }, "The kernels were compiled for these features of the scene and its settings. The others cost nothing. Some have stages of their own, whose time was measured in this render; the rest of a feature's time lies within stages that it shares, mostly shade, and cannot be told apart there. The last column says how much longer a sample took with the feature on the scene and machine of kernels/FEATURES.md: it tells which are dear."),
    table([...columns, ...costs], all.filter((entry) => entry.on), "features that are in"),
    el("details", {}, el("summary", {}, out.length + " features were compiled out"), table(columns, out, "features that are out"))];
}

// The stages that only run for a feature, or nearly so.
const OWN_STAGES = { next_event: ["shadow"], environment: ["miss"], environment_map: ["miss"],
  light_paths: ["light_generate", "light_shade", "light_paths", "splat"] };

/** The time of a feature's own stages on all devices, and its share. */
function ownStages(stats, name) {
  const stages = listOf(stats.stages), sum = (some) => some.reduce((total, stage) => total + stage.seconds, 0);
  const own = stages.filter((stage) => (OWN_STAGES[name] || []).includes(stage.stage));
  if (own.length === 0 || sum(own) === 0) return "";
  return secondsText(sum(own)) + ", " + (100 * sum(own) / sum(stages)).toFixed(1) + " %";
}

function costElsewhere(name) {
  const cost = Object.hasOwn(FEATURE_COSTS, name) ? FEATURE_COSTS[name] : null;
  return cost ? el("span", { title: cost[0] }, (cost[1] > 0 ? "+" : "") + cost[1] + " ns") : "";
}

function sceneFacts(stats) {
  const scene = stats.scene || {}, contents = Object.entries(scene.contents || {}).filter(([, count]) => count > 0);
  return [
    facts([["Triangles", short(stats.triangles)], ...contents.map(([name, count]) => [name[0].toUpperCase() + name.slice(1), short(count)]),
      isNumber(scene.bytes) ? ["Files", bytesText(scene.bytes)] : null, ["Tree and triangles", bytesText(stats.geometry_bytes)]]),
    el("p", { class: "soft" }, "File ", el("span", { class: "mono" }, String(scene.path)), ", hash ", el("span", { class: "mono" }, String(scene.hash))),
    ...listOf(scene.warnings).map((line) => el("p", {}, String(line)))];
}

function settingsTable(stats) {
  const rows = Object.entries(stats.settings || {}).filter(([name]) => !["scene", "sceneHash", "version"].includes(name));
  if (rows.length === 0) return null;
  return table([{ name: "setting", cell: (row) => row[0] },
    { name: "value", cell: (row) => el("span", { class: "mono" }, isNumber(row[1]) ? String(row[1]) : row[1]) }], rows, "settings");
}

function eventsPart(stats) {
  const events = listOf(stats.events), rejected = stats.rejected_samples;
  if (events.length === 0 && !(rejected > 0)) return null;
  return [rejected > 0 ? el("p", { class: "bad" }, rejected + " samples were rejected: not finite, or beyond the film's range.") : el("span"),
    ...events.map((event) => el("p", {}, secondsText(event.seconds) + ", device " + event.device + ": " + event.text))];
}

function renderReport() {
  const stats = data.stats || {}, picture = data.picture;
  const path = (stats.scene || {}).path;
  document.getElementById("title").textContent = path ? String(path).split("/").pop() : "Render";
  document.getElementById("made-by").textContent = "Report of a render by " + (stats.version || "eikon");
  document.getElementById("summary").append(...summary(stats));
  section("Picture", () => picture && el("div", { class: "pictures" }, pictureFigure(picture, data.display || {}), picture.error ? errorFigure(picture) : el("p", { class: "soft" }, "Nothing is known of the error of single pixels.")));
  section("Error over time", () => errorOverTime(stats, data.timeline));
  section("Where the time went", () => whereTimeWent(stats));
  section("Timeline", () => timelinePart(data.timeline));
  section("Scene", () => sceneFacts(stats));
  section("Features", () => featureTables(stats));
  section("Settings", () => settingsTable(stats));
  section("What went wrong", () => eventsPart(stats));
}

function batchReport() {
  const batch = data.batch || {}, jobs = listOf(batch.jobs);
  const count = (state) => jobs.filter((job) => job.state === state).length;
  document.getElementById("title").textContent = batch.name ? String(batch.name).split("/").pop() : "Batch";
  document.getElementById("made-by").textContent = "Report of a batch by " + (batch.version || "eikon");
  document.getElementById("summary").append(
    facts([["Jobs", String(jobs.length)], ...["done", "skipped", "failed", "interrupted", "not run"].filter((state) => count(state) > 0)
      .map((state) => [state[0].toUpperCase() + state.slice(1), String(count(state))]), ["Time", secondsText(batch.seconds)],
    ["Samples", short(jobs.reduce((sum, job) => sum + (job.samples || 0), 0))]]),
    batch.command ? el("p", { class: "command mono" }, batch.command) : "");
  section("Jobs", () => table([
    { name: "line", number: true, cell: (job) => (isNumber(job.frame) ? (job.line > 0 ? job.line + ":" : "") + job.frame : String(job.line)) },
    { name: "state", cell: (job) => el("span", { class: "state-" + job.state }, String(job.state)) },
    { name: "output", cell: (job) => el("span", { class: "mono" }, job.output === null ? "" : String(job.output)) },
    { name: "time", number: true, cell: (job) => (isNumber(job.seconds) ? secondsText(job.seconds) : "") },
    { name: "samples", number: true, cell: (job) => (isNumber(job.samples) ? short(job.samples) : "") },
    { name: "samples/s", number: true, cell: (job) => (job.render_seconds > 0 ? short(job.samples / job.render_seconds) : "") },
    { name: "error", number: true, cell: (job) => (isNumber(job.relmse) ? percentError(job.relmse) : "") },
    { name: "command", cell: (job) => el("div", {}, el("span", { class: "mono" }, String(job.command)), job.message ? el("div", { class: "bad" }, String(job.message)) : null) },
  ], jobs, "jobs of the batch"));
}

if (data.kind === "batch") batchReport();
else renderReport();
document.documentElement.dataset.ready = "yes";
