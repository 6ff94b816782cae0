#!/usr/bin/env bash
# Builds and runs the tests in the preset test. --ci adds what continuous integration does: the hash tests in a build of one SIMD
# lane, and the library and the command in the preset release. --sanitize adds these, and the address and undefined-behaviour
# sanitizers on the unit and hostile tests, in a debug build. --long adds all of this, the long campaigns in the preset test, the
# thread sanitizer, clang, all that the preset release builds, and the fuzz targets. It takes more than two hours on two processors.
set -euo pipefail
cd "$(dirname "$0")"
long=0 ci=0 sanitize=0
case "${1:-}" in
    "") ;;
    --ci) ci=1 ;;
    --sanitize) ci=1 sanitize=1 ;;
    --long) ci=1 long=1 sanitize=1 ;;
    *) echo "usage: ./test.sh [--ci | --sanitize | --long]" >&2; exit 2 ;;
esac
if [ $long -eq 1 ]; then ./install-packages.sh --long; else ./install-packages.sh; fi

passed=0 failed=0 skipped=0
# Prints the sum of the summary lines that GoogleTest prints for PASSED, FAILED or SKIPPED.
count() { sed -nE "s/^\[  $1 *\] ([0-9]+) tests?.*/\1/p" "$2" | awk '{n += $1} END {print n + 0}'; }

# build PRESET TARGET ...: builds targets of a preset, and ends with what went wrong if that fails.
build() {
    local preset=$1 log=build/$1.build.log
    shift
    { cmake --preset "$preset" && cmake --build --preset "$preset" --target "$@"; } > "$log" 2>&1 || {
        grep -E '[Ee]rror|FAILED' -A 3 "$log" | head -n 60
        exit 1
    }
}

# run PRESET SUITES [VARIABLE=VALUE ...]: builds a preset and runs its suites (folders of tests/, separated by |), or "all".
run() {
    local preset=$1 suites=$2 status=0 pattern='.*' targets=(all)
    shift 2
    if [ "$suites" != all ]; then
        pattern="^occam_($suites)_tests"
        mapfile -t targets < <(tr '|' '\n' <<< "$suites" | sed 's/.*/occam_&_tests/')
    fi
    local folder=build/$preset log=build/$preset.log
    local began=$SECONDS built
    echo "== $preset: $suites"
    build "$preset" "${targets[@]}"
    built=$SECONDS
    # Some tests wait more than they compute, so there are two more than there are processors.
    env "$@" ctest --test-dir "$folder" -R "$pattern" -j "$(($(nproc) + 2))" --no-tests=error --timeout 7200 > "$folder.ctest.log" 2>&1 ||
        status=1
    cp "$folder/Testing/Temporary/LastTest.log" "$log"

    local p f s
    # Each test that does not use GoogleTest counts as one.
    p=$(($(count PASSED "$log") + $(grep -cE '(style|install) \.+ +Passed' "$folder.ctest.log" || true)))
    s=$(count SKIPPED "$log")
    f=$(($(count FAILED "$log") + $(grep -cE "(style|install) \.+\*\*\*" "$folder.ctest.log" || true)))
    # A program that ended without a summary line has failed too.
    [ $status -eq 0 ] || [ "$f" -gt 0 ] || f=1
    grep -E ': Skipped$' -A 1 "$log" | grep -vE ': Skipped$|^--$' | sort | uniq -c | sed -E 's/^ *([0-9]+) /   \1 skipped: /' || true
    if [ $status -ne 0 ]; then
        grep -E '\*\*\*' "$folder.ctest.log" || true
        grep -E ': Failure$|ERROR: |runtime error:|WARNING: ThreadSanitizer|^CMake Error|^\[  FAILED  \] .*[^)]$' -A 8 "$log" | head -n 150 || true
        echo "   all of it: $log"
    fi
    echo "   $p passed, $f failed, $s skipped; $((built - began)) s to build, $((SECONDS - built)) s to run"
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
}

# build_release TARGET ...: builds targets in the preset release. It compiles each file by itself, and so finds what a file does not
# include, and what the compiler warns of there alone.
build_release() {
    echo "== release: $*"
    build release "$@"
}

# Fuzzes each importer for so many seconds (tests/fuzz): the targets of the preset fuzz print lines like GoogleTest's.
fuzz() {
    local log=build/fuzz.log
    echo "== fuzz: $1 s for each target"
    build fuzz all
    tests/fuzz/run.sh "$1" > "$log" || true
    sed 's/^/   /' "$log"
    passed=$((passed + $(count PASSED "$log"))) failed=$((failed + $(count FAILED "$log")))
}

mkdir -p build
hashes=OCCAM_HASHES=$PWD/build/hashes.txt
rm -f build/hashes.txt
run test all "$hashes" OCCAM_HASHES_MODE=write OCCAM_LONG=$long
if [ $ci -eq 1 ]; then
    run one_lane hash "$hashes" OCCAM_HASHES_MODE=compare OCCAM_LONG=$long
    if [ $long -eq 1 ]; then build_release all; else build_release occam occam_cli; fi
fi
if [ $sanitize -eq 1 ]; then run asan 'unit|hostile'; fi
if [ $long -eq 1 ]; then
    # The thread sanitizer runs the tests in which threads meet.
    run tsan 'unit|hash|campaign' TSAN_OPTIONS=ignore_noninstrumented_modules=1 \
        GTEST_FILTER='Api.*:FramesOfThreads.*:Threads.*:*Shared*:*Quer*:Picture.*:Random*:Load.*:Progressive.*:Resume.*:Deadline.*:Cancel*:Workers.*:TextureStore.*:TiledTextures.*:Adaptive*:Memory.*:OnDemand*:Changing*:Trees.*:MovingTracer.*:Path.*:Holes.*'
    run clang all "$hashes" OCCAM_HASHES_MODE=compare
    fuzz 150
fi
echo "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]
