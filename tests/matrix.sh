#!/usr/bin/env bash
# What the ordinary tests do not cover because it needs other compilers, other flags or hours. Run by hand; every part
# prints what it ran and fails loudly.
#   bash tests/matrix.sh [PART ...]      parts: repeat levels clang asan tsan valgrind soak kills fuzz (default: all)
set -eu
cd "$(dirname "$0")/.."
root=$PWD
jobs=${JOBS:-$(nproc)}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

build() {  # PRESET TARGET ...
  local preset=$1
  shift
  [ -f ".build/$preset/build.ninja" ] || cmake --preset "$preset" >/dev/null
  ninja -C ".build/$preset" -j "$jobs" "$@" | tail -n 1
}

lab() {  # a small measurement in $scratch/lab, made by the given tool
  rm -rf "$scratch/lab"
  "$1" simulate data-synthetic/scenes/small-20-0.toml -o "$scratch/lab" >/dev/null
}

# Without what may differ from run to run: the time in CFITSIO's checksum cards, and the checksums over it.
bare() {
  LC_ALL=C sed -E 's/(CHECKSUM|DATASUM )= .{70}//g' "$1" | sha256sum | cut -d' ' -f1
}

# The same bytes from repeated runs, from one thread and from two.
part_repeat() {
  build release scatmap
  local tool=$root/.build/release/tools/scatmap first now verb
  lab "$tool"
  cd "$scratch/lab"
  for verb in angles brdf model; do
    first=
    for cpus in 0 0 0,1 0,1; do
      case $verb in
        angles) taskset -c "$cpus" "$tool" angles instrument.toml --stage-deg 20 --arm-deg 40 -o out.fits --force ;;
        brdf) taskset -c "$cpus" "$tool" brdf measurement.toml -o out.fits --force ;;
        model) taskset -c "$cpus" "$tool" model model.toml --like like.fits -o out.fits --force ;;
      esac >/dev/null
      [ "$verb" = brdf ] && cp out.fits like.fits
      now=$(bare out.fits)
      [ -z "$first" ] || [ "$first" = "$now" ] || { echo "$verb: other bytes on CPUs $cpus"; exit 1; }
      first=$now
    done
    echo "repeat: $verb gives the same bytes in 4 runs, on 1 and 2 CPUs"
  done
  cd "$root"
}

# Tests against independent references, at other optimisation levels and instruction sets.
part_levels() {
  local flags name
  local tests="test_angles_angle_map test_angles_inverse test_model_microfacet test_model_stripes
    test_model_polarization_q test_brdf_scale test_brdf_signature"
  for flags in "-O0" "-O1" "-O2 -march=native" "-O3 -march=native" "-O2"; do
    name=$(echo "$flags" | tr -d ' =')
    cmake -S . -B ".build/levels$name" -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="$flags" >/dev/null
    # shellcheck disable=SC2086
    ninja -C ".build/levels$name" -j "$jobs" $tests | tail -n 1
    for test in $tests; do
      ".build/levels$name/tests/$test" >"$scratch/log" 2>&1 || { tail -n 30 "$scratch/log"; exit 1; }
    done
    echo "levels: $flags holds the bounds"
  done
}

part_clang() {
  build clang all
  ctest --preset clang -j "$jobs"
}

part_asan() {
  build asan all
  ctest --preset asan -j "$jobs"
}

part_tsan() {
  build tsan all
  ctest --preset tsan -j "$jobs"
}

# Readers under memcheck: uninitialised values, which AddressSanitizer does not see.
part_valgrind() {
  build release replay_fits_frame replay_fits_structure replay_map_fits replay_tiff replay_png replay_pgm \
    replay_instrument replay_measurement replay_model replay_scene replay_targets replay_bad_pixels replay_poni \
    replay_refractive_index
  for program in .build/release/tests/fuzz/replay_*; do
    local name=${program##*replay_}
    [ "$name" = cameramodel ] && continue  # mrcal's own code is not ours to mend
    # AVX-512 is beyond valgrind 3.19.
    GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F valgrind -q --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite \
      "$program" "tests/fuzz/corpus/$name" >"$scratch/log" 2>&1 || { tail -n 60 "$scratch/log"; exit 1; }
    echo "valgrind: $name"
  done
}

# Memory of one process that reduces 2000 frames, and of 200 measurements one after the other.
part_soak() {
  build release test_flow_soak_slow
  .build/release/tests/test_flow_soak_slow
}

part_kills() {
  build release scatmap test_faults_kills_slow
  .build/release/tests/test_faults_kills_slow
}

part_fuzz() { RUNS=1000000 bash tests/fuzz/run.sh; }

for part in ${*:-repeat levels clang asan tsan valgrind soak kills fuzz}; do "part_$part"; done
echo "done: ${*:-all parts}"
