#!/usr/bin/env bash
# Builds the fuzz targets with clang and runs each from a copy of its saved corpus. Fails on the first crash, leak, hang
# over 5 s or allocation over 4 GiB; the input that did it is then in .build/fuzz/found/TARGET.
#   bash tests/fuzz/run.sh [SECONDS_EACH [TARGET ...]]     default: 60 seconds, every target
#   RUNS=1000000 bash tests/fuzz/run.sh                    that many executions instead
#   KEEP=1: small new inputs that reach new code are added to the saved corpus
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-60}
[ $# -gt 0 ] && shift
cmake --preset fuzz >/dev/null
all=$(sed -n '/^set(targets/,/)/p' tests/fuzz/CMakeLists.txt | tr -d '\n' | sed -E 's/set\(targets (.*)\)/\1/')
targets=${*:-$all}
# shellcheck disable=SC2086
cmake --build .build/fuzz --target $(printf 'fuzz_%s ' $targets) -- ${JOBS:+-j$JOBS} | tail -n 1
limit=(-max_total_time="$seconds")
[ -n "${RUNS:-}" ] && limit=(-runs="$RUNS")
for target in $targets; do
  corpus=.build/fuzz/corpus/$target found=.build/fuzz/found/$target
  mkdir -p "$corpus" "$found"
  cp -u tests/fuzz/corpus/"$target"/* "$corpus"/
  options=(-timeout=5 -malloc_limit_mb=4096 -rss_limit_mb=6144 -artifact_prefix="$found/" -print_final_stats=1
    -close_fd_mask=3 -max_len=262144)
  case $target in
    fits_* | map_fits) options+=(-dict=tests/fuzz/fits.dict) ;;
    instrument | measurement | model | scene) options+=(-dict=tests/fuzz/toml.dict -max_len=16384) ;;
    tiff | png | pgm) options+=(-max_len=4096) ;;
    *) options+=(-max_len=8192) ;;
  esac
  echo "== $target"
  if ! ASAN_OPTIONS=allocator_may_return_null=0:detect_leaks=1 \
      .build/fuzz/tests/fuzz/fuzz_"$target" "${limit[@]}" "${options[@]}" "$corpus" 2>"$found/log"; then
    tail -n 40 "$found/log"
    exit 1
  fi
  grep -E "stat::(number_of_executed_units|average_exec_per_sec|new_units_added|slowest_unit|peak_rss)" "$found/log"
  if [ -n "${KEEP:-}" ]; then
    small=$(mktemp -d)
    find "$corpus" -size -2k -type f -exec cp {} "$small" \;
    .build/fuzz/tests/fuzz/fuzz_"$target" -merge=1 -close_fd_mask=3 tests/fuzz/corpus/"$target" "$small" 2>/dev/null
    rm -r "$small"
  fi
done
