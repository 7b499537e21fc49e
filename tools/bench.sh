#!/bin/bash
# bench.sh [--rounds N] [--seconds S] [--record-dir DIR]: what the machine makes of servohil, in 3 minutes. Of each
# number: the median over the rounds, (min..max), and the goal. Nothing is asserted.
#  1. Time of one tick, mean and worst over the envelope (Google Benchmark).
#  2. `servohil simulate` of 60 s, with and without a recording, against real time and against as many ticks.
#  3. Wake-up latency of `servohil run` at 0.1 ms beside cyclictest's with the same priority, period and CPU, by turns
#     in one run, on the machine as it is and under stress-ng; and with everything recorded and published each 1 ms,
#     beside neither. Ratios are what counts on a shared machine. Needs real-time privilege; without, exit status 3.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
rounds=5 seconds=4 where=()
usage() {
  echo "usage: tools/bench.sh [--rounds N] [--seconds S of each run] [--record-dir DIR]" >&2
  exit 2
}
while [ $# -gt 0 ]; do
  [ $# -ge 2 ] || usage
  case $1 in
    --rounds) rounds=$2 ;;
    --seconds) seconds=$2 ;;
    --record-dir) where=(--record-dir "$2") ;;
    *) usage ;;
  esac
  shift 2
done
for number in "$rounds" "$seconds"; do [[ $number =~ ^[1-9][0-9]*$ ]] || usage; done

# A build that is given is taken as it is.
if [ -z "${SERVOHIL_BUILD-}" ]; then
  tools/deps.sh test
  cmake --preset release >/dev/null
  cmake --build --preset release --target servohil tick_benchmark
  export SERVOHIL_BUILD=$PWD/build/release
fi
echo "== one tick: mean, and the slowest over the envelope (times_mean: against the mean)"
"$SERVOHIL_BUILD/bin/tick_benchmark" --benchmark_min_time=0.2 --benchmark_repetitions="$rounds" \
  --benchmark_report_aggregates_only=true
/usr/bin/python3 tools/bench_simulate.py --rounds "$rounds" "${where[@]}"
/usr/bin/python3 tools/bench_latency.py --rounds "$rounds" --seconds "$seconds" "${where[@]}"
