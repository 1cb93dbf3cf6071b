// SPDX-License-Identifier: Apache-2.0
// The camera of the view: where it stands, what it turns around, and its flags of `eikon render`.
"use strict";

const add = (a, b) => a.map((x, i) => x + b[i]);
const scaled = (a, s) => a.map((x) => x * s);
const minus = (a, b) => add(a, scaled(b, -1));
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.sqrt(dot(a, a));
const normalised = (a) => scaled(a, 1 / (length(a) || 1));

/** `v` turned about a unit axis [Rodrigues]. */
function turned(v, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(scaled(v, c), scaled(cross(axis, v), s)), scaled(axis, dot(axis, v) * (1 - c)));
}

/** The numbers with as many decimals as steps of this size need. */
function decimals(values, step) {
  const places = Math.min(Math.max(Math.ceil(-Math.log10(step)), 0), 20);
  return values.map((x) => Number(x.toFixed(places)));
}

class ViewCamera {
  /** camera: of the scene's outline; middle, radius: of the scene */
  constructor(camera, middle, radius) {
    this.eye = camera.eye;
    this.up = camera.up;
    this.radius = radius;
    this.fov = camera.fov === null ? 40 : camera.fov;
    // The surface in the middle of the picture is taken to lie about as far away as the middle of the scene.
    const ahead = scaled(camera.back, -1), distance = Math.max(dot(minus(middle, camera.eye), ahead), 0.1 * radius);
    this.target = add(camera.eye, scaled(ahead, distance));
    // The world's vertical, unless the camera looks along it.
    this.world = Math.abs(dot(ahead, [0, 1, 0])) > 0.99 ? camera.up : [0, camera.up[1] < 0 ? -1 : 1, 0];
  }

  /** Turns around the target of a --look-at, as this camera stands there already. */
  aimAs(lookAt) {
    const [, target, up] = lookAt.split(":").map((point) => point.split(",").map(Number));
    this.target = target;
    if (up) this.world = up;
    return this;
  }

  get distance() { return length(minus(this.eye, this.target)); }
  get back() { return normalised(minus(this.eye, this.target)); }
  get right() { return normalised(cross(this.world, this.back)); }

  /** Turns around the target; angles in radians, to the right and up. */
  orbit(across, along) {
    let offset = turned(minus(this.eye, this.target), this.world, -across);
    const axis = normalised(cross(this.world, offset)), lifted = turned(offset, axis, -along);
    // Not over the pole.
    if (Math.abs(dot(normalised(lifted), this.world)) < 0.999) offset = lifted;
    this.eye = add(this.target, offset);
  }

  /** Moves eye and target by shares of the picture's height at the target. */
  pan(across, along) {
    const height = 2 * this.distance * Math.tan(this.fov * Math.PI / 360), right = this.right, up = cross(this.back, right);
    this.shift(add(scaled(right, across * height), scaled(up, along * height)));
  }

  zoom(factor) {
    const offset = scaled(minus(this.eye, this.target), factor);
    if (length(offset) > 1e-4 * this.radius && length(offset) < 1e3 * this.radius) this.eye = add(this.target, offset);
  }

  /** Walks: by metres to the right, up and ahead; the target comes along. */
  walk(right, up, ahead) {
    this.shift(add(add(scaled(this.right, right), scaled(this.world, up)), scaled(this.back, -ahead)));
  }

  /** Looks around from where it stands. */
  turn(across, along) {
    let offset = turned(minus(this.target, this.eye), this.world, -across);
    const lifted = turned(offset, this.right, along);
    if (Math.abs(dot(normalised(lifted), this.world)) < 0.999) offset = lifted;
    this.target = add(this.eye, offset);
  }

  shift(by) {
    this.eye = add(this.eye, by);
    this.target = add(this.target, by);
  }

  flags() {
    const text = (v) => v.map((x) => Number(x.toPrecision(7))).join(",");
    // Scenes far from the origin have large coordinates of which the last digits matter.
    const place = (v) => decimals(v, 1e-7 * Math.min(this.radius, this.distance)).join(",");
    const up = this.world[0] === 0 && this.world[1] === 1 && this.world[2] === 0 ? "" : ":" + text(this.world);
    return { "--look-at": place(this.eye) + ":" + place(this.target) + up, "--fov": String(Number(this.fov.toPrecision(5))) };
  }
}
