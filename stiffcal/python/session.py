"""A campaign as an object: its steps, its states and residuals, trials of other models."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.python.answers import FitHistory, FittedModel, LoadPrediction, MeasurementPlan, ModelValidation
from stiffcal.python.campaign_answer import CampaignAnswer
from stiffcal.python.model_diagnosis import ModelDiagnosis
from stiffcal.results.next_step import Step
from stiffcal.stages.steps import (
    FIT_STATES,
    HELDOUT_STATES,
    Ingested,
    RunContext,
    TrialModel,
    up_to_date_states,
    with_trial_model,
)
from stiffcal.trust.notices import notices_diverted

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from stiffcal.campaign.loading import Campaign
    from stiffcal.python.improvement import ModelImprovement
    from stiffcal.python.page import CampaignPage
    from stiffcal.python.plots import CampaignPlots

Answered = TypeVar("Answered", bound=CampaignAnswer)

logger = logging.getLogger("stiffcal")


class CampaignSession:
    """A campaign folder with its store; made by `stiffcal.open`.

    Each step first runs those before it that are missing or stale, and keeps its results in the store, as the commands
    do; notes and warnings go to the logger ``stiffcal``. A step can be interrupted by Ctrl-C: the store stays whole.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress, and the model that is tried, if any.
    """

    def __init__(self, folder: Path, context: RunContext) -> None:
        self.folder = folder
        self._context = context

    @property
    def title(self) -> str:
        """The effects of the model, in words."""
        model = self._campaign().model
        return " + ".join(dict.fromkeys(entry.type for entry in model.effects)) or "no effect"

    @property
    def model(self) -> str:
        """The model as model.toml would read; "" where the default model holds."""
        from stiffcal.stages.steps import model_text

        return self._context.trial.text if self._context.trial is not None else model_text(self._campaign())

    def identify(self, loss: str = "linear") -> FittedModel:
        """Fit the model.

        Parameters
        ----------
        loss : "linear" (least squares) or "huber" (outliers count less).

        Raises
        ------
        InputError : the input is wrong, or nothing can be fitted.
        """
        from stiffcal.commands.identify import identify_campaign

        with self._logged():
            result = identify_campaign(self.folder, self._context, loss)
        return self._answered(FittedModel(result, str(self.folder.resolve()), self.title), Step.IDENTIFY)

    def validate(self) -> ModelValidation:
        """Judge the model in poses that the fit has left out."""
        from stiffcal.commands.validate import validate_campaign

        with self._logged():
            return self._answered(ModelValidation(validate_campaign(self.folder, self._context)), Step.VALIDATE)

    def diagnose(self) -> ModelDiagnosis:
        """Judge whether the model is good enough, and search for the effects that it lacks; minutes on large data."""
        from stiffcal.commands.diagnose import diagnose_campaign
        from stiffcal.stages.diagnoses.stored_curves import EVIDENCE

        with self._logged():
            result = diagnose_campaign(self.folder, self._context)
            store = self._data().store
            evidence = store.read_table(EVIDENCE) if EVIDENCE in store.tables else None
            return self._answered(ModelDiagnosis(result, evidence), Step.DIAGNOSE)

    def improve(self, dry_run: bool = False) -> ModelImprovement:
        """Add what is missing to model.toml, one effect after another, then remove what is not needed.

        Each step is taken when it is asked for: ``for step in campaign.improve()``. After the last step that is
        taken model.toml stays as that step made it; ``campaign.improve().result`` takes all steps.

        Parameters
        ----------
        dry_run : only hand out what would be added and removed.

        Returns
        -------
        ModelImprovement
            First the model as it was, then each change, with its error before and after, and what is left.

        Raises
        ------
        InputError : this session holds another model than model.toml; of the steps, when they are taken.
        """
        from stiffcal.commands.improve import improvement
        from stiffcal.python.improvement import ModelImprovement

        self._refuse_trial("improve")
        return ModelImprovement(improvement(self.folder, self._context, dry_run=dry_run), self._logged)

    def view(self, raw: bool = True, height: int = 900) -> CampaignPage:
        """Return the page that ``stiffcal view`` writes; a notebook shows it where it stands, without a server.

        Parameters
        ----------
        raw : whether the states' readings and the names of the logs are in it.
        height : px, in a notebook.

        Raises
        ------
        InputError : the input is wrong.
        """
        from stiffcal.commands.view import page_of
        from stiffcal.python.page import CampaignPage

        with self._logged():
            return CampaignPage(page_of(self.folder, self._context, raw).html, height)

    def report(self, file: str | Path | None = None, *, short: bool = False, overwrite: bool = False) -> Path:
        """Write the report that ``stiffcal report`` writes, and return its path.

        Parameters
        ----------
        file : ``*.pdf``; None: report.pdf in the campaign folder.
        short : two pages for a customer.
        overwrite : also a file that holds something stiffcal did not write.

        Raises
        ------
        InputError : of a model that is tried; the file cannot be written or holds something else.
        """
        from stiffcal.commands.report import report_campaign

        self._refuse_trial("report")
        context = replace(self._context, overwrite=overwrite)
        with self._logged():
            return Path(report_campaign(self.folder, context, None if file is None else Path(file), short).file)

    def history(self) -> FitHistory:
        """Return every fit of the campaign, oldest first, with its error in held-out data.

        Raises
        ------
        InputError : of a model that is tried, which is in no history.
        """
        from stiffcal.commands.history import read_history

        self._refuse_trial("history")
        with self._logged():
            return FitHistory(read_history(self.folder, self._context))

    def plan(
        self,
        purpose: str = "stiffness",
        *,
        runs: int | None = None,
        force: float | None = None,
        tell: Sequence[str] = (),
    ) -> MeasurementPlan:
        """Plan which poses and loads to measure, with the means of plan.toml; no file is written.

        Parameters
        ----------
        purpose : "stiffness", "look-alikes" (of the last diagnosis), "region" (of plan.toml), or a CSV of poses and
            loads to predict deflection at.
        runs : their number; None: as plan.toml has it. force : the largest, N; None: likewise.
        tell : two or more effects with their places that the runs are to distinguish, as "backlash j4".

        Raises
        ------
        InputError : of a model that is tried; plan.toml is missing or wrong, or nothing can be planned.
        """
        from stiffcal.commands.plan import plan_campaign
        from stiffcal.planning.campaign.request import PlanRequest

        self._refuse_trial("plan")
        request = PlanRequest(purpose=purpose, runs=runs, force=force, rivals=tuple(tell))
        with self._logged():
            return MeasurementPlan(plan_campaign(self.folder, self._context, request))

    def predict(self, poses: str | Path | pd.DataFrame | Mapping[str, Sequence[float]]) -> LoadPrediction:
        """Predict deflection and Cartesian stiffness under loads.

        Parameters
        ----------
        poses : a table, or a CSV file: a column per joint in degrees, ``Fx`` … ``Tz`` in N and N·m, base axes, on the
            robot at the manifest's load point; another unit in brackets, as ``A1 [rad]``.

        Raises
        ------
        InputError : a column or a value is wrong, or a load is more than the robot holds.
        """
        import numpy as np

        from stiffcal.commands.predict import predict_campaign
        from stiffcal.compensation.load_table import load_table_of

        if isinstance(poses, str | Path):
            loads: Any = Path(poses)
        else:
            table: Any = poses
            columns = {str(name): np.atleast_1d(np.asarray(table[name])) for name in table}
            chain = self._campaign().chain
            loads = load_table_of(columns, chain.joint_names, prismatic=chain.prismatic_names)
        with self._logged():
            return LoadPrediction(predict_campaign(self.folder, self._context, loads))

    @property
    def states(self) -> pd.DataFrame:
        """The load states as the store holds them: one a row, a unit at the end of every column's name."""
        from stiffcal.python.frames import frame_of_table

        with self._logged():
            return frame_of_table(self._data().table)

    def residuals(self, heldout: bool = True) -> pd.DataFrame:
        """Return the measured, predicted and residual deflection, with what each state carries; one load state a row.

        Parameters
        ----------
        heldout : True: in poses that the fit has left out; False: of the fit itself.

        Returns
        -------
        DataFrame
            ``run``, ``row``, ``branch``, ``load_N``, ``tau_1_Nm`` …, joint angles, measured, predicted and residual of
            every target (base axes), and ``noise_m``: the rms length that the instruments scatter.

        Raises
        ------
        InputError : the campaign contains no load states.
        """
        from stiffcal.commands.residuals import residual_columns
        from stiffcal.python.frames import frame_of
        from stiffcal.stages.fit import up_to_date_fit_at_hand
        from stiffcal.stages.validation import up_to_date_validation

        with self._logged():
            data = self._data()
            if len(data.states) == 0:
                reason, mend = "the campaign contains no load states", "see identify().result for the measurements"
                raise InputError.at(FaultCode.DATA_MISSING, str(self.folder), "runs", reason, mend)
            identified, fit = up_to_date_fit_at_hand(data, self._context)
            if heldout:
                up_to_date_validation(data, identified, self._context, fit)
            return frame_of(residual_columns(data, identified, HELDOUT_STATES if heldout else FIT_STATES))

    def with_effect(
        self,
        effect: str,
        joints: Iterable[int | str] = (),
        links: Iterable[str] = (),
        pairs: Iterable[tuple[int, int]] = (),
        curved: bool = False,
    ) -> CampaignSession:
        """Return the same campaign with an effect added to its model, to be tried: all of it stays in memory.

        Parameters
        ----------
        effect : its name.
        joints, links, pairs : where; none for an effect of the set-up.
        curved : in the law's curved form.

        Raises
        ------
        InputError : there is no such effect or place.
        """
        from stiffcal.campaign.model.model_file import model_of_text
        from stiffcal.model.editing import model_with, places_at
        from stiffcal.store.trial import TrialResults

        with self._logged():
            campaign = self._campaign()
            where = places_at(campaign, joints, links, pairs)
            text = model_with(campaign, self.model, effect, where=where, curved=curved)
            trial = TrialModel(text, model_of_text(text, campaign.chain.n_joints), TrialResults())
        return CampaignSession(self.folder, replace(self._context, trial=trial))

    @property
    def plot(self) -> CampaignPlots:
        """Pictures of the campaign."""
        from stiffcal.python.plots import CampaignPlots

        return CampaignPlots(self)

    def drawn(self, run: str | None, against: str | None, of: str | None) -> tuple[Figure, str]:
        """Return the picture that ``stiffcal plot`` draws, and what is in it; `plot` has a method for each.

        Parameters
        ----------
        run, against, of : as of `save_plot`.
        """
        from stiffcal.report.gathering.one_picture import check_request, draw_picture

        with self._logged():
            check_request(run, against, of)
            return draw_picture(self._data(), self._context, run, against, of)

    def save_plot(
        self,
        file: str | Path,
        run: str | None = None,
        against: str | None = None,
        *,
        of: str | None = None,
        overwrite: bool = False,
    ) -> None:
        """Write the picture that ``stiffcal plot`` draws.

        Parameters
        ----------
        file : ``*.svg``, ``*.png`` or ``*.pdf``.
        run : only this run.
        against : draw the residual in held-out poses against this, as ``torque:4``; None: load against deformation.
        of : draw the fit instead: ``normal`` (residuals against a normal law), ``influence`` (of each run on each
            value), ``correlation``, ``profile`` (of values near a bound or that bend a law), ``history``.
        overwrite : also a file that holds something stiffcal did not write.

        Raises
        ------
        InputError : there is nothing to draw, or the file cannot be written or holds something else.
        """
        from stiffcal.commands.plot import plot_campaign

        with self._logged():
            plot_campaign(self.folder, replace(self._context, overwrite=overwrite), Path(file), run, against, of)

    def _answered(self, answer: Answered, step: Step) -> Answered:
        """Return an answer that knows its campaign; of a model that is tried the folder says nothing."""
        if self._context.trial is not None:
            return answer
        return answer.of_campaign(self.folder, self._context.store, step)

    def _refuse_trial(self, step: str) -> None:
        """Raise InputError where a model is tried: the step would write, or read, what is of model.toml."""
        if self._context.trial is not None:
            reason = f"{step} works with model.toml, and this session holds another model"
            mend = f"call {step} on a session of the campaign itself, stiffcal.open(DIR)"
            raise InputError.at(FaultCode.OPTION_INVALID, str(self.folder), step, reason, mend)

    def _data(self) -> Ingested:
        return up_to_date_states(self.folder, self._context)

    def _campaign(self) -> Campaign:
        from stiffcal.campaign.loading import load_campaign

        return with_trial_model(load_campaign(self.folder, check_files=False), self._context)

    @contextmanager
    def _logged(self) -> Iterator[None]:
        """Have what the command line would write to standard error go to the logger."""
        outlet: Callable[[str], None] = logger.warning
        with notices_diverted(outlet):
            yield

    def __repr__(self) -> str:
        trial = "" if self._context.trial is None else f", trial of {self.title}"
        return f"<stiffcal campaign {self.folder}{trial}>"
