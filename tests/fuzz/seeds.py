#!/usr/bin/env python3
"""Writes seeds for the fuzz targets: seeds.py FOLDER [SHARED]. Each target gets a folder with a few tiny files of our own and, if the
shared test data is present, those of its files that are small enough to be mutated well."""
import base64
import json
import pathlib
import struct
import sys
import zlib

MOST_BYTES = 16384
FORMATS = {"gltf", "glb", "obj", "mtl", "ply", "off", "stl"}
IMAGES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".hdr", ".exr", ".webp"}

TRIANGLE = struct.pack("<9f3Hxx", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 2)


def png():
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes([y * 60, 255 - y * 60, 128, 255 - y * 20]) for y in range(4))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", 1, 4, 8, 6, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def tiled(width, height):
    """Returns a texture of grey texels as `occam texture` writes it, but without compression."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data

    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(c + b"\0" + struct.pack("<4i", 1, 0, 1, 1) for c in (b"A", b"B", b"G", b"R")) + b"\0"
    header = struct.pack("<2I", 20000630, 0x202) + b"".join(attribute(*a) for a in (
        (b"channels", b"chlist", channels), (b"compression", b"compression", b"\0"), (b"dataWindow", b"box2i", window),
        (b"displayWindow", b"box2i", window), (b"lineOrder", b"lineOrder", b"\0"), (b"occam_texture", b"string", b"1"),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1)), (b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1)), (b"tiles", b"tiledesc", struct.pack("<2IB", 64, 64, 1)))) + b"\0"
    tiles = []
    for level in range(max(width, height).bit_length()):
        wide, high = max(1, width >> level), max(1, height >> level)
        for y in range(0, high, 64):
            for x in range(0, wide, 64):
                texels = min(64, wide - x) * min(64, high - y)
                tiles.append(struct.pack("<5i", x // 64, y // 64, level, level, 8 * texels) + struct.pack("<H", 0x3800) * 4 * texels)
    at = len(header) + 8 * len(tiles)
    offsets = [at + sum(len(t) for t in tiles[:i]) for i in range(len(tiles))]
    return header + struct.pack(f"<{len(tiles)}Q", *offsets) + b"".join(tiles)


def gltf(buffer):
    """Returns a scene with a bit of everything that the importer reads."""
    data_uri = "data:image/png;base64," + base64.b64encode(png()).decode()
    views = [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}]
    position = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}
    sparse = {"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "extensionsUsed": ["KHR_texture_transform", "KHR_lights_punctual", "FB_ngon_encoding", "KHR_materials_clearcoat"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 0.5}}]}},
        "nodes": [{"mesh": 0, "scale": [-1, 1, 1], "children": [3], "skin": 0},
                  {"camera": 0, "rotation": [0, 0.6, 0, 0.8], "extensions": {"KHR_lights_punctual": {"light": 0}}},
                  {"mesh": 0, "extras": {"occam": {"scheme": "catmull-clark", "boundary": "edge-only"}}},
                  {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 1],
                   "extras": {"occam": {"area_light": {"shape": "disc", "size": [1, 1], "radiance": [1, 2, 3]}}}}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "skins": [{"joints": [3, 1]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                        "samplers": [{"input": 3, "output": 0, "interpolation": "LINEAR"}]}],
        "meshes": [{"weights": [0.5], "primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": 2}, "indices": 1, "material": 0, "targets": [{"POSITION": 2}],
             "extensions": {"FB_ngon_encoding": {}}}, {"attributes": {"POSITION": 2}, "mode": 5}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {
            "index": 0, "extensions": {"KHR_texture_transform": {"rotation": 1, "scale": [2, 2]}}}},
            "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}, "alphaMode": "MASK"}],
        "textures": [{"source": 0, "sampler": 0}], "images": [{"uri": data_uri}], "samplers": [{"wrapS": 33071}],
        "accessors": [position, {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
                      {"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse},
                      {"bufferView": 0, "componentType": 5126, "count": 3, "type": "SCALAR", "byteOffset": 4}],
        "bufferViews": views, "buffers": [dict(buffer, byteLength=44)]}).encode()


def glb(text, binary):
    """Returns the form that the target glb puts into a container."""
    return text + b"\0" + binary


def bmp(bits, compression, rows):
    """Returns a BMP of 2 x 2 pixels."""
    palette = bytes(range(4 << bits)) if bits <= 4 else bytes(k >> 2 for k in range(1024)) if bits == 8 else b""
    head = struct.pack("<IiiHHIIiiII", 40, 2, 2, 1, bits, compression, len(rows), 0, 0, 0, 0)
    return struct.pack("<2sIHHI", b"BM", 54 + len(palette) + len(rows), 0, 0, 54 + len(palette)) + head + palette + rows


def tga(kind, bits, data, palette=b""):
    """Returns a TGA of 2 x 2 pixels, with a palette of 24 bits an entry if there is one."""
    head = struct.pack("<BBBHHBHHHHBB", 0, palette != b"", kind, 0, len(palette) // 3, 24 if palette else 0, 0, 0, 2, 2, bits, 32)
    return head + palette + data


def dds(code, block):
    """Returns a DDS of 4 x 4 pixels in one block."""
    pixel = struct.pack("<II4s5I", 32, 4, code, 0, 0, 0, 0, 0)
    return b"DDS " + struct.pack("<7I", 124, 0x81007, 4, 4, len(block), 0, 0) + bytes(44) + pixel + struct.pack("<5I", 0x1000, 0, 0, 0, 0) + block


def small_images():
    yield "bmp24", bmp(24, 0, b"abcdef\0\0" * 2)
    yield "bmp16", bmp(16, 0, b"abcd" * 2)
    yield "bmp8", bmp(8, 0, b"ab\0\0" * 2)
    yield "bmp1", bmp(1, 0, b"\x80\0\0\0" * 2)
    yield "bmp_runs8", bmp(8, 1, b"\2a\0\0\0\3ab\0\0\0\1")
    yield "bmp_runs4", bmp(4, 2, b"\2\x12\0\0\2\x21\0\1")
    yield "bmp_oldest", struct.pack("<2sIHHIIHHHH", b"BM", 0, 0, 0, 26, 12, 2, 2, 1, 24) + b"abcdef\0\0" * 2
    yield "tga", tga(2, 24, b"abcdefabcdef")
    yield "tga_gray", tga(3, 8, b"abcd")
    yield "tga_runs", tga(10, 32, b"\x83abcd")
    yield "tga_palette", tga(1, 8, b"\0\1\1\0", b"abcdef")
    yield "tga_palette_runs", tga(9, 8, b"\x81\1\1\0\1", b"abcdef")
    yield "dds1", dds(b"DXT1", b"abcd\0\1\2\3")
    yield "dds5", dds(b"DXT5", b"ab012345abcd\0\1\2\3")
    yield "gif", b"GIF89a\1\0\1\0\x80\0\0\0\0\0\xff\xff\xff!\xf9\4\0\0\0\0\0,\0\0\0\0\1\0\1\0\0\2\2D\1\0;"
    yield "webp", b"RIFF\x1a\0\0\0WEBPVP8L\r\0\0\0/\0\0\0\x10\7\x10\x11\x11\x88\x88\xfe\7\0"
    for name, image in (("p1", b"P1 2 1 0 1"), ("p3", b"P3 1 1 9 1 2 3"), ("p4", b"P4 8 1\n\xaa"), ("p5", b"P5 2 1 65535\nabcd"),
                        ("p6", b"P6 2 1 255\nabcdef"), ("pf", b"PF 1 1 -1.0\nabcdefghijkl")):
        yield "pnm_" + name, image
    yield "hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\nabcdefgh"


def own_seeds():
    uri = "data:application/octet-stream;base64," + base64.b64encode(TRIANGLE).decode()
    text = gltf({})
    chunks = struct.pack("<I4s", len(text) + -len(text) % 4, b"JSON") + text + b" " * (-len(text) % 4)
    chunks += struct.pack("<I4s", len(TRIANGLE), b"BIN\0") + TRIANGLE
    ply = "ply\nformat %s 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n" \
          "property list uchar int vertex_indices\nend_header\n"
    corners = struct.unpack("<9f", TRIANGLE[:36])
    yield "gltf", "own", gltf({"uri": uri})
    yield "glb", "own_parts", glb(text, TRIANGLE)
    yield "glb", "own_whole", struct.pack("<4s2I", b"glTF", 2, 12 + len(chunks)) + chunks
    yield "obj", "own", (b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3/1 -1\ns 1\ng a\nf 1 2 3\n"
                         b"t crease 2/1/0 0 1 3.5\nt corner 1/1/0 2 10\nt hole 1/0/0 1\nt interpolateboundary 1/0/0 2\nl 1 2\n")
    yield "mtl", "own", (b"newmtl a\nKd 0.5 0.5 0.5\nKe 1 1 1\nNs 30\nd 0.5\nmap_Kd -s 2 2 2 -o 1 1 1 -clamp on a.png\n"
                         b"norm n.png\nmap_Pr r.png\nmap_Pm m.png\nmap_d d.png\nPr 0.5\nPm 0.5\nPc 1\nmap_Bump -bm 0.3 b.png\n")
    yield "ply", "ascii", (ply % "ascii").encode() + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    for order, name in (("<", "binary_little_endian"), (">", "binary_big_endian")):
        yield "ply", name, (ply % name).encode() + struct.pack(order + "9fB3i", *corners, 3, 0, 1, 2)
    yield "off", "own", b"STCNOFF\n3 1 0\n" + b"0 0 0 0 0 1 1 0 0 1 0.5 0.5\n" * 3 + b"3 0 1 2 255 0 0\n"
    yield "stl", "ascii", b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n"
    yield "stl", "binary", b"\0" * 80 + struct.pack("<I12fH", 1, 0, 0, 1, *corners, 0)
    yield "texture", "png", png()
    yield "tiled", "small", tiled(3, 2)
    yield "tiled", "two_tiles", tiled(66, 5)
    for name, image in small_images():
        yield "texture", name, image


def parts(path):
    """Returns a glTF whose only buffer is a file beside it, as JSON and binary chunk, or None for any other glTF."""
    try:
        scene = json.loads(path.read_bytes())
        uri = scene["buffers"][0].pop("uri")
        binary = (path.parent / uri).read_bytes()
        return glb(json.dumps(scene).encode(), binary) if len(scene["buffers"]) == 1 else None
    except (ValueError, KeyError, TypeError, IndexError, OSError):
        return None


def shared_seeds(shared):
    for path in sorted(p for p in (shared / "data").rglob("*") if p.is_file() and p.stat().st_size <= MOST_BYTES):
        kind = path.suffix.lower()[1:]
        if kind in FORMATS:
            yield kind, path.name, path.read_bytes()
        if kind == "gltf" and "hostile" not in path.parts:
            whole = parts(path)
            if whole and len(whole) <= MOST_BYTES:
                yield "glb", path.name, whole
        if path.suffix.lower() in IMAGES:
            yield "texture", path.name, path.read_bytes()


def main():
    folder = pathlib.Path(sys.argv[1])
    shared = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    seeds = list(own_seeds()) + (list(shared_seeds(shared)) if shared and (shared / "data").is_dir() else [])
    for number, (target, name, data) in enumerate(seeds):
        (folder / target).mkdir(parents=True, exist_ok=True)
        (folder / target / f"{number:04}_{name}").write_bytes(data)


main()
