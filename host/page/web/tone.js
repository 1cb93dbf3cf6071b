// SPDX-License-Identifier: Apache-2.0
// From scene-linear radiance to what a display shows: the curves of host/image/tonemap.cpp, which says where they are from.
"use strict";

const TONES = ["none", "reinhard", "aces", "agx", "pbr-neutral"];
const unit = (x) => Math.min(Math.max(x, 0), 1);

function matrix(m, v) {
  return [m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2], m[6] * v[0] + m[7] * v[1] + m[8] * v[2]];
}

const CURVES = {
  "none": (v) => v,
  "reinhard": (v) => {
    const factor = 1 / (1 + 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2]);
    return [v[0] * factor, v[1] * factor, v[2] * factor];
  },
  "aces": (linear) => {
    const v = matrix([0.59719, 0.35458, 0.04823, 0.07600, 0.90834, 0.01566, 0.02840, 0.13383, 0.83777], linear);
    const curve = v.map((x) => (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081));
    return matrix([1.60475, -0.53108, -0.07367, -0.10208, 1.10813, -0.00605, -0.00327, -0.07276, 1.07602], curve).map(unit);
  },
  "agx": (linear) => {
    const wide = matrix([0.6274, 0.3293, 0.0433, 0.0691, 0.9195, 0.0113, 0.0164, 0.0880, 0.8956], linear);
    const inset = matrix([0.856627153315983, 0.0951212405381588, 0.0482516061458583, 0.137318972929847, 0.761241990602591,
      0.101439036467562, 0.11189821299995, 0.0767994186031903, 0.811302368396859], wide);
    const least = -12.47393, most = 4.026069;
    const contrast = inset.map((value) => {
      const x = unit((Math.log2(Math.max(value, 1e-10)) - least) / (most - least));
      return -0.00232 + x * (0.1191 + x * (0.4298 + x * (-6.868 + x * (31.96 + x * (-40.14 + x * 15.5)))));
    });
    const outset = matrix([1.1271005818144368, -0.11060664309660323, -0.016493938717834573, -0.1413297634984383,
      1.157823702216272, -0.016493938717834257, -0.14132976349843826, -0.11060664309660294, 1.2519364065950405], contrast);
    return matrix([1.6605, -0.5876, -0.0728, -0.1246, 1.1329, -0.0083, -0.0182, -0.1006, 1.1187],
      outset.map((x) => Math.pow(Math.max(x, 0), 2.2))).map(unit);
  },
  "pbr-neutral": (v) => {
    const fresnel = 0.04, begin = 0.8 - fresnel, room = 1 - begin, desaturation = 0.15;
    const least = Math.min(v[0], v[1], v[2]);
    const offset = least < 2 * fresnel ? least - 6.25 * least * least : fresnel;
    const colour = v.map((x) => x - offset), peak = Math.max(...colour);
    if (peak < begin) return colour;
    const compressed = 1 - room * room / (peak + room - begin);
    const toWhite = 1 - 1 / (desaturation * (peak - compressed) + 1);
    return colour.map((x) => x * (compressed / peak) * (1 - toWhite) + compressed * toWhite);
  },
};

/** 8 bits of sRGB by IEC 61966-2-1, of linear values in steps of 2^-16: even in the dark, 20 of them make one of the 8 bits. */
const SRGB = Uint8ClampedArray.from({ length: 65537 }, (_, i) => {
  const x = i / 65536;
  return Math.floor(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * Math.pow(x, 1 / 2.4) - 0.055) + 0.5);
});
const toByte = (x) => SRGB[Math.round(65536 * unit(x))];

/** Bytes (three mantissas and an exponent a pixel) to linear values, three a pixel. */
function fromRgbe(rgbe) {
  const count = rgbe.length / 4, linear = new Float32Array(3 * count);
  for (let i = 0; i < count; ++i) {
    if (rgbe[4 * i + 3] === 0) continue;
    const scale = Math.pow(2, rgbe[4 * i + 3] - 136);
    for (let c = 0; c < 3; ++c) linear[3 * i + c] = (rgbe[4 * i + c] + 0.5) * scale;
  }
  return linear;
}

/** Fills the pixels of an ImageData from linear values. */
function expose(linear, pixels, exposure, tone) {
  const scale = Math.pow(2, exposure), curve = CURVES[tone] || CURVES.none, plain = curve === CURVES.none;
  for (let i = 0, k = 0; i < linear.length; i += 3, k += 4) {
    let r = linear[i] * scale, g = linear[i + 1] * scale, b = linear[i + 2] * scale;
    if (!plain) [r, g, b] = curve([r, g, b]);
    pixels[k] = toByte(r);
    pixels[k + 1] = toByte(g);
    pixels[k + 2] = toByte(b);
    pixels[k + 3] = 255;
  }
}

/** Colours from little to much: dark violet over red and orange to pale yellow. */
const HEAT = [[0, 0, 4], [40, 11, 84], [101, 21, 110], [159, 42, 99], [212, 72, 66], [245, 125, 21], [250, 193, 39], [252, 255, 164]];
function heat(share) {
  const at = unit(share) * (HEAT.length - 1), i = Math.min(Math.floor(at), HEAT.length - 2), t = at - i;
  return HEAT[i].map((low, c) => Math.round(low + t * (HEAT[i + 1][c] - low)));
}
const heatGradient = () => "linear-gradient(to right, " + HEAT.map((c) => "rgb(" + c.join(",") + ")").join(", ") + ")";
