#!/bin/bash
# shellcheck disable=SC2317  # stages are called by name
# test.sh: installs what the tests need, builds, and runs all of them: format and lint, unit tests with and without
# sanitizers, whole-program tests, fuzzers, and the same client tests on a real SocketCAN stack (in a guest; never
# skipped). Idempotent. All stages run, whatever the others come to; a table at the end says what each did, build/log has
# what each printed. Exit status 1: a stage failed.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

tools/deps.sh test
rm -rf build/log
mkdir -p build/log

export PYTHONDONTWRITEBYTECODE=1 LSAN_OPTIONS=suppressions=$PWD/tests/lsan.supp:print_suppressions=0
pytest=(/usr/bin/python3 -m pytest -q -p no:cacheprovider)
# What was compiled before, in any checkout on this machine, is not compiled again. Never needed.
launcher=-DCMAKE_CXX_COMPILER_LAUNCHER=
if command -v ccache >/dev/null; then
  launcher+=ccache
  export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
fi
# Unit tests of what has pointers, threads or bytes from outside.
sanitized=(model fault can rt configuration signal_map simulation recording emulator scenario run)
threaded=(rt can)

# --- The stages, each a function: what it prints is its log, its exit status the result. ---

lint() {
  git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run -Werror
  git ls-files | xargs -d '\n' grep -lE '^#!/bin/(ba)?sh' | xargs shellcheck
  "${pytest[@]}" tests/test_rooms.py -k "not compiler"
}

configure() { for preset in release asan tsan dev; do cmake --preset "$preset" "$launcher"; done; }
build_release() { cmake --build --preset release; }
# Each file for itself, not a folder as one: includes that are missing are seen.
build_dev() { cmake --build --preset dev --target servohil; }
build_asan() { cmake --build --preset asan --target "${sanitized[@]/%/_test}" servohil; }
build_tsan() { cmake --build --preset tsan --target "${threaded[@]/%/_test}" servohil; }
# Kernels of the CAN guests, built or downloaded once a machine.
build_guests() { tools/vcan-guest --build && tools/vcan-guest --controllers --build; }

clang_tidy() {
  run-clang-tidy -quiet -p build/release -extra-arg=-Wno-unknown-warning-option "src/.*[.]dir/Unity/" >build/clang-tidy.log 2>&1 ||
    { grep -E 'warning:|error:' build/clang-tidy.log | sort -u; return 1; }
  # A room is not overlooked: each has been looked at.
  for room in src/*/CMakeLists.txt; do
    grep -q "/$(dirname "$room")/CMakeFiles/.*/Unity/" build/clang-tidy.log || { echo "nothing of $room was looked at"; return 1; }
  done
}

unit_release() { ctest --preset release; }
unit_asan() { for room in "${sanitized[@]}"; do "build/asan/bin/${room}_test" --gtest_brief=1; done; }
e2e_release() { SERVOHIL_BUILD=$PWD/build/release "${pytest[@]}" tests/test_rooms.py tests/can tests/e2e; }
# A sanitizer build of the whole program meets hostile clients and mistakes, too.
e2e_asan() {
  SERVOHIL_BUILD=$PWD/build/asan "${pytest[@]}" tests/e2e/test_{bus,cli,control,lockstep,snapshot,injected_faults,safety,scenario,fault_can}.py
}
threads() { # unit tests, and what has clients
  for room in "${threaded[@]}"; do "build/tsan/bin/${room}_test" --gtest_brief=1; done
  SERVOHIL_BUILD=$PWD/build/tsan "${pytest[@]}" -k "not kill" tests/e2e/test_{bus,control,lockstep,recording,injected_faults,safety}.py
}
fuzzers() { tools/fuzz.sh -t 3; }
same_steps() { tests/e2e/lockstep_soak.py --runs 20 --disturb --programs build/release build/asan; }

# The real SocketCAN stack, in a guest whatever this kernel has: interfaces are made, removed and broken there. Its time
# is virtual: whatever else runs meanwhile, the result is the same. On the emulated controllers it is real, and nothing
# is judged by it.
on_vcan() {
  local guest=(tools/vcan-guest --timeout 600 --env "SERVOHIL_BUILD=$PWD/build/release" --env PYTHONDONTWRITEBYTECODE)
  "${guest[@]}" build/release/bin/socketcan_test --gtest_brief=1
  for file in bus bus_faults enable_trip injected_faults protection safety servohil_ci; do
    "${guest[@]}" --env SERVOHIL_BUS=socketcan -- "${pytest[@]}" "tests/e2e/test_$file.py"
  done
}
on_controllers() {
  local guest=(tools/vcan-guest --timeout 600 --env "SERVOHIL_BUILD=$PWD/build/release" --env PYTHONDONTWRITEBYTECODE)
  # shellcheck disable=SC2016  # expands in the guest
  "${guest[@]}" --controllers --env SERVOHIL_BUS=controllers -- \
    bash -c 'build/release/bin/controller_test --gtest_brief=1 && "$@"' - "${pytest[@]}" tests/e2e/test_can_controllers.py
}

# --- Running them: two at a time, for two processors: what computes beside what waits. ---

# stage NAME [NEEDED...]: the result goes to build/log/NAME.result: "passed 12", "FAILED 12", "not_run 0 (build_asan)".
stage() {
  local name=$1 begin=$SECONDS result=passed needed
  for needed in "${@:2}"; do
    grep -qs '^passed' "build/log/$needed.result" && continue
    echo "not_run 0 ($needed)" >"build/log/$name.result"
    echo "== $name: not run, for want of $needed"
    return
  done
  (set -e; "$name") >"build/log/$name.log" 2>&1 </dev/null &
  wait $! || result=FAILED
  echo "$result $((SECONDS - begin))" >"build/log/$name.result"
  echo "== $name: $result, $((SECONDS - begin)) s, $SECONDS s since the start"
  [ $result = passed ] || sed "s/^/$name: /" "build/log/$name.log" | tail -n 80
}

tests_that_wait() {
  stage unit_release build_release
  stage on_vcan build_release build_guests
  stage on_controllers build_release build_guests
  stage e2e_release build_release build_guests
  stage clang_tidy configure
}
builds_and_their_tests() {
  stage build_asan configure
  stage unit_asan build_asan
  stage e2e_asan build_asan
  stage build_tsan configure
  stage threads build_tsan
  stage same_steps build_release build_asan
  stage build_dev configure
  stage fuzzers configure
}

# Each side is a process group, to be ended as a whole.
declare -A sides
start() {
  set -m
  "$1" &
  set +m
  sides[$1]=$!
}
finish() {
  wait "${sides[$1]}" || true
  unset "sides[$1]"
}
end_all() { for group in "${sides[@]}"; do kill -- "-$group" 2>/dev/null || true; done; }
trap end_all EXIT

guests() { stage build_guests; }

stage lint
stage configure
start guests
stage build_release configure
finish guests
start tests_that_wait
start builds_and_their_tests
finish builds_and_their_tests
finish tests_that_wait

# --- What it came to: the worst of all stages; last, the lines of the test runners. ---
status=0
printf '\n%-16s %-8s %s\n' stage result seconds
for result in build/log/*.result; do
  read -r outcome seconds why <"$result"
  printf '%-16s %-8s %7d %s\n' "$(basename "$result" .result)" "${outcome/_/ }" "$seconds" "${why-}"
  [ "$outcome" = passed ] || status=1
done
printf '%-16s %-8s %7d\n\n' all "$([ $status = 0 ] && echo passed || echo FAILED)" "$SECONDS"
grep -hE '^[0-9]+% tests passed|^Total Test time' build/log/unit_release.log || true
tail -qn 1 build/log/{e2e_asan,threads,e2e_release}.log 2>/dev/null || true
exit $status
