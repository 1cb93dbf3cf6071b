# SPDX-License-Identifier: Apache-2.0
"""The measured Cornell box: reflectance spectra, the light's spectrum, and the linear Rec. 709 triples made of them.

Spectra: Cornell University Program of Computer Graphics, "Cornell Box Data"; 400 to 700 nm in steps of 4.
Run this file to print the triples.

  reflectance   colour under D65 relative to a perfect white under D65, so that a white of 1 is (1, 1, 1)
  emission      X, Y, Z of the spectrum over the integral of y-bar, to Rec. 709 without adaptation: a light of constant
                radiance 1 has luminance 1, and the warm light stays warm
"""

import math

WHITE = [
    .343, .445, .551, .624, .665, .687, .708, .723, .715, .710, .745, .758, .739, .767, .777, .765, .751, .745, .748,
    .729, .745, .757, .753, .750, .746, .747, .735, .732, .739, .734, .725, .721, .733, .725, .732, .743, .744, .748,
    .728, .716, .733, .726, .713, .740, .754, .764, .752, .736, .734, .741, .740, .732, .745, .755, .751, .744, .731,
    .733, .744, .731, .712, .708, .729, .730, .727, .707, .703, .729, .750, .760, .751, .739, .724, .730, .740, .737,
]
RED = [
    .040, .046, .048, .053, .049, .050, .053, .055, .057, .056, .059, .057, .061, .061, .060, .062, .062, .062, .061,
    .062, .060, .059, .057, .058, .058, .058, .056, .055, .056, .059, .057, .055, .059, .059, .058, .059, .061, .061,
    .063, .063, .067, .068, .072, .080, .090, .099, .124, .154, .192, .255, .287, .349, .402, .443, .487, .513, .558,
    .584, .620, .606, .609, .651, .612, .610, .650, .638, .627, .620, .630, .628, .642, .639, .657, .639, .635, .642,
]
GREEN = [
    .092, .096, .098, .097, .098, .095, .095, .097, .095, .094, .097, .098, .096, .101, .103, .104, .107, .109, .112,
    .115, .125, .140, .160, .187, .229, .285, .343, .390, .435, .464, .472, .476, .481, .462, .447, .441, .426, .406,
    .373, .347, .337, .314, .285, .277, .266, .250, .230, .207, .186, .171, .160, .148, .141, .136, .130, .126, .123,
    .121, .122, .119, .114, .115, .117, .117, .118, .120, .122, .128, .132, .139, .144, .146, .150, .152, .157, .159,
]

# Radiance of the light; linear in between.
EMISSION = [(400, 0.0), (500, 8.0), (600, 15.6), (700, 18.4)]
LIGHT_REFLECTANCE = 0.78

# CIE standard illuminant D65, 400 to 700 nm in steps of 10.
D65 = [
    82.75, 91.49, 93.43, 86.68, 104.86, 117.01, 117.81, 114.86, 115.92, 108.81, 109.35, 107.80, 104.79, 107.69, 104.41,
    104.05, 100.00, 96.33, 95.79, 88.69, 90.01, 89.60, 87.70, 83.29, 83.70, 80.03, 80.21, 82.28, 78.28, 69.72, 71.61,
]

WAVELENGTHS_NM = range(400, 701, 4)

# [Rec. ITU-R BT.709] linear RGB from X, Y, Z.
RGB_FROM_XYZ = [
    (3.2404542, -1.5371385, -0.4985314),
    (-0.9692660, 1.8760108, 0.0415560),
    (0.0556434, -0.2040259, 1.0572252),
]


def matching(wavelength):
    """CIE 1931 x-bar, y-bar, z-bar by the multi-lobe fit of [Wyman, Sloan, Shirley 2013, JCGT 2(2)]."""
    def lobe(height, centre, below, above):
        return height * math.exp(-0.5 * ((wavelength - centre) / (below if wavelength < centre else above)) ** 2)

    return (
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )


def _linear(samples, wavelength):
    for (x0, y0), (x1, y1) in zip(samples, samples[1:]):
        if wavelength <= x1:
            return y0 + (y1 - y0) * (wavelength - x0) / (x1 - x0)
    raise ValueError(f"{wavelength} nm is outside the data")


def _rgb(spectrum):
    """Rec. 709 of a spectrum (one value per wavelength), as the integrals over the range leave it."""
    xyz = [sum(s * matching(w)[i] for s, w in zip(spectrum, WAVELENGTHS_NM)) for i in range(3)]
    return [sum(m * c for m, c in zip(row, xyz)) for row in RGB_FROM_XYZ]


def reflectance(spectrum):
    """Linear Rec. 709 reflectance of one of the measured spectra, four decimals."""
    daylight = [_linear(list(zip(range(400, 701, 10), D65)), w) for w in WAVELENGTHS_NM]
    colour = _rgb([s * d for s, d in zip(spectrum, daylight)])
    return [round(c / w, 4) for c, w in zip(colour, _rgb(daylight))]


def emission():
    """Linear Rec. 709 radiance of the light, three decimals."""
    weight = sum(matching(w)[1] for w in WAVELENGTHS_NM)
    return [round(c / weight, 3) for c in _rgb([_linear(EMISSION, w) for w in WAVELENGTHS_NM])]


if __name__ == "__main__":
    for label, values in (("white", reflectance(WHITE)), ("red", reflectance(RED)), ("green", reflectance(GREEN)),
                          ("light", emission())):
        print(f"{label:6s}", *values)
