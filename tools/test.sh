#!/bin/bash
# test.sh: installs what the tests need, builds, and runs all of them: format and lint, unit tests under the
# sanitizers, unit tests and whole-program tests of the release build, and the same client tests on a real SocketCAN
# stack (in a guest, and on vcan0 where this kernel has it; never skipped). Idempotent.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

say() { printf '\n== %s (%d s since the start)\n' "$1" "$SECONDS"; }

say "packages"
tools/deps.sh test

say "format and lint"
git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run -Werror
git ls-files | xargs -d '\n' grep -lE '^#!/bin/(ba)?sh' | xargs shellcheck
for preset in release asan tsan; do cmake --preset "$preset" >/dev/null; done
run-clang-tidy -quiet -p build/release -extra-arg=-Wno-unknown-warning-option "servohil_(model|linear|fault|rt|can)[.]dir/Unity/" >build/clang-tidy.log 2>&1 ||
  { grep -E 'warning:|error:' build/clang-tidy.log | sort -u; exit 1; }
grep -q servohil_model.dir build/clang-tidy.log || { echo "test.sh: clang-tidy has looked at nothing" >&2; exit 1; }

say "kernels of the CAN guests (built or downloaded once a machine)"
tools/vcan-guest --build
tools/vcan-guest --controllers --build

say "build"
cmake --build --preset release
cmake --build --preset asan --target model_test fault_test rt_test can_test configuration_test signal_map_test simulation_test recording_test emulator_test scenario_test run_test servohil
cmake --build --preset tsan --target rt_test can_test servohil

pytest=(/usr/bin/python3 -m pytest -q -p no:cacheprovider)
export PYTHONDONTWRITEBYTECODE=1 LSAN_OPTIONS=suppressions=$PWD/tests/lsan.supp:print_suppressions=0

# The real SocketCAN stack, in a guest whatever this kernel has: interfaces are made, removed and broken there. Its time
# is virtual: whatever else runs meanwhile, the result is the same. On the emulated controllers it is real, and nothing
# is judged by it.
on_vcan() {
  local guest=(tools/vcan-guest --timeout 600 --env "SERVOHIL_BUILD=$PWD/build/release" --env PYTHONDONTWRITEBYTECODE)
  "${guest[@]}" build/release/bin/socketcan_test --gtest_brief=1
  for file in bus bus_faults enable_trip injected_faults protection safety servohil_ci; do
    "${guest[@]}" --env SERVOHIL_BUS=socketcan -- "${pytest[@]}" "tests/e2e/test_$file.py"
  done
  # shellcheck disable=SC2016  # expands in the guest
  "${guest[@]}" --controllers --env SERVOHIL_BUS=controllers -- \
    bash -c 'build/release/bin/controller_test --gtest_brief=1 && "$@"' - "${pytest[@]}" tests/e2e/test_can_controllers.py
}

# The threads: unit tests, and what has clients.
with_thread_sanitizer() {
  for test in rt_test can_test; do "build/tsan/bin/$test" --gtest_brief=1; done
  SERVOHIL_BUILD=$PWD/build/tsan "${pytest[@]}" -k "not kill" tests/e2e/test_{bus,control,lockstep,recording,injected_faults,safety}.py
}

# Both beside what follows, which leaves half of two processors idle: each a process group, to be ended as a whole.
declare -A beside
start() {
  set -m
  (set -e; "$1") >"build/$1.log" 2>&1 &
  set +m
  beside[$1]=$!
}
finish() {
  local status=0
  wait "${beside[$1]}" || status=$?
  unset "beside[$1]"
  cat "build/$1.log"
  [ "$status" = 0 ] || exit "$status"
}
end_all() { for group in "${beside[@]}"; do kill -- "-$group" 2>/dev/null || true; done; }
trap end_all EXIT
start on_vcan
start with_thread_sanitizer

say "unit tests, address and undefined-behaviour sanitizer"
for test in {model,fault,rt,can,configuration,signal_map,simulation,recording,emulator,scenario,run}_test; do "build/asan/bin/$test" --gtest_brief=1; done

# A sanitizer build of the whole program meets hostile clients and mistakes, too.
say "whole program, address and undefined-behaviour sanitizer"
SERVOHIL_BUILD=$PWD/build/asan "${pytest[@]}" tests/e2e/test_{bus,cli,control,lockstep,snapshot,injected_faults,safety,scenario,fault_can}.py

say "threads under their sanitizer (since the unit tests began)"
finish with_thread_sanitizer

say "fuzzers, from their corpora"
tools/fuzz.sh -t 3

say "release and sanitizer build step alike"
tests/e2e/lockstep_soak.py --runs 20 --disturb --programs build/release build/asan

say "whole program on the real SocketCAN stack (since the unit tests began)"
finish on_vcan

say "unit tests, release build"
ctest --preset release

say "whole program, release build"
export SERVOHIL_BUILD=$PWD/build/release
"${pytest[@]}" tests/can tests/e2e
