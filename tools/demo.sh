#!/bin/bash
# demo.sh: the emulator and a stand-in governor on a CAN bus, with air in the oil; first without the stabilizer, then
# with it. Leaves one picture, out/demo.png. Set SERVOHIL_BUILD to use a program that is built already.
set -euo pipefail

cd "$(dirname "$(readlink -f "$0")")/.."
step_psi=0.27
settings=(--set start.x3_in=4 --set servo.bulk_modulus_psi=90000
  # The oscillation has some 150 Hz: a frame every millisecond shows it. 56 % of a bus of 500 kbit/s.
  --set publish.position_ms=1 --set publish.pressures_ms=1)
stabilizer=(--set stabilizer.enabled=true --set stabilizer.capillary_diameter_in=0.30
  --set stabilizer.capillary_length_in=15 --set stabilizer.oil_volume_in3=100 --set stabilizer.gas_volume_in3=100)
window=(0.10 0.25) # s after the step: the step itself is over, what moves still is the oscillation

die() {
  echo "demo.sh: $*" >&2
  exit 1
}
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }

emulator='' made_vcan='' work=$(mktemp -d)
clean_up() {
  [ -z "$emulator" ] || kill "$emulator" 2>/dev/null || true
  [ -z "$made_vcan" ] || as_root ip link delete vcan0 || true
  rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# Builds only what the demonstration needs, in a folder of its own.
build() {
  tools/deps.sh demo
  echo "building (the first time a minute or two) ..."
  mkdir -p build/demo
  { cmake --preset release -B build/demo -DSERVOHIL_TESTS=OFF && cmake --build build/demo --target servohil; } \
    >build/demo/log 2>&1 || {
    tail -n 20 build/demo/log >&2
    die "building failed; all of it: build/demo/log"
  }
}

# vcan0 where the kernel has CAN, else a serial adapter played by the emulator.
choose_bus() {
  bus=slcan:pty
  if [ ! -e /sys/class/net/vcan0 ]; then
    { as_root modprobe vcan; as_root ip link add dev vcan0 type vcan; } >/dev/null 2>&1 || true
    [ ! -e /sys/class/net/vcan0 ] || made_vcan=1
  fi
  if [ -e /sys/class/net/vcan0 ]; then
    as_root ip link set up vcan0 2>/dev/null || true
    ip link show vcan0 | grep -q '[<,]UP[,>]' || die "vcan0 is down; set it up: sudo ip link set up vcan0"
    bus=socketcan:vcan0
    echo "bus: vcan0"
  else
    echo "bus: a serial CAN adapter that the emulator plays (slcan:pty), as this kernel has no CAN"
  fi
}

# One run: emulator on the bus, step by the governor, out/demo_NAME.csv.
run() { # NAME TEXT [SETTING...]
  local name=$1 text=$2 url ready status=0
  shift 2
  echo
  echo "--- $text"
  mkfifo "$work/$name"
  "$program" run -c config/servohil.toml --can "$bus" "${settings[@]}" "$@" >"$work/$name" 2>"$work/log" &
  emulator=$!
  exec {output}<"$work/$name"
  read -rt 20 ready <&"$output" || {
    cat "$work/log" >&2
    die "the emulator did not start"
  }
  url=${ready#ready: }
  tools/governor.py --can "${url%%;*}" --accept-invalid -o "out/demo_$name.csv" --last 0.3 --duration 1 \
    step "$rest_psi" "$(awk "BEGIN { printf \"%.3f\", $rest_psi + $step_psi }")" --at 0.3 | grep -E '^(sent|gaps|NOTE)' ||
    die "the governor failed"
  kill "$emulator"
  wait "$emulator" || status=$?
  emulator=''
  verdict=$(grep '^verdict' <&"$output") || die "the emulator ended without a verdict, exit status $status"
  exec {output}<&-
  echo "emulator  ${verdict#verdict  }"
  case $status in
    0) ;;
    1) invalid=1 ;;
    *) die "the emulator ended with exit status $status" ;;
  esac
}

if [ -z "${SERVOHIL_BUILD-}" ]; then build; fi
program=${SERVOHIL_BUILD:-build/demo}/bin/servohil
[ -x "$program" ] || die "$program is missing"
mkdir -p out
invalid=''
rest_psi=$("$program" steady -c config/servohil.toml --set servo.bulk_modulus_psi=90000 --x3 4 |
  awk '$1 == "p1_psi" { printf "%.3f", $2 }')
echo "servomotor at rest at x3 = 4 in, P1 = $rest_psi psi; air in the oil: bulk modulus 90,000 psi"
choose_bus
run without "P1 rises by $step_psi psi, no stabilizer"
run with "the same with the transient flow stabilizer (d7 0.30 in, L7 15 in, Va 100 in3)" "${stabilizer[@]}"

echo
echo "peak to peak, ${window[0]} to ${window[1]} s after the step:"
tools/plot.py out/demo_without.csv out/demo_with.csv --label 'without stabilizer' --label 'with stabilizer' \
  --columns x3_in,v3_in_s,p3_psi --from-step --window -0.02 0.25 --swing "${window[@]}" -o out/demo.png --title \
  "Air in the oil makes the servomotor ring; the stabilizer removes it
Control pressure P1 steps by $step_psi psi at x3 = 4 in. Bulk modulus of the oil 90,000 psi. Read from the CAN bus every millisecond."
if [ -n "$invalid" ]; then
  echo "INVALID: this machine was at times too late for real time. The emulator caught up: the curves are right in simulated"
  echo "time, but a governor met some of them late. A real-time kernel or an idle machine helps; the picture stands."
fi
echo "picture: out/demo.png"
