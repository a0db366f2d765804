"""How the attempts of a module ended, kept and reported until central has it."""

from __future__ import annotations

import contextlib
import logging
from collections import OrderedDict
from dataclasses import dataclass, field

from tca_bus._core import Core
from tca_bus._errors import ClosedError, TcaError
from tca_bus._failure import Failure
from tca_bus._protocol import HandleTask, Outcome, ReportOutcome
from tca_bus._tasks import OUT_OF_REACH, TaskSender

logger = logging.getLogger(__name__)

MOST_REPORTED = 1024
"""Acknowledged outcomes that are kept, to report again should central ask again."""

REPORT_PATIENCE = 60.0
"""Wall seconds of one attempt to report; a report is repeated for as long as the module lives."""

Try = tuple[str, int]
"""A task id and the attempt number."""


@dataclass
class Outcomes:
    """The ends of attempts: each is reported until it is taken, and again when central asks."""

    core: Core
    sender: TaskSender
    _known: OrderedDict[Try, ReportOutcome] = field(default_factory=OrderedDict)
    _reporting: set[Try] = field(default_factory=set)
    _asked_again: set[Try] = field(default_factory=set)

    def known(self, id: str, attempt: int) -> ReportOutcome | None:
        """How an attempt ended, if that is still remembered."""
        return self._known.get((id, attempt))

    def conclude(self, report: ReportOutcome) -> None:
        """Keep how an attempt ended, and report it until central has it."""
        self._known[report.id, report.attempt] = report
        self.report(report)
        if len(self._known) > MOST_REPORTED:
            self._forget_oldest()

    def _forget_oldest(self) -> None:
        """Forget the oldest outcome that central has; the others are as many as it gave tasks."""
        oldest = next((key for key in self._known if key not in self._reporting), None)
        if oldest is not None:
            del self._known[oldest]

    def report(self, report: ReportOutcome) -> None:
        """Report it, and once more if central asks while it is being reported."""
        key = (report.id, report.attempt)
        if key in self._reporting:
            self._asked_again.add(key)
            return
        name = f"{self.core.name}.report.{report.id}"
        # A module that is closing reports no more; central sees it leave.
        with contextlib.suppress(ClosedError):
            self.core.spawn(self._report_until_taken(report), name=name)
            self._reporting.add(key)

    async def _report_until_taken(self, report: ReportOutcome) -> None:
        key = (report.id, report.attempt)
        try:
            while True:
                try:
                    await self.sender.ask_central(report, timeout=REPORT_PATIENCE)
                except OUT_OF_REACH as error:
                    logger.warning("outcome of task %s is not reported yet: %s", report.id, error)
                    continue
                if key not in self._asked_again:
                    return
                self._asked_again.discard(key)
        except TcaError:
            logger.exception("central does not take the outcome of task %s", report.id)
        finally:
            self._reporting.discard(key)
            self._asked_again.discard(key)


def killed(id: str, attempt: int) -> ReportOutcome:
    """The outcome of an attempt that was stopped."""
    return ReportOutcome(id=id, attempt=attempt, outcome=Outcome.KILLED)


def failed(task: HandleTask, failure: Failure) -> ReportOutcome:
    """The outcome of an attempt that failed."""
    return ReportOutcome(id=task.id, attempt=task.attempt, outcome=Outcome.FAILURE, failure=failure)
