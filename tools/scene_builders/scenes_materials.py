# SPDX-License-Identifier: Apache-2.0
"""The shipped scenes of glTF's materials, textures, lights and environments. The first line of each docstring says what
the scene proves; it is kept in the file as well.
"""

import math

from . import scene_pictures
from .gltf_writer import GltfWriter
from .scene_shapes import box, inside_out, join, look_at, quad, sphere
from .scenes_lambert import BLACK, cornell_camera, cornell_walls, room_with_window

GOLD, SILVER = (1.0, 0.77, 0.34), (0.97, 0.96, 0.92)


def solid(ior, color=None, distance_m=None):
    """extensions= of a clear solid; `color` is what is left of white after `distance_m` (Beer's law)."""
    volume = {"thicknessFactor": 1.0}
    if color is not None:
        volume |= {"attenuationColor": list(color), "attenuationDistance": distance_m}
    return {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": ior},
            "KHR_materials_volume": volume}


def smooth_sphere(gltf, subdivisions, material):
    """A unit sphere with normals of its own, for `place`."""
    points, triangles = sphere(1.0, subdivisions)
    return gltf.primitive(points, triangles, material, normals=points)


def place(gltf, name, primitive, material, centre, radius):
    """A node with the geometry of `primitive` in another material; the data are shared."""
    gltf.mesh(name, [{**primitive, "material": material}], translation=list(centre), scale=[radius] * 3)


def checker_floor(gltf, x0, x1, z0, z1, square_m, y=0.0):
    """A Lambert floor of squares, textured through KHR_texture_transform from coordinates in metres."""
    picture = gltf.texture("checker", scene_pictures.checker(), sampler={"magFilter": 9728},
                           transform={"scale": [0.5 / square_m, 0.5 / square_m]})
    material = gltf.material("checker", extensions={"KHR_materials_specular": {"specularFactor": 0.0}},
                             baseColorTexture=picture)
    corners = [(x0, y, z1), (x1, y, z1), (x1, y, z0), (x0, y, z0)]
    points, triangles = quad(*corners)
    gltf.mesh("floor", [gltf.primitive(points, triangles, material, uv=[(x, z) for x, _, z in corners])])


def lamp(gltf, radiance, x0, x1, z0, z1, y):
    """A rectangle that shines downwards."""
    corners = quad((x0, y, z0), (x1, y, z0), (x1, y, z1), (x0, y, z1))
    gltf.mesh("lamp", [gltf.primitive(*corners, gltf.lambert("lamp", BLACK, radiance))])


def cornell_spheres():
    """Delta transport: a glass and a mirror sphere in the measured Cornell box, with the caustic under the glass."""
    gltf = GltfWriter(cornell_spheres.__doc__)
    _, light, hole = cornell_walls(gltf)
    mirror = gltf.material("mirror", (0.95, 0.95, 0.95), metallic=1.0, roughness=0.0)
    glass = gltf.material("glass", roughness=0.0, extensions=solid(1.5))
    ball = smooth_sphere(gltf, 4, glass)
    place(gltf, "mirror sphere", ball, mirror, (0.40, 0.10, 0.36), 0.10)
    place(gltf, "glass sphere", ball, glass, (0.17, 0.10, 0.19), 0.10)
    gltf.mesh("light", [gltf.primitive(*quad(*hole), light)])
    cornell_camera(gltf)
    return gltf


def veach_plates():
    """Multiple importance sampling: plates of alpha 0.005 to 0.1 mirror four lights of equal power and different size."""
    gltf = GltfWriter(veach_plates.__doc__)
    grey = gltf.lambert("grey", (0.4, 0.4, 0.4))
    gltf.mesh("floor", [gltf.primitive(*quad((-10, -4.15, 10), (10, -4.15, 10), (10, -4.15, -2), (-10, -4.15, -2)), grey)])
    gltf.mesh("wall", [gltf.primitive(*quad((-10, -4.15, -2), (10, -4.15, -2), (10, 10, -2), (-10, 10, -2)), grey)])
    eye = (0.0, 2.0, 15.0)
    # Each plate is turned so that its middle mirrors the row of lights (x = any, y = 0, z = 0) into
    # the camera.
    for alpha, middle in ((0.005, (-2.3951, -0.1351)), (0.02, (-3.0634, 0.9231)), (0.05, (-3.5824, 2.2231)),
                          (0.1, (-3.9084, 3.5745))):
        y, z = middle
        to_light, to_eye = math.hypot(y, z), math.hypot(eye[1] - y, eye[2] - z)
        ny, nz = -y / to_light + (eye[1] - y) / to_eye, -z / to_light + (eye[2] - z) / to_eye
        length = math.hypot(ny, nz) / 0.5  # half the plate's width
        dy, dz = nz / length, -ny / length
        metal = gltf.material(f"plate {alpha}", (0.9, 0.9, 0.9), metallic=1.0, roughness=round(math.sqrt(alpha), 12))
        gltf.mesh(f"plate {alpha}", [gltf.primitive(*quad(
            (-4, y - dy, z - dz), (4, y - dy, z - dz), (4, y + dy, z + dz), (-4, y + dy, z + dz)), metal)])
    colors = ((1.0, 0.55, 0.45), (1.0, 0.95, 0.5), (0.5, 1.0, 0.6), (0.5, 0.65, 1.0))
    for x, radius, color in zip((-3.75, -1.25, 1.25, 3.75), (1 / 30, 0.1, 0.3, 0.9), colors):
        light = gltf.lambert(f"light {radius:.2g}", BLACK, [round(c / radius ** 2, 9) for c in color])
        gltf.mesh(f"light {radius:.2g}", [gltf.primitive(*sphere(radius, 2, (x, 0.0, 0.0)), light)])
    gltf.camera(0.48, 1.5, matrix=look_at(eye, (0.0, -2.0, 2.5)))
    return gltf


def snells_window():
    """Refraction and total reflection: from under water the sky fills a cone of 48.6 degrees, 1.742 bright at its middle."""
    gltf = GltfWriter(snells_window.__doc__)
    gltf.environment((1.0, 1.0, 1.0))
    # Open water without absorption, so that no light is found by chance alone: the sky comes
    # through one surface.
    water = gltf.material("water", roughness=0.0, extensions=solid(1.333))
    tile = gltf.lambert("pool", (0.12, 0.35, 0.4))
    gltf.mesh("water", [gltf.primitive(*quad((-4, 0, 4), (4, 0, 4), (4, 0, -4), (-4, 0, -4)), water)])
    pool = inside_out(box((-4, -2, -4), (4, 0, 4)))
    gltf.mesh("pool", [gltf.primitive(pool[0], pool[1][:8] + pool[1][10:], tile)])
    for name, color, x, z in (("red post", (0.6, 0.08, 0.06), 0, -5), ("green post", (0.1, 0.5, 0.1), 5, 0),
                              ("blue post", (0.1, 0.15, 0.6), 0, 5), ("yellow post", (0.7, 0.6, 0.1), -5, 0)):
        post = box((x - 0.4, 0.0, z - 0.4), (x + 0.4, 5.0, z + 0.4))
        gltf.mesh(name, [gltf.primitive(*post, gltf.lambert(name, color))])
    gltf.camera(2.2, 1.0, matrix=look_at((0.0, -1.5, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0)))
    return gltf


def ior_row():
    """Refraction by index: spheres of water 1.333, glass 1.5 and diamond 2.417, and one of amber that absorbs."""
    gltf = GltfWriter(ior_row.__doc__)
    gltf.environment_map("sky.hdr", scene_pictures.sky())
    checker_floor(gltf, -8, 8, -8, 8, 0.5)
    lamp(gltf, (8.0, 7.5, 7.0), -1.5, 1.5, -1.0, 1.0, 4.0)
    water = gltf.material("water", roughness=0.0, extensions=solid(1.333))
    glass = gltf.material("glass", roughness=0.0, extensions=solid(1.5))
    diamond = gltf.material("diamond", roughness=0.0, extensions=solid(2.417))
    amber = gltf.material("amber", roughness=0.0, extensions=solid(1.55, (0.9, 0.35, 0.05), 1.0))
    ball = smooth_sphere(gltf, 4, water)
    for x, material, name in ((-1.8, water, "water"), (-0.6, glass, "glass"), (0.6, diamond, "diamond"),
                              (1.8, amber, "amber")):
        place(gltf, name, ball, material, (x, 0.55, 0.0), 0.5)
    gltf.camera(0.5, 2.0, matrix=look_at((0.0, 1.6, 5.4), (0.0, 0.45, 0.0)))
    return gltf


def roughness_row(name, proves, materials):
    """Returns the maker of a row of six spheres; materials(gltf, roughness, number) makes their materials."""
    def make():
        gltf = GltfWriter(proves)
        gltf.environment_map("sky.hdr", scene_pictures.sky())
        checker_floor(gltf, -10, 10, -10, 10, 0.5)
        lamp(gltf, (20.0, 19.0, 17.0), -0.5, 0.5, 0.5, 1.5, 3.5)
        ball = None
        for number in range(6):
            roughness = number / 5
            material = materials(gltf, roughness, number)
            ball = ball or smooth_sphere(gltf, 4, material)
            place(gltf, f"{name} {roughness}", ball, material, (1.1 * (number - 2.5), 0.5, 0.0), 0.5)
        gltf.camera(0.36, 3.0, matrix=look_at((0.0, 1.7, 6.2), (0.0, 0.45, 0.0)))
        return gltf

    make.__doc__ = proves
    return make


roughness_metal = roughness_row(
    "metal", "Metal of roughness 0, 0.2, ... 1 under a sky and a lamp: gold and silver in turns.",
    lambda gltf, roughness, number: gltf.material(
        f"metal {roughness}", GOLD if number % 2 else SILVER, metallic=1.0, roughness=roughness))

roughness_plastic = roughness_row(
    "plastic", "Plastic of roughness 0, 0.2, ... 1 under a sky and a lamp: the diffuse base under a GGX coat.",
    lambda gltf, roughness, number: gltf.material(
        f"plastic {roughness}", (0.7, 0.08, 0.05) if number % 2 else (0.05, 0.2, 0.6), roughness=roughness))

rough_glass = roughness_row(
    "glass", "Transmission by roughness: solid glass of 0, 0.4, 0.8 and thin panes of 0.2, 0.6, 1, each on a checker.",
    lambda gltf, roughness, number: gltf.material(
        f"glass {roughness}", (0.75, 0.9, 0.8) if number % 2 else (1.0, 1.0, 1.0), roughness=roughness,
        extensions={"KHR_materials_transmission": {"transmissionFactor": 1.0}} if number % 2 else solid(1.5)))


def vase(segments, rows):
    """A turned vase as (points, triangles, normals, uv, tangents): u once around, v from its mouth down."""
    def radius(t):
        return 0.34 + 0.14 * math.sin(2 * math.pi * (0.9 * t + 0.05))

    points, normals, uv, tangents = [], [], [], []
    for j in range(rows + 1):
        t = j / rows
        slope = (radius(t + 1e-4) - radius(t - 1e-4)) / 2e-4
        for i in range(segments + 1):
            phi = 2 * math.pi * i / segments
            s, c = math.sin(phi), math.cos(phi)
            points.append((radius(t) * s, 1.2 * (1 - t), radius(t) * c))
            length = math.hypot(1.2, slope)
            normals.append((1.2 * s / length, slope / length, 1.2 * c / length))
            uv.append((3 * i / segments, 2 * t))
            tangents.append((c, 0.0, -s, 1.0))
    triangles = []
    for j in range(rows):
        for i in range(segments):
            a, b = j * (segments + 1) + i, (j + 1) * (segments + 1) + i
            triangles += [(a, b, b + 1), (a, b + 1, a + 1)]
    return points, triangles, normals, uv, tangents


def textured():
    """Textures: colour, roughness, metal and normals on two vases that must look alike, tangents given and left out."""
    gltf = GltfWriter(textured.__doc__)
    gltf.environment_map("sky.hdr", scene_pictures.sky(), rotate_deg=150.0)
    checker_floor(gltf, -6, 6, -6, 6, 0.4)
    glazed = gltf.material(
        "glazed tiles", metallic=1.0, roughness=1.0, doubleSided=True,
        baseColorTexture=gltf.texture("tiles color", scene_pictures.tiles_color(), "tiles_color.png"),
        metallicRoughnessTexture=gltf.texture("tiles metallic roughness", scene_pictures.tiles_metallic_roughness(),
                                              "tiles_metallic_roughness.png"),
        normalTexture=gltf.texture("tiles normal", scene_pictures.tiles_normal(), "tiles_normal.png", scale=0.8))
    # The same pictures turned by 30 degrees, smaller and shifted.
    turned = {"offset": [0.25, 0.1], "rotation": round(math.pi / 6, 12), "scale": [2.0, 2.0]}
    board = gltf.material(
        "turned tiles", metallic=0.0, roughness=0.4, emission=(1.0, 1.0, 1.0),
        baseColorTexture=gltf.texture("tiles color", scene_pictures.tiles_color(), transform=turned),
        normalTexture=gltf.texture("tiles normal", scene_pictures.tiles_normal(), transform=turned),
        emissiveTexture=gltf.texture("leaf", scene_pictures.leaf(), sampler={"wrapS": 33071, "wrapT": 33648},
                                     transform={"offset": [-0.5, 0.0], "scale": [2.0, 2.0]}))
    points, triangles, normals, uv, tangents = vase(48, 24)
    for name, given, x in (("vase, tangents given", tangents, -0.65), ("vase, tangents left out", None, 0.65)):
        gltf.mesh(name, [gltf.primitive(points, triangles, glazed, normals, uv, given)], translation=[x, 0.0, 0.3])
    corners = quad((-1.5, 0.0, -0.8), (1.5, 0.0, -0.8), (1.5, 1.5, -0.8), (-1.5, 1.5, -0.8))
    gltf.mesh("board", [gltf.primitive(*corners, board, uv=[(0, 1), (2, 1), (2, 0), (0, 0)])])
    gltf.camera(0.5, 1.5, matrix=look_at((0.0, 1.4, 4.2), (0.0, 0.6, 0.0)))
    return gltf


def sun_room():
    """Sun and sky: a directional light through a window onto a polished floor, a sky from a picture, metal and glass."""
    gltf = GltfWriter(sun_room.__doc__)
    gltf.environment_map("sky.hdr", scene_pictures.sky(), scale=2.0, rotate_deg=110.0)
    plaster = gltf.lambert("plaster", (0.75, 0.73, 0.7))
    parquet = gltf.material("parquet", (0.4, 0.22, 0.1), roughness=0.3)
    blue = gltf.lambert("blue", (0.1, 0.2, 0.5))
    grass = gltf.lambert("grass", (0.15, 0.25, 0.08))
    room_with_window(gltf, plaster, parquet, blue, grass)
    # From the lightest place of the sky, which is turned with it.
    gltf.punctual_light("sun", "directional", (1.0, 0.9, 0.75), 90.0,
                        matrix=look_at((-0.7698, 0.5736, -0.2802), (0.0, 0.0, 0.0)))
    brass = gltf.material("brass", (0.91, 0.78, 0.42), metallic=1.0, roughness=0.25)
    glass = gltf.material("glass", roughness=0.0, extensions=solid(1.5))
    lacquer = gltf.material("lacquer", (0.5, 0.05, 0.04), roughness=0.15)
    ball = smooth_sphere(gltf, 3, brass)
    place(gltf, "brass ball", ball, brass, (1.5, 0.35, -3.3), 0.35)
    place(gltf, "glass ball", ball, glass, (2.35, 0.25, -2.4), 0.25)
    gltf.mesh("chest", [gltf.primitive(*box((2.5, 0.0, -4.6), (3.6, 0.7, -3.9)), lacquer)])
    gltf.camera(0.95, 1.5, matrix=look_at((3.2, 1.55, -0.25), (1.7, 0.85, -3.6)))
    return gltf


def alpha():
    """Opacity: leaves cut out by MASK, panes of BLEND one behind another, and their shadows in both."""
    gltf = GltfWriter(alpha.__doc__)
    gltf.environment((0.5, 0.6, 0.8))
    checker_floor(gltf, -6, 6, -6, 6, 0.4)
    lamp(gltf, (12.0, 11.0, 9.0), -0.8, 0.8, -0.8, 0.8, 4.0)
    leaf = gltf.material("leaf", roughness=0.6, alphaMode="MASK", alphaCutoff=0.5, doubleSided=True,
                         baseColorTexture=gltf.texture("leaf", scene_pictures.leaf()))
    blades = []
    for k in range(7):
        phi = 2 * math.pi * k / 7
        s, c = round(math.sin(phi), 9), round(math.cos(phi), 9)
        stem, tip = (-0.95 + 0.05 * s, 0.1, 0.05 * c), (-0.95 + 0.75 * s, 0.75 + 0.05 * k, 0.75 * c)
        side = (0.3 * c, 0.0, -0.3 * s)
        blades.append([tuple(p + sign * d for p, d in zip(point, side))
                       for point, sign in ((stem, -1), (stem, 1), (tip, 1), (tip, -1))])
    points, triangles = join(*(quad(*corners) for corners in blades))
    gltf.mesh("plant", [gltf.primitive(points, triangles, leaf, uv=[(0, 1), (1, 1), (1, 0), (0, 0)] * len(blades))])
    for k, (color, opacity) in enumerate((((0.8, 0.1, 0.1), 0.25), ((0.1, 0.6, 0.1), 0.5), ((0.1, 0.2, 0.8), 0.75))):
        pane = gltf.material(f"pane {opacity}", color, roughness=0.5, opacity=opacity, alphaMode="BLEND", doubleSided=True)
        x, z = 0.1 + 0.3 * k, 0.5 - 0.5 * k
        corners = quad((x, 0.02, z), (x + 1.0, 0.02, z), (x + 1.0, 1.2, z), (x, 1.2, z))
        gltf.mesh(f"pane {opacity}", [gltf.primitive(*corners, pane)])
    gltf.camera(0.5, 1.5, matrix=look_at((0.1, 2.0, 4.8), (0.1, 0.45, 0.0)))
    return gltf


MAKERS = {
    "cornell_spheres": cornell_spheres,
    "veach_plates": veach_plates,
    "snells_window": snells_window,
    "ior_row": ior_row,
    "roughness_metal": roughness_metal,
    "roughness_plastic": roughness_plastic,
    "rough_glass": rough_glass,
    "textured": textured,
    "sun_room": sun_room,
    "alpha": alpha,
}
