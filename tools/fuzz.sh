#!/bin/bash
# fuzz.sh [-n EXECUTIONS | -t SECONDS] [NAME...]: builds the fuzzers of tests/fuzz and runs each, or those named, from
# its corpus, as many at once as there are processors; default: 10,000,000 executions. What they learn is kept in
# build/fuzz/corpus, a finding in build/fuzz/findings (exit status 1). fuzz.sh --keep [NAME...]: takes what was learnt
# into tests/fuzz/corpus, minimised.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

# Longest input: more is slower and finds nothing new.
declare -A longest=([dbc]=900 [configuration]=500 [slcan]=300 [frame]=120 [request]=500 [scenario]=700 [file]=1000
  [fault_frame]=256)
limit=-runs=10000000
case ${1-} in
  -n) limit=-runs=$2; shift 2 ;;
  -t) limit=-max_total_time=$2; shift 2 ;;
  --keep) limit=keep; shift ;;
  -*) sed -n '2,5s/^# //p' "$0" >&2; exit 2 ;;
esac
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(dbc configuration slcan frame request scenario file fault_frame)

launcher=
command -v ccache >/dev/null && launcher=ccache
cmake --preset fuzz -DCMAKE_CXX_COMPILER_LAUNCHER=$launcher >/dev/null
cmake --build --preset fuzz --target words "${names[@]/%/_fuzz}" >build/fuzz/build.log 2>&1 || { tail -n 40 build/fuzz/build.log >&2; exit 1; }

# keep NAME
keep() {
  local kept=tests/fuzz/corpus/$1
  rm -rf "$kept.new"
  mkdir -p "$kept.new" "$kept" "build/fuzz/corpus/$1"
  "build/fuzz/bin/${1}_fuzz" -merge=1 -use_counters=0 -max_len="${longest[$1]}" "$kept.new" "$kept" "build/fuzz/corpus/$1" >"build/fuzz/$1.log" 2>&1
  rm -rf "$kept"
  mv "$kept.new" "$kept"
  echo "fuzz.sh: $1: $(find "$kept" -type f | wc -l) inputs kept"
}

# fuzz NAME
fuzz() {
  local log=build/fuzz/$1.log dictionary=build/fuzz/$1.dict
  local options=(-max_len="${longest[$1]}" -timeout=20 -rss_limit_mb=1024 -artifact_prefix="build/fuzz/findings/$1-")
  mkdir -p "build/fuzz/corpus/$1" build/fuzz/findings
  build/fuzz/bin/words "$1" >"$dictionary"
  [ ! -s "$dictionary" ] || options+=(-dict="$dictionary")
  if ! "build/fuzz/bin/${1}_fuzz" "$limit" "${options[@]}" "build/fuzz/corpus/$1" "tests/fuzz/corpus/$1" >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    echo "fuzz.sh: $1: a finding: build/fuzz/findings" >&2
    return 1
  fi
  echo "fuzz.sh: $1: $(sed -n 's/^Done \(.*\)/\1/p' "$log"), no finding"
}

status=0
for name in "${names[@]}"; do
  if [ "$limit" = keep ]; then keep "$name"; continue; fi
  [ "$(jobs -rp | wc -l)" -lt "$(nproc)" ] || wait -n || status=1
  fuzz "$name" &
done
while [ -n "$(jobs -p)" ]; do wait -n || status=1; done
exit $status
