#!/usr/bin/env bash
# Runs fuzz targets one after the other, each for so many seconds: fuzz/run.sh SECONDS [TARGET]... Stops at the first finding.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:?seconds a target}
shift
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
    mapfile -t targets < <(cargo +nightly fuzz list)
fi
for target in "${targets[@]}"; do
    echo "== $target"
    corpus=fuzz/corpus/$target
    mkdir -p "$corpus"
    case $target in
        drive_csv | rig_csv) words=csv ;;
        challenge_key | verdict_json | tables) words=json ;;
        *) words=$target ;;
    esac
    dictionary=fuzz/dictionaries/$words.dict
    options=(-max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1)
    if [ -f "$dictionary" ]; then
        options+=(-dict="$dictionary")
    fi
    cargo +nightly fuzz run "$target" "$corpus" "fuzz/seeds/$target" -- "${options[@]}"
done
