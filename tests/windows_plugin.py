"""Keeps pytest, on Windows or under Wine, from tests that cannot run there.

``./dev windows python`` runs ``tests/python`` with it.
"""

from __future__ import annotations

from pathlib import Path

import pytest

_FORK = "is about fork, Unix's signals or pipes"
_LINUX = "is about Linux's own files and drivers"
_PATHS = "opens a file of Linux by its path"
_TREE = "is about a package that pip has installed from a tree, not as a wheel"
# Modules that cannot be imported there, or have no test that could run.
FILES = {
    "test_dial_descriptor.py": "reads descriptors with hid-tools, which is for Linux",
    "test_disk_full.py": "limits the size of files as Unix does",
    "test_game_descriptor.py": "reads descriptors with hid-tools, which is for Linux",
    "test_game_hosts.py": _LINUX,
    "test_torque_off.py": "limits the size of files, and sends signals, as Unix does",
    "test_virtual_knob.py": "the virtual USB knob is a program for Linux",
}
# The others, by name, without parameters.
TESTS = {
    "test_a_thousand_knobs_in_reference_cycles_stay_small": _LINUX,
    "test_a_thousand_open_knobs_touch_little_memory": _LINUX,
    "test_child_that_an_event_callback_forks_ends": _FORK,
    "test_command_without_its_extra_says_how_to_install_it": _TREE,
    "test_demo_without_matplotlib_measures_and_says_how_to_get_its_picture": _TREE,
    "test_disk_that_is_full_is_told": _LINUX,
    "test_every_message_of_every_topic_is_as_its_schema_says": "node, of Linux, reads it too",
    "test_file_that_is_no_hid_device_is_found_out_by_opening_it": _LINUX,
    "test_file_that_is_not_a_hid_device_is_refused_by_name": _PATHS,
    "test_file_whose_name_is_no_text_is_told": "Windows keeps names as text",
    "test_forked_child_goes_on_with_the_same_knobs": _FORK,
    "test_forked_child_with_an_open_knob_ends_and_may_open_its_own": _FORK,
    "test_interrupt_ends_a_waiting_iteration_at_once": _FORK,
    "test_interrupt_ends_call_at_once": _FORK,
    "test_interrupt_ends_the_wait": _FORK,
    "test_interrupt_is_heard_within_a_step_of_knobs_that_take_long": _FORK,
    "test_interrupt_in_an_event_callback_goes_on_to_the_program": _FORK,
    "test_interrupted_recording_has_its_samples": _FORK,
    "test_knob_in_sysfs_is_found_with_port_serial_driver_and_file": _LINUX,
    "test_knob_that_another_driver_holds_is_a_problem": _LINUX,
    "test_library_needs_numpy_alone": "what mends Wine is a module too",
    "test_line_that_installs_an_extra_names_the_tree_that_the_package_came_from": _TREE,
    "test_link_to_a_file_that_is_not_a_hid_device_is_refused_by_name": _PATHS,
    "test_missing_file_in_a_container_is_a_problem": _LINUX,
    "test_signal_ends_a_program_at_once": _FORK,
    "test_stream_has_the_wall_and_the_distances_of_the_device": "its library is not fetched",
    "test_what_cannot_be_read_is_told_with_its_reason": "takes rights away as Unix does",
    "test_two_drives_are_not_guessed_between": _LINUX,
    "test_who_has_neither_name_nor_folder_is_impersonal_as_they_are": "has Unix's list of users",
}
PARAMETERS = {
    "test_example_runs[stream_to_lsl]": "its library is not fetched",
    "test_place_that_cannot_be_written_is_named_before_the_visit[arguments3]": _PATHS,
}


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Leave out whole modules."""
    return True if collection_path.name in FILES else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out single tests."""
    out = [
        item
        for item in items
        if getattr(item, "originalname", "") in TESTS or item.name in PARAMETERS
    ]
    config.hook.pytest_deselected(items=out)
    items[:] = [item for item in items if item not in out]
