from __future__ import annotations

import gc
import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

from stiffcal.trust import notices
from tests.laboratory import once
from tests.laboratory.database import database
from tests.laboratory.few_effects import few_effects
from tests.laboratory.offers_of_tests import _offers, _watched
from tests.laboratory.processor_time import (
    pytest_runtest_logreport,
    pytest_runtest_makereport,
    pytest_runtestloop,
    pytest_terminal_summary,
)
from tests.laboratory.s3 import bucket
from tests.laboratory.small_campaign import write_small_campaign

__all__ = [
    "_offers",
    "_watched",
    "bucket",
    "database",
    "pytest_runtest_logreport",
    "pytest_runtest_makereport",
    "pytest_runtestloop",
    "pytest_terminal_summary",
]  # fmt: skip

# Python's search for unused cycles goes through all objects that there are, here nine thousand tests and all libraries:
# a third of what collecting takes. Seldom is enough; what nothing refers to is freed without it.
gc.set_threshold(100_000)

# The same inputs each time: what is found at random belongs to `make fuzz`, and no change fails by luck.
hypothesis.settings.register_profile("the same inputs", derandomize=True, database=None, deadline=None)
hypothesis.settings.load_profile("the same inputs")

# A shell that starts the tests in the background has them ignore Ctrl-C, and every process that they start with them.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Folders and files whose tests judge numbers: they run under the kernels of several processors (`tests/kernels.py`).
# A kernel changes the last digits of products and factors. It can turn a rank, a sign, an order of candidates or a
# verdict, and numbers that must agree to rounding.
NUMERICAL = (
    "compensation", "contracts", "diagnosis/test_scoring.py", "effects", "estimation", "kinds", "identification",
    "independent", "links", "measurements", "mechanics", "mistakes", "planning", "reduction",
    "simulation",
    "validation", "commands/test_fingerprint.py",
)  # fmt: skip
# Of these, files in which it can turn nothing: means of many states with tolerances of the noise, faults of whole
# tables that stand out by orders of magnitude, compiled code, times, texts of the code, made and read logs.
NO_KERNEL = (
    "compensation/test_c_code.py", "compensation/test_st_code.py", "contracts/test_dropped_in.py",
    "contracts/test_estimation_alone.py",
    "contracts/test_opaque_texts.py", "contracts/test_readers.py", "contracts/test_sources.py", "effects/test_creep.py",
    "effects/test_motor_friction.py", "kinds/test_clamped_sigma.py", "kinds/test_friction.py",
    "identification/test_absolute_speed.py", "identification/test_exact_derivatives.py",
    "identification/test_overstated_noise.py", "mistakes/test_load_units.py", "mistakes/test_mirrored_axes.py",
    "mistakes/test_moved_base.py", "mistakes/test_other_rows.py", "mistakes/test_turned_sensor.py",
    "independent/test_friction_motion.py",
    "independent/test_practice_truth.py", "planning/test_efficiency.py", "reduction/test_clocks.py",
    "reduction/test_copied_logs.py", "reduction/test_rounded_copies.py",
    "mistakes/test_angle_conventions.py", "mistakes/test_kinematics.py", "reduction/test_holds.py",
    "mistakes/test_place_faults.py", "mistakes/test_place_faults_of_tables.py", "reduction/test_long_runs.py",
    "reduction/test_recordings.py", "reduction/test_registration.py", "simulation/test_schema.py",
    "simulation/test_simulate.py", "validation/test_practice_absolute.py",
)  # fmt: skip
# These run in an environment of their own, which holds the peer.
collect_ignore = ["benchmarks/figaroh"]
# Folders and files of `make test-long`: whole campaigns, and files that take five seconds of processor time or more for
# what a change rarely breaks. Elsewhere the tests and files that are marked themselves.
LONG = (
    "benchmarks", "compensation/test_c_code.py", "diagnosis/suspects/test_find.py",
    "diagnosis/test_few_poses.py", "diagnosis/test_model_settings.py", "diagnosis/test_moving_joints.py",
    "diagnosis/test_refit_values.py", "diagnosis/test_search.py",
    "kinds/test_clamped_sigma.py", "kinds/test_friction.py", "faults", "fuzz",
    "mistakes/test_moved_base.py", "live/test_command.py", "live/test_server.py", "live/test_watching.py",
    "next_steps", "planning/test_efficiency.py", "rates", "mistakes/test_kinematics.py",
    "mistakes/test_place_faults.py", "mistakes/test_place_faults_of_tables.py", "report/test_figures.py",
    "security/test_hostile_endpoints.py",
    "security/test_imports.py", "security/test_limits.py", "security/test_names.py", "security/test_plugin_ends.py",
    "security/test_readers.py", "security/test_remote_stores.py", "security/test_stored_shapes.py",
    "security/test_stores.py", "security/test_streams.py", "store/test_remote.py", "store/test_two_at_once.py",
    "test_wheel.py", "whole_campaigns", "commands/test_campaigns_of_one_robot.py",
    "propose/test_clamped_template.py", "commands/test_controller_export.py", "report/test_effect_pictures.py",
    "commands/test_fingerprint.py", "stages/test_followed.py", "ingest/test_formats.py",
    "commands/test_improve.py", "commands/plan/test_plan.py",
    "commands/plan/test_plan_absolute.py", "commands/plan/test_plan_program.py", "commands/plan/test_plan_rivals.py",
    "report/test_report_diagnosis.py", "judgement/test_suspects.py",
)  # fmt: skip

# Files and tests of `make practice`, which CI leaves out: each takes long, and what it holds is held by shorter ones of
# the suite as well. A test stands here by the beginning of its name.
PRACTICE = (
    "benchmarks/test_smoke.py::test_coverage_of_clamped_joints",
    "benchmarks/test_smoke.py::test_every_benchmark_runs[batch",
    "benchmarks/test_smoke.py::test_every_benchmark_runs[ingest",
    "calibration/stress/test_classes.py::test_a_class_is_judged",
    "compensation/test_c_code.py::test_prismatic",
    "compensation/test_c_code.py::test_states_each_by_itself[every_law]",
    "contracts/test_opaque_texts.py",
    "diagnosis/test_clamped_drives.py::test_a_law_of_one_drive",
    "diagnosis/test_clamped_drives.py::test_drives_with_springs_alone",
    "diagnosis/test_clamped_drives.py::test_laws_of_both_drives",
    "diagnosis/test_held_to_places.py::test_places_decide_whether_a_turned_tracker_is_named",
    "diagnosis/test_large_campaigns.py::test_a_diagnosis_is_the_same_when_signatures_are_not_kept",
    "diagnosis/test_model_settings.py",
    "diagnosis/test_moving_joints.py::test_an_effect_of_the_model",
    "diagnosis/test_moving_joints.py::test_of_many_rows",
    "diagnosis/test_moving_joints.py::test_one_effect_is_named_alone_and_certain[friction-",
    "diagnosis/test_moving_joints.py::test_one_effect_is_named_alone_and_certain[stribeck",
    "diagnosis/test_moving_joints.py::test_time_would_do",
    "diagnosis/test_moving_joints.py::test_two_effects",
    "diagnosis/test_moving_joints.py::test_where_the_model_has_no_friction",
    "diagnosis/test_noise_of_a_lab.py::test_a_stated_noise_too_small_is_said_and_a_structure_is_still_distinguished_from_it[True",
    "diagnosis/test_noise_of_a_lab.py::test_noise_that_lingers",
    "diagnosis/test_redundant.py",
    "diagnosis/test_refit_values.py",
    "diagnosis/test_rods.py",
    "diagnosis/test_same_within_noise.py::test_the_true_effect_is_listed",
    "diagnosis/test_search.py::test_a_hidden_effect_is_named",
    "diagnosis/test_search.py::test_an_effect_without_balance",
    "diagnosis/test_search.py::test_nothing_is_missing_where_nothing_is",
    "diagnosis/test_search.py::test_rotation_and_translation",
    "diagnosis/test_search.py::test_the_hidden_size",
    "diagnosis/test_search.py::test_what_the_model_has_and_does_not_need",
    "diagnosis/test_steep_laws.py",
    "diagnosis/test_tilts_and_links.py::test_springs_of_a_link",
    "diagnosis/test_tilts_and_links.py::test_tilts_across_a_link",
    "diagnosis/test_undecided.py::test_an_effect_that_has_less",
    "diagnosis/test_wrong_geometry.py",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/clamped-joints",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/drilling-and-milling",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/folder-of-logs",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/friction",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/into-the-controller",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/linear-axes",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/logs-of-instruments",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/many-campaigns",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/own-effect",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/plan-a-campaign",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/rehearse",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/rods",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/seven-joints",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/use-the-model",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[how-to/watch-a-robot-age",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[tutorials/absolute-poses",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[tutorials/missing-effect",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[tutorials/notebook",
    "docs/test_blocks.py::test_a_page_s_commands_print_what_it_shows[tutorials/report-and-view",
    "mistakes/test_moved_base.py::test_the_diagnosis",
    "ingest/test_run_readings.py::test_of_other_kinds_the_run_whose_log_was_edited_is_read_again[rehearsed-controller",
    "ingest/test_run_readings.py::test_of_other_kinds_the_run_whose_log_was_edited_is_read_again[rods",
    "judgement/test_checks.py::test_squares_that_are_expected",
    "judgement/test_curves.py::test_a_joint_whose_compliance_follows_another_joints_angle",
    "judgement/test_judge.py::test_a_force_sensor_that_was_zeroed_anew",
    "judgement/test_judge.py::test_a_run_in_another_unit",
    "judgement/test_judge.py::test_a_second_plugin_of_the_same_law",
    "judgement/test_judge.py::test_a_single_reading",
    "judgement/test_judge.py::test_an_effect_is_taken_back",
    "judgement/test_judge.py::test_two_runs",
    "judgement/test_kernels.py",
    "judgement/test_misjudged_campaigns.py",
    "judgement/test_other_states.py",
    "judgement/test_settings_off.py::test_a_parameter_that_is_held_at_a_wrong_value",
    "judgement/test_settings_off.py::test_a_parameter_that_is_held_at_its",
    "judgement/test_settings_off.py::test_a_tool",
    "judgement/test_settings_off.py::test_a_wrench_that_acts_on_the_deformed_robot",
    "judgement/test_tails.py::test_a_far_reading_of_noise_with_tails_is_no_step[18",
    "judgement/test_weight.py::test_no_effect",
    "judgement/test_whole_curves.py",
    "kinds/test_clamped_sigma.py::test_an_encoders_step",
    "kinds/test_clamped_sigma.py::test_correlated_noise",
    "kinds/test_clamped_sigma.py::test_filtered_noise",
    "kinds/test_clamped_sigma.py::test_white_noise",
    "kinds/test_friction.py::test_weight_does_not_matter",
    "live/test_models.py::test_a_written_model",
    "live/test_models.py::test_tried_models",
    "live/test_models.py::test_what_was_diagnosed_is",
    "live/test_watching.py::test_a_diagnosis_of_the_logs_before",
    "mistakes/test_angle_conventions.py::test_axes_that_are_not_parallel_counted_together[-1.0",
    "mistakes/test_angle_conventions.py::test_axes_that_are_not_parallel_counted_together[1.0-4",
    "mistakes/test_angle_conventions.py::test_axes_that_are_not_parallel_counted_together[1.0-5",
    "mistakes/test_angle_conventions.py::test_half_a_turn",
    "mistakes/test_angle_conventions.py::test_in_a_table_of_displacements[-1",
    "mistakes/test_angle_conventions.py::test_the_zero_of_a_joint_is_named_with_its_angle[-33",
    "mistakes/test_angle_conventions.py::test_the_zero_of_a_joint_is_named_with_its_angle[90",
    "mistakes/test_kinematics.py::test_the_one_change_that_fits_is_named[False]",
    "mistakes/test_place_faults_of_tables.py::test_a_wrong_sign_is_named_by_its_joint[05",
    "mistakes/test_place_faults_of_tables.py::test_a_zero_that_is_off_is_named_by_its_joint[05",
    "planning/test_efficiency.py",
    "python/test_improvement.py::test_the_steps_are_those_of_the_command",
    "rates/test_absolute_robots.py::test_without_the_hidden_effect",
    "rates/test_benches.py::test_an_effect_of_three_times_the_noise",
    "rates/test_rates.py::test_a_motor_that_is_pushed_off",
    "rates/test_rates.py::test_the_score_counts",
    "rates/test_rates.py::test_a_slip_is_found_where_it_was",
    "validation/test_elasticity.py::test_an_eccentricity_of_another_joint",
    "view/test_page.py::test_absolute_places_are_judged_states",
    "whole_campaigns/test_absolute_and_loads.py::test_nothing_is_missing",
    "whole_campaigns/test_absolute_places.py::test_drift_counts_from",
    "whole_campaigns/test_clamped_without_curve.py",
    "whole_campaigns/test_hidden.py::test_names_what_is_hidden",
    "whole_campaigns/test_hidden_robots.py",
    "whole_campaigns/test_insufficient_logs.py::test_readings_at_the_end",
    "whole_campaigns/test_ipa_ur10.py",
    "whole_campaigns/test_kr125.py::test_table_2_comes_back[1",
    "whole_campaigns/test_kr125.py::test_the_report_has_the_papers_pages",
    "whole_campaigns/test_kr125_bodies.py",
    "whole_campaigns/test_kr125_friction.py",
    "whole_campaigns/test_logs_of_a_lab.py::test_a_folder_of_other_programs_logs_gives_the_right_stiffnesses[camera",
    "whole_campaigns/test_logs_of_a_lab.py::test_a_folder_of_other_programs_logs_gives_the_right_stiffnesses[dates",
    "whole_campaigns/test_logs_of_a_lab.py::test_a_folder_of_other_programs_logs_gives_the_right_stiffnesses[document",
    "whole_campaigns/test_logs_of_a_lab.py::test_a_folder_of_other_programs_logs_gives_the_right_stiffnesses[key_lines",
    "whole_campaigns/test_logs_of_a_lab.py::test_a_folder_of_other_programs_logs_gives_the_right_stiffnesses[minutes",
    "whole_campaigns/test_logs_of_a_lab.py::test_a_folder_of_other_programs_logs_gives_the_right_stiffnesses[several",
    "whole_campaigns/test_logs_of_a_lab.py::test_a_folder_of_other_programs_logs_gives_the_right_stiffnesses[epoch",
    "whole_campaigns/test_files_of_labs.py::test_an_excel_sheet_and_text_saved_from_it[g",
    "whole_campaigns/test_files_of_labs.py::test_an_excel_sheet_and_text_saved_from_it[table_german",
    "whole_campaigns/test_files_of_labs.py::test_an_excel_sheet_and_text_saved_from_it[tr",
    "whole_campaigns/test_files_of_labs.py::test_an_excel_sheet_and_text_saved_from_it[u",
    "whole_campaigns/test_files_of_labs.py::test_the_zero_of_a_force_sensor",
    "whole_campaigns/test_files_of_labs.py::test_a_third_axis_that_is_counted_against_the_horizontal[table_m",
    "whole_campaigns/test_files_of_labs.py::test_a_lift_with_seven_joints",
    "whole_campaigns/test_max100.py::test_diagnosis_with_rods_and_without",
    "whole_campaigns/test_mixed.py::test_the_ladder_ends",
    "whole_campaigns/test_order_of_approach.py",
    "whole_campaigns/test_practice.py",
    "whole_campaigns/test_practice_absolute.py",
    "whole_campaigns/test_practice_joints.py",
    "commands/test_controller_export.py::test_a_complete_model",
    "commands/test_controller_export.py::test_the_path_of_paper_002",
    "stages/test_followed.py",
    "commands/test_improve.py::test_another_effect",
    "commands/test_improve.py::test_each_step",
    "commands/test_improve.py::test_what_a_user",
    "commands/test_improve_pages.py",
    "commands/plan/test_plan.py::test_a_plan_for_a",
    "commands/plan/test_plan.py::test_check_reads",
    "commands/plan/test_plan_absolute.py::test_payloads_show",
    "commands/plan/test_plan_rivals.py::test_more_runs",
    "judgement/test_suspects.py",
    "commands/test_trend.py::test_a_change_of_the_set_up",
    "diagnosis/test_geometry_nuisance.py",
    "diagnosis/test_large_campaigns.py",
    "diagnosis/test_tilts_and_links.py",
    "whole_campaigns/test_moved_tracker.py",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that judge numbers, and those that take long, where they do not do so themselves."""
    here = Path(__file__).parent
    marks: dict[Path, list[pytest.MarkDecorator]] = {}
    for item in items:
        if item.path not in marks:
            marks[item.path] = _marks_of_file(item.path.relative_to(here)) if here in item.path.parents else []
        for mark in marks[item.path]:
            item.add_marker(mark)
        if item.nodeid.removeprefix("tests/").startswith(PRACTICE):
            item.add_marker(pytest.mark.practice)
        if "practice" in item.keywords:
            item.add_marker(pytest.mark.long)
    # Files with tests that take long come first: the last ones of a session are short, and no process waits for long.
    first = {item.path for item in items if "long" in item.keywords or "docs" in item.keywords}
    items.sort(key=lambda item: item.path not in first)


def _marks_of_file(file: Path) -> list[pytest.MarkDecorator]:
    """Return the marks of all tests of a file, which is relative to this folder."""
    name = file.as_posix()
    above = {name, *(parent.as_posix() for parent in file.parents)}
    numerical = not above.isdisjoint(NUMERICAL) and name not in NO_KERNEL
    return [pytest.mark.numerical] * numerical + [pytest.mark.long] * (not above.isdisjoint(LONG))


@pytest.fixture(scope="session", autouse=True)
def _own_state(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep what stiffcal remembers of its user (what they trust, what they wrote) out of the tester's home.

    All processes of a session share it: a store that one has written is the user's own to the others.
    """
    before = {name: os.environ.get(name) for name in ("STIFFCAL_STATE", "XDG_STATE_HOME", "LOCALAPPDATA", once.PLACE)}
    base = tmp_path_factory.getbasetemp()
    session = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    for folder in ("state", "made-once"):
        (session / folder).mkdir(exist_ok=True)
    os.environ.update(dict.fromkeys(before, str(session / "state")))
    os.environ[once.PLACE] = str(session / "made-once")
    yield
    for name, value in before.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


@pytest.fixture(scope="module")
def few_known_effects() -> Iterator[None]:
    """For a module that does not ask which effect is found: a short catalogue."""
    with few_effects():
        yield


@pytest.fixture(scope="session")
def validated_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign that is ingested, identified and validated; not to be changed."""
    from stiffcal.commands.validate import validate_campaign

    folder = write_small_campaign(tmp_path_factory.mktemp("campaigns") / "small")
    validate_campaign(folder)
    return folder


@pytest.fixture
def campaign(validated_folder: Path, tmp_path: Path) -> Path:
    """A copy of it that a test may change."""
    return Path(shutil.copytree(validated_folder, tmp_path / "small", symlinks=True))


@pytest.fixture
def state(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty state folder of this test alone; every notice is given anew."""
    folder = tmp_path_factory.mktemp("state") / "stiffcal"
    monkeypatch.setenv("STIFFCAL_STATE", str(folder))
    monkeypatch.delenv("STIFFCAL_TRUST", raising=False)
    monkeypatch.setattr(notices, "_given", set())
    return folder
