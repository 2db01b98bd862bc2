#!/bin/sh
# Whether the present program gives the numbers of an earlier commit. Both programs calibrate and validate from the same
# track files; no_drift.py compares what they write, to the last digit, and names what may differ.
#   bench/no_drift.sh [COMMIT [FOLDER]]
# COMMIT is 90ba708 where none is given. The films of the bin are looked for in ../shared/lab-videos/macro. Builds and
# runs of the earlier program are kept in FOLDER (out/bench/no_drift); those of the present program are made anew.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
hash=$(git rev-parse --short --verify "${1:-90ba708}^{commit}")
folder=${2:-out/bench/no_drift}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
earlier=$folder/$hash
data=$folder/$hash.data      # tracks and experiment files
before=$folder/$hash.runs after=$folder/present.runs
films=$root/../shared/lab-videos/macro

# build SOURCE: its program, as ./run build makes it
build() {
  log=$folder/build-$(basename "$1").log
  if ! (cd "$1" && cmake --preset release && cmake --build --preset release --target graintruth) >"$log" 2>&1; then
    tail -n 30 "$log" >&2
    exit 3
  fi
}

# once STAMP COMMAND...: unless it has ended before
once() {
  stamp=$1
  shift
  [ ! -e "$stamp" ] || return 0
  "$@"
  touch "$stamp"
}

track_micro() {
  "$earlier/build/release/graintruth" track "$earlier/datasets/micro/experiment.toml" --out "$data/micro" --quiet
  sed 's|^video = "\(.*\)\.mp4"|tracks = "micro/tracks/\1.csv"|' "$earlier/datasets/micro/experiment.toml" \
    >"$data/micro.toml"
}

# Six films: two of each of three orifices, of which the narrowest is held out
track_bin() {
  awk -v RS= -v ORS='\n\n' '!/\[\[replicate\]\]/ || /orifice(065|085|100)_rep[12]\.mp4/' \
    "$earlier/datasets/macro/experiment.toml" | sed 's|^video = ".*/|video = "'"$films"'/|' >"$data/bin_films.toml"
  "$earlier/build/release/graintruth" track "$data/bin_films.toml" --out "$data/bin" --quiet
  sed 's|^video = ".*/\(.*\)\.mp4"|tracks = "bin/tracks/\1.csv"|' "$data/bin_films.toml" >"$data/bin.toml"
  # Together: the widest orifice beside the micro experiment, with the bench values of that
  awk -v RS= -v ORS='\n\n' '!/\[\[replicate\]\]/ || /orifice100/' "$data/bin.toml" >"$data/wide.toml"
  for name in friction_particle_particle friction_particle_wall restitution; do
    value=$(sed -n "s/^$name = \([0-9.]*\)\$/\1/p" "$data/micro.toml")
    sed "s/^$name = [0-9.]*\$/$name = $value/" "$data/wide.toml" >"$data/wide.new"
    mv "$data/wide.new" "$data/wide.toml"
  done
  {
    printf 'title = "Balls on the piston, and out of the bin"\n\n'
    printf '[[experiment]]\nfile = "%s.toml"\n\n' micro wide
    sed -n '/^\[tune\]/,/^$/p' "$data/micro.toml"
  } >"$data/together.toml"
}

# calibrate PROGRAM RUNS NAME BUDGET
calibrate() { "$1" calibrate "$data/$3.toml" --out "$2/$3" --budget "$4" --quiet >"$2/$3.log"; }
# validate PROGRAM RUNS NAME: at what the earlier program found, whoever validates it
validate() {
  "$1" validate "$data/$3.toml" --parameters "$before/$3/result.json" --out "$2/$3-validated" --quiet >"$2/$3-validated.log"
}

# run_all PROGRAM RUNS
run_all() {
  mkdir -p "$2"
  once "$2/micro.done" calibrate "$1" "$2" micro 40
  once "$2/micro-validated.done" validate "$1" "$2" micro
  [ -d "$films" ] || return 0
  once "$2/bin.done" calibrate "$1" "$2" bin 20
  once "$2/bin-validated.done" validate "$1" "$2" bin
  once "$2/together.done" calibrate "$1" "$2" together 20
}

git worktree prune
[ -d "$earlier" ] || git worktree add --quiet --detach "$earlier" "$hash"
echo "building $hash and the present program"
build "$earlier"
build "$root"
mkdir -p "$data"
echo "tracking and running, first with the program of $hash"
once "$data/micro.done" track_micro
if [ -d "$films" ]; then
  once "$data/bin.done" track_bin
else
  echo "skipped: the bin, alone and with the micro experiment; its films are not in ../shared/lab-videos/macro"
fi
run_all "$earlier/build/release/graintruth" "$before"
rm -rf "$after"
run_all "$root/build/release/graintruth" "$after"
exec /usr/bin/python3 bench/no_drift.py "$before" "$after"
