#!/bin/bash
# fuzz.sh [-n EXECUTIONS | -t SECONDS] [NAME...]: builds the fuzzers of tests/fuzz and runs each, or those named, from
# its corpus; default: 10,000,000 executions. What they learn is kept in build/fuzz/corpus, a finding in
# build/fuzz/findings (exit status 1). fuzz.sh --keep [NAME...]: takes what was learnt into tests/fuzz/corpus, minimised.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

# Longest input: more is slower and finds nothing new.
declare -A longest=([dbc]=600 [configuration]=500 [slcan]=300 [frame]=72 [request]=500)
limit=-runs=10000000
case ${1-} in
  -n) limit=-runs=$2; shift 2 ;;
  -t) limit=-max_total_time=$2; shift 2 ;;
  --keep) limit=keep; shift ;;
  -*) sed -n '2,4s/^# //p' "$0" >&2; exit 2 ;;
esac
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(dbc configuration slcan frame request)

cmake --preset fuzz >/dev/null
cmake --build --preset fuzz --target "${names[@]/%/_fuzz}" >build/fuzz/build.log 2>&1 || { tail -n 40 build/fuzz/build.log >&2; exit 1; }

for name in "${names[@]}"; do
  program=build/fuzz/bin/${name}_fuzz kept=tests/fuzz/corpus/$name corpus=build/fuzz/corpus/$name log=build/fuzz/$name.log
  mkdir -p "$corpus" build/fuzz/findings
  if [ "$limit" = keep ]; then
    rm -rf "$kept.new"
    mkdir "$kept.new"
    "$program" -merge=1 -max_len="${longest[$name]}" "$kept.new" "$kept" "$corpus" >"$log" 2>&1
    rm -rf "$kept"
    mv "$kept.new" "$kept"
    echo "fuzz.sh: $name: $(find "$kept" -type f | wc -l) inputs kept"
    continue
  fi
  if ! "$program" "$limit" -max_len="${longest[$name]}" -timeout=20 -rss_limit_mb=1024 -artifact_prefix="build/fuzz/findings/$name-" \
      "$corpus" "$kept" >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    echo "fuzz.sh: $name: a finding: build/fuzz/findings" >&2
    exit 1
  fi
  echo "fuzz.sh: $name: $(sed -n 's/^Done \(.*\)/\1/p' "$log"), no finding"
done
