#!/bin/bash
# container.sh INSTALLED COMMAND...: in the guest of tools/vcan-guest, starts systemd as the first process of a container
# whose files are this machine's with INSTALLED (a folder like /) laid over them and all writable; runs COMMAND under
# it, on its console, and ends with COMMAND's exit status.
set -euo pipefail
installed=$1 root=/run/container layer=/run/layer
shift

mkdir -p "$root" "$layer"
mount -t tmpfs tmpfs "$layer"
mkdir "$layer/upper" "$layer/work"
mount -t overlay overlay -o "lowerdir=/,upperdir=$layer/upper,workdir=$layer/work" "$root"
cp -a "$installed"/* "$root"
mount -t tmpfs tmpfs "$root/run" -o mode=755
mkdir -p "$root/run/systemd/system" "$root/run/tmpfiles.d"
ln -s /dev/null "$root/run/tmpfiles.d/tmp.conf" # /tmp is not emptied
printf '%q ' cd "$PWD" >"$root/run/command"
printf '\n' >>"$root/run/command"
printf '%q ' "$@" >>"$root/run/command"
cat >"$root/run/systemd/system/command.service" <<'TEXT'
[Unit]
After=systemd-journald.service
Requires=systemd-journald.service
DefaultDependencies=no
SuccessAction=exit
FailureAction=exit
[Service]
Type=oneshot
ExecStart=bash /run/command
StandardOutput=tty
StandardError=tty
TEXT

cat >"$root/run/first-process" <<TEXT
set -eu
cd $root
mount -t proc proc proc
mount -t sysfs sysfs sys
mount -t cgroup2 cgroup2 sys/fs/cgroup
mount --rbind /dev dev
mount --bind \$(tty) dev/console
mkdir run/before
pivot_root . run/before
umount --lazy run/before
exec /usr/bin/env -i container=guest PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
  /lib/systemd/systemd --unit=command.service --show-status=0 --log-target=journal
TEXT
exec script -qefc "unshare --pid --mount --uts --ipc --cgroup --fork bash $root/run/first-process" /dev/null
