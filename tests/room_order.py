"""Holds the order of the rooms: a file includes its own room and those below it, never one above (README.md, Rooms)."""
import pathlib
import re
import sys

# Lowest first; a room may include what stands before it, less what FORBIDDEN says.
ROOMS = ["base", "scenegraph", "io", "lod", "accel", "shade", "render", "verify", "api", "command"]
FORBIDDEN = {("shade", "accel"), ("verify", "shade"), ("verify", "render")}
MAY_USE = {
    room: {below for below in ROOMS[:place] if (room, below) not in FORBIDDEN}
    for place, room in enumerate(ROOMS)
}


def main() -> int:
    root = pathlib.Path(sys.argv[1])
    faults, includes = [], 0
    for room, below in MAY_USE.items():
        for path in sorted((root / room).rglob("*")):
            if path.suffix not in {".h", ".cpp"}:
                continue
            for number, line in enumerate(path.read_text().splitlines(), 1):
                found = re.match(r'\s*#\s*include\s*"(\w+)/', line)
                if not found or found.group(1) not in MAY_USE:
                    continue
                includes += 1
                if found.group(1) != room and found.group(1) not in below:
                    faults.append(f"{path.relative_to(root)}:{number}: {room} may not include {found.group(1)}")
    print("\n".join(faults))
    print(f"{includes} includes between rooms, {len(faults)} against the order")
    return 1 if faults or includes == 0 else 0


sys.exit(main())
