"""From a fit of load states to what ``identify`` answers."""

from __future__ import annotations

from dataclasses import replace

from stiffcal.identification.answers.document import (
    correlated_parameters,
    finite,
    fit_warnings,
    identified_parameter,
    included_by_convention,
    measured_links,
    model_summary,
    noise_per_axis,
    rejected_states,
    resting_on_limits,
    unidentified_parameters,
    values_in_fit,
)
from stiffcal.identification.answers.fit_results import GeometryTaken
from stiffcal.identification.answers.measured_robots import unusual_stiffness_warnings
from stiffcal.identification.bodies.bodies import cartesian_stiffness, joints_by_themselves
from stiffcal.identification.bodies.measured_links import link_results
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry import with_geometry
from stiffcal.identification.fitting.identify import fit_rms
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.rms import Rms
from stiffcal.reduction.copies.repeated_rows import repeated_rows
from stiffcal.results.identify_result import IdentifyResult


def identify_result(fit: Fit, states: LoadStates) -> IdentifyResult:
    """Return the result of ``identify`` for load states alone, but for the error to expect.

    Parameters
    ----------
    fit : the fit.
    states : all load states of the campaign, those set aside among them.
    """
    links, fit = measured_links(fit), with_geometry(fit, states)
    in_fit, included, resting = values_in_fit(fit), included_by_convention(fit), resting_on_limits(fit)
    by_temperature = fit.data.order.logs_temperature
    by_geometry, prior = fit.covariance_from_geometry, fit.geometry
    return IdentifyResult(
        warnings=[
            *fit_warnings(fit),
            *unusual_stiffness_warnings(fit),
            *repeated_rows(states),
            *(fault.sentence for link in links for fault in link.faults),
        ],
        model=model_summary(fit.robot),
        parameters=[
            replace(
                identified_parameter(parameter, in_fit.get(parameter.name), by_temperature),
                includes=included.get(parameter.name),
                rests_on=resting.get(parameter.name),
            )
            for parameter in fit.parameters
        ],
        n_states=fit.data.n_measured,
        # rows of an absolute run are runs of their own in the fit, of one run of the manifest
        n_runs=len({states.runs[run].of or states.runs[run].name for run in set(fit.data.run.tolist())}),
        rms=Rms.of(fit_rms(fit)),
        noise=Rms.of(fit.noise_length) if fit.noise is not None else None,
        noise_source="none" if fit.noise is None else fit.noise.source,
        noise_per_axis=noise_per_axis(fit),
        reduced_chi2=finite(fit.reduced_chi2),
        dof=fit.dof,
        std_scaled_by_reduced_chi2=fit.scaled,
        condition=finite(fit.condition),
        not_identifiable=[unidentified_parameters(ambiguity) for ambiguity in fit.ambiguities],
        rejected=rejected_states(states),
        free_parameters=list(fit.free_names),
        covariance=fit.covariance.tolist(),
        covariance_from_geometry=None if by_geometry is None else by_geometry.tolist(),
        geometry=None
        if prior is None
        else GeometryTaken(length_sigma=prior.length, angle_sigma=prior.angle, source=prior.source),
        correlation=correlated_parameters(fit),
        iterations=fit.iterations,
        links=link_results(links) or None,
        expected_rms=None,
        expected_error="",
        joints_by_themselves=joints_by_themselves(states, fit.robot.chain) or None,
        cartesian_stiffness=cartesian_stiffness(states, fit.robot.chain) or None,
    )
