#!/usr/bin/env bash
# Installs what is missing of the Debian packages that scatmap is built from. Run by tools/demo.sh and tests/run.sh.
set -eu

packages=(
  g++ cmake ninja-build pkg-config
  libeigen3-dev libtbb-dev libcli11-dev nlohmann-json3-dev libtomlplusplus-dev nettle-dev zlib1g-dev
  libcfitsio-dev libtiff-dev libpng-dev libopenexr-dev
  libopencv-core-dev libopencv-imgproc-dev libopencv-calib3d-dev libceres-dev libmrcal-dev
  libgtest-dev libbenchmark-dev gnuplot-nox
)

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo)
echo "installing: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
