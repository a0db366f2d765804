"""What a module has lost, refused and found amiss."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field

from tca_bus._complaints import Complaints
from tca_bus._errors import InvalidMessageError

logger = logging.getLogger(__name__)


@dataclass
class Tally:
    """What a module has lost and refused, for its card."""

    invalid: int = 0
    counters: dict[str, Callable[[], int]] = field(default_factory=dict)
    complaints: Complaints = field(default_factory=Complaints)

    def note_invalid(self, error: InvalidMessageError, *, sender: str) -> None:
        """Count a message that did not validate, and log it once."""
        self.invalid += 1
        self.complain(f"{error.message} from {sender}", f"from {sender}: {error}")

    def complain(self, cause: str, text: str, *, error: BaseException | None = None) -> None:
        """Log what is amiss; a cause that comes again within a minute is only counted."""
        told = self.complaints.tell(cause, text)
        if told is not None:
            logger.log(logging.ERROR if error else logging.WARNING, "%s", told, exc_info=error)

    def dropped(self) -> dict[str, int]:
        """How many messages each queue has dropped; queues without a loss are left out."""
        counts = {name: count() for name, count in self.counters.items()}
        return {name: count for name, count in counts.items() if count}
