# SPDX-License-Identifier: Apache-2.0
"""Adds to an exported glTF document what Blender's exporter leaves out and eikon reads: area lights, lamps with a radius, the
lens, and one camera."""
import base64
import math
import struct

import mathutils

# Blender's z is up, glTF's y.
GLTF_FROM_BLENDER = mathutils.Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))
# A rectangle of EIKON_shape lies in x and z and shines along +y; a light of Blender lies in x and y
# and shines along -z.
LIGHT_FROM_SHAPE = mathutils.Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))
DISC_CORNERS = 64


def add_used(document, *extensions):
    used = document.setdefault("extensionsUsed", [])
    used.extend(name for name in extensions if name not in used)


def add_node(document, node):
    """Adds a node to the top of the scene."""
    document.setdefault("nodes", []).append(node)
    scene = document["scenes"][document.get("scene", 0)]
    scene.setdefault("nodes", []).append(len(document["nodes"]) - 1)


def columns(matrix):
    """A matrix as glTF writes it."""
    return [value for column in matrix.transposed() for value in column]


def emissive(document, name, radiance):
    """The index of a new material that sends this radiance from its front and reflects nothing."""
    strength = max(max(radiance), 1e-30)
    document.setdefault("materials", []).append({
        "name": name,
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
        "emissiveFactor": [max(value, 0.0) / strength for value in radiance],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength},
                       "KHR_materials_specular": {"specularFactor": 0}},
    })
    add_used(document, "KHR_materials_emissive_strength", "KHR_materials_specular")
    return len(document["materials"]) - 1


def add_view(document, data, target):
    """Appends bytes as a buffer and a view of it; returns the view's index."""
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode("ascii")
    document.setdefault("buffers", []).append({"byteLength": len(data), "uri": uri})
    document.setdefault("bufferViews", []).append(
        {"buffer": len(document["buffers"]) - 1, "byteLength": len(data), "target": target})
    return len(document["bufferViews"]) - 1


def disc_mesh(document, material):
    """The index of a new mesh: a disc of radius 1 in x and z, as a polygon of the same area, whose front is +y."""
    n = DISC_CORNERS
    radius = math.sqrt(math.pi / (n / 2 * math.sin(2 * math.pi / n)))
    corners = [(radius * math.cos(2 * math.pi * i / n), 0.0, -radius * math.sin(2 * math.pi * i / n)) for i in range(n)]
    indices = [index for i in range(1, n - 1) for index in (0, i, i + 1)]
    positions = add_view(document, b"".join(struct.pack("<3f", *corner) for corner in corners), 34962)
    triangles = add_view(document, struct.pack("<%dH" % len(indices), *indices), 34963)
    accessors = document.setdefault("accessors", [])
    accessors.append({"bufferView": positions, "componentType": 5126, "count": n, "type": "VEC3",
                      "min": [-radius, 0, -radius], "max": [radius, 0, radius]})
    accessors.append({"bufferView": triangles, "componentType": 5123, "count": len(indices), "type": "SCALAR"})
    document.setdefault("meshes", []).append({"primitives": [
        {"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1, "material": material}]})
    return len(document["meshes"]) - 1


def add_area_light(document, name, light, world):
    """Adds an area light. light: Blender's data of it; world: the matrix of its object"""
    location, rotation, scale = world.decompose()
    size_x = light.size * abs(scale.x)
    size_y = (light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size) * abs(scale.y)
    is_round = light.shape in {"DISK", "ELLIPSE"}
    area = size_x * size_y * (math.pi / 4 if is_round else 1.0)
    if not area > 0:
        return
    # The energy in watts is spread by the cosine to the area's front.
    energy = light.energy * 2 ** getattr(light, "exposure", 0.0)
    material = emissive(document, name, [energy * value / (math.pi * area) for value in light.color])
    place = mathutils.Matrix.LocRotScale(location, rotation, None)
    node = {"name": name, "matrix": columns(GLTF_FROM_BLENDER @ place @ LIGHT_FROM_SHAPE)}
    if is_round:
        stretch = mathutils.Matrix.Diagonal((size_x / 2, 1, size_y / 2, 1))
        node["matrix"] = columns(GLTF_FROM_BLENDER @ place @ LIGHT_FROM_SHAPE @ stretch)
        node["mesh"] = disc_mesh(document, material)
    else:
        shape = {"type": "plane", "plane": {"sizeX": size_x, "sizeZ": size_y}}
        node["extensions"] = {"EIKON_shape": {"shape": shape, "material": material}}
        add_used(document, "EIKON_shape")
    add_node(document, node)


def add_sphere_light(document, name, light, world):
    """Adds a point light as a sphere of its radius."""
    energy = light.energy * 2 ** getattr(light, "exposure", 0.0)
    area = 4 * math.pi * light.shadow_soft_size ** 2
    material = emissive(document, name, [energy * value / (math.pi * area) for value in light.color])
    shape = {"type": "sphere", "sphere": {"radius": light.shadow_soft_size}}
    add_used(document, "EIKON_shape")
    add_node(document, {"name": name, "translation": list(GLTF_FROM_BLENDER @ world.translation),
                        "extensions": {"EIKON_shape": {"shape": shape, "material": material}}})


def drop_point_lights(document, names):
    """Takes away the point lights of nodes that have these names."""
    for node in document.get("nodes", []):
        extensions = node.get("extensions", {})
        if node.get("name") in names and "KHR_lights_punctual" in extensions:
            del extensions["KHR_lights_punctual"]


def keep_camera(document, name):
    """Leaves only the camera of the object of this name, and returns its description; None if it was not exported."""
    kept = None
    parents = {child: node for node in document.get("nodes", []) for child in node.get("children", [])}
    for index, node in enumerate(document.get("nodes", [])):
        if "camera" not in node:
            continue
        # Older exporters put the camera into a node below that of its object, to turn it.
        names = {node.get("name"), parents.get(index, {}).get("name")}
        if kept is None and name in names:
            kept = document["cameras"][node["camera"]]
        else:
            del node["camera"]
    return kept


def add_lens(document, camera, data, focus_m):
    """Gives the exported camera the lens of Blender's."""
    radius = data.lens / 1000 / (2 * data.dof.aperture_fstop)
    camera.setdefault("extensions", {})["EIKON_camera_lens"] = {"radius": radius, "focusDistance": focus_m}
    add_used(document, "EIKON_camera_lens")
