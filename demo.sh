#!/usr/bin/env bash
# Builds Occam and renders its built-in scene to demo.png and demo.exr.
set -euo pipefail
cd "$(dirname "$0")"
./install-packages.sh
cmake --preset demo > /dev/null
cmake --build --preset demo
./build/demo/occam render -o demo.exr --spp 16 --aov depth,normal,albedo --stats demo.json
./build/demo/occam render -o demo.png --spp 16
echo "demo.png and demo.exr are in $PWD; demo.json says where the time went."
