"""Makes the crowd that beside_cycles.py renders: 64 cages, each twisted its own way, over a floor under two square lights.

The recipe is that of crowd.h, but for the cage, which is a torus of 24 x 12 quads with lumps, and for the twist: copy i turns
about y by 2 a y, and a goes from 1.2 sin(i) to 1.2 sin(0.7 + i) while the shutter is open, along straight lines. Occam
reads it as glTF, whose polygons are the cages of Catmull-Clark surfaces and whose twist is a morph target. Blender makes the
same meshes from JSON: a subdivision modifier and a shape key. Both are lit by the two lights alone, without bounces.
"""
import json
import math
import pathlib
import struct

COPIES, AROUND, ACROSS, TWIST, RADIANCE = 64, 24, 12, 1.2, 12.0
SIDE = int(math.sqrt(COPIES))
EXTENT = 1.2 * SIDE
EYE, TARGET, FOV_DEG = (0.1 * EXTENT, 0.45 * EXTENT, -0.85 * EXTENT), (0, 0, 0), 45
LIGHTS = ((-0.7 * EXTENT, 0.9 * EXTENT, -0.3 * EXTENT), (0.8 * EXTENT, 0.7 * EXTENT, -0.5 * EXTENT))
LIGHT_SIDE = 0.15 * EXTENT
GREY = 0.6

IN_BLENDER = """
import bpy, json, mathutils, sys
job = json.loads(sys.argv[sys.argv.index("--") + 1])
crowd = json.load(open(job["scene"]))
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
def world_of(p):
    return mathutils.Vector((p[0], -p[2], p[1]))
grey = bpy.data.materials.new("grey")
grey.use_nodes = True
nodes, links = grey.node_tree.nodes, grey.node_tree.links
nodes.clear()
diffuse, out = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
diffuse.inputs["Color"].default_value = (crowd["grey"],) * 3 + (1,)
links.new(diffuse.outputs[0], out.inputs["Surface"])
for shape in crowd["shapes"]:
    mesh = bpy.data.meshes.new("shape")
    mesh.from_pydata([world_of(p) for p in shape["open"]], [], shape["faces"])
    mesh.materials.append(grey)
    placed = bpy.data.objects.new("shape", mesh)
    scene.collection.objects.link(placed)
    if not shape["is_cage"]:
        continue
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    if job["blur"]:
        placed.shape_key_add(name="open")
        closed = placed.shape_key_add(name="closed")
        closed.data.foreach_set("co", [x for p in shape["closed"] for x in world_of(p)])
        for frame in (0, 1):
            closed.value = frame
            closed.keyframe_insert("value", frame=frame)
        for curve in mesh.shape_keys.animation_data.action.fcurves:
            curve.extrapolation = "LINEAR"
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
    divided = placed.modifiers.new("surface", "SUBSURF")
    divided.levels = divided.render_levels = job["levels"]
for at in crowd["lights"]:
    light = bpy.data.lights.new("light", "AREA")
    light.shape, light.size = "SQUARE", crowd["light_side"]
    # Cycles gives an area light of power P and area A the radiance P / 4A.
    light.energy = crowd["radiance"] * 4 * crowd["light_side"] ** 2
    placed = bpy.data.objects.new("light", light)
    placed.location = world_of(at)
    placed.rotation_euler = (-placed.location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(placed)
camera = bpy.data.cameras.new("camera")
camera.sensor_fit, camera.angle, camera.clip_start = "VERTICAL", job["fov"], 1e-3
placed = bpy.data.objects.new("camera", camera)
eye, target = world_of(job["eye"]), world_of(job["target"])
placed.location, placed.rotation_euler = eye, (target - eye).to_track_quat("-Z", "Y").to_euler()
scene.collection.objects.link(placed)
scene.camera = placed
render, cycles = scene.render, scene.cycles
render.engine, cycles.device = "CYCLES", "CPU"
cycles.samples, cycles.seed, cycles.use_denoising = job["samples"], job["seed"], False
cycles.use_adaptive_sampling = job["end_below"] > 0
if cycles.use_adaptive_sampling:
    cycles.adaptive_threshold, cycles.adaptive_min_samples = job["end_below"], job["min_samples"]
cycles.max_bounces = 0
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
scene.frame_set(0)
render.use_motion_blur, render.motion_blur_shutter, cycles.motion_blur_position = job["blur"], 1.0, "START"
render.threads_mode, render.threads = "FIXED", job["threads"]
render.resolution_x, render.resolution_y, render.resolution_percentage = job["width"], job["height"], 100
render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
render.image_settings.color_mode, render.filepath = "RGB", job["picture"]
bpy.ops.render.render(write_still=True)
"""


def cage() -> tuple:
    """Returns the points and the quads of a torus with lumps, of unit size about its middle."""
    points, faces = [], []
    for i in range(AROUND):
        for j in range(ACROSS):
            turn, roll = 2 * math.pi * i / AROUND, 2 * math.pi * j / ACROSS
            tube = 0.16 * (1 + 0.25 * math.sin(5 * turn) * math.cos(2 * roll))
            ring = 0.31 + tube * math.cos(roll)
            points.append((ring * math.cos(turn), ring * math.sin(turn), tube * math.sin(roll)))
            a, b = i * ACROSS, (i + 1) % AROUND * ACROSS
            faces.append((a + j, b + j, b + (j + 1) % ACROSS, a + (j + 1) % ACROSS))
    return points, faces


def twisted(points: list, copy: int, frame: int) -> list:
    a = TWIST * math.sin(0.7 * frame + copy)
    place = [1.2 * (k - (SIDE - 1) * 0.5) for k in (copy % SIDE, copy // SIDE)]
    turned = []
    for x, y, z in points:
        s, c = math.sin(2 * a * y), math.cos(2 * a * y)
        turned.append((c * x + s * z + place[0], y, c * z - s * x + place[1]))
    return turned


def look_rotation(at: tuple) -> list:
    """Returns the quaternion that turns -z towards the origin from a point."""
    length = math.sqrt(sum(x * x for x in at))
    d = [-x / length for x in at]
    w = 1 - d[2]  # half-way between -z and d: the axis is their cross product
    axis = (d[1], -d[0], 0.0)
    n = math.sqrt(w * w + axis[0] ** 2 + axis[1] ** 2)
    return [axis[0] / n, axis[1] / n, 0.0, w / n]


class Document:
    """Collects the arrays of a glTF document."""

    def __init__(self):
        self.binary, self.views, self.accessors = b"", [], []

    def add(self, rows: list, code: str, component: int, kind: str) -> int:
        data = b"".join(struct.pack("<" + code * len(row), *row) for row in rows)
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        ends = {"min": [min(r[i] for r in rows) for i in range(len(rows[0]))],
                "max": [max(r[i] for r in rows) for i in range(len(rows[0]))]} if code == "f" else {}
        self.accessors.append({"bufferView": len(self.views) - 1, "componentType": component, "count": len(rows), "type": kind,
                               **ends})
        self.binary += data + b"\0" * (-len(data) % 4)
        return len(self.accessors) - 1


def single(points: list) -> list:
    """Rounds to floats, so that both programs read the same numbers."""
    return [struct.unpack("<3f", struct.pack("<3f", *p)) for p in points]


def write(folder: pathlib.Path) -> pathlib.Path:
    """Writes crowd.gltf with crowd.bin, and crowd.json, and returns the path of the first."""
    points, faces = cage()
    half = EXTENT
    floor = [(-half, -0.6, half), (half, -0.6, half), (half, -0.6, -half), (-half, -0.6, -half)]
    shapes = [{"open": single(floor), "faces": [(0, 1, 2, 3)], "is_cage": False}]
    shapes += [{"open": single(twisted(points, i, 0)), "closed": single(twisted(points, i, 1)), "faces": faces,
                "is_cage": True} for i in range(COPIES)]
    crowd = {"shapes": shapes, "grey": GREY, "lights": LIGHTS, "light_side": LIGHT_SIDE, "radiance": RADIANCE}
    (folder / "crowd.json").write_text(json.dumps(crowd))

    document, meshes, nodes, channels, samplers = Document(), [], [], [], []
    clock = document.add([(0.0,), (1.0,)], "f", 5126, "SCALAR")
    weights = document.add([(0.0,), (1.0,)], "f", 5126, "SCALAR")
    for shape in shapes:
        # Successive triangles that share their first vertex are one polygon (FB_ngon_encoding), so the corner that a fan
        # begins with changes from one quad to the next.
        fans, last = [], None
        for a, b, c, d in shape["faces"]:
            corners = (a, b, c, d) if a != last else (b, c, d, a)
            last = corners[0]
            fans += [(corners[0],), (corners[1],), (corners[2],), (corners[0],), (corners[2],), (corners[3],)]
        primitive = {"attributes": {"POSITION": document.add(shape["open"], "f", 5126, "VEC3")},
                     "indices": document.add(fans, "I", 5125, "SCALAR"), "material": 0,
                     "extensions": {"FB_ngon_encoding": {}}}
        mesh = {"primitives": [primitive]}
        if shape["is_cage"]:
            moves = [tuple(b - a for a, b in zip(p, q)) for p, q in zip(shape["open"], shape["closed"])]
            primitive["targets"] = [{"POSITION": document.add(moves, "f", 5126, "VEC3")}]
            mesh.update(weights=[0], extras={"occam": {"scheme": "catmull-clark"}})
            samplers.append({"input": clock, "output": weights, "interpolation": "LINEAR"})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": len(nodes), "path": "weights"}})
        nodes.append({"mesh": len(meshes)})
        meshes.append(mesh)
    for at in LIGHTS:
        light = {"shape": "rect", "size": [LIGHT_SIDE, LIGHT_SIDE], "radiance": [RADIANCE] * 3}
        nodes.append({"translation": at, "rotation": look_rotation(at), "extras": {"occam": {"area_light": light}}})
    (folder / "crowd.bin").write_bytes(document.binary)
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
             "meshes": meshes, "extensionsUsed": ["FB_ngon_encoding", "KHR_materials_specular"], "accessors": document.accessors,
             "animations": [{"name": "twist", "channels": channels, "samplers": samplers}],
             "bufferViews": document.views,
             "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [GREY, GREY, GREY, 1], "metallicFactor": 0},
                            "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}],
             "buffers": [{"byteLength": len(document.binary), "uri": "crowd.bin"}]}
    path = folder / "crowd.gltf"
    path.write_text(json.dumps(scene))
    return path
