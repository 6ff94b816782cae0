#!/usr/bin/env bash
# Runs each fuzz target for a given time: tests/fuzz/run.sh SECONDS [TARGET ...], after cmake --build --preset fuzz. As many run at
# once as there are processors. Findings are in build/fuzz/findings; a target replays a file that is its only argument.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:?usage: tests/fuzz/run.sh SECONDS [TARGET ...]}
shift
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(gltf glb obj mtl ply off stl texture tiled)
build=build/fuzz
mkdir -p $build/findings
shared=${OCCAM_SHARED:-../shared}
rm -rf $build/seeds
if [ -d "$shared/data" ]; then python3 tests/fuzz/seeds.py $build/seeds "$shared"; else python3 tests/fuzz/seeds.py $build/seeds; fi

# A hostile file may take up to a gibibyte. Freed blocks that the sanitizer keeps in quarantine count as well, so it keeps few.
fuzz() {
    local target=$1 build=build/fuzz status=0
    mkdir -p "$build/corpus/$target"
    ASAN_OPTIONS=quarantine_size_mb=16 "$build/tests/fuzz/occam_fuzz_$target" -max_total_time="$2" -rss_limit_mb=1024 \
        -timeout=20 -max_len=65536 -print_final_stats=1 -artifact_prefix="$build/findings/$target-" \
        "$build/corpus/$target" "$build/seeds/$target" > "$build/$target.log" 2>&1 || status=$?
    local runs
    runs=$(sed -n 's/^stat::number_of_executed_units: //p' "$build/$target.log")
    if [ $status -eq 0 ]; then
        echo "[  PASSED  ] 1 test: $target, ${runs:-?} inputs in $2 s"
    else
        grep -E 'ERROR:|runtime error:|SUMMARY|Test unit written' "$build/$target.log" | head -n 5
        echo "[  FAILED  ] 1 test: $target, all of it: $build/$target.log"
        return 1
    fi
}
export -f fuzz
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} bash -c "fuzz {} $seconds"
