#!/usr/bin/env bash
# Runs fuzz targets, SECONDS (60) each, all of them unless some are named, from the seeds in fuzz/seeds/:
#
#   scripts/fuzz.sh [SECONDS] [TARGET...]
#
# Needs a nightly toolchain and cargo-fuzz (`cargo install cargo-fuzz`). New inputs that reach new code are kept in
# fuzz/corpus/TARGET/ and are where the next run begins. Exit code 1 if there is a finding.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=60
if [[ ${1:-} =~ ^[0-9]+$ ]]; then
    seconds=$1
    shift
fi
targets=("$@")
if [ $# -eq 0 ]; then
    for file in fuzz/fuzz_targets/*.rs; do
        targets+=("$(basename "$file" .rs)")
    done
fi

# One thread, so that a run can be repeated. Targets put their files where temporary files are: in memory, if that is possible,
# where some targets run ten times as often as on a slow disk.
export RAYON_NUM_THREADS=1
TMPDIR=$(mktemp -d -p /dev/shm 2>/dev/null || mktemp -d)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

# Without a sanitizer, because there is no unsafe code of ours to watch; with assertions and overflow checks.
flags=(--sanitizer none -O -a)
cargo +nightly fuzz build "${flags[@]}"

findings=0
printf '%-18s %12s %10s %8s  %s\n' target executions "a second" coverage findings
for target in "${targets[@]}"; do
    mkdir -p "fuzz/corpus/$target" "fuzz/artifacts/$target"
    log=fuzz/artifacts/$target.log
    verdict=none
    if ! cargo +nightly fuzz run "${flags[@]}" "$target" "fuzz/corpus/$target" "fuzz/seeds/$target" -- \
        -max_total_time="$seconds" -timeout=60 -rss_limit_mb=4096 -print_final_stats=1 >"$log" 2>&1; then
        findings=1
        # The last input that libFuzzer kept; without one, the log says what went wrong.
        kept=$(sed -n 's/^.*Test unit written to //p' "$log" | tail -1)
        verdict="${kept:-none kept}, see $log"
    fi
    stat() { sed -n "s/^stat::$1: *//p" "$log" | tail -1; }
    coverage=$(sed -n 's/^.* cov: \([0-9]*\) .*$/\1/p' "$log" | tail -1)
    printf '%-18s %12s %10s %8s  %s\n' "$target" "$(stat number_of_executed_units)" \
        "$(stat average_exec_per_sec)" "${coverage:-?}" "$verdict"
done
exit $findings
