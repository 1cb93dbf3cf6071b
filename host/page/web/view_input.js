// SPDX-License-Identifier: Apache-2.0
// This file turns mouse, touch and keys on the picture into moves of the camera.
"use strict";

/** The pixel of the whole picture under a pointer. */
function pixelAt(event) {
  const box = canvas.getBoundingClientRect(), [width, height] = sizeNow();
  const at = (share, side) => Math.min(Math.max(Math.floor(share * side), 0), side - 1);
  return [at((event.clientX - box.left) / box.width, width), at((event.clientY - box.top) / box.height, height)];
}

let drag = null;

canvas.addEventListener("pointerdown", (event) => {
  canvas.focus();
  if (actAt(...pixelAt(event))) return;
  canvas.setPointerCapture(event.pointerId);
  drag = { x: event.clientX, y: event.clientY, pan: tool === "pan" || event.shiftKey || event.button === 1 || event.button === 2, look: tool === "look" };
});
canvas.addEventListener("pointermove", (event) => {
  if (!drag) return;
  const height = canvas.getBoundingClientRect().height;
  const across = (event.clientX - drag.x) / height, along = (event.clientY - drag.y) / height;
  Object.assign(drag, { x: event.clientX, y: event.clientY });
  move((c) => {
    if (drag.pan) c.pan(-across, along);
    else if (drag.look) c.turn(-2 * across, 2 * along);
    else c.orbit(Math.PI * across, -Math.PI * along);
  });
});
for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { drag = null; });
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  move((c) => c.zoom(Math.pow(1.0015, Math.max(-400, Math.min(400, event.deltaY)))));
}, { passive: false });

canvas.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const step = 0.05 * (event.shiftKey ? 4 : 1), metres = scene ? step * scene.radius : step;
  const moves = {
    ArrowLeft: (c) => c.orbit(-2 * step, 0), ArrowRight: (c) => c.orbit(2 * step, 0), ArrowUp: (c) => c.orbit(0, 2 * step), ArrowDown: (c) => c.orbit(0, -2 * step),
    w: (c) => c.walk(0, 0, metres), s: (c) => c.walk(0, 0, -metres), a: (c) => c.walk(-metres, 0, 0), d: (c) => c.walk(metres, 0, 0),
    e: (c) => c.walk(0, metres, 0), q: (c) => c.walk(0, -metres, 0), "+": (c) => c.zoom(0.9), "=": (c) => c.zoom(0.9), "-": (c) => c.zoom(1 / 0.9),
  };
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, middle = sizeNow().map((side) => Math.floor(side / 2));
  if (moves[key]) move(moves[key]);
  else if (key === "[" || key === "]") {
    controls.exposure.value = Number(controls.exposure.value) + (key === "]" ? 0.5 : -0.5);
    controls.exposure.dispatchEvent(new Event("input"));
  } else if (key === "Enter") actAt(...middle);
  else if (key === "Home") resetCamera("");
  else if (key === "Escape") clearPath();
  else return;
  event.preventDefault();
});
// Also when a line below the picture comes or goes.
new ResizeObserver(() => { if (frame) fit(sizeNow()); }).observe(document.getElementById("picture"));

// A scene file may be dropped anywhere on the page.
document.addEventListener("dragover", (event) => event.preventDefault());
document.addEventListener("drop", (event) => {
  event.preventDefault();
  if (event.dataTransfer.files.length > 0) openFile(event.dataTransfer.files[0]);
});
