#!/bin/sh
# Reads COUNT mutated files (default 1000000) with every reader, or with those named behind it, and prints what came of
# it. Builds the readers with clang and its sanitizers in build/fuzz first. What makes a reader fail is kept in
# build/fuzz/found.
#   bench/fuzz/run.sh [COUNT [READER...]]
set -eu
cd "$(dirname "$0")/../.."
count=${1:-1000000}
[ $# -gt 0 ] && shift
build=build/fuzz
cmake -S . -B $build -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Release -DGRAINTRUTH_FUZZ=ON >/dev/null
ninja -C $build fuzzers
inputs=$PWD/$build/bench/fuzz_inputs runs=$PWD/$build/bench/fuzz_runs
[ $# -gt 0 ] || set -- $("$inputs" names) $("$runs" names)
mkdir -p $build/found
# Memory of OpenCV's and FFmpeg's threads is theirs; a size that no file needs is ours.
export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
printf '%-12s %10s %10s %10s %10s  %s\n' reader inputs inputs/s edges corpus outcome
status=0
for reader in "$@"; do
  corpus=$build/corpus/$reader
  log=$build/$reader.log
  mkdir -p "$corpus"
  fuzz=$inputs
  "$runs" names | grep -qx "$reader" && fuzz=$runs
  "$fuzz" "$reader" seeds "$corpus"
  if "$fuzz" "$reader" -runs="$count" -seed=1 -max_len=65536 -timeout=20 -rss_limit_mb=3000 -print_final_stats=1 \
      -artifact_prefix="$build/found/$reader-" "$corpus" >"$log" 2>&1; then
    outcome="nothing found"
  else
    outcome="FAILED, see $log"
    status=1
  fi
  stat() { sed -n "s/^stat::$1: *//p" "$log" | tail -1; }
  edges=$(sed -n 's/.* cov: \([0-9]*\).*/\1/p' "$log" | tail -1)
  printf '%-12s %10s %10s %10s %10s  %s\n' "$reader" "$(stat number_of_executed_units)" \
    "$(stat average_exec_per_sec)" "$edges" "$(ls "$corpus" | wc -l)" "$outcome"
done
exit $status
