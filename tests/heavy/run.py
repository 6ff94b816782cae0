#!/usr/bin/env python3
"""Renders files of at most 10 MB that ask for as much as such files can: run.py PROGRAM [PATTERN [SEED]].

PROGRAM is the command-line program. PATTERN chooses kinds of files by their names, as a shell does. Each file is rendered at 64 x 48
with the default settings. A line tells its size, the exit code, the processor time and the memory that it took. The exit code is 1 if any
run ended by a signal, took more than two minutes of processor time (one minute of two processors), or took more than 4 GB."""
import fnmatch
import json
import math
import os
import pathlib
import random
import resource
import struct
import subprocess
import sys
import tempfile

MOST_SECONDS, MOST_KILOBYTES = 120, 4_000_000
MATERIALS = {
    "opaque": {},
    "blend": {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.2]}},
    "mask": {"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.7]}},
    "glass": {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
                             "KHR_materials_volume": {"thicknessFactor": 1}}},
    "light": {"emissiveFactor": [1, 0.5, 0.2]},
    "mirror": {"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}}}
SMOOTH = ["--subdivide", "on"]
CUBE = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]


class Glb:
    """A glTF scene in its binary form."""
    FORMATS = {"f": 5126, "I": 5125, "H": 5123}
    WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        self.bytes = bytearray()

    def add(self, what, item):
        """Adds an item to a list of the file and returns its index."""
        items = self.json.setdefault(what, [])
        items.append(item)
        return len(items) - 1

    def accessor(self, values, form, kind):
        self.bytes += bytes(-len(self.bytes) % 4)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(values) * struct.calcsize(form)})
        self.bytes += struct.pack(f"<{len(values)}{form}", *values)
        width = self.WIDTHS[kind]
        return self.add("accessors", {
            "bufferView": view, "componentType": self.FORMATS[form], "count": len(values) // width, "type": kind,
            "min": [min(values[i::width]) for i in range(width)], "max": [max(values[i::width]) for i in range(width)]})

    def mesh(self, points, triangles, material="opaque", **more):
        primitive = {"attributes": {"POSITION": self.accessor([x for p in points for x in p], "f", "VEC3")},
                     "indices": self.accessor([i for t in triangles for i in t], "I", "SCALAR"),
                     "material": self.add("materials", MATERIALS[material])}
        primitive["attributes"].update(more.pop("attributes", {}))
        return self.add("meshes", {"primitives": [dict(primitive, **more)]})

    def cube(self, radius, material="opaque"):
        return self.mesh([[radius * (1 if i >> a & 1 else -1) for a in range(3)] for i in range(8)], CUBE, material)

    def node(self, **what):
        index = self.add("nodes", what)
        self.json["scenes"][0]["nodes"].append(index)
        return index

    def animate(self, path, values_of):
        """Gives each node a track of three keys, one second apart; values_of(node) returns the values."""
        times, kind = self.accessor([0, 1, 2], "f", "SCALAR"), "VEC4" if path == "rotation" else "VEC3"
        tracks = [self.accessor(values_of(), "f", kind) for _ in self.json["nodes"]]
        self.add("animations", {"samplers": [{"input": times, "output": track} for track in tracks],
                                "channels": [{"sampler": i, "target": {"node": i, "path": path}} for i in range(len(tracks))]})

    def write(self, path):
        self.bytes += bytes(-len(self.bytes) % 4)
        text = json.dumps(dict(self.json, buffers=[{"byteLength": len(self.bytes)}]), separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.bytes)) +
                         struct.pack("<I4s", len(text), b"JSON") + text +
                         struct.pack("<I4s", len(self.bytes), b"BIN\0") + bytes(self.bytes))


class Obj:
    def __init__(self, points, faces, creases=()):
        self.lines = ["v %.4g %.4g %.4g" % tuple(p) for p in points] + ["t crease 2/1/0 %d %d %.3g" % c for c in creases]
        self.lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]

    def write(self, path):
        path.write_text("\n".join(self.lines) + "\n")


def anywhere(rng, extent):
    return [round(rng.uniform(-extent, extent), 2) for _ in range(3)]


def soup(rng, count, size):
    """Returns triangles of about that size, anywhere in a cube."""
    points = []
    for _ in range(count):
        middle = [rng.uniform(-1, 1) for _ in range(3)]
        points += [[x + rng.gauss(0, size) for x in middle] for _ in range(3)]
    return points, [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(count)]


def soup_of(material, count, size):
    def make(rng):
        file = Glb()
        file.node(mesh=file.mesh(*soup(rng, count, size), material))
        return file
    return make


def cubes(material, count, radius, extent):
    def make(rng):
        file = Glb()
        mesh = file.cube(radius, material)
        for _ in range(count):
            file.node(mesh=mesh, translation=anywhere(rng, extent))
        return file
    return make


def separate_meshes(rng):
    """Many meshes that share their accessors, so that each of them is a cage of its own."""
    file = Glb()
    file.cube(1)
    for i in range(30_000):
        file.add("meshes", file.json["meshes"][0])
        file.node(mesh=i, translation=anywhere(rng, 60))
    return file


def instances(rng):
    file = Glb()
    offsets = file.accessor([rng.uniform(-1, 1) for _ in range(3 * 700_000)], "f", "VEC3")
    file.json["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    file.node(mesh=file.cube(0.02), extensions={"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": offsets}}})
    return file


def lamps(rng):
    file = Glb()
    file.node(mesh=file.cube(3))
    file.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}, {"type": "spot", "spot": {}}]}}
    for i in range(60_000):
        file.node(translation=anywhere(rng, 9), extensions={"KHR_lights_punctual": {"light": i % 2}})
    return file


def swarm(path, count):
    """Cubes that fly, turn or grow at random while the shutter is open."""
    def values(rng):
        if path != "rotation":
            return [rng.uniform(0.1, 9) for _ in range(9)]
        turns = [[rng.gauss(0, 1) for _ in range(4)] for _ in range(3)]
        return [x / math.sqrt(sum(y * y for y in turn)) for turn in turns for x in turn]

    def make(rng):
        file = cubes("opaque", count, 0.2, 5)(rng)
        file.animate(path, lambda: values(rng))
        return file
    return make


def skins(rng):
    """Sheets that follow joints that are strewn around, all in one place."""
    file, side, joints = Glb(), 20, 50
    points = [(x / side, 0.1 * math.sin(9 * x / side), y / side) for y in range(side + 1) for x in range(side + 1)]
    corners = [y * (side + 1) + x for y in range(side) for x in range(side)]
    triangles = [t for c in corners for t in ((c, c + 1, c + side + 2), (c, c + side + 2, c + side + 1))]
    mesh = file.mesh(points, triangles, attributes={
        "JOINTS_0": file.accessor([rng.randrange(joints) for _ in range(4 * len(points))], "H", "VEC4"),
        "WEIGHTS_0": file.accessor([0.25] * 4 * len(points), "f", "VEC4")})
    bones = [file.node(translation=anywhere(rng, 0.1)) for _ in range(joints)]
    file.add("skins", {"joints": bones})
    for _ in range(100):
        file.node(mesh=mesh, skin=0)
    return file


def polygons(count, corners, least):
    def make(rng):
        points, faces = [], []
        for i in range(count):
            faces.append(range(len(points), len(points) + corners))
            for k in range(corners):
                angle, away = 2 * math.pi * k / corners, rng.uniform(least, 1)
                points.append((away * math.cos(angle) + 2.1 * i, away * math.sin(angle), 0.1 * math.sin(5 * angle)))
        return Obj(points, faces)
    return make


def poles(count, faces, creased):
    """Bipyramids, of whose edges at the poles a share has a sharpness of its own."""
    def make(rng):
        points, triangles, creases = [], [], []
        for i in range(count):
            top = len(points)
            points += [(2.1 * i, 0, 1), (2.1 * i, 0, -1)]
            points += [(2.1 * i + math.cos(2 * math.pi * k / faces), math.sin(2 * math.pi * k / faces), 0) for k in range(faces)]
            for k in range(faces):
                a, b = top + 2 + k, top + 2 + (k + 1) % faces
                triangles += [(top, a, b), (top + 1, b, a)]
                if rng.random() < creased:
                    creases.append((top, a, rng.uniform(0.3, 9)))
        return Obj(points, triangles, creases)
    return make


def creased_grid(side):
    def make(rng):
        points = [(x, y, math.sin(20 * x) * math.sin(17 * y)) for y in range(side + 1) for x in range(side + 1)]
        corners = [y * (side + 1) + x for y in range(side) for x in range(side)]
        return Obj(points, [(c, c + 1, c + side + 2, c + side + 1) for c in corners],
                   [(c, c + rng.choice((1, side + 1)), rng.randrange(1, 40) / 4) for c in corners])
    return make


def planks(rng):
    points = []
    for _ in range(40_000):
        a, b = ([rng.uniform(-1, 1) for _ in range(3)] for _ in range(2))
        points += [a, b, [x + 0.0005 for x in b], [x + 0.0005 for x in a]]
    return Obj(points, [range(i, i + 4) for i in range(0, len(points), 4)])


SHUTTER = ["--time", "0.7", "--shutter", "-9,9"]
KINDS = {
    "instances": (instances, []), "instances-smooth": (instances, SMOOTH), "lamps": (lamps, []),
    "meshes": (separate_meshes, []), "meshes-smooth": (separate_meshes, SMOOTH),
    "skins": (skins, []), "skins-smooth": (skins, SMOOTH),
    "planks": (planks, []), "planks-smooth": (planks, SMOOTH),
    "creases-few": (creased_grid(60), SMOOTH), "creases-many": (creased_grid(200), SMOOTH)}
for name in MATERIALS:
    KINDS[f"soup-small-{name}"] = (soup_of(name, 200_000, 0.02), [])
    KINDS[f"soup-large-{name}"] = (soup_of(name, 60_000, 0.5), [])
    KINDS[f"cubes-{name}"] = (cubes(name, 20_000, 0.3, 9), [])
    KINDS[f"cubes-smooth-{name}"] = (cubes(name, 20_000, 0.3, 9), SMOOTH)
for path in ("translation", "rotation", "scale"):
    KINDS[f"swarm-{path}"] = (swarm(path, 8_000), SHUTTER)
    KINDS[f"swarm-smooth-{path}"] = (swarm(path, 8_000), SHUTTER + SMOOTH)
for count, corners in ((1, 100_000), (100, 2_000), (10_000, 20)):
    KINDS[f"polygons-{corners}"] = (polygons(count, corners, 0.2), [])
    KINDS[f"polygons-smooth-{corners}"] = (polygons(count, corners, 0.2), SMOOTH)
for count, faces in ((10, 10_000), (100, 1_000), (1_000, 100)):
    KINDS[f"poles-{faces}"] = (poles(count, faces, 0), SMOOTH)
    KINDS[f"poles-creased-{faces}"] = (poles(count, faces, 0.5), SMOOTH)


def holds(program, folder, kind, seed):
    """Renders a file of the kind, prints what that took, and returns whether it stayed within the limits."""
    make, options = KINDS[kind]
    made = make(random.Random(seed))
    path = folder / ("scene.glb" if isinstance(made, Glb) else "scene.obj")
    made.write(path)
    seconds = MOST_SECONDS + 10
    process = subprocess.Popen(
        [program, "render", path, "-o", folder / "picture.png", "--size", "64x48", "-q", *options], stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 2)))
    messages = process.stderr.read().strip().splitlines()
    _, status, used = os.wait4(process.pid, 0)
    spent = used.ru_utime + used.ru_stime
    is_held = not os.WIFSIGNALED(status) and spent <= MOST_SECONDS and used.ru_maxrss <= MOST_KILOBYTES
    print(f"{'' if is_held else 'TOO MUCH: '}{kind}: {path.stat().st_size / 1e6:.1f} MB, exit code {os.waitstatus_to_exitcode(status)}, "
          f"{spent:.1f} s, {used.ru_maxrss / 1e3:.0f} MB. {messages[-1][:120] if messages else ''}", flush=True)
    return is_held


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    pattern, seed = sys.argv[2] if len(sys.argv) > 2 else "*", int(sys.argv[3]) if len(sys.argv) > 3 else 1
    with tempfile.TemporaryDirectory() as folder:
        chosen = [kind for kind in KINDS if fnmatch.fnmatch(kind, pattern)]
        results = [holds(sys.argv[1], pathlib.Path(folder), kind, seed) for kind in chosen]
    print(f"{sum(results)} of {len(results)} kinds of files stayed within {MOST_SECONDS} s and {MOST_KILOBYTES // 1000} MB")
    sys.exit(0 if results and all(results) else 1)


if __name__ == "__main__":
    main()
