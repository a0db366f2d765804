"""The ways to talk that `bench/bus.py` compares, one file for each."""

from contenders import bare_zenoh, grpc_aio, nats_py, ours, zeromq
from contenders.base import Contender

CONTENDERS: dict[str, Contender] = {
    contender.name: contender
    for contender in (
        *ours.CONTENDERS,
        *bare_zenoh.CONTENDERS,
        zeromq.CONTENDER,
        *nats_py.CONTENDERS,
        grpc_aio.CONTENDER,
    )
}
