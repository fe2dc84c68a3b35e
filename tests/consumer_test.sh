#!/usr/bin/env bash
# Installs the build into a scratch folder and builds tests/consumer against it with find_package(scatmap).
#   bash tests/consumer_test.sh SOURCE_DIR BUILD_DIR
set -eu
source=$1 build=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cmake --install "$build" --prefix "$folder/installed" >/dev/null
"$folder/installed/bin/scatmap" --version
cmake -S "$source/tests/consumer" -B "$folder/build" -G Ninja -DCMAKE_PREFIX_PATH="$folder/installed" >/dev/null
cmake --build "$folder/build" >/dev/null
"$folder/build/consumer"
