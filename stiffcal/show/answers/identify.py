"""What `identify` shows: how well the model fits, each value with its uncertainty, what the data do not identify."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.estimation.undetermined import Undetermined
from stiffcal.quantity import JOINT_ANGLE, Units
from stiffcal.results.geometry_words import FRAME, IN_ROWS
from stiffcal.results.next_step import is_within_noise
from stiffcal.results.unidentified_words import unidentified_in_words
from stiffcal.show import parts
from stiffcal.show.bodies import add_cartesian, add_joints
from stiffcal.show.builder import PageBuilder, number
from stiffcal.show.links import add_coupling, add_links
from stiffcal.show.parameters import add_parameters
from stiffcal.wording import deviation, in_unit, length, significant

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from stiffcal.identification.answers.agreement_results import Agreement
    from stiffcal.identification.answers.fit_results import DualQuaternionFit, GeometryTaken
    from stiffcal.identification.answers.geometry_results import GeometryFound
    from stiffcal.presentation.values import Level, Overview, Page
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.show.options import ShowOptions

MOST_VALUES, VALUES_IN_PART = 10, 5
"""Values that are listed next to stiffness without details: of `identify`, and of an answer that holds its fit."""
MOST_GROUPS = 2
"""Groups of parameters whose reason is stated without details."""


def page(result: IdentifyResult, options: ShowOptions) -> Page:
    """Return how well it fits, then the values and what these data do not identify.

    With details there are also single runs, all values, and the parameters that the rows of the geometry state in
    another form.
    """
    made = PageBuilder("Fit")
    level, text = fit_verdict(result)
    made.say(text, "verdict", level)
    add_fitted(made, result, options.details)
    if _of_places_alone(result):
        made.say("whether these poses identify the stiffness of a joint is stated by validate", "stated-elsewhere")
    return made.page()


def fit_verdict(result: IdentifyResult) -> tuple[Level, str]:
    """Return how a fit stands: against the noise, and whether these data identify the model."""
    names = {name for group in result.not_identifiable for name in group.parameters} - _conventions(result)
    known = [parameter for parameter in result.parameters if parameter.value is not None]
    if result.parameters and not known:
        return "fail", "no parameter is identifiable from these data"
    is_good = is_within_noise(result.rms, result.noise) and not names
    count = f"{len(names)} parameter{'s are' if len(names) > 1 else ' is'} not identifiable from these data"
    identifiable = count if names else "all parameters are identifiable from these data"
    return "pass" if is_good else "warn", f"{_fit_in_words(result)}; {identifiable}"


def _fit_in_words(result: IdentifyResult) -> str:
    units = Units.of_errors((result.rms, result.noise, result.expected_rms))
    known = result.noise is not None
    against = f", noise {deviation(result.noise, units)} (from {result.noise_source})" if known else ", noise not known"
    return f"fit {deviation(result.rms, units)} rms{against}"


def add_fitted(
    made: PageBuilder,
    result: IdentifyResult,
    details: bool = False,
    is_part: bool = False,
    unclaimed: Collection[int] = (),
) -> None:
    """Add a fit without its verdict.

    Parameters
    ----------
    details : also single runs, all values, and parameters that the rows of the geometry state in another form.
    is_part : whether it is a part of another answer, whose verdict stands before it: then the fit is compared with the
        noise in a line of its own, and the command shows the rest.
    unclaimed : joints whose compliance is not identified, as `add_parameters` takes them.
    """
    made.add(parts.registration(result.registration))
    made.say(f"{_read_in_words(result)} in {result.n_runs} run{'s' * (result.n_runs != 1)}", "fit")
    kinds = _overviews(result)
    elsewhere = {name for overview in kinds for name in overview.parameters}
    shown = [parameter for parameter in result.parameters if parameter.name not in elsewhere]
    if not details:
        shown = [parameter for parameter in shown if parameter.name not in _in_rows(result)]
    most = VALUES_IN_PART if is_part else MOST_VALUES
    add_parameters(made, shown, unclaimed, result.shifted or (), None if details else most)
    add_overviews(made, kinds, details)
    if is_part:
        made.say(_fit_in_words(result), "fit")
        made.add(parts.suspects(result.suspects, None))
        return
    if result.geometry is not None:
        _add_geometry(made, result.geometry, in_uncertainty=result.covariance_from_geometry is not None)
    for agreement in result.agreement or ():
        _add_agreement(made, agreement, details)
    made.say(_conditioning(result), "conditioning")
    if result.joints_by_themselves:
        add_joints(made, result.joints_by_themselves)
    if result.cartesian_stiffness:
        add_cartesian(made, result.cartesian_stiffness)
    if result.links:
        add_links(made, result.links)
    if result.rejected:
        made.say(
            f"{len(result.rejected)} states set aside before the fit (excluded, bumped or not measured)", "set-aside"
        )
    made.add(parts.suspects(result.suspects, result.suspects_not_checked if details else None))
    elsewhere |= set() if details else _conventions(result)  # the lines below the rows name them
    sentences = list(
        unidentified_in_words(
            group for group in result.not_identifiable if not (elsewhere and set(group.parameters) <= elsewhere)
        )
    )
    if details or len(sentences) <= MOST_GROUPS:
        for sentence in sentences:
            made.say(f"cannot be identified: {sentence}", "not-identifiable")
    else:
        made.say(
            f"cannot be identified: {len(sentences)} groups of parameters (identify --details)", "not-identifiable"
        )
    if result.expected_error:
        made.say(result.expected_error, "expected-error")
    if result.coupling is not None:
        add_coupling(made, result.coupling)
    if result.dual_quaternions is not None:
        _add_dual_quaternions(made, result.dual_quaternions)


def add_overviews(made: PageBuilder, overviews: Sequence[Overview], details: bool) -> None:
    """Add what kinds of experiment have to show; of single runs as details."""
    for overview in overviews:
        made.add((*overview.blocks, *(overview.details if details else ())))
    if not details and any(overview.details for overview in overviews):
        made.say("identify --details shows each run, and how these values are defined", "more")


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


def _in_rows(result: IdentifyResult) -> set[str]:
    """Return the parameters that the rows of the geometry state, and the frames that they are counted from."""
    return {one.name for one in result.parameters if _has_rows(result) and one.effect in (IN_ROWS, FRAME)}


def _conventions(result: IdentifyResult) -> set[str]:
    """Return those of them that no poses determine: other numbers of the rows contain them.

    What other poses would determine is none, and stands among what cannot be identified.
    """
    in_rows = _in_rows(result)
    alike = (group for group in result.not_identifiable if in_rows and group.cause is Undetermined.SAME_MOTION)
    return in_rows & {name for group in alike for name in group.parameters}


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
        names = {name for group in result.not_identifiable for name in group.parameters} - _conventions(result)
        why = "see below" if names else "the geometry contains conventions"
        texts.append(f"condition number infinite ({why})")
    return ", ".join(texts)


def _add_agreement(made: PageBuilder, agreement: Agreement, details: bool) -> None:
    """Add whether two kinds of experiment agree; what each determines alone where they do not, and as details."""
    from stiffcal.results.agreement_words import rows, runs_of_kinds, verdict

    if agreement.agree and not details:
        made.say(verdict(agreement), "agreement")
        return
    first, second = runs_of_kinds(agreement)
    alone = (number(f"{name} alone, ± 95 %") for name in (first, second))
    made.table(("parameter", *alone, "", number("standard errors")), rows(agreement))
    made.say(verdict(agreement), "agreement")


def _add_geometry(made: PageBuilder, geometry: GeometryTaken | GeometryFound, *, in_uncertainty: bool) -> None:
    """Add the geometry that was found, or how well it was taken to be known."""
    from stiffcal.identification.answers.fit_results import GeometryTaken
    from stiffcal.results.geometry_words import HEADER, convention_in_words, sentences, table_rows

    if isinstance(geometry, GeometryTaken):
        if in_uncertainty:
            made.say(geometry_in_words(geometry), "geometry")
        return
    made.table([number(f"{title}, {unit}") if unit else title for title, unit in HEADER], table_rows(geometry))
    made.say(convention_in_words(geometry), "convention")
    for sentence in sentences(geometry):
        made.say(sentence, "geometry")


def geometry_in_words(geometry: GeometryTaken) -> str:
    """Return how well the geometry is known, and what that is from.

    Examples
    --------
    >>> from stiffcal.identification.answers.fit_results import GeometryTaken
    >>> from stiffcal.identification.fitting.geometry_source import GeometrySource
    >>> geometry_in_words(GeometryTaken(length_sigma=5e-4, angle_sigma=3.49e-4, source=GeometrySource.DEFAULT))
    'geometry known to 0.50 mm per length and 0.020° per angle (default; [geometry] of robot.toml states it)'
    """
    from stiffcal.identification.fitting.geometry_source import GeometrySource

    mend = "" if geometry.source is GeometrySource.ROBOT_FILE else "; [geometry] of robot.toml states it"
    source = "absolute positions" if geometry.source is GeometrySource.PLACES else geometry.source.value
    return (
        f"geometry known to {length(geometry.length_sigma, digits=2)} per length and "
        f"{in_unit(geometry.angle_sigma, JOINT_ANGLE.usual, 2)} per angle ({source}{mend})"
    )


def _add_dual_quaternions(made: PageBuilder, comparison: DualQuaternionFit) -> None:
    """Add the two forms next to each other, and the paper's unweighted estimate separately."""

    def stiffness(compliance: float | None) -> str:
        return significant(1.0 / compliance) if compliance else "–"

    rows = [
        (
            parameter.name,
            stiffness(parameter.matrix),
            stiffness(parameter.dual_quaternion),
            stiffness(parameter.unweighted_in_metres),
            stiffness(parameter.unweighted_in_millimetres),
        )
        for parameter in comparison.parameters
    ]
    forms = ("matrices", "dual quaternions", "unweighted, m", "unweighted, mm")
    made.table(("stiffness, N·m/rad", *map(number, forms)), rows)
    made.say(
        f"both forms agree within {significant(comparison.largest_relative_difference, 1)} "
        f"(relative); unweighted: Li et al. 2019, "
        "eq. 35 as printed, which weights lengths in m or mm and dimensionless numbers equally",
        "dual-quaternions",
    )
