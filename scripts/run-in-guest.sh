#!/usr/bin/env bash
# Runs a program as root on a real Debian kernel in a throw-away virtual machine, where it may make input devices.
#
#   scripts/run-in-guest.sh [--udev] [--without MODULE] [--share DIR] [--timeout S] PROGRAM [ARGUMENT...]
#   scripts/run-in-guest.sh --prepare          fetches what is needed, and checks that it is there
#
#   --udev            udev runs in the guest: device nodes get their rules, gamepad libraries their events
#   --without MODULE  that kernel module (uinput, evdev, joydev) is there, but not loaded
#   --share DIR       what the program writes under DIR stays; without it, nothing does
#   --timeout S       gives up after S seconds (120)
#
# The guest sees this machine's files as they are, and of its settings the path, the language and whatever concerns tests and
# gamepads. What it writes to files stays in its own memory. Its standard output and error come out here, apart; its exit
# code is that of the script. 125: there was no guest (the kernel's last words are printed), 124: time was up.
#
# Needs busybox-static, cpio, kmod and xz-utils. The kernel, udev and qemu are fetched from Debian's archive and unpacked
# into ${GELPAD_GUEST:-~/.cache/gelpad/guest}, once (90 MB): none of them is installed.
set -euo pipefail

MODULES=(virtio_pci virtio_console 9pnet_virtio 9p overlay uinput evdev joydev)
cache=${GELPAD_GUEST:-${XDG_CACHE_HOME:-$HOME/.cache}/gelpad/guest}
udev= without= share= seconds=120 prepare=

usage() { sed -n '2,/^set/s/^# \{0,1\}//p' "$0"; }
fail() {
  echo "run-in-guest: $*" >&2
  exit 125
}

while [ $# -gt 0 ]; do
  case $1 in
    --udev) udev=1 ;;
    --without) without=${2:?a module}; shift ;;
    --share) share=$(realpath "${2:?a folder}"); shift ;;
    --timeout) seconds=${2:?seconds}; shift ;;
    --prepare) prepare=1 ;;
    --help) usage; exit 0 ;;
    -*) usage >&2; exit 2 ;;
    *) break ;;
  esac
  shift
done
[ $# -gt 0 ] || [ -n "$prepare" ] || { usage >&2; exit 2; }

# Downloads packages and unpacks them all into one folder, whole or not at all.
unpack_into() {
  local folder=$1 fresh=$1.fresh; shift
  rm -rf "$fresh"; mkdir -p "$fresh/packages"
  # apt drops its privileges: the folder must be open to it.
  (cd "$fresh/packages" && apt-get -qq -o APT::Sandbox::User=root download "$@" >&2) ||
    fail "no package $* in the archive: run apt-get update"
  local package
  for package in "$fresh"/packages/*.deb; do dpkg-deb -x "$package" "$fresh"; done
  rm -rf "$fresh/packages"
  mv "$fresh" "$folder"
}

# The kernel as the boot loader wants it least packed: qemu starts an ELF image at once, a compressed one in seconds.
unpack_kernel() {
  local image
  image=$(apt-cache show linux-image-amd64 | sed -n 's/^Depends: \(linux-image-[^ ,]*\).*/\1/p' | head -n 1)
  [ -n "$image" ] || fail "no package linux-image-amd64 in the archive: run apt-get update"
  unpack_into "$cache/kernel" "$image"
  local packed at
  packed=$(echo "$cache"/kernel/boot/vmlinuz-*)
  at=$(LC_ALL=C grep -a -b -o -m 1 -P '\xFD7zXZ\x00' "$packed" | head -n 1 | cut -d : -f 1) || fail "$packed holds no xz"
  # What follows the compressed kernel is none of xz's business, and it says so.
  { tail -c "+$((at + 1))" "$packed" | xz -dc 2>/dev/null || true; } >"$cache/vmlinux.fresh"
  keep_modules
  mv "$cache/vmlinux.fresh" "$cache/vmlinux"
}

# The few modules that are loaded, and what they stand on; the other 300 MB go.
keep_modules() {
  local root=$cache/kernel release name
  release=$(ls "$root/lib/modules")
  depmod -b "$root" "$release"
  for name in "${MODULES[@]}"; do modprobe -d "$root" -S "$release" --show-depends "$name"; done |
    awk '$1 == "insmod" { print $2 }' | sort -u >"$root/kept"
  find "$root/lib/modules" -name '*.ko' | sort | comm -23 - "$root/kept" | xargs rm
  depmod -b "$root" "$release" 2>/dev/null
  rm -r "$root/usr" "$root"/boot/vmlinuz-*
  echo "${MODULES[*]}" >"$root/asked-for"
}

# qemu and whatever libraries it misses here. apt tells what it would install; that is unpacked instead.
unpack_qemu() {
  local packages
  mapfile -t packages < <(apt-get -s --no-install-recommends install qemu-system-x86 | awk '$1 == "Inst" { print $2 }')
  [ ${#packages[@]} -gt 0 ] || fail "no package qemu-system-x86 in the archive: run apt-get update"
  unpack_into "$cache/qemu" "${packages[@]}"
}

# The guest's first root: busybox, the modules, udev.
make_ramdisk() {
  local root=$cache/root
  rm -rf "$root"; mkdir -p "$root"/{bin,proc,sys,dev,host,ram,udev}
  cp "$(command -v busybox)" "$root/bin/busybox"
  cp -r "$cache/kernel/lib" "$root/lib"
  [ -x "$cache/udev/bin/udevadm" ] || unpack_into "$cache/udev" udev
  cp -r "$cache/udev/bin/udevadm" "$cache/udev/lib/udev/rules.d" "$root/udev/"
  guest_init >"$root/init"
  chmod +x "$root/init"
  (cd "$root" && find . | cpio --quiet -o -H newc) >"$cache/fresh.cpio"
  rm -r "$root"
  find "$cache" -name 'ramdisk-*.cpio' -mtime +1 -delete
  mv "$cache/fresh.cpio" "$ramdisk"
}

# The guest's first program. This machine's root lies below, read-only; a RAM disk above takes what is written.
guest_init() {
  cat <<'INIT'
#!/bin/busybox sh
/bin/busybox mkdir -p /sbin; /bin/busybox --install -s /bin
export PATH=/bin
mount -t proc proc /proc; mount -t sysfs sysfs /sys; mount -t devtmpfs devtmpfs /dev
option() { sed -n "s/.*guest\.$1=\([^ ]*\).*/\1/p" /proc/cmdline; }
for module in virtio_pci virtio_console 9pnet_virtio 9p overlay; do modprobe $module; done
exec 1>/dev/vport0p1 2>/dev/vport0p2
for module in uinput evdev joydev; do [ $module = "$(option without)" ] || modprobe $module; done

plan9=trans=virtio,version=9p2000.L,msize=262144
mkdir /below; mount -t 9p -o ro,cache=loose,$plan9 host /below
mount -t tmpfs ram /ram; mkdir /ram/upper /ram/work
mount -t overlay -o lowerdir=/below,upperdir=/ram/upper,workdir=/ram/work root /host
for folder in proc sys dev; do mount --move /$folder /host/$folder; done
mkdir -p /host/dev/pts /host/dev/shm /host/lib/modules
mount -t devpts devpts /host/dev/pts
for folder in dev/shm run tmp; do mount -t tmpfs -o mode=1777 ram /host/$folder; done
mount --bind /lib/modules /host/lib/modules
mkdir -p /host/run/guest; mount -t 9p -o $plan9 job /host/run/guest
. /host/run/guest/options
# A folder of the host's /tmp is hidden by the guest's own.
case $FOLDER in
  /tmp/* | /run/*) mkdir -p "/host$FOLDER"; mount --bind "/below$FOLDER" "/host$FOLDER" ;;
esac
[ -z "$SHARE" ] || { mkdir -p "/host$SHARE"; mount -t 9p -o cache=mmap,$plan9 share "/host$SHARE"; }
ip link set lo up
if [ -n "$UDEV" ]; then
  mkdir -p /host/run/udev
  [ -e /host/usr/bin/udevadm ] || cp /udev/udevadm /host/usr/bin/
  mkdir -p /host/usr/lib/udev/rules.d; cp /udev/rules.d/* /host/usr/lib/udev/rules.d/
  ln -s /usr/bin/udevadm /host/run/systemd-udevd
  # udev does nothing in what it takes for a container's root.
  export SYSTEMD_IGNORE_CHROOT=1
  chroot /host /run/systemd-udevd --daemon >/dev/null 2>&1
  chroot /host udevadm trigger --action=add -s input -s misc
  chroot /host udevadm settle
fi
chroot /host /bin/sh /run/guest/start </host/dev/null
echo $? >/host/run/guest/status
sync; reboot -f
INIT
}

mkdir -p "$cache"
for tool in busybox cpio depmod modprobe xz; do
  command -v "$tool" >/dev/null || fail "no $tool here: install busybox-static cpio kmod xz-utils"
done
exec 9>"$cache/lock"
flock 9
[ "$(cat "$cache/kernel/asked-for" 2>/dev/null)" = "${MODULES[*]}" ] || { rm -rf "$cache/kernel"; unpack_kernel; }
# One for each version of this script: two of them may run side by side.
ramdisk=$cache/ramdisk-$(cksum <"$0" | cut -d ' ' -f 1).cpio
[ -e "$ramdisk" ] || make_ramdisk
qemu=$(command -v qemu-system-x86_64 || true)
firmware=()
if [ -z "$qemu" ]; then
  [ -e "$cache/qemu" ] || unpack_qemu
  qemu=$cache/qemu/usr/bin/qemu-system-x86_64
  firmware=(-L "$cache/qemu/usr/share/qemu" -L "$cache/qemu/usr/share/seabios")
  export LD_LIBRARY_PATH=$cache/qemu/usr/lib/x86_64-linux-gnu:$cache/qemu/lib/x86_64-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
fi
flock -u 9
"$qemu" --version >/dev/null || fail "$qemu does not start"
[ -z "$prepare" ] || exit 0

job=$(mktemp -d)
trap 'rm -rf "$job"' EXIT
printf 'UDEV=%q\nSHARE=%q\nFOLDER=%q\n' "$udev" "$share" "$PWD" >"$job/options"
{
  printf 'cd %q 2>/dev/null\n' "$PWD"
  for name in $(compgen -e); do
    case $name in
      PATH | LANG | TERM | RUST_* | GELPAD_* | GILRS_* | SDL_* | QT_*) printf 'export %s=%q\n' "$name" "${!name}" ;;
    esac
  done
  printf 'export HOME=/root GELPAD_IN_GUEST=1 SYSTEMD_IGNORE_CHROOT=1\nexec'
  printf ' %q' "$@"
  echo
} >"$job/start"
mkfifo "$job/out" "$job/err"
cat "$job/out" & cat "$job/err" >&2 &

shares=(-virtfs local,path=/,mount_tag=host,security_model=none,multidevs=remap,readonly=on
  -virtfs "local,path=$job,mount_tag=job,security_model=none")
[ -z "$share" ] || shares+=(-virtfs "local,path=$share,mount_tag=share,security_model=none,multidevs=remap")
code=0
# A processor without AVX2: qemu 7.2 gets its gathers wrong. One processor: a second one only adds waiting.
timeout "$seconds" "$qemu" "${firmware[@]}" -accel tcg -M pc -cpu Nehalem,+rdrand -smp 1 -m 1024 \
  -nodefaults -no-user-config -display none -no-reboot -serial "file:$job/kernel.log" \
  -device virtio-serial-pci,max_ports=3 \
  -chardev "file,id=out,path=$job/out" -device virtserialport,chardev=out,nr=1 \
  -chardev "file,id=err,path=$job/err" -device virtserialport,chardev=err,nr=2 \
  "${shares[@]}" -kernel "$cache/vmlinux" -initrd "$ramdisk" \
  -append "console=ttyS0 quiet panic=-1 reboot=t tsc=reliable no_timer_check mitigations=off nokaslr cryptomgr.notests \
random.trust_cpu=on guest.without=${without:-none}" </dev/null >>"$job/qemu.log" 2>&1 || code=$?
# If the guest never started, these pipes have no reader.
exec 8<>"$job/out" 7<>"$job/err"; exec 8>&- 7>&-
wait
[ $code -ne 124 ] || { echo "run-in-guest: time was up after $seconds s" >&2; exit 124; }
[ -s "$job/status" ] || { cat "$job/qemu.log" >&2; tail -n 20 "$job/kernel.log" >&2; fail "the guest gave no answer"; }
exit "$(cat "$job/status")"
