"""How soon the agent's planner acts on a request that arrives among many open ones."""

from __future__ import annotations

import time
from dataclasses import replace

from planners.office import Instance, Job, batch
from planners.ours import Office, errand

from rogue.admission import choose
from rogue.messages import DeliveryRequest, RequestState
from rogue.prodigy import Execute, Search


def reaction(open_errands: int, seed: int) -> float:
    """Seconds from an arrival among so many open errands to the robot's next step.

    The arrival is learnt of while the second step goes on, and is more urgent than most. What is
    measured is the choice of who takes part, the change of the search, and the planning until the
    next step is known.
    """
    instance = _ranked(batch(48, open_errands + 1, seed))
    office = Office(instance)
    requests = [_request(job) for job in instance.jobs]
    jobs = {job.name: job for job in instance.jobs}
    first = _chosen(requests[:-1], office, ())
    search = office.search([jobs[name] for name in first], instance.start)
    steps = 0
    began = 0.0
    for event in search.events():
        if isinstance(event, Execute):
            if began:
                return time.process_time() - began
            steps += 1
            if steps == 2:
                began = time.process_time()
                _take_in(office, search, jobs, first, _chosen(requests, office, first))
            search.executed()
    raise AssertionError("an errand takes more than two steps")


def _ranked(instance: Instance) -> Instance:
    last = len(instance.jobs) - 1
    ranks = [number * 5 % 7 for number in range(last)] + [6]
    jobs = (replace(job, rank=rank) for job, rank in zip(instance.jobs, ranks, strict=True))
    return replace(instance, jobs=tuple(jobs))


def _request(job: Job) -> DeliveryRequest:
    one = errand(job)
    return DeliveryRequest(
        id=job.name,
        user=one.user,
        item=one.item,
        pickup=one.pickup,
        deliver=one.deliver,
        state=RequestState.QUEUED,
        rank=job.rank,
        posted=0.0,
        deadline=1e9,
    )


def _chosen(
    requests: list[DeliveryRequest], office: Office, begun: tuple[str, ...]
) -> tuple[str, ...]:
    found = choose(
        requests,
        begun=begun,
        pinned=(),
        priority=lambda request: office.agenda.priority(request.user, request.item),
        identity=lambda request: (request.user, request.item),
    )
    return tuple(request.id for request in found)


def _take_in(
    office: Office,
    search: Search,
    jobs: dict[str, Job],
    before: tuple[str, ...],
    after: tuple[str, ...],
) -> None:
    switches = office.switches
    for name in set(before) - set(after):
        one = errand(jobs[name])
        search.remove_goal(switches.goal(one), switches.facts(one))
    for name in set(after) - set(before):
        one = errand(jobs[name])
        search.add_goal(switches.facts(one), switches.goal(one))
