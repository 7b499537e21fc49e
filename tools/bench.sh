#!/bin/bash
# bench.sh [--rounds N] [--seconds S]: what the machine makes of servohil.
#  1. Time of one tick, mean and worst over the envelope (Google Benchmark).
#  2. Wake-up latency of `servohil run` at 0.1 ms beside cyclictest's with the same priority, period and CPU,
#     alternating in one run; their ratio is the figure that counts on a shared machine.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
rounds=5 seconds=10
while [ $# -gt 0 ]; do
  case $1 in
    --rounds) rounds=$2; shift 2 ;;
    --seconds) seconds=$2; shift 2 ;;
    *) echo "usage: tools/bench.sh [--rounds N] [--seconds S]" >&2; exit 2 ;;
  esac
done
tools/deps.sh test
cmake --preset release >/dev/null
cmake --build --preset release --target servohil tick_benchmark
echo "== one tick: mean, and the slowest over the envelope (times_mean: against the mean)"
build/release/bin/tick_benchmark --benchmark_repetitions=5 --benchmark_report_aggregates_only=true
echo "== wake-up latency, $rounds rounds of $seconds s each"
exec /usr/bin/python3 tools/bench_latency.py --rounds "$rounds" --seconds "$seconds"
