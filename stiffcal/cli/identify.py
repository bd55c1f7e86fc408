"""`stiffcal identify`: fit the model, show the stiffness table."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.bodies import show_cartesian, show_joints
from stiffcal.cli.endings import OK
from stiffcal.cli.links import show_coupling, show_links
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Details, Folder, NoUpdate, StoreAt
from stiffcal.cli.pages import draw_blocks
from stiffcal.cli.registration import show_registration
from stiffcal.cli.suspects import show_suspects
from stiffcal.cli.tables import plain_table, show_parameters
from stiffcal.cli.verdict import Level, show_verdict
from stiffcal.cli.wording import deviation, significant
from stiffcal.quantity import JOINT_ANGLE
from stiffcal.results.geometry_words import IN_ROWS
from stiffcal.results.next_step import Step, is_within_noise
from stiffcal.results.unidentified_words import unidentified_in_words
from stiffcal.wording import in_unit, length

if TYPE_CHECKING:
    from collections.abc import Collection

    from rich.console import Console

    from stiffcal.cli.console import AnswerConsole
    from stiffcal.identification.answers.agreement_results import Agreement
    from stiffcal.identification.answers.fit_results import DualQuaternionFit, GeometryTaken
    from stiffcal.identification.answers.geometry_results import GeometryFound
    from stiffcal.presentation.values import Overview
    from stiffcal.results.identify_result import IdentifyResult


def identify(
    folder: Folder = HERE,
    loss: Annotated[str, typer.Option(help="linear (least squares) or huber (less weight for outliers).")] = "linear",
    dual_quaternions: Annotated[
        bool,
        typer.Option(
            "--dual-quaternions",
            help="Joint springs as dual quaternions too (Li et al. 2019), next to the matrix form.",
        ),
    ] = False,
    coupling: Annotated[
        bool, typer.Option("--coupling", help="With rods on a link: compare with the fit that does not use them.")
    ] = False,
    details: Details = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Fit the model: each stiffness with its uncertainty.

    Also lists parameters that the data do not identify, and the expected error in new poses.

    Example: stiffcal identify demo --loss huber
    """
    with answering(as_json) as answer:
        from stiffcal.commands.identify import identify_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        result = identify_campaign(folder, context, loss, dual_quaternions, coupling)
        answer.give(result, partial(show_fit, details=details), following(folder, store, Step.IDENTIFY))
    return OK


def show_fit(console: AnswerConsole, result: IdentifyResult, details: bool = False) -> None:
    """Draw a fit: how well it fits, then the table and what these data do not identify."""
    show_verdict(console, *fit_verdict(result))
    show_fitted(console, result, details)
    if _of_places_alone(result):
        console.print("whether these poses identify the stiffness of a joint is stated by validate", soft_wrap=True)


def fit_verdict(result: IdentifyResult) -> tuple[Level, str]:
    """Return how a fit stands: against the noise, and whether these data identify the model."""
    names = {name for group in result.not_identifiable for name in group.parameters}
    known = [parameter for parameter in result.parameters if parameter.value is not None]
    if result.parameters and not known:
        return "fail", "no parameter is identifiable from these data"
    is_good = is_within_noise(result.rms, result.noise) and not names
    count = f"{len(names)} parameter{'s are' if len(names) > 1 else ' is'} not identifiable from these data"
    identifiable = count if names else "all parameters are identifiable from these data"
    return "pass" if is_good else "warn", f"{_fit_in_words(result)}; {identifiable}"


def _fit_in_words(result: IdentifyResult) -> str:
    known = result.noise is not None
    against = f", noise {deviation(result.noise)} (from {result.noise_source})" if known else ", noise not known"
    return f"fit {deviation(result.rms)} rms{against}"


def show_fitted(
    console: AnswerConsole,
    result: IdentifyResult,
    details: bool = False,
    is_part: bool = False,
    unclaimed: Collection[int] = (),
) -> None:
    """Draw a fit without its verdict.

    Parameters
    ----------
    details : also the parameters that the rows of the geometry state in another form.
    is_part : whether it is a part of another answer, whose verdict stands before it: then the fit is compared with the
        noise in a line of its own.
    unclaimed : joints whose compliance is not identified, as `show_parameters` takes them.
    """
    console.show_warnings(result.warnings)
    show_registration(console, result.registration)
    console.print(f"{_read_in_words(result)} in {result.n_runs} run{'s' * (result.n_runs != 1)}")
    kinds = _overviews(result)
    elsewhere = {name for overview in kinds for name in overview.parameters}
    shown = [parameter for parameter in result.parameters if parameter.name not in elsewhere]
    if _has_rows(result) and not details:
        shown = [parameter for parameter in shown if parameter.effect != IN_ROWS]
    show_parameters(console, shown, unclaimed, result.shifted)
    for overview in kinds:
        draw_blocks(console, overview.blocks)
    if result.geometry is not None:
        _show_geometry(console, result.geometry, in_uncertainty=result.covariance_from_geometry is not None)
    for agreement in result.agreement or ():
        _show_agreement(console, agreement)
    if is_part:
        console.print(_fit_in_words(result))
    console.print(_conditioning(result), soft_wrap=True)
    if result.joints_by_themselves:
        show_joints(console, result.joints_by_themselves)
    if result.cartesian_stiffness:
        show_cartesian(console, result.cartesian_stiffness)
    if result.links:
        show_links(console, result.links)
    if result.rejected:
        console.print(f"{len(result.rejected)} states set aside before the fit (excluded, bumped or not measured)")
    show_suspects(console, result.suspects, result.suspects_not_checked)
    for sentence in unidentified_in_words(
        group for group in result.not_identifiable if not (elsewhere and set(group.parameters) <= elsewhere)
    ):
        console.print(f"cannot be identified: {sentence}")
    if result.expected_error:
        console.print(result.expected_error)
    if result.coupling is not None:
        show_coupling(console, result.coupling)
    if result.dual_quaternions is not None:
        _show_dual_quaternions(console, result.dual_quaternions)


def _overviews(result: IdentifyResult) -> list[Overview]:
    """Return what kinds of experiment have to show of a fit."""
    from stiffcal.kinds import all_kinds

    return [overview for kind in all_kinds() if (overview := kind.overview(result)) is not None]


def _read_in_words(result: IdentifyResult) -> str:
    """Return how many load states, poses or readings were fitted."""
    if result.n_readings:
        return f"{result.n_readings} readings"
    if _of_places_alone(result):
        return f"{result.n_states} poses"
    return f"{result.n_states} poses and load states" if result.agreement else f"{result.n_states} load states"


def _has_rows(result: IdentifyResult) -> bool:
    """Return whether the geometry that was found stands as rows of joints, as a controller takes it."""
    from stiffcal.identification.answers.geometry_results import GeometryFound

    return isinstance(result.geometry, GeometryFound)


def _of_places_alone(result: IdentifyResult) -> bool:
    """Return whether a fit is of absolute poses without load runs."""
    from stiffcal.identification.answers.geometry_results import GeometryFound

    return isinstance(result.geometry, GeometryFound) and not result.agreement


def _conditioning(result: IdentifyResult) -> str:
    """Return the reduced χ² and the condition number, and of what is not known the reason."""
    chi2, condition = result.reduced_chi2, result.condition
    texts = ["reduced χ² not known (the noise is not)" if chi2 is None else f"reduced χ² {significant(chi2)}"]
    if condition is not None:
        texts.append(f"condition number {significant(condition)}")
    elif result.not_identifiable:
        texts.append("condition number infinite: some parameters cannot be identified (below)")
    return ", ".join(texts)


def _show_agreement(console: Console, agreement: Agreement) -> None:
    """Draw what two kinds of experiment determine, each alone, and whether they agree."""
    from stiffcal.results.agreement_words import rows, runs_of_kinds, verdict

    first, second = runs_of_kinds(agreement)
    table = plain_table(
        "parameter", f"{first} alone, ± 95 %>", f"{second} alone, ± 95 %>", "",
        "standard errors>",
    )  # fmt: skip
    for row in rows(agreement):
        table.add_row(*row)
    console.print(table)
    console.print(verdict(agreement))


def _show_geometry(console: Console, geometry: GeometryTaken | GeometryFound, *, in_uncertainty: bool) -> None:
    """Draw the geometry that was found, or how well it was taken to be known."""
    from stiffcal.identification.answers.fit_results import GeometryTaken
    from stiffcal.results.geometry_words import HEADER, convention_in_words, sentences, table_rows

    if isinstance(geometry, GeometryTaken):
        if in_uncertainty:
            console.print(geometry_in_words(geometry))
        return
    table = plain_table(*(f"{title}, {unit}>" if unit else title for title, unit in HEADER))
    for row in table_rows(geometry):
        table.add_row(*row)
    console.print(table)
    console.print(convention_in_words(geometry))
    for sentence in sentences(geometry):
        console.print(sentence)


def geometry_in_words(geometry: GeometryTaken) -> str:
    """Return how well the geometry is known, and what that is from.

    Examples
    --------
    >>> from stiffcal.identification.answers.fit_results import GeometryTaken
    >>> from stiffcal.identification.fitting.geometry_prior import GeometrySource
    >>> geometry_in_words(GeometryTaken(length_sigma=5e-4, angle_sigma=3.49e-4, source=GeometrySource.DEFAULT))
    'geometry known to 0.50 mm per length and 0.020° per angle (default; [geometry] of robot.toml states it)'
    """
    from stiffcal.identification.fitting.geometry_prior import GeometrySource

    mend = "" if geometry.source is GeometrySource.ROBOT_FILE else "; [geometry] of robot.toml states it"
    source = "absolute positions" if geometry.source is GeometrySource.PLACES else geometry.source.value
    return (
        f"geometry known to {length(geometry.length_sigma, digits=2)} per length and "
        f"{in_unit(geometry.angle_sigma, JOINT_ANGLE.usual, 2)} per angle ({source}{mend})"
    )


def _show_dual_quaternions(console: Console, comparison: DualQuaternionFit) -> None:
    """Draw the two forms next to each other, and the paper's unweighted estimate separately."""

    def stiffness(compliance: float | None) -> str:
        return significant(1.0 / compliance) if compliance else "–"

    table = plain_table("stiffness, N·m/rad", "matrices>", "dual quaternions>", "unweighted, m>", "unweighted, mm>")
    for parameter in comparison.parameters:
        table.add_row(
            parameter.name,
            stiffness(parameter.matrix),
            stiffness(parameter.dual_quaternion),
            stiffness(parameter.unweighted_in_metres),
            stiffness(parameter.unweighted_in_millimetres),
        )
    console.print(table)
    console.print(
        f"both forms agree within {significant(comparison.largest_relative_difference, 1)} "
        f"(relative); unweighted: Li et al. 2019, "
        "eq. 35 as printed, which weights lengths in m or mm and dimensionless numbers equally"
    )
