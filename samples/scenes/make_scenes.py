#!/usr/bin/env python3
"""Makes the two small scenes that the README's examples use.

    python3 samples/scenes/make_scenes.py            writes them beside this file
    python3 samples/scenes/make_scenes.py --check    exit code 1 if the files differ from what would be written

fish.glb   a skinned mesh with vertex colours that faces +z, and the clip "Swim" of one second
vase.obj   a Catmull-Clark cage with infinitely sharp edges at the foot and semi-sharp edges at the rim, and vase.mtl
"""
import json
import math
import pathlib
import struct
import sys

FOLDER = pathlib.Path(__file__).parent

RINGS, AROUND, JOINTS = 25, 12, 4
LENGTH = 2.4  # from the tip of the tail at z = -1.4 to the mouth at z = 1


def rounded(x):
    """Rounds to four decimals, in which every C library gives the same result."""
    return round(x, 4) + 0.0


def profile(t):
    """Returns half the width and half the height of the fish at t, from the tail (0) to the mouth (1)."""
    body = max(0.0, math.sin(math.pi * min(1.0, max(0.0, (t - 0.16) / 0.84)) ** 0.8)) ** 0.75
    fin = max(0.0, 1 - t / 0.24) ** 0.7
    return 0.015 + 0.2 * body, 0.05 + 0.4 * body + 0.36 * fin


def color(t, up):
    white = any(abs(t - band) < width for band, width in ((0.36, 0.05), (0.62, 0.06), (0.84, 0.04)))
    if white:
        return 235, 235, 225, 255
    if t > 0.95 or t < 0.12:
        return 70, 35, 20, 255
    return (240, 105, 25, 255) if up > -0.5 else (250, 170, 90, 255)


def fish():
    points, normals, colors, joints, weights = [], [], [], [], []
    for ring in range(RINGS):
        t = ring / (RINGS - 1)
        width, height = profile(t)
        at = (1 - t) * (JOINTS - 1)  # joint 0 is at the head
        joint = min(int(at), JOINTS - 2)
        share = round(255 * (at - joint))
        for k in range(AROUND):
            c, s = math.cos(2 * math.pi * k / AROUND), math.sin(2 * math.pi * k / AROUND)
            points.append((rounded(width * c), rounded(height * s), rounded(LENGTH * (t - 1) + 1)))
            n = (c / width, s / height)
            length = math.hypot(*n)
            normals.append((rounded(n[0] / length), rounded(n[1] / length), 0.0))
            colors.append(color(t, s))
            joints.append((joint, joint + 1, 0, 0))
            weights.append((255 - share, share, 0, 0))
    triangles = []
    for ring in range(RINGS - 1):
        for k in range(AROUND):
            a, b = ring * AROUND + k, ring * AROUND + (k + 1) % AROUND
            triangles += [a, b, b + AROUND, a, b + AROUND, a + AROUND]
    for k in range(1, AROUND - 1):  # the tail and the mouth are closed
        last = (RINGS - 1) * AROUND
        triangles += [0, k + 1, k, last, last + k, last + k + 1]

    step = LENGTH / (JOINTS - 1)
    inverse_binds = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, rounded(step * j - 1), 1] for j in range(JOINTS)]
    times = [rounded(key / 8) for key in range(9)]
    turns = []
    for j in range(JOINTS):
        keys = []
        for key in range(9):
            half = 0.5 * (0.1 + 0.12 * j) * math.sin(2 * math.pi * (key / 8 - 0.2 * j))
            keys.append((0.0, rounded(math.sin(half)), 0.0, rounded(math.cos(half))))
        turns.append(keys)

    binary, views, accessors = b"", [], []

    def add(rows, code, component, kind, **more):
        nonlocal binary
        data = b"".join(struct.pack("<" + code * len(row), *row) for row in rows)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(rows), "type": kind, **more})
        binary += data + b"\0" * (-len(data) % 4)
        return len(accessors) - 1

    low = [min(p[i] for p in points) for i in range(3)]
    high = [max(p[i] for p in points) for i in range(3)]
    attributes = {
        "POSITION": add(points, "f", 5126, "VEC3", min=low, max=high),
        "NORMAL": add(normals, "f", 5126, "VEC3"),
        "COLOR_0": add(colors, "B", 5121, "VEC4", normalized=True),
        "JOINTS_0": add(joints, "B", 5121, "VEC4"),
        "WEIGHTS_0": add(weights, "B", 5121, "VEC4", normalized=True),
    }
    indices = add([(v,) for v in triangles], "H", 5123, "SCALAR")
    binds = add(inverse_binds, "f", 5126, "MAT4")
    clock = add([(t,) for t in times], "f", 5126, "SCALAR", min=[times[0]], max=[times[-1]])
    samplers = [{"input": clock, "output": add(keys, "f", 5126, "VEC4"), "interpolation": "LINEAR"} for keys in turns]

    nodes = [{"name": "fish", "mesh": 0, "skin": 0}]
    for j in range(JOINTS):
        node = {"name": f"joint {j}", "translation": [0, 0, 1 if j == 0 else -rounded(step)]}
        if j + 1 < JOINTS:
            node["children"] = [j + 2]
        nodes.append(node)
    scene = {
        "asset": {"version": "2.0", "generator": "make_scenes.py"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": nodes,
        "meshes": [{"name": "fish", "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "materials": [{"name": "scales", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.35}}],
        "skins": [{"joints": [1 + j for j in range(JOINTS)], "inverseBindMatrices": binds}],
        "animations": [
            {
                "name": "Swim",
                "channels": [{"sampler": j, "target": {"node": 1 + j, "path": "rotation"}} for j in range(JOINTS)],
                "samplers": samplers,
            }
        ],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(scene, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def vase():
    around = 8
    # The rings have a radius and a height, from the foot up the outside and down the inside.
    rings = [(0.62, 0), (0.55, 0.12), (0.98, 0.62), (0.9, 1.25), (0.42, 1.62), (0.66, 2.0),
             (0.58, 2.0), (0.34, 1.62), (0.8, 1.2), (0.86, 0.64), (0.45, 0.2)]
    lines = ["# Made by make_scenes.py.", "mtllib vase.mtl", "o vase"]
    for radius, height in rings:
        for k in range(around):
            angle = 2 * math.pi * k / around
            lines.append(f"v {rounded(radius * math.cos(angle)):g} {height:g} {rounded(-radius * math.sin(angle)):g}")
    lines.append("usemtl celadon")
    for ring in range(len(rings) - 1):
        for k in range(around):
            a, b = 1 + ring * around + k, 1 + ring * around + (k + 1) % around
            lines.append(f"f {a} {b} {b + around} {a + around}")
    lines.append("f " + " ".join(str(around - k) for k in range(around)))
    lines.append("f " + " ".join(str((len(rings) - 1) * around + k + 1) for k in range(around)))
    # A tag holds two vertices, counted from 0, and the sharpness of the edge between them, where 10 is infinitely sharp.
    for ring, sharpness in ((0, 10), (5, 2), (6, 2)):
        for k in range(around):
            lines.append(f"t crease 2/1/0 {ring * around + k} {ring * around + (k + 1) % around} {sharpness:g}")
    return ("\n".join(lines) + "\n").encode()


MATERIAL = b"# Made by make_scenes.py.\nnewmtl celadon\nKd 0.16 0.4 0.33\nPr 0.25\n"


def main():
    different = []
    for name, content in {"fish.glb": fish(), "vase.obj": vase(), "vase.mtl": MATERIAL}.items():
        path = FOLDER / name
        if sys.argv[1:] == ["--check"]:
            if not path.is_file() or path.read_bytes() != content:
                different.append(name)
        else:
            path.write_bytes(content)
    for name in different:
        print(f"{name} is not what make_scenes.py writes")
    return 1 if different else 0


sys.exit(main())
