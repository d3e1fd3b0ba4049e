"""Linux for `torsio doctor`: whether the kernel sees a knob, and who may open it."""

from __future__ import annotations

import importlib.resources
import shlex

from torsio.apps.doctor.facts import PRODUCT_ID, RULE, VENDOR_ID, Permission, UsbKnob
from torsio.apps.doctor.findings import Finding

__all__ = ["check_driver", "check_permission", "check_usb", "install_rule_line"]


def install_rule_line() -> str:
    """Give the line that installs the udev rule that this package brings."""
    rule = importlib.resources.files("torsio").joinpath(RULE)
    return (
        f"sudo install -m 644 {shlex.quote(str(rule))} /etc/udev/rules.d/ && "
        "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=hidraw"
    )


def check_usb(knobs: list[UsbKnob]) -> Finding:
    """Look for a knob on the USB."""
    if knobs:
        where = ", ".join(f"port {knob.port}, serial number {knob.serial}" for knob in knobs)
        return Finding("usb", True, f"the kernel sees {where}")
    return Finding(
        "usb",
        False,
        "the kernel sees no Torsio knob on the USB",
        "plug it in. If it is, try another port, and a cable that carries data. Look for it in "
        f"`lsusb -d {VENDOR_ID}:{PRODUCT_ID}`",
    )


def check_driver(knob: UsbKnob) -> Finding:
    """See whether the kernel has made a device of it that programs can open."""
    node = knob.node
    if node is not None and node.exists:
        return Finding("driver", True, f"{knob.driver or 'the kernel'} made {node.path}")
    if node is not None:
        return Finding(
            "driver",
            False,
            f"the kernel has {node.path}, but here is no such file",
            "in a container, pass the device in (docker run --device or -v /dev:/dev); else udev "
            "or devtmpfs does not run",
        )
    if knob.driver in ("", "usbhid", "hid-generic"):
        return Finding(
            "driver",
            False,
            "no driver has taken the knob" if not knob.driver else "the kernel made no hidraw file",
            "run `sudo modprobe -a usbhid hid-generic` and plug the knob in again; a kernel for "
            "clouds or containers may lack USB (CONFIG_USB_HID, CONFIG_HIDRAW)",
        )
    return Finding(
        "driver",
        False,
        f"the driver {knob.driver} has taken the knob, so it has no hidraw file",
        f"end the program that holds it through {knob.driver}, or pass it back from a virtual "
        "machine, and plug the knob in again",
    )


def check_permission(knob: UsbKnob, permission: Permission) -> Finding:
    """See whether this user may open it, and not everybody."""
    node = knob.node
    assert node is not None
    values = {"path": node.path, "mode": f"{node.mode:04o}", "rule": permission.rule}
    if node.mode & 0o002:
        return Finding(
            "permission",
            False,
            f"everybody on this machine may move the knob: {node.path} has mode {node.mode:04o}",
            "some udev rule says MODE=0666 for it: `grep -r hidraw /etc/udev/rules.d` finds it; "
            "Torsio's own rule needs no such thing",
            values,
        )
    if node.usable:
        return Finding("permission", True, f"you may open {node.path}", values=values)
    text = f"you may not open {node.path}"
    if not permission.rule:
        text += ": Torsio's udev rule is not installed"
        advice = f"run `./dev udev` in the source tree, or: {install_rule_line()}"
    elif not permission.udev_runs:
        text += ": udev does not run, so its rules do nothing"
        advice = "in a container, give the file to your user on the host; else start udev"
    elif permission.remote:
        text += ": the rule serves the user at the machine's own screen, and you came over ssh"
        advice = (
            "use the machine's own screen, or give yourself this file until it is unplugged: "
            f"sudo setfacl -m u:$USER:rw {node.path}"
        )
    else:
        text += f", although {permission.rule} is installed: udev has not applied it"
        advice = (
            "run `sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=hidraw`, "
            "or plug the knob in again; it serves the session at the screen (see `loginctl`)"
        )
    return Finding("permission", False, text, advice, values)
