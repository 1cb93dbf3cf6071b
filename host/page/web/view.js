// SPDX-License-Identifier: Apache-2.0
// The page of `eikon view`: asks for pictures, shows them as they refine, and moves the camera.
"use strict";

const token = new URLSearchParams(location.search).get("token") || "";
const problem = document.getElementById("problem"), panel = document.querySelector(".panel");
const SIZES = ["320x240", "480x360", "640x480", "960x540", "1280x720", "1920x1080"];
const REST_MS = 250;  // without a change, after which the whole picture is wanted
const LENSES = ["--f-number", "--focus-distance"], VIEWS = ["--look-at", "--fov", ...LENSES];

// The flags and the camera that are asked for. `camera` is null until somebody moves: then the scene's own camera is shown.
const look = { flags: { "--size": "640x480" }, layer: "picture", mix: {} };
let camera = null, tool = "orbit", scene = null, frame = null, linear = null, status = {};
let version = 0, adoptedLook = 0, restTimer = 0, sending = false, nextLook = null, stateSince = 0;

const sizeNow = () => look.flags["--size"].split("x").map(Number);

async function ask(path, body) {
  const options = { headers: { "X-Eikon-Token": token }, cache: "no-store" };
  if (body !== undefined) Object.assign(options, { method: "POST", body: body instanceof Blob ? body : JSON.stringify(body) });
  const answer = await fetch(path, options);
  if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).error || "the server answers " + answer.status);
  return answer;
}

function complain(text) {
  problem.textContent = text;
  problem.hidden = !text;
}

// Requests.

/** Sends the newest look; while one is under way, only the newest of those that follow is sent. */
async function send(wanted) {
  if (sending) return void (nextLook = wanted);
  sending = true;
  try {
    adoptedLook = (await (await ask("/api/look", wanted)).json()).number;
    complain(status.state === "failed" ? status.error : "");
  } catch (error) {
    complain(error.message);
  }
  sending = false;
  const next = nextLook;
  nextLook = null;
  if (next) send(next);
}

/** moving: more of it may follow at once */
function change(moving) {
  clearPath();
  clearTimeout(restTimer);
  restTimer = moving ? setTimeout(() => change(false), REST_MS) : 0;
  if (camera) Object.assign(look.flags, camera.flags());
  send({ ...structuredClone(look), moving });
}

/** Sets a flag, or takes it away where the value is null. */
function setFlag(name, value, moving) {
  if (value === null) delete look.flags[name];
  else look.flags[name] = String(value);
  change(moving);
}

function ownCamera() {
  if (!camera && scene) {
    camera = new ViewCamera(scene.view, scene.middle, scene.radius);
    if (look.flags["--look-at"]) camera.aimAs(look.flags["--look-at"]);
    delete look.flags["--camera"];
  }
  return camera;
}

function move(how) {
  if (!ownCamera()) return;
  how(camera);
  controls.fov.show(camera.fov);
  change(true);
}

// News.

async function listen() {
  for (;;) {
    try {
      const answer = await ask("/api/news?after=" + version + "&frame=" + (frame ? frame.number : 0));
      take(await answer.arrayBuffer());
      document.body.dataset.connected = "yes";
    } catch (error) {
      document.body.dataset.connected = "no";
      version = 0;
      document.getElementById("status").replaceChildren(el("b", {}, "not connected"));
      document.getElementById("waiting").hidden = true;
      complain("eikon does not answer (" + error.message + "). It may have ended; this page tries again.");
      await new Promise((resolve) => setTimeout(resolve, 1000));
    }
  }
}

function take(bytes) {
  const head = new DataView(bytes).getUint32(0, true);
  const news = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, head)));
  version = news.version;
  if (news.status.state !== status.state) {
    stateSince = performance.now();
    document.getElementById("spoken").textContent = stateWords(news.status.state);
  }
  const wasFailed = status.state === "failed" || document.body.dataset.connected === "no";
  status = news.status;
  if (status.scene) takeScene(status.scene);
  if (status.look_number > adoptedLook && !sending && !restTimer) adopt(status.look, status.look_number);
  if (status.state === "failed") complain(status.error);
  else if (wasFailed) complain("");
  controls.command.value = status.command;
  controls.notes.replaceChildren(...status.notes.map((note) => el("li", {}, note)));
  controls.noteGroup.hidden = status.notes.length === 0;
  showFinal(news.final);
  if (news.frame) {
    frame = { number: news.frame.number, ...news.frame.about };
    linear = fromRgbe(new Uint8Array(bytes, 4 + head));
    repaint();
  }
  showStatus();
  Object.assign(document.body.dataset, { state: status.state, samples: frame ? frame.samples : 0 });
}

/** Takes over what another tab, or this page before it was loaded again, has asked for. */
function adopt(wanted, number) {
  adoptedLook = number;
  camera = null;
  look.flags = wanted.flags;
  look.layer = wanted.layer;
  look.mix = wanted.mix;
  showControls();
  repaint();
}

function takeScene(outline) {
  scene = outline;
  document.title = outline.name + " - eikon view";
  document.getElementById("title").textContent = outline.name;
  showControls();
}

function repaint() {
  if (frame) paint(frame, linear, Number(controls.exposure.value), controls.tone.value, sizeNow());
}

// States that are not listed are shown under their own names.
const STATES = { loading: "loading the scene", building: "building the scene's tree", compiling: "compiling for the devices", rendering: "refining" };
const LONG = ["loading", "building", "compiling"], LONG_S = 2;  // states that may last, and from when on their seconds are shown
const stateWords = (state) => STATES[state] || state;

function stateText() {
  const seconds = Math.floor((performance.now() - stateSince) / 1000);
  const more = LONG.includes(status.state) && seconds >= LONG_S ? " for " + seconds + " s" : "";
  return stateWords(status.state) + more;
}

function showStatus() {
  const part = (name, value) => el("span", {}, el("span", { class: "soft" }, name + " "), el("b", {}, value));
  const waiting = document.getElementById("waiting");
  waiting.hidden = !LONG.includes(status.state);
  waiting.textContent = stateText();
  const parts = [el("b", {}, stateText())];
  if (frame) {
    parts.push(part("samples", frame.small ? "preview" : frame.samples + " of " + frame.samples_total));
    if (frame.rate > 0) parts.push(part("rate", short(frame.rate) + "/s"));
    if (frame.error !== null) {
      const interval = frame.error_high === null ? "" : " (95 %: " + percentError(frame.error_low) + " to " + percentError(frame.error_high) + ")";
      parts.push(part(frame.layer === "denoised" ? "predicted error before denoising" : "predicted error", percentError(frame.error) + interval));
    }
  }
  document.getElementById("status").replaceChildren(...parts);
}

// A path, and the distance of what is sharp.

function clearPath() {
  overlay.replaceChildren();
  controls.path.replaceChildren();
}

const pathAt = async (x, y) => (await ask("/api/path?x=" + x + "&y=" + y + "&sample=0")).json();

async function tracePath(x, y) {
  clearPath();
  controls.path.replaceChildren(el("li", {}, "tracing pixel " + x + ", " + y));
  const path = await pathAt(x, y);
  drawPath(path, x, y, sizeNow());
  controls.path.replaceChildren(...pathWords(path, scene.radius));
}

async function focusAt(x, y) {
  const hit = (await pathAt(x, y)).vertices[1];
  if (!hit || hit.distance === null) return complain("There is nothing to focus on.");
  ownCamera();
  // Along the axis of view: the plane that is sharp stands across it.
  const distance = Math.max(dot(minus(hit.point, camera.eye), scaled(camera.back, -1)), 1e-6);
  look.flags["--focus-distance"] = String(Number(distance.toPrecision(5)));
  if (!look.flags["--f-number"]) look.flags["--f-number"] = "2.8";
  showControls();
  change(false);
}

/** What the tool does at a pixel; false for tools that drag. */
function actAt(x, y) {
  if (tool !== "path" && tool !== "focus") return false;
  (tool === "path" ? tracePath(x, y) : focusAt(x, y)).catch((error) => { clearPath(); complain(error.message); });
  return true;
}

// Controls.

function setTool(name) {
  tool = name;
  canvas.dataset.tool = name;
  for (const one of controls.tools.children) one.setAttribute("aria-pressed", one.dataset.tool === name);
}

const LENS_OFF = 6;  // position of the slider, beyond f/64
const lensText = (v) => (v >= LENS_OFF ? "pinhole" : "f/" + Math.pow(2, v).toPrecision(2));

function setLens(position) {
  if (!ownCamera()) return;
  if (position >= LENS_OFF) LENSES.forEach((name) => delete look.flags[name]);
  else {
    look.flags["--f-number"] = Math.pow(2, position).toPrecision(3);
    if (!look.flags["--focus-distance"]) look.flags["--focus-distance"] = String(Number(camera.distance.toPrecision(5)));
  }
  change(true);
}

function resetCamera(name) {
  camera = null;
  VIEWS.forEach((flag) => delete look.flags[flag]);
  setFlag("--camera", name === "" ? null : name, false);
}

/** Shows what is asked for, and what the scene has to choose from. */
function showControls() {
  const flags = look.flags, known = (name) => flags[name] !== undefined;
  fill(controls.size, SIZES.map((size) => [size, size.replace("x", " × ")]), flags["--size"]);
  controls.layer.value = look.layer;
  controls.exposure.show(Number(flags["--exposure"] || 0));
  controls.tone.value = flags["--tonemap"] || "none";
  controls.lens.show(known("--f-number") ? Math.log2(Number(flags["--f-number"])) : LENS_OFF);
  controls.rotate.show(Number(flags["--env-rotate"] || 0));
  controls.envScale.show(known("--env-scale") ? Math.log2(Number(flags["--env-scale"])) : 0);
  if (!scene) return;
  const cameras = scene.cameras.map((c, i) => [String(i), c.name || "camera " + i]);
  fill(controls.camera, [["", cameras.length > 0 ? "as started" : "the whole scene"], ...cameras], flags["--camera"] || "");
  fill(controls.variant, [["", "as started"], ...scene.variants.map((name) => [name, name])], flags["--variant"] || "");
  fill(controls.env, [["", "as started"], ["neutral", "neutral studio"], ["none", "none"], ["1,1,1", "white"]], flags["--env"] || "");
  showRow(controls.variant, scene.variants.length > 0);
  showRow(controls.time, Boolean(scene.time));
  if (scene.time) {
    Object.assign(controls.time, { min: scene.time[0], max: scene.time[1], step: (scene.time[1] - scene.time[0]) / 240 });
    controls.time.show(known("--scene-time") ? Number(flags["--scene-time"]) : scene.time[0]);
  }
  showRow(controls.rotate, scene.environment !== "none" && scene.environment !== "constant");
  showRow(controls.envScale, scene.environment !== "none");
  if (!camera && scene.view.fov !== null) controls.fov.show(scene.view.fov);
  showLights();
}

const layerWords = (name) => ({ denoised: "picture, denoised", error: "error of each pixel", lights: "light groups" }[name] || name);

/** A slider for each group of lights, while their layer is shown. */
function showLights() {
  const missing = status.denoiser !== "";
  fill(controls.layer, data.layers.filter((name) => name !== "lights" || scene.lights.length > 0)
    .map((name) => [name, layerWords(name) + (name === "denoised" && missing ? " (not available)" : ""), name === "denoised" && missing]), look.layer);
  controls.denoiserText.textContent = status.denoiser;
  controls.denoiser.hidden = !missing;
  controls.lightGroup.hidden = look.layer !== "lights";
  const names = JSON.stringify(scene.lights);
  if (controls.lightGroup.dataset.names !== names) {
    controls.lightGroup.dataset.names = names;
    controls.lightGroup.replaceChildren(el("legend", {}, "Light groups"), ...scene.lights.map((name, i) =>
      range("light" + i, name, [0, 4, 0.05, 1], (v) => "× " + v.toFixed(2), (v) => { look.mix[name] = v; change(false); })));
  }
  scene.lights.forEach((name, i) => controls["light" + i].show(look.mix[name] === undefined ? 1 : look.mix[name]));
}

function showFinal(final) {
  const words = { none: "", running: "rendering to " + final.image, done: "written: " + final.image + " and " + final.png,
    stopped: "stopped; what was done is in " + final.image, failed: final.message };
  controls.finalState.textContent = words[final.state];
  controls.finalState.classList.toggle("bad", final.state === "failed");
  controls.finalProgress.hidden = controls.stop.hidden = final.state !== "running";
  controls.finalProgress.value = final.share;
  controls.start.hidden = final.state === "running";
}

/** Shows a scene file of the user's. */
async function openFile(file) {
  complain("");
  try {
    await ask("/api/drop?name=" + encodeURIComponent(file.name), file);
  } catch (error) {
    complain(error.message);
  }
}

const postCommand = (path) => ask(path, {}).then(() => complain(""), (error) => complain(error.message));

function setDisplayFlag(name, value) {
  if (value === null) delete look.flags[name];
  else look.flags[name] = String(value);
  repaint();
  send({ ...structuredClone(look), moving: Boolean(restTimer) });
}

const KEYS = [["arrows", "turn the camera"], ["W A S D", "walk"], ["Q E", "down, up"], ["+ −", "nearer, further"], ["[ ]", "darker, brighter"],
  ["Enter", "focus, or trace the path, in the middle"], ["Home", "reset the camera"], ["Esc", "clear the path"]];
const TOOLS = [["orbit", "Orbit"], ["pan", "Pan"], ["look", "Look around"], ["focus", "Focus"], ["path", "Trace path"]];

function build() {
  controls.tools = el("div", { class: "buttons", role: "group", "aria-label": "what a click or drag on the picture does" },
    ...TOOLS.map(([name, text]) => button(text, () => setTool(name), { "data-tool": name })));
  controls.path = el("ul", { "aria-label": "vertices of the path", "aria-live": "polite" });
  controls.denoiserText = el("p", { class: "small" });
  controls.denoiser = el("details", { class: "soft", hidden: true }, el("summary", {}, "Why is there no denoised layer?"), controls.denoiserText);
  controls.command = el("textarea", { id: "command", readonly: true, spellcheck: "false" });
  controls.notes = el("ul", {});
  controls.noteGroup = group("Notes", controls.notes);
  controls.lightGroup = group("Light groups");
  controls.lightGroup.hidden = true;
  controls.finalState = el("p", { role: "status", "aria-live": "polite", class: "soft" });
  controls.finalProgress = el("progress", { max: 1, value: 0, "aria-label": "share of the render that is done", hidden: true });
  controls.start = button("Render to a file", () => postCommand("/api/render"), { class: "main" });
  controls.stop = button("Stop", () => postCommand("/api/stop"), { hidden: true });
  controls.file = el("input", { type: "file", id: "file", accept: ".glb,.gltf",
    onclick: () => { controls.file.value = ""; },  // so that the same file can be opened again
    onchange: () => controls.file.files[0] && openFile(controls.file.files[0]) });
  const copied = el("span", { class: "soft", role: "status" });
  const copy = async () => {
    controls.command.select();
    copied.textContent = await navigator.clipboard.writeText(controls.command.value).then(() => "copied", () => "selected; copy it with Ctrl+C");
  };
  panel.append(
    group("Mouse", controls.tools, controls.path),
    group("Camera",
      choice("camera", "Camera", [["", "as started"]], resetCamera),
      range("fov", "Field of view", [1, 150, 1, 40], (v) => v.toFixed(0) + "°", (v) => move((c) => { c.fov = v; })),
      range("lens", "Aperture", [0, LENS_OFF, 0.1, LENS_OFF], lensText, setLens),
      el("div", { class: "buttons" }, button("Reset camera", () => resetCamera("")))),
    group("Show",
      choice("layer", "Layer", data.layers.map((name) => [name, name]), (value) => { look.layer = value; showControls(); change(false); }),
      controls.denoiser,
      range("exposure", "Exposure", [-10, 10, 0.1, 0], evText, (v) => setDisplayFlag("--exposure", v === 0 ? null : v)),
      choice("tone", "Tone curve", TONES.map((name) => [name, name]), (value) => setDisplayFlag("--tonemap", value === "none" ? null : value)),
      choice("size", "Size", SIZES.map((size) => [size, size]), (value) => setFlag("--size", value, false))),
    controls.lightGroup,
    group("Scene", el("div", { class: "row" }, el("label", { for: "file" }, "Open a file"), controls.file),
      el("p", { class: "soft small" }, "A .glb, or a .gltf that stands alone, can be dropped on this page, too."),
      choice("variant", "Variant", [["", "as started"]], (value) => setFlag("--variant", value || null, false)),
      range("time", "Time", [0, 1, 0.01, 0], (v) => v.toFixed(2) + " s", (v) => setFlag("--scene-time", v, true)),
      choice("env", "Environment", [["", "as started"]], (value) => setFlag("--env", value || null, false)),
      range("rotate", "Turn it", [-180, 180, 1, 0], (v) => v + "°", (v) => setFlag("--env-rotate", v === 0 ? null : v, true)),
      range("envScale", "Its strength", [-5, 5, 0.1, 0], evText, (v) => setFlag("--env-scale", v === 0 ? null : Number(Math.pow(2, v).toPrecision(4)), true))),
    group("Render this picture", el("label", { for: "command", class: "soft" }, "The command of the same picture, with all samples:"), controls.command,
      el("div", { class: "buttons" }, controls.start, controls.stop, button("Copy", copy), copied), controls.finalProgress, controls.finalState),
    controls.noteGroup,
    group("Keys on the picture", el("dl", { class: "keys", id: "keys" },
      ...KEYS.flatMap(([key, what]) => [el("dt", {}, el("kbd", {}, key)), el("dd", {}, what)]))));
  // Until it is known what the scene has.
  for (const name of ["variant", "time", "rotate", "envScale"]) showRow(controls[name], false);
  setTool("orbit");
}

build();
setInterval(() => { if (LONG.includes(status.state) && document.body.dataset.connected === "yes") showStatus(); }, 1000);
listen();
