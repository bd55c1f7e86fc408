"""Make a campaign folder: a commented one to fill in, or one proposed from a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from stiffcal.campaign.toml.reach import check_given
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.at_rest import at_rest
from stiffcal.propose.chosen_urdf import chosen_urdf, is_urdf_or_package
from stiffcal.propose.explained import unused_in_words
from stiffcal.propose.from_logs import KINDS_OF_LOGS
from stiffcal.propose.from_table import Proposal
from stiffcal.propose.lines import Question
from stiffcal.propose.log_devices import files_in
from stiffcal.results.command_results import InitResult

OF_TABLES = ("load", "absolute")
"""Kinds of campaign that a table of states gives."""


def init_campaign(
    folder: Path,
    kind: str | None = None,
    tables: Sequence[Path] = (),
    urdf: Path | None = None,
    robot: str | None = None,
    tool: Sequence[float] | None = None,
    *,
    ask: Callable[[Question], str] | None = None,
    overwrite: bool = False,
) -> InitResult:
    """Write a campaign folder.

    Parameters
    ----------
    folder : where; it must not hold a campaign yet.
    kind : of the template: a commented folder of that kind. None without a table: "load". With tables: "load",
        "absolute" (which of the two the table's columns show), "clamped" or "friction".
    tables : propose the campaign from the headers and values of one table, or of several of equal length (angles in
        one, forces in another), instead; for clamped and friction runs from their logs, one run each. Or one folder of
        logs.
    urdf, robot : the robot as URDF (a file, or the folder of its package), or the name of a bundled one, a robot file
        (*.toml) or what `urdf` takes, not both; of templates that of "load" alone takes one.
    tool : with a table: where the load acts and the displacement is measured, m, in the flange frame.
    ask : called with what no log or table states, returns the answer or "".
    overwrite : also over files that are there.

    Returns
    -------
    InitResult
        What was written, and the lines of campaign.toml to look at.

    Raises
    ------
    InputError : the options do not go together, or the folder holds a campaign already.
    """
    folder = Path(folder)
    of_logs = bool(tables) and kind in KINDS_OF_LOGS
    _check_options(kind, tables, urdf, robot, tool)
    if urdf is not None:
        urdf = chosen_urdf(urdf)
    elif robot is not None and is_urdf_or_package(str(robot)):
        urdf, robot = chosen_urdf(Path(robot), "--robot"), None
    if not tables and tool is None and kind in (None, "load") and (urdf is not None or robot is not None):
        from stiffcal.propose.of_robot import write_for_robot

        made = write_for_robot(folder, urdf=urdf, robot=robot, overwrite=overwrite)
        return InitResult(warnings=[], files=[str(file) for file in made], guessed=[])
    only_with_table = {"--urdf": urdf, "--robot": robot, "--tool": tool}
    option = next((name for name, given in only_with_table.items() if given is not None), None)
    if not tables and option is not None:
        raise InputError.at(
            FaultCode.OPTION_CONFLICT,
            "command line",
            option,
            "this option requires --from",
            "give --from TABLE.csv too",
        )
    columns, to_write = None, None
    if any(Path(table).is_dir() for table in tables):
        if len(tables) > 1:
            raise InputError.at(
                FaultCode.OPTION_CONFLICT,
                "command line",
                "--from",
                "a folder and further tables are given",
                "put all logs into the folder",
            )
        inside = [Path(tables[0]) / file for file in files_in(Path(tables[0]))]
        if not of_logs and not _is_one_table(inside, urdf, robot):
            return _from_folder(folder, Path(tables[0]), urdf, robot, tool, ask=ask, overwrite=overwrite)
        tables = inside
    if not tables:
        from stiffcal.propose.templates import write_template

        written, guessed, unused = write_template(folder, kind or "load", overwrite=overwrite), [], []
    else:
        from stiffcal.propose.from_folder import are_logs, propose_of_logs
        from stiffcal.propose.from_logs import propose_from_logs
        from stiffcal.propose.from_table import propose_campaign

        if urdf is not None:
            with suppress(OSError):
                check_given(urdf)
        with at_rest(tables) as files_at_rest:
            is_kind_of_its_own = of_logs or kind == "absolute"
            if (
                not is_kind_of_its_own
                and all(map(Path.is_file, files_at_rest))
                and are_logs(files_at_rest, urdf, robot)
            ):
                return _result(
                    propose_of_logs(
                        folder, files_at_rest, urdf=urdf, robot=robot, tool=tool, ask=ask, overwrite=overwrite
                    )
                )
            if of_logs:
                proposal = propose_from_logs(
                    folder, str(kind), files_at_rest, urdf=urdf, robot=robot, overwrite=overwrite
                )
            else:
                proposal = propose_campaign(
                    folder, files_at_rest, urdf=urdf, robot=robot, tool=tool, ask=ask, overwrite=overwrite
                )
        written, guessed = proposal.files, list(proposal.guessed)
        to_write = list(proposal.to_write)
        columns = list(proposal.columns) or None
        unused = [*proposal.remarks, *unused_in_words(proposal.unused)]
        if not of_logs and (urdf is not None or robot is not None):
            from stiffcal.propose.robot_remarks import remarks_of

            unused += remarks_of(folder, proposal, "robot.toml" if urdf is None else urdf.name)
    files = [str(file) for file in written]
    return InitResult(warnings=unused, files=files, guessed=guessed, to_write=to_write, columns=columns)


def _check_options(
    kind: str | None, tables: Sequence[Path], urdf: Path | None, robot: str | None, tool: Sequence[float] | None
) -> None:
    """Refuse options that do not go together."""
    of_logs = bool(tables) and kind in KINDS_OF_LOGS
    if tables and kind is not None and not of_logs and kind not in OF_TABLES:
        raise InputError.at(
            FaultCode.OPTION_CONFLICT,
            "command line",
            "--kind",
            f"no campaign of kind {kind} can be proposed from a table",
            "leave out --from, or use --kind load, absolute, clamped or friction",
        )
    if of_logs and tool is not None:
        raise InputError.at(
            FaultCode.OPTION_CONFLICT, "command line", "--tool", f"a {kind} run has no tool point", "leave it out"
        )
    if urdf is not None and robot is not None:
        raise InputError.at(
            FaultCode.OPTION_CONFLICT,
            "command line",
            "--urdf",
            f"--robot {robot} names another robot",
            "leave out one of the two",
        )


def _is_one_table(files: Sequence[Path], urdf: Path | None, robot: str | None) -> bool:
    """Return whether a folder holds nothing but one table, whose rows name their runs."""
    from stiffcal.propose.from_folder import is_table_of_runs

    return len(files) == 1 and files[0].is_file() and is_table_of_runs(files[0], urdf, robot)


def _from_folder(
    folder: Path,
    logs: Path,
    urdf: Path | None,
    robot: str | None,
    tool: Sequence[float] | None,
    *,
    ask: Callable[[Question], str] | None,
    overwrite: bool,
) -> InitResult:
    from stiffcal.propose.from_folder import propose_from_folder

    proposal = propose_from_folder(folder, logs, urdf=urdf, robot=robot, tool=tool, ask=ask, overwrite=overwrite)
    return _result(proposal)


def _result(proposal: Proposal) -> InitResult:
    """Return the answer on a campaign of logs."""
    return InitResult(
        warnings=[*proposal.remarks, *unused_in_words(proposal.unused)],
        files=[str(file) for file in proposal.files],
        guessed=list(proposal.guessed),
        to_write=list(proposal.to_write),
        runs=list(proposal.runs),
        columns=list(proposal.columns) or None,
    )
