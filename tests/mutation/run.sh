#!/usr/bin/env bash
# Takes guards out of the source one by one, builds the test program that is meant to miss them, and expects it to
# fail. Works on a copy of the tree. Prints one line per mutation: what caught it, or SURVIVED.
#   bash tests/mutation/run.sh [FIRST [LAST]]      mutations by number; default all
set -eu
cd "$(dirname "$0")/../.."
here=$PWD
first=${1:-1} last=${2:-999}
copy=$PWD/.build/mutation
mkdir -p "$copy"
git ls-files -z --cached --others --exclude-standard | tar --null -T - -c | tar -x -C "$copy"
cd "$copy"
cmake --preset release >/dev/null
number=0 caught=0 survived=0
while IFS='~' read -r file program expression meaning; do
  case $file in '' | '#'*) continue ;; esac
  number=$((number + 1))
  [ "$number" -ge "$first" ] && [ "$number" -le "$last" ] || continue
  sed -i -E "$expression" "$file"
  if cmp -s "$file" "$here/$file"; then
    echo "$number: the expression for '$meaning' changes nothing in $file" >&2
    exit 2
  fi
  if ! ninja -C .build/release -j "${JOBS:-$(nproc)}" "$program" >build.log 2>&1; then
    echo "$number: does not build without '$meaning'" >&2
    tail -n 20 build.log >&2
    exit 2
  fi
  binary=$(find .build/release/tests -type f -name "$program" -perm -u+x)
  if timeout 300 prlimit --as=8000000000 "$binary" --gtest_brief=1 >test.log 2>&1; then
    echo "$number | $meaning | $file | SURVIVED $program"
    survived=$((survived + 1))
  else
    by=$(grep -m1 -oE 'FAILED  \] [A-Za-z./0-9_]+' test.log | sed 's/FAILED  \] //' || true)
    echo "$number | $meaning | $file | ${by:-$program ended by a signal}"
    caught=$((caught + 1))
  fi
  cp "$here/$file" "$file"
done <"$here/tests/mutation/mutations.txt"
echo "$caught caught, $survived survived"
[ "$survived" -eq 0 ]
