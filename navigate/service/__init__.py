"""The navigator on the bus."""

from navigate.service._service import NavigateService

__all__ = [
    "NavigateService",
]
