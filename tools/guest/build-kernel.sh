#!/bin/bash
# build-kernel.sh VERSION DIR: builds DIR/linux, the guest kernel of tools/vcan-guest (user-mode Linux with CAN), from
# Debian's package linux-source-6.1 in that VERSION and the kernel.config and
# kernel.patch beside this script. DIR is the scratch folder
# (1.6 GB). Needs: flex bison bc gcc make patch xz-utils libc6-dev. No root. The same input gives the same kernel.
set -euo pipefail
version=$1 dir=$2
here=$(dirname "$(readlink -f "$0")")
config=$here/kernel.config
unset MAKEFLAGS MFLAGS MAKELEVEL CROSS_COMPILE # when called from within a make
cd "$dir"

apt-get -qq -o APT::Sandbox::User="$(id -un)" download "linux-source-6.1=$version"
mkdir src
dpkg-deb --fsys-tarfile linux-source-6.1_*.deb | tar -xO ./usr/src/linux-source-6.1.tar.xz |
  tar -xJ -C src --strip-components=1
rm linux-source-6.1_*.deb

cp "$here/host-xstate.h" src/arch/x86/um/os-Linux/
patch -s -p1 -d src --fuzz=0 --no-backup-if-mismatch <"$here/kernel.patch" ||
  { echo "build-kernel.sh: the source of $version looks different: mend tools/guest/kernel.patch" >&2; exit 1; }

make -s -C src ARCH=um KCONFIG_ALLCONFIG="$config" allnoconfig
grep '^CONFIG_' "$config" | while read -r option; do
  grep -qx "$option" src/.config || { echo "build-kernel.sh: $option did not take" >&2; exit 1; }
done
make -s -C src ARCH=um -j"$(nproc)" KBUILD_BUILD_TIMESTAMP=@0 KBUILD_BUILD_USER=servohil KBUILD_BUILD_HOST=guest linux
strip -s -o linux src/linux
rm -rf src
