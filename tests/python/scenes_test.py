#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that scenes from arrays are those of files: scenes_test.py EIKON [unittest arguments]"""
import base64
import json

import eikon
import numpy as np
from package_case import SCENES, Package, main


def arrays_of(document, accessor):
    """The values of an accessor of a .gltf file whose buffers are in it."""
    accessor = document["accessors"][accessor]
    view = document["bufferViews"][accessor["bufferView"]]
    data = base64.b64decode(document["buffers"][view["buffer"]]["uri"].split(",")[1])
    kind = {5126: "<f4", 5125: "<u4", 5123: "<u2", 5121: "u1"}[accessor["componentType"]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return np.frombuffer(data, kind, accessor["count"] * width, begin).reshape(accessor["count"], width)


class Scenes(Package):
    def rebuilt(self, name):
        """A shipped scene, made of arrays."""
        document = json.loads((SCENES / name).read_text())
        scene = eikon.Scene()
        materials = [scene.material(**fields) for fields in document["materials"]]
        meshes = []
        for mesh in document["meshes"]:
            (primitive,) = mesh["primitives"]
            attributes = primitive["attributes"]
            optional = {"normals": "NORMAL", "texcoords": "TEXCOORD_0"}
            more = {key: arrays_of(document, attributes[a]) for key, a in optional.items() if a in attributes}
            meshes.append(scene.mesh(arrays_of(document, attributes["POSITION"]), arrays_of(document, primitive["indices"]),
                                     material=materials[primitive["material"]], **more))
        for node in document["nodes"]:
            fields = {k: v for k, v in node.items() if k not in ("mesh", "camera")}
            if "camera" in node:
                camera = document["cameras"][node["camera"]]["perspective"]
                self.assertNotIn("matrix", fields)
                matrix = np.eye(4)
                x, y, z, w = fields.get("rotation", (0, 0, 0, 1))
                matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                                  [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                                  [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
                matrix[:3, 3] = fields.get("translation", (0, 0, 0))
                scene.camera(fov=np.degrees(camera["yfov"]), aspect=camera.get("aspectRatio"), matrix=matrix)
            else:
                scene.add(meshes[node["mesh"]] if "mesh" in node else None, **fields)
        return scene

    def test_of_arrays_has_the_bits_of_the_same_scene_as_a_file(self):
        scene = self.rebuilt("cornell.gltf")
        view = {"look_at": ((0.278, 0.273, 1.0), (0.278, 0.273, 0.0)), "fov": 40, "size": (24, 24), "spp": 8, "aov": ["normal"]}
        built, file = eikon.render(scene, **view), eikon.render(SCENES / "cornell.gltf", **view)
        self.assertGreater(file.rgb.mean(), 0.01)
        self.assert_same_picture(built, file)
        scene.save(self.folder / "cornell.glb")
        self.assert_same_picture(built, eikon.render((self.folder / "cornell.glb").read_bytes(), **view))
        self.assert_same_picture(built, eikon.render((SCENES / "cornell.gltf").read_bytes(), **view))

    def test_shows_images_from_arrays_bytes_and_files(self):
        pixels = np.zeros((2, 2, 3), np.uint8)
        pixels[0, 1] = 255
        file = self.folder / "pixels.png"
        file.write_bytes(eikon._scene.png_of(pixels))
        pictures = []
        for image in (pixels, file.read_bytes(), file, {"image": pixels, "texCoord": 0, "magFilter": 9728}):
            scene = eikon.Scene()
            unlit = scene.material(pbrMetallicRoughness={"baseColorTexture": image}, extensions={"KHR_materials_unlit": {}})
            square = scene.mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [0, 1, 2, 0, 2, 3], material=unlit,
                                texcoords=[[0, 1], [1, 1], [1, 0], [0, 0]])
            scene.add(square)
            scene.camera(height=2, aspect=1, matrix=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]])
            pictures.append(eikon.render(scene, size=(8, 8), spp=2).rgb)
        for other in pictures[1:3]:
            np.testing.assert_array_equal(pictures[0], other)
        nearest = pictures[3]
        np.testing.assert_allclose(nearest[:4, 4:], 1)  # the white pixel is at the top right
        np.testing.assert_allclose(nearest[4:], 0)
        np.testing.assert_allclose(nearest[:, :4], 0)

    def test_places_a_mesh_by_matrix_translation_and_light(self):
        def render(**place):
            scene = eikon.Scene()
            triangle = scene.mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], colors=np.eye(3),
                                  material=scene.material(pbrMetallicRoughness={"metallicFactor": 0}))
            scene.add(triangle, **place)
            scene.add(triangle, translation=(-1.5, 0, 0))
            scene.light("spot", intensity=100, outerConeAngle=0.6, matrix=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]])
            return eikon.render(scene, look_at=((0, 0, 4), (0, 0, 0)), size=(16, 16), spp=4, aov=["id"])

        by_matrix = render(matrix=[[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        self.assert_same_picture(by_matrix, render(translation=(0.5, 0, 0)))
        self.assertEqual(len(np.unique(by_matrix["id"])), 3)
        self.assertGreater(by_matrix.rgb.max(), 0.1)

    def test_refuses_numbers_that_are_not_finite_and_meshes_of_nothing(self):
        scene = eikon.Scene()
        for positions in ([[0, 0, float("nan")]] * 3, [[0, 0, float("inf")]] * 3, np.zeros((0, 3))):
            with self.assertRaises(eikon.UsageError):
                scene.mesh(positions)
        scene.material(emissiveFactor=[float("nan"), 0, 0])
        with self.assertRaises(eikon.UsageError):
            scene.to_glb()

    def test_refuses_arrays_of_another_shape(self):
        scene = eikon.Scene()
        corners = np.zeros((3, 3))
        for arguments in ({"positions": np.zeros((3, 2))}, {"positions": corners, "normals": np.zeros((2, 3))},
                          {"positions": corners, "indices": [0.0, 1.0, 2.0]}, {"positions": corners, "indices": [0, 1]},
                          {"positions": corners, "indices": [0, 1, -1]}, {"positions": corners, "indices": [0, 1, 2 ** 32 + 2]},
                          {"positions": corners, "texcoords": corners}):
            with self.assertRaises(eikon.UsageError):
                scene.mesh(**arguments)
        with self.assertRaises(eikon.UsageError):
            scene.add(0, matrix=np.eye(3))
        with self.assertRaises(eikon.UsageError):
            scene.material(pbrMetallicRoughness={"baseColorTexture": np.zeros((2, 2, 3))})
        with self.assertRaises(eikon.UsageError):
            scene.camera()
        scene.add(scene.mesh(corners, [0, 1, 7]))  # what the reader refuses in a file
        with self.assertRaises(eikon.InputError):
            eikon.render(scene)


if __name__ == "__main__":
    main()
