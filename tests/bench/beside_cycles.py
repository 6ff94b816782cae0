"""Renders whole frames by Occam and by Blender's Cycles, and compares their time at equal error.

    beside_cycles.py OCCAM [FILE.obj ...] [--only NAME] [--size 480x270] [--samples 64] [--threads 2] [--keep FOLDER]

Both programs path-trace the same triangles under a sky of an even radiance of 1, with six bounces, without clamping,
or denoising, and without adaptive sampling unless --end-early is given, through the same pinhole and a box filter of one pixel. Without files, four scenes are made: a
furnished room whose ceiling is open, a level of eight such rooms, and a crowd of 64 cages in direct light, once at rest and
once blurred by their own deformation (crowd_scene.py; Cycles divides each cage --levels times). --only chooses one of them
(room, level, crowd, blurred). A file is seen as --look-at says.

Each program is measured against a reference of its own (--reference times the samples), by the relative RMSE of linear
radiance. Occam then renders with the fewest samples whose error is at most that of Cycles with --samples, as far as four
trials find them. Times are of whole processes, from the
start of the program to the finished file: by the clock, and CPU seconds of all threads, which a shared machine disturbs less.
Memory is the largest resident set.

With --end-early both programs end the pixels whose estimated error is small (adaptive sampling), after 4 samples or more. How
many they may take at most, and below which error they end, is tried in a few pairs for each program; the fastest of
Occam's is then named for each of Cycles', among those with no more error.

Blender 3.4 of Debian 12 (the package `blender`) has to be installed.
"""
import argparse
import json
import math
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

import crowd_scene

IN_BLENDER = """
import bpy, json, mathutils, sys
job = json.loads(sys.argv[sys.argv.index("--") + 1])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=job["scene"], forward_axis="NEGATIVE_Z", up_axis="Y")
for material in bpy.data.materials:
    nodes, links = material.node_tree.nodes, material.node_tree.links
    color = tuple(nodes["Principled BSDF"].inputs["Base Color"].default_value)
    nodes.clear()
    diffuse, out = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = color
    links.new(diffuse.outputs[0], out.inputs["Surface"])
scene = bpy.context.scene
def world_of(p):
    return mathutils.Vector((p[0], -p[2], p[1]))
camera = bpy.data.cameras.new("camera")
camera.sensor_fit, camera.angle, camera.clip_start = "VERTICAL", job["fov"], 1e-3
placed = bpy.data.objects.new("camera", camera)
eye, target = world_of(job["eye"]), world_of(job["target"])
placed.location, placed.rotation_euler = eye, (target - eye).to_track_quat("-Z", "Y").to_euler()
scene.collection.objects.link(placed)
scene.camera, scene.world = placed, bpy.data.worlds.new("sky")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
render, cycles = scene.render, scene.cycles
render.engine, cycles.device = "CYCLES", "CPU"
cycles.samples, cycles.seed, cycles.use_denoising = job["samples"], job["seed"], False
cycles.use_adaptive_sampling = job["end_below"] > 0
if cycles.use_adaptive_sampling:
    cycles.adaptive_threshold, cycles.adaptive_min_samples = job["end_below"], job["min_samples"]
cycles.max_bounces = cycles.diffuse_bounces = 6
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
render.threads_mode, render.threads = "FIXED", job["threads"]
render.resolution_x, render.resolution_y, render.resolution_percentage = job["width"], job["height"], 100
render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
render.image_settings.color_mode, render.filepath = "RGB", job["picture"]
bpy.ops.render.render(write_still=True)
"""

# Writes a sky of 8 x 4 texels of radiance 1 to the file that is the last argument.
SKY_IN_BLENDER = """
import bpy, sys
sky = bpy.data.images.new("sky", 8, 4, float_buffer=True)
sky.pixels = [1.0] * (8 * 4 * 4)
sky.file_format, sky.filepath_raw = "OPEN_EXR", sys.argv[-1]
sky.save()
"""


class Room:
    """Writes furnished rooms as an OBJ of triangles with three grey and coloured materials."""

    def __init__(self, path: pathlib.Path, rooms: int):
        self.out, self.vertices, self.random = [], 0, random.Random(1)
        materials = {"wall": "0.7 0.7 0.7", "red": "0.6 0.2 0.15", "blue": "0.2 0.3 0.6"}
        text = "".join(f"newmtl {name}\nKd {color}\nKs 0 0 0\nillum 1\n" for name, color in materials.items())
        path.with_suffix(".mtl").write_text(text)
        self.out += [f"mtllib {path.stem}.mtl", "s off"]
        for x in range(rooms):
            self.furnish(6.0 * x)
        path.write_text("\n".join(self.out) + "\n")

    def add(self, points: list, faces: list) -> None:
        self.out += ["v %.5f %.5f %.5f" % p for p in points]
        self.out += ["f " + " ".join(str(self.vertices + 1 + i) for i in face) for face in faces]
        self.vertices += len(points)

    def box(self, lo: tuple, hi: tuple) -> None:
        points = [((lo, hi)[i & 1][0], (lo, hi)[i >> 1 & 1][1], (lo, hi)[i >> 2][2]) for i in range(8)]
        quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
        self.add(points, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])

    def ball(self, centre: tuple, radius: float, rows: int, columns: int) -> None:
        points = []
        for r in range(rows + 1):
            ring, height = radius * math.sin(math.pi * r / rows), radius * math.cos(math.pi * r / rows)
            for c in range(columns):
                angle = 2 * math.pi * c / columns
                points.append((centre[0] + ring * math.cos(angle), centre[1] + height, centre[2] + ring * math.sin(angle)))
        faces = []
        for r in range(rows):
            for c in range(columns):
                a, b = r * columns + c, r * columns + (c + 1) % columns
                faces += [(a, b, b + columns)] * (r > 0) + [(a, b + columns, a + columns)] * (r < rows - 1)
        self.add(points, faces)

    def furnish(self, x: float) -> None:
        self.out.append("usemtl wall")
        self.box((x, -0.1, 0), (x + 5.9, 0, 6))
        for lo, hi in (((x, 0, -0.1), (x + 5.9, 3, 0)), ((x, 0, 6), (x + 5.9, 3, 6.1)), ((x - 0.1, 0, 0), (x, 3, 2)),
                       ((x - 0.1, 0, 4), (x, 3, 6)), ((x, 2.9, 0), (x + 5.9, 3, 4))):
            self.box(lo, hi)
        for i in range(14):
            self.out.append("usemtl " + ("red", "blue")[i % 2])
            px, pz = x + self.random.uniform(0.6, 5.2), self.random.uniform(0.6, 5.2)
            if i % 3 == 0:
                self.box((px - 0.3, 0, pz - 0.3), (px + 0.3, self.random.uniform(0.4, 1.4), pz + 0.3))
            else:
                size = self.random.uniform(0.2, 0.45)
                self.ball((px, size, pz), size, 20, 21)


MIN_SAMPLES = 4  # of --end-early


class Cost:
    """Says what a process took: seconds by the clock and of CPU, and its largest resident set in megabytes."""

    def __init__(self, command: list):
        start = time.monotonic()
        with tempfile.TemporaryFile("w+") as output:
            process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            self.seconds = time.monotonic() - start
            self.cpu, self.megabytes = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
            if process.returncode != 0:
                output.seek(0)
                sys.exit(f"{command[0]} failed:\n{output.read()}")

    def __str__(self) -> str:
        return f"{self.seconds:.2f} s, CPU {self.cpu:.2f} s, {self.megabytes:.0f} MB"


def run_in_blender(script: str, argument: str, folder: pathlib.Path) -> Cost:
    file = folder / "job.py"
    file.write_text(script)
    return Cost(["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "-P", str(file), "--",
                  argument])


class Frame:
    """Renders one scene by either program."""

    def __init__(self, given: argparse.Namespace, folder: pathlib.Path, scene: pathlib.Path, view: list):
        self.given, self.folder, self.scene, self.view = given, folder, scene, view
        self.width, self.height = (int(n) for n in given.size.split("x"))
        self.name, self.fov_deg = scene.stem, 60

    def picture(self, who: str, samples: int, seed: int, end_below: float = 0) -> pathlib.Path:
        return self.folder / f"{self.name}.{who}.{samples}.{seed}.{end_below}.exr"

    def job(self, samples: int, seed: int, end_below: float) -> dict:
        return {"end_below": end_below, "min_samples": MIN_SAMPLES, "scene": str(self.scene), "eye": self.view[:3], "target": self.view[3:], "fov": math.radians(self.fov_deg),
                "samples": samples, "seed": seed, "threads": self.given.threads, "width": self.width, "height": self.height,
                "picture": str(self.picture("cycles", samples, seed, end_below))}

    def cycles(self, samples: int, seed: int, end_below: float = 0) -> Cost:
        return run_in_blender(IN_BLENDER, json.dumps(self.job(samples, seed, end_below)), self.folder)

    def light(self) -> list:
        sky = self.folder / "sky.exr"
        if not sky.exists():
            run_in_blender(SKY_IN_BLENDER, str(sky), self.folder)
        return ["--environment", str(sky), "--integrator", "path", "--bounces", "6"]

    def occam(self, samples: int, seed: int, end_below: float = 0) -> Cost:
        light, picture = self.light(), str(self.picture("occam", samples, seed, end_below))
        if end_below > 0:
            light += ["--error", str(end_below), "--min-spp", str(MIN_SAMPLES)]
        return Cost([self.given.occam, "render", str(self.scene), "-o", picture, "-q",
                     "--look-at=" + ",".join(map(str, self.view)), "--fov", str(self.fov_deg), "--size", self.given.size,
                     "--exr", "float", *light, "--clamp", "0", "--spp", str(samples), "--seed", str(seed), "--threads",
                     str(self.given.threads)])

    def error(self, a: pathlib.Path, b: pathlib.Path) -> float:
        command = [self.given.occam, "compare", str(a), str(b), "--json"]
        ran = subprocess.run(command, capture_output=True, text=True, check=True)
        return math.sqrt(next(layer["rel_mse"] for layer in json.loads(ran.stdout) if layer["layer"] == "beauty"))


class CrowdFrame(Frame):
    """Renders the crowd: at rest, or while it twists and the shutter is open for a whole frame."""

    def __init__(self, given: argparse.Namespace, folder: pathlib.Path, is_blurred: bool):
        super().__init__(given, folder, crowd_scene.write(folder), [*crowd_scene.EYE, *crowd_scene.TARGET])
        self.is_blurred, self.fov_deg = is_blurred, crowd_scene.FOV_DEG
        self.name = "blurred" if is_blurred else "crowd"

    def cycles(self, samples: int, seed: int, end_below: float = 0) -> Cost:
        job = self.job(samples, seed, end_below)
        job.update(scene=str(self.scene.with_suffix(".json")), blur=self.is_blurred, levels=self.given.levels)
        return run_in_blender(crowd_scene.IN_BLENDER, json.dumps(job), self.folder)

    def light(self) -> list:
        shutter = "0,1" if self.is_blurred else "0,0"
        return ["--environment", "none", "--integrator", "direct", "--clip", "twist", "--time", "0", "--fps", "1", "--shutter",
                shutter]


def compare(frame: Frame, samples: int, reference: int) -> None:
    def picture(who: str, count: int, seed: int) -> pathlib.Path:
        return frame.picture(who, count, seed)

    def error_of(who: str, count: int, seed: int) -> float:
        return frame.error(picture(who, count, seed), picture(who, reference * samples, 7))

    for program in (frame.occam, frame.cycles):
        program(reference * samples, 7)
    cycles, wanted = frame.cycles(samples, 1), error_of("cycles", samples, 1)
    frame.occam(samples, 1)
    enough = max(1, round(samples * (error_of("occam", samples, 1) / wanted) ** 2))
    for _ in range(4):
        occam, reached = frame.occam(enough, 2), error_of("occam", enough, 2)
        if reached <= wanted:
            break
        enough = max(enough + 1, round(enough * reached / wanted))
    apart = frame.error(picture("occam", reference * samples, 7),
                        picture("cycles", reference * samples, 7))
    print(f"{frame.name}: Cycles, {samples} samples: {cycles}, error {wanted:.4f}; Occam, {enough} samples: {occam}, error "
          f"{reached:.4f}; times as fast: {cycles.seconds / occam.seconds:.2f}, by CPU {cycles.cpu / occam.cpu:.2f}; "
          f"references differ by {apart:.4f}", flush=True)


def compare_early_ends(frame: Frame, samples: int, reference: int) -> None:
    for program in (frame.occam, frame.cycles):
        program(reference * samples, 7)

    def trials(who: str, program, limits: tuple) -> list:
        made = []
        for count in (samples // 2, samples, 2 * samples, 4 * samples):
            for end_below in limits:
                cost = program(count, 1, end_below)
                error = frame.error(frame.picture(who, count, 1, end_below), frame.picture(who, reference * samples, 7))
                print(f"{frame.name}: {who}, at most {count} samples, ends below {end_below}: {cost}, error {error:.4f}", flush=True)
                made.append((cost, error))
        return made

    ours = trials("occam", frame.occam, (0, 0.2, 0.1, 0.05))
    for cost, error in trials("cycles", frame.cycles, (0, 0.1, 0.03, 0.01)):
        enough = [cost for cost, reached in ours if reached <= error]
        if enough:
            best = min(enough, key=lambda cost: cost.cpu)
            print(f"{frame.name}: at Cycles' error of {error:.4f} Occam is {cost.seconds / best.seconds:.2f} times as fast, "
                  f"by CPU {cost.cpu / best.cpu:.2f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("occam")
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    parser.add_argument("--look-at", default="")
    parser.add_argument("--size", default="480x270")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--reference", type=int, default=32)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--levels", type=int, default=3)
    parser.add_argument("--only", choices=["room", "level", "crowd", "blurred"])
    parser.add_argument("--end-early", action="store_true")
    parser.add_argument("--keep", type=pathlib.Path)
    given = parser.parse_args()
    if not shutil.which("blender"):
        sys.exit("Blender is not installed, so there is nothing to compare with.")
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.keep or pathlib.Path(temporary)
        os.makedirs(folder, exist_ok=True)
        if given.files:
            view = [float(x) for x in given.look_at.split(",")]
            frames = [Frame(given, folder, file.resolve(), view) for file in given.files]
        else:
            Room(folder / "room.obj", 1)
            Room(folder / "level.obj", 8)
            frames = [Frame(given, folder, folder / "room.obj", [5.4, 1.7, 5.5, 2, 0.7, 2]),
                      Frame(given, folder, folder / "level.obj", [0.4, 1.7, 3.6, 12, 0.9, 2.8]),
                      CrowdFrame(given, folder, False), CrowdFrame(given, folder, True)]
        for frame in frames:
            if given.only in (None, frame.name):
                (compare_early_ends if given.end_early else compare)(frame, given.samples, given.reference)


main()
