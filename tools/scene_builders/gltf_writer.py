# SPDX-License-Identifier: Apache-2.0
"""Writes small glTF 2.0 files, always the same bytes for the same calls. Standard library only.

Positions are metres, +Y up, triangles counter-clockwise seen from the front; texture coordinates have v down from the
top of the picture, as glTF has them.
"""

import base64
import json
import pathlib
import re
import struct

from .glb_file import pack_glb

UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT, FLOAT = 5121, 5123, 5125, 5126  # componentType of an accessor
VERTEX_DATA, INDEX_DATA = 34962, 34963  # target of a bufferView

def _floats(vectors):
    values = [c for v in vectors for c in v]
    return struct.pack(f"<{len(values)}f", *values)


class GltfWriter:
    """Collects meshes, nodes, materials, textures, lights and cameras of one scene; `write` picks .gltf or .glb by the
    name. `files` holds what must lie beside the scene: name -> bytes."""

    def __init__(self, proves):
        """proves: what the scene is for, kept in asset.extras so that the file explains itself."""
        self.root = {
            "asset": {"version": "2.0", "generator": "eikon tools/make_scenes.py", "extras": {"proves": proves}},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
        }
        self.buffer = bytearray()
        self.files = {}

    def environment(self, radiance):
        """Sets constant radiance from every direction, W / (sr m^2), linear Rec. 709."""
        self.root["scenes"][0]["extras"] = {"environment": {"radiance": list(radiance)}}

    def environment_map(self, uri, data, scale=1.0, rotate_deg=0.0):
        """Sets the radiance by a picture beside the scene, named `uri`: equirectangular, its middle is -Z, u grows towards +X."""
        self.files[uri] = data
        entry = {"uri": uri, "scale": scale, "rotate": rotate_deg}
        self.root["scenes"][0]["extras"] = {"environment": entry}

    def lambert(self, name, color, emission=None, double_sided=False, **members):
        """Adds a material that is exactly Lambert and returns its index. `color` is its reflectance, `emission` the radiance of its
        front side; members: what else stands in the material (extras=)."""
        entry = {
            **members,
            "name": name,
            "pbrMetallicRoughness": {"baseColorFactor": [*color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}},
        }
        self._use_extension("KHR_materials_specular")
        if double_sided:
            entry["doubleSided"] = True
        self._emission(entry, emission)
        self.root["materials"].append(entry)
        return len(self.root["materials"]) - 1

    def material(self, name, color=(1.0, 1.0, 1.0), metallic=0.0, roughness=1.0, emission=None, opacity=1.0,
                 extensions=None, **members):
        """Adds any other material and returns its index. extensions: {"KHR_materials_...": {...}}; members: what stands in the
        material itself (alphaMode=, normalTexture=, ...), or, for baseColorTexture and metallicRoughnessTexture, one level
        down."""
        lobe = {"baseColorFactor": [*color, opacity], "metallicFactor": metallic, "roughnessFactor": roughness}
        for key in ("baseColorTexture", "metallicRoughnessTexture"):
            if key in members:
                lobe[key] = members.pop(key)
        entry = {"name": name, "pbrMetallicRoughness": lobe, **members}
        if extensions:
            entry["extensions"] = dict(extensions)
            for extension in extensions:
                self._use_extension(extension)
        self._emission(entry, emission)
        self.root["materials"].append(entry)
        return len(self.root["materials"]) - 1

    def texture(self, name, png, uri=None, transform=None, sampler=None, **use):
        """Returns one use of a picture, for baseColorTexture= and its kin. png: its bytes; uri: as a file beside the scene,
        else inside the buffer; transform: KHR_texture_transform; sampler: glTF's; use: scale=, texCoord=."""
        images = self.root.setdefault("images", [])
        found = next((i for i, image in enumerate(images) if image["name"] == name), None)
        if found is None:
            found = len(images)
            if uri is not None:
                self.files[uri] = png
                images.append({"name": name, "uri": uri})
            else:
                images.append({"name": name, "mimeType": "image/png", "bufferView": self._view(png, None)})
        entry = {"source": found}
        if sampler is not None:
            samplers = self.root.setdefault("samplers", [])
            if sampler not in samplers:
                samplers.append(sampler)
            entry["sampler"] = samplers.index(sampler)
        textures = self.root.setdefault("textures", [])
        if entry not in textures:
            textures.append(entry)
        reference = {"index": textures.index(entry), **use}
        if transform is not None:
            reference["extensions"] = {"KHR_texture_transform": transform}
            self._use_extension("KHR_texture_transform")
        return reference

    def punctual_light(self, name, kind, color, intensity, spot=None, **transform):
        """Adds a light of KHR_lights_punctual and its node, shining along the node's -Z. intensity: candela, or lux of a
        directional one; spot: {"innerConeAngle": rad, "outerConeAngle": rad}."""
        self._use_extension("KHR_lights_punctual")
        lights = self.root.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append({"name": name, "type": kind, "color": list(color), "intensity": intensity,
                       **({"spot": spot} if spot else {})})
        self._node({"name": name, "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}, **transform})

    def primitive(self, points, triangles, material, normals=None, uv=None, tangents=None):
        """Returns a primitive: points [(x, y, z)], triangles [(a, b, c)] into points; per point or none: normals (none: flat),
        texture coordinates uv [(u, v)], tangents [(x, y, z, sign of the bitangent)]. Raises ValueError if a triangle names a
        point that does not exist."""
        indices = [i for t in triangles for i in t]
        if min(indices) < 0 or max(indices) >= len(points):
            raise ValueError("a triangle names a point that does not exist")
        index_format = ("H", UNSIGNED_SHORT) if len(points) < 65535 else ("I", UNSIGNED_INT)
        attributes = {"POSITION": self._vectors(_floats(points))}
        if normals is not None:
            attributes["NORMAL"] = self._vectors(_floats(normals))
        if uv is not None:
            attributes["TEXCOORD_0"] = self._accessor(_floats(uv), FLOAT, "VEC2", len(uv), VERTEX_DATA)
        if tangents is not None:
            attributes["TANGENT"] = self._accessor(_floats(tangents), FLOAT, "VEC4", len(tangents), VERTEX_DATA)
        data = struct.pack(f"<{len(indices)}{index_format[0]}", *indices)
        return {
            "attributes": attributes,
            "indices": self._accessor(data, index_format[1], "SCALAR", len(indices), INDEX_DATA),
            "material": material,
        }

    def vertex_colors(self, colors):
        """Returns an accessor of colours [(r, g, b)], linear: COLOR_0 among the "attributes" of a primitive."""
        return self._accessor(_floats(colors), FLOAT, "VEC3", len(colors), VERTEX_DATA)

    def primitive_arrays(self, positions, normals, indices, bounds, material):
        """Returns a large primitive from ready bytes: float32 positions and normals, uint32 indices; bounds ((lo), (hi))."""
        return {
            "attributes": {
                "POSITION": self._accessor(positions, FLOAT, "VEC3", len(positions) // 12, VERTEX_DATA, bounds),
                "NORMAL": self._accessor(normals, FLOAT, "VEC3", len(normals) // 12, VERTEX_DATA),
            },
            "indices": self._accessor(indices, UNSIGNED_INT, "SCALAR", len(indices) // 4, INDEX_DATA),
            "material": material,
        }

    def mesh(self, name, primitives, **transform):
        """Adds a mesh and a node that shows it; transform: translation=, rotation= (x, y, z, w), scale=, or matrix=."""
        self.place_mesh(name, self.mesh_alone(name, primitives), **transform)

    def mesh_alone(self, name, primitives):
        """Adds a mesh that no node shows yet, for place_mesh() and instances(), and returns its index."""
        self.root["meshes"].append({"name": name, "primitives": primitives})
        return len(self.root["meshes"]) - 1

    def place_mesh(self, name, mesh_index, **transform):
        """Adds a node that shows a mesh_alone(); transform as of mesh()."""
        self._node({"name": name, "mesh": mesh_index, **transform})

    def joint(self, name, parent=None, **transform):
        """Adds an empty node below the node `parent`, or in the scene, and returns its index."""
        self.root["nodes"].append({"name": name, **transform})
        index = len(self.root["nodes"]) - 1
        siblings = self.root["scenes"][0]["nodes"] if parent is None else self.root["nodes"][parent].setdefault("children", [])
        siblings.append(index)
        return index

    def skin(self, name, joints, inverse_binds):
        """Adds a skin of joints and the inverses of their places at rest, [16 numbers, column by column]. Returns its index, for
        mesh(skin=)."""
        matrices = self._accessor(_floats(inverse_binds), FLOAT, "MAT4", len(joints), None)
        self.root.setdefault("skins", []).append({"name": name, "joints": joints, "inverseBindMatrices": matrices})
        return len(self.root["skins"]) - 1

    def joint_weights(self, joints, weights):
        """Returns JOINTS_0 and WEIGHTS_0 for the "attributes" of a primitive: 4 indices and 4 shares of 255 for each point."""
        data = bytes(j for row in joints for j in row), bytes(w for row in weights for w in row)
        shares = self._accessor(data[1], UNSIGNED_BYTE, "VEC4", len(weights), VERTEX_DATA)
        self.root["accessors"][shares]["normalized"] = True
        return {"JOINTS_0": self._accessor(data[0], UNSIGNED_BYTE, "VEC4", len(joints), VERTEX_DATA), "WEIGHTS_0": shares}

    def morph_target(self, positions, normals):
        """Returns a morph target for the "targets" of a primitive: differences [(x, y, z)] of positions and of normals."""
        return {"POSITION": self._vectors(_floats(positions)), "NORMAL": self._vectors(_floats(normals))}

    def channel(self, animation, target, times, values, interpolation="LINEAR"):
        """Moves `target`, {"node": n, "path": "..."} or a JSON pointer (KHR_animation_pointer), in the animation of this
        name. values: a vector for each time, three with CUBICSPLINE; numbers alone for weights and other scalars."""
        if isinstance(target, str):
            self._use_extension("KHR_animation_pointer")
            target = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": target}}}
        animations = self.root.setdefault("animations", [])
        entry = next((a for a in animations if a["name"] == animation), None)
        if entry is None:
            entry = {"name": animation, "channels": [], "samplers": []}
            animations.append(entry)
        vectors = [v if isinstance(v, (tuple, list)) else (v,) for v in values]
        kind = "SCALAR" if len(vectors[0]) == 1 else f"VEC{len(vectors[0])}"
        clock = self._accessor(_floats([(t,) for t in times]), FLOAT, "SCALAR", len(times), None, ([times[0]], [times[-1]]))
        output = self._accessor(_floats(vectors), FLOAT, kind, len(vectors), None)
        entry["samplers"].append({"input": clock, "output": output, "interpolation": interpolation})
        entry["channels"].append({"sampler": len(entry["samplers"]) - 1, "target": target})

    def node_index(self, name):
        """Returns the index of the first node of this name."""
        return next(i for i, node in enumerate(self.root["nodes"]) if node.get("name") == name)

    def instances(self, name, mesh_index, translations, rotations, scales):
        """Adds a node that shows a mesh_alone() at many places (EXT_mesh_gpu_instancing): translations, rotations and scales
        are bytes of float32 vectors of 3, 4 and 3."""
        self._use_extension("EXT_mesh_gpu_instancing")
        count = len(translations) // 12
        attributes = {
            "TRANSLATION": self._accessor(translations, FLOAT, "VEC3", count, None),
            "ROTATION": self._accessor(rotations, FLOAT, "VEC4", count, None),
            "SCALE": self._accessor(scales, FLOAT, "VEC3", count, None),
        }
        self._node({"name": name, "mesh": mesh_index, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}})

    def shape(self, name, kind, material, sizes, **transform):
        """Adds a node with a sphere, a box or another shape that is no mesh (EIKON_shape); kind and sizes as in the draft
        KHR_implicit_shapes: "sphere", {"radius": r}. transform as of mesh()."""
        self._use_extension("EIKON_shape")
        shape = {"shape": {"type": kind, kind: sizes}, "material": material}
        self._node({"name": name, "extensions": {"EIKON_shape": shape}, **transform})

    def implicit_surface(self, name, f, bounds, material, **transform):
        """Adds a node with the surface f(x, y, z) = 0 within bounds (least x, y, z, then the largest); f > 0 is outside."""
        self._use_extension("EIKON_implicit_surface")
        surface = {"f": f, "bounds": list(bounds), "material": material}
        self._node({"name": name, "extensions": {"EIKON_implicit_surface": surface}, **transform})

    def camera(self, yfov_rad, aspect, name="camera", **transform):
        """Adds a perspective camera, looking along its -Z with +Y up."""
        perspective = {"aspectRatio": aspect, "yfov": yfov_rad, "znear": 1e-6}
        self.root.setdefault("cameras", []).append({"name": name, "type": "perspective", "perspective": perspective})
        self._node({"name": name, "camera": len(self.root["cameras"]) - 1, **transform})

    def write(self, path):
        """Writes the file, as .glb or as .gltf with its buffer inside, and the `files` beside it."""
        path = pathlib.Path(path)
        path.write_bytes(self.glb() if path.suffix == ".glb" else self.gltf())
        for name, data in self.files.items():
            (path.parent / name).write_bytes(data)

    def gltf(self):
        """Returns the bytes of the .gltf form: indented JSON, the buffer as one base64 data URI."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.buffer).decode()
        text = json.dumps({**self.root, "buffers": [{"byteLength": len(self.buffer), "uri": uri}]}, indent=1)
        # Vectors on one line each, for the eye.
        text = re.sub(r"\[\s+([-+.e\d,\s]+?)\s+\]", lambda m: "[" + re.sub(r"\s+", " ", m.group(1)) + "]", text)
        return (text + "\n").encode()

    def glb(self):
        """Returns the bytes of the binary form."""
        document = {**self.root, "buffers": [{"byteLength": len(self.buffer)}]}
        return pack_glb(json.dumps(document, separators=(",", ":")).encode(), self.buffer)

    def variants(self, names):
        """Sets the names of KHR_materials_variants, for variant_of()."""
        self._use_extension("KHR_materials_variants")
        entry = {"variants": [{"name": name} for name in names]}
        self.root.setdefault("extensions", {})["KHR_materials_variants"] = entry

    @staticmethod
    def variant_of(primitive, materials):
        """Returns `primitive` with materials by variant, in the order of variants(); its own is shown without any."""
        mappings = [{"material": material, "variants": [i]} for i, material in enumerate(materials)]
        return {**primitive, "extensions": {"KHR_materials_variants": {"mappings": mappings}}}

    def _emission(self, entry, emission):
        if emission is None or max(emission) <= 0:
            return
        # emissiveFactor must lie in [0, 1]; the strength carries the rest.
        strength = max(1.0, max(emission))
        entry["emissiveFactor"] = [e / strength for e in emission]
        if strength > 1.0:
            entry.setdefault("extensions", {})["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
            self._use_extension("KHR_materials_emissive_strength")

    def _use_extension(self, name):
        used = self.root.setdefault("extensionsUsed", [])
        if name not in used:
            used.append(name)

    def _node(self, node):
        self.root["nodes"].append(node)
        self.root["scenes"][0]["nodes"].append(len(self.root["nodes"]) - 1)

    def _vectors(self, data):
        # min and max are those of the rounded values, as the file holds them.
        values = struct.unpack(f"<{len(data) // 4}f", data)
        bounds = ([min(values[a::3]) for a in range(3)], [max(values[a::3]) for a in range(3)])
        return self._accessor(data, FLOAT, "VEC3", len(values) // 3, VERTEX_DATA, bounds)

    def _view(self, data, target):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        entry = {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)}
        self.root["bufferViews"].append(entry if target is None else {**entry, "target": target})
        self.buffer += data
        return len(self.root["bufferViews"]) - 1

    def _accessor(self, data, component, kind, count, target, bounds=None):
        entry = {"bufferView": self._view(data, target), "componentType": component, "count": count, "type": kind}
        if bounds is not None:
            entry["min"], entry["max"] = [list(b) for b in bounds]
        self.root["accessors"].append(entry)
        return len(self.root["accessors"]) - 1
