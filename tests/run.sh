#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test but those labelled slow.
#   bash tests/run.sh [PRESET [ctest options]]      PRESET: release (default), debug, asan
set -eu
cd "$(dirname "$0")/.."
preset=${1:-release}
[ $# -gt 0 ] && shift
bash tools/setup.sh
cmake --preset "$preset" >/dev/null
cmake --build --preset "$preset" -- -k 0 | tail -n 5
ctest --preset "$preset" -j "$(nproc)" "$@"
