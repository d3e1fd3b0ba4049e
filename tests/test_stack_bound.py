"""The stack's bound, on listings written by hand and counted by hand."""

from __future__ import annotations

import pytest

from tools.stack_bound import Function, UnknownStack, bound, depth_bytes, read_listing, resolve

# root: 5 registers and 40 bytes; calls leaf (8 + 8 + 16 of d8 and d9) and, by a jump, large.
LISTING = """
20000000 <root>:
20000000:	push	{r4, r5, r6, r7, lr}
20000002:	sub	sp, #40	@ 0x28
20000004:	bl	20000020 <leaf>
20000008:	beq.n	20000004 <root+0x4>
2000000a:	add	sp, #40	@ 0x28
2000000c:	b.w	20000040 <large>

20000020 <leaf>:
20000020:	str.w	lr, [sp, #-8]!
20000024:	stmdb	sp!, {r4, fp}
20000026:	vpush	{d8-d9}
20000028:	ldr	r3, [sp, #4]
20000029:	ldmia.w	sp, {r0, r1, r2}
2000002a:	ldr.w	pc, [sp], #8

20000040 <large>:
20000040:	push	{r4, lr}
20000042:	ldr	r4, [pc, #8]	@ (2000004c <large+0xc>)
20000044:	add	sp, r4
20000046:	bx	lr
20000048:	nop
2000004c:	.word	0xfffffc00
"""
LEAF = 8 + 8 + 16
LARGE = 8 + 1024


def test_depth_is_the_sum_of_the_frames_along_the_deepest_path() -> None:
    functions = read_listing(LISTING)
    assert {name: function.frame_bytes for name, function in functions.items()} == {
        "root": 20 + 40,
        "leaf": LEAF,
        "large": LARGE,
    }
    assert depth_bytes(functions, "root") == (20 + 40 + LARGE, ["root", "large"])


def test_bound_adds_every_interrupt_and_what_the_processor_pushes() -> None:
    def empty(address: str, name: str) -> str:
        return f"{address} <{name}>:\n{address}:\tpush\t{{r4, lr}}\n\n"

    handlers = ("_ZN7on_tickEv", "dcd_rp2040_irq")
    listing = LISTING.replace("<root>:", "<main>:").replace("<root+", "<main+")
    listing += "".join(empty(f"2000010{n}", name) for n, name in enumerate(handlers))
    listing += empty("20000200", "runtime_init")
    deepest = bound(listing, frozenset(), "rp2040", 4096)
    assert deepest.main_bytes == 60 + LARGE
    assert deepest.interrupt_bytes == 2 * (8 + 36 + 8)
    assert deepest.path == ["main", "large"]


def resolve_and_measure(functions: dict[str, Function]) -> None:
    resolve(functions)
    depth_bytes(functions, "root")


@pytest.mark.parametrize(
    ("code", "complaint"),
    [
        ("blx\tr3", "call through a pointer in leaf"),
        ("bx\tr2", "call through a pointer in leaf"),
        ("bl\t20000000 <root>", "recursion: root -> leaf -> root"),
        ("mov\tsp, r7", "leaf: mov sp, r7"),
        ("sub.w\tsp, sp, r3", "leaf: sub.w sp, sp, r3"),
        ("add\tsp, r5", "leaf: sp changed by an unknown amount"),
        ("msr\tMSP, r1", "leaf: msr MSP, r1"),
    ],
)
def test_what_the_code_does_not_tell_is_an_error(code: str, complaint: str) -> None:
    functions = read_listing(LISTING.replace("ldr\tr3, [sp, #4]", code))
    with pytest.raises(UnknownStack, match=complaint):
        resolve_and_measure(functions)


def test_a_declared_target_that_is_gone_is_an_error() -> None:
    listing = LISTING.replace("<leaf>", "<tud_task_ext>").replace("ldr\tr3, [sp, #4]", "blx\tr3")
    with pytest.raises(UnknownStack, match="tud_task_ext should call"):
        resolve(read_listing(listing))
