#!/usr/bin/env bash
# Builds and passes the tests: release with all of them, address and undefined-behaviour sanitizers on the unit and hostile
# tests, the one-lane build on the hash tests. --long adds debug, thread sanitizer, clang and the long campaigns.
set -euo pipefail
cd "$(dirname "$0")"
long=0
[ "${1:-}" = "--long" ] && long=1
./install-packages.sh

passed=0 failed=0 skipped=0
count() { grep -oE "^\[  $1 *\] [0-9]+ test" "$2" | grep -oE '[0-9]+' | awk '{n += $1} END {print n + 0}'; }
# run PRESET TARGETS NAME-PATTERN [VARIABLE=VALUE ...]: builds targets of a preset and runs its tests whose names match.
run() {
    local preset=$1 targets=$2 pattern=$3 log=build/$1.log status=0
    shift 3
    echo "== $preset: $pattern"
    cmake --preset "$preset" > "build/$preset.configure.log" 2>&1 || { cat "build/$preset.configure.log"; exit 1; }
    # shellcheck disable=SC2086  # several targets
    cmake --build --preset "$preset" --target $targets > "build/$preset.build.log" 2>&1 || { grep -E 'error|FAILED' "build/$preset.build.log" | head -n 40; exit 1; }
    env OCCAM_LONG=$long "$@" ctest --test-dir "build/$preset" -R "$pattern" -V -j2 > "$log" 2>&1 || status=1
    sed 's/^[0-9]*: //' "$log" > "$log.plain"
    local p f s scripts
    p=$(count PASSED "$log.plain") s=$(count SKIPPED "$log.plain") f=$(count FAILED "$log.plain")
    # Tests that are not GoogleTest's count one each.
    scripts=$(grep -cE '(room_order|install) \.+ +Passed' "$log" || true)
    [ $status -eq 1 ] && [ "$f" -eq 0 ] && f=1
    echo "   $((p + scripts)) passed, $f failed, $s skipped"
    grep -E '^\[  FAILED  \]|Skipped' -A 1 "$log.plain" | grep -vE '^--$' | sort -u | head -n 30 || true
    [ $status -eq 0 ] || grep -E 'Failure|ERROR|runtime error' -A 6 "$log.plain" | head -n 80 || true
    passed=$((passed + p + scripts)) failed=$((failed + f)) skipped=$((skipped + s))
}

mkdir -p build
run release all '.*' OCCAM_HASHES="$PWD/build/hashes.txt" OCCAM_HASHES_MODE=write
run one_lane occam_hash_tests 'occam_hash_tests' OCCAM_HASHES="$PWD/build/hashes.txt" OCCAM_HASHES_MODE=compare
run asan 'occam_unit_tests occam_hostile_tests' 'occam_(unit|hostile)_tests' ASAN_OPTIONS=detect_leaks=1
if [ $long -eq 1 ]; then
    run debug all 'occam_(unit|hostile|hash)_tests' OCCAM_HASHES="$PWD/build/hashes.txt" OCCAM_HASHES_MODE=compare
    run tsan 'occam_unit_tests occam_hash_tests' 'occam_(unit|hash)_tests' \
        TSAN_OPTIONS="ignore_noninstrumented_modules=1 suppressions=$PWD/tests/tsan.supp"
    run clang all '.*' OCCAM_HASHES="$PWD/build/hashes.txt" OCCAM_HASHES_MODE=compare
fi
echo "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]
