#!/bin/bash
# deps.sh build|ci|demo|test|guest|controllers ...: installs the Debian packages that building, tests by servohil_ci,
# the demo, the tests, the CAN guest or the one with CAN controllers need. Does nothing when they are there.
set -euo pipefail

build=(g++ cmake ninja-build pkg-config libeigen3-dev libtomlplusplus-dev libcli11-dev libspdlog-dev libmnl-dev libsocketcan-dev
       nlohmann-json3-dev libhdf5-dev libsystemd-dev)
ci=("${build[@]}" python3-pytest python3-can python3-serial python3-canmatrix)
demo=("${build[@]}" python3-can python3-serial python3-canmatrix python3-matplotlib python3-numpy iproute2)
guest=(flex bison bc gcc make patch xz-utils libc6-dev iproute2)
controllers=(qemu-system-x86 cpio xz-utils gcc libc6-dev iproute2)
test=("${demo[@]}" "${guest[@]}" "${controllers[@]}" libgtest-dev libgmock-dev libbenchmark-dev librapidcheck-dev clang-format clang-tidy
      clang-tools python3-pytest python3-hypothesis python3-scipy python3-h5py python3-crcmod can-utils rt-tests stress-ng shellcheck git
      clang libclang-rt-14-dev systemd ccache)

[ $# -gt 0 ] || { echo "usage: tools/deps.sh build|ci|demo|test|guest|controllers ..." >&2; exit 2; }
wanted=()
for set in "$@"; do
  case $set in
    build) wanted+=("${build[@]}") ;;
    ci) wanted+=("${ci[@]}") ;;
    demo) wanted+=("${demo[@]}") ;;
    test) wanted+=("${test[@]}") ;;
    guest) wanted+=("${guest[@]}") ;;
    controllers) wanted+=("${controllers[@]}") ;;
    *) echo "deps.sh: '$set' is none of build, ci, demo, test, guest, controllers" >&2; exit 2 ;;
  esac
done

missing=()
for package in $(printf '%s\n' "${wanted[@]}" | sort -u); do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || { echo "deps.sh: all packages for '$*' are installed"; exit 0; }

echo "deps.sh: installing ${missing[*]}"
sudo=()
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "deps.sh: run as root, or install sudo, to install: ${missing[*]}" >&2; exit 3; }
  sudo=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
"${sudo[@]}" apt-get update -q
"${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}"
