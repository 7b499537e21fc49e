#!/bin/bash
# test.sh: installs what the tests need, builds, and runs all of them: format and lint, unit tests under the
# sanitizers, unit tests and whole-program tests of the release build, and the same client tests on a real SocketCAN
# stack (vcan0 of this kernel where it has CAN, else in a guest; never skipped). Idempotent.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

say() { printf '\n== %s (%d s since the start)\n' "$1" "$SECONDS"; }

say "packages"
tools/deps.sh test

say "format and lint"
git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run -Werror
git ls-files | xargs -d '\n' grep -lE '^#!/bin/(ba)?sh' | xargs shellcheck
for preset in release asan tsan; do cmake --preset "$preset" >/dev/null; done
run-clang-tidy -quiet -p build/release -extra-arg=-Wno-unknown-warning-option "$PWD/src/(model|fault|rt|can)/.*\.cpp" >build/clang-tidy.log 2>&1 ||
  { grep -E 'warning:|error:' build/clang-tidy.log | sort -u; exit 1; }

say "the CAN guest's kernel (built once a machine)"
tools/vcan-guest --build

say "build"
cmake --build --preset release
cmake --build --preset asan --target model_test fault_test rt_test can_test app_test servohil
cmake --build --preset tsan --target rt_test can_test servohil

say "unit tests under sanitizers"
export LSAN_OPTIONS=suppressions=$PWD/tests/lsan.supp:print_suppressions=0
for test in model_test fault_test rt_test can_test app_test; do "build/asan/bin/$test" --gtest_brief=1; done
for test in rt_test can_test; do "build/tsan/bin/$test" --gtest_brief=1; done

# A sanitizer build of the whole program meets hostile clients and mistakes, too.
say "whole program under sanitizers"
pytest=(/usr/bin/python3 -m pytest -q -p no:cacheprovider)
export PYTHONDONTWRITEBYTECODE=1
SERVOHIL_BUILD=$PWD/build/asan "${pytest[@]}" tests/e2e/test_{bus,cli,control,lockstep,snapshot,injected_faults,safety,scenario,fault_can}.py
SERVOHIL_BUILD=$PWD/build/tsan "${pytest[@]}" -k "not kill" tests/e2e/test_{bus,control,lockstep,recording,injected_faults,safety}.py

say "fuzzers, from their corpora"
tools/fuzz.sh -t 3

say "release and sanitizer build step alike"
tests/e2e/lockstep_soak.py --runs 20 --disturb --programs build/release build/asan

say "unit tests, release build"
ctest --preset release

say "whole program on the real SocketCAN stack"
export SERVOHIL_BUILD=$PWD/build/release
if ip link show vcan0 >/dev/null 2>&1; then
  build/release/bin/socketcan_test
  SERVOHIL_BUS=socketcan "${pytest[@]}" tests/e2e/test_{bus,servohil_ci,injected_faults}.py
else
  tools/vcan-guest --timeout 300 build/release/bin/socketcan_test
  for file in test_bus test_servohil_ci test_injected_faults; do
    tools/vcan-guest --timeout 600 --env SERVOHIL_BUS=socketcan --env SERVOHIL_BUILD --env PYTHONDONTWRITEBYTECODE \
      -- "${pytest[@]}" "tests/e2e/$file.py"
  done
fi

# Interfaces are made, removed and broken: in a guest, whatever this kernel has.
say "bus faults on the real SocketCAN stack"
tools/vcan-guest --timeout 300 --env SERVOHIL_BUS=socketcan --env SERVOHIL_BUILD --env PYTHONDONTWRITEBYTECODE \
  -- "${pytest[@]}" tests/e2e/test_bus_faults.py

say "whole program, release build"
"${pytest[@]}" tests/can tests/e2e
