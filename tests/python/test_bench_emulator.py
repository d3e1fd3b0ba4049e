"""The emulator's benchmark prints what it promises. No bound on time: the machine may be busy."""

from __future__ import annotations

from tests.python.bench_lines import bench_lines

PARTS = {"plant", "control", "protocol", "encoder", "clock_cable_and_host"}
#: what is in the plant: numbers that it then carries from step to step
STATES = {
    "without_spring_and_brake": 3,
    "basis": 6,
    "brake_hysteresis": 7,
    "shaft_hardening": 6,
    "cogging": 6,
    "belt": 8,
    "all_parts": 9,
}


def test_bench_emulator_prints_a_line_per_rate_and_plant() -> None:
    lines = bench_lines("emulator", "--seconds", "0.2", "--repeats", "1")
    assert {line["benchmark"] for line in lines} == {"emulator"}
    first_runs = [line for line in lines if line["what"] == "first_run"]
    assert {line["parts"] for line in first_runs} <= STATES.keys()
    assert len(first_runs) == 4
    lines = [line for line in lines if line not in first_runs]
    assert {line["control_rate_hz"] for line in lines} == {1000, 10_000}
    for rate_hz in (1000, 10_000):
        of_rate = [line for line in lines if line["control_rate_hz"] == rate_hz]
        assert all(line["ns_per_tick"] > 0 for line in of_rate)
        (device,) = (line for line in of_rate if line["what"] == "device")
        assert device["realtime_factor"] > 0
        assert set(device["ns_per_tick_by_part"]) == PARTS
        assert device["ns_per_tick_of_plant_and_law_in_a_loop"] > 0
        plants = {line["parts"]: line for line in of_rate if line["what"] == "plant"}
        assert {name: line["states"] for name, line in plants.items()} == STATES
        assert plants["all_parts"]["saved_of_all_parts"] == 0.0
