#!/bin/busybox sh
# First process of the virtual machine: loads modules, mounts the host's files, runs the command
# that the host has put into the share, and ends the machine with the command's status.
export PATH=/bin
/bin/busybox --install -s /bin

# The device isa-debug-exit ends the machine; QEMU's own status is then 2 n + 1.
end() {
  sync
  printf %b "\\x$(printf %x "$1")" | dd of=/dev/port bs=1 seek=244 2>/dev/null
  poweroff -f
}

mount -t devtmpfs dev /dev
mount -t proc proc /proc
grep -q torsio.probe /proc/cmdline && end 0
mount -t sysfs sys /sys

echo "torsio: boot noise ends here" >/dev/kmsg
while read -r module; do
  insmod "/modules/$module.ko" || { echo "init: cannot load $module"; end 9; }
done </modules/order

nine_p=trans=virtio,version=9p2000.L,msize=262144
mount -t 9p -o "$nine_p,ro,cache=loose" root /lower || end 9
mount -t tmpfs tmpfs /upper
mkdir -p /upper/files /upper/work /upper/whole
# Everything may be written to, nothing reaches the host.
mount -t overlay -o lowerdir=/lower,upperdir=/upper/files,workdir=/upper/work overlay /root || end 9
mount --bind /root /upper/whole
mkdir -p /root/proc /root/sys /root/dev /root/tmp /root/run /root/torsio-share
mount --move /dev /root/dev
mount --move /sys /root/sys
mount -t proc proc /root/proc
mount -t debugfs debugfs /root/sys/kernel/debug
mount -t tmpfs -o mode=1777 tmpfs /root/tmp
mount -t tmpfs tmpfs /root/run
mkdir -p /root/dev/shm /root/dev/pts
mount -t tmpfs -o mode=1777 tmpfs /root/dev/shm
mount -t devpts devpts /root/dev/pts
ip link set lo up
mount -t 9p -o "$nine_p,cache=none" share /root/torsio-share || end 9
# Where the tree is in one of the folders that are new, it is put back.
IFS= read -r tree </root/torsio-share/tree
if [ ! -e "/root$tree" ]; then
  mkdir -p "/root$tree"
  mount --bind "/upper/whole$tree" "/root$tree" || end 9
fi

read -r uptime _ </proc/uptime
echo "init: the guest is up after $uptime s"
chroot /root /bin/sh /torsio-share/command
status=$?
dmesg -r >/root/torsio-share/dmesg
echo "init: the command ended with status $status"
umount /root/torsio-share
# Only whole bytes fit; what matters is whether it is 0.
[ "$status" -lt 100 ] || status=100
mount -t devtmpfs dev /dev
end "$status"
