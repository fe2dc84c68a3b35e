#!/usr/bin/env bash
# The main job on embedded synthetic data: installs what is missing, builds, then simulate -> angles -> brdf -> model ->
# compare on the solar-cell scenes of the paper. Says where the maps and pictures are; opens nothing.
#   bash tools/demo.sh [FOLDER]      FOLDER: scatmap-demo by default; what the demo made there before is replaced
set -eu
cd "$(dirname "$0")/.."
out=${1:-scatmap-demo}
bash tools/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release --target scatmap | tail -n 1
scatmap=.build/release/tools/scatmap

# scene, and the figures of the paper that it is
scenes=(
  "full-20-0  Figs.2ab,8ab"
  "full-60-0  Figs.2cd,8cd"
  "half-40-45 Figs.3a,9a"
  "half-40-90 Figs.3b,9b"
  "half-20-45 Figs.4a,10a"
  "half-60-45 Figs.4b,10b"
)

mkdir -p "$out"
for entry in "${scenes[@]}"; do
  read -r scene figures <<<"$entry"
  dir=$out/$scene
  echo "== $scene (${figures//,/, })"
  "$scatmap" simulate "data-synthetic/scenes/$scene.toml" -o "$dir" --force >/dev/null
  stage=$(sed -n 's/^stage_deg = //p' "$dir/measurement.toml")
  arm=$(sed -n 's/^arm_deg = //p' "$dir/measurement.toml" | head -n 1)
  "$scatmap" angles "$dir/instrument.toml" --stage-deg "$stage" --arm-deg "$arm" -o "$dir/angles.fits" --force
  "$scatmap" brdf "$dir/measurement.toml" -o "$dir/map.fits" --force
  "$scatmap" model "$dir/model.toml" --like "$dir/map.fits" -o "$dir/model.fits" --force
  "$scatmap" compare "$dir/map.fits" "$dir/model.fits" -o "$dir/comparison" --force
done

echo
echo "Results, per scene, in $(realpath "$out"):"
echo "  SCENE/map.fits                 measured BRDF, uncertainty, mask, angles (any FITS viewer shows the angles)"
echo "  SCENE/model.fits               the model on the same pixels"
echo "  SCENE/comparison/overview.png  measured beside modelled, as the paper's figures"
echo "  SCENE/comparison/              maps, profiles along the fringes, residuals, comparison.json"
