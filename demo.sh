#!/usr/bin/env bash
# Builds Occam and renders its built-in scene to demo.png and demo.exr.
set -euo pipefail
cd "$(dirname "$0")"
./install-packages.sh
echo "Building (a few minutes the first time)"
mkdir -p build
{ cmake --preset demo && cmake --build --preset demo; } > build/demo.log 2>&1 || { tail -n 40 build/demo.log; exit 1; }
began=$SECONDS
build/demo/occam render -o demo.png --size 720x405
echo "$PWD/demo.png: $((SECONDS - began)) s (the default size is 1280x720, which takes three times as long)"
began=$SECONDS
build/demo/occam render -o demo.exr --size 640x360 --aov depth,normal,albedo --stats demo.json
echo "$PWD/demo.exr: $((SECONDS - began)) s, with layers for depth, normal and base colour; demo.json says where the time went"
