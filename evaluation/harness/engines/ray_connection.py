"""Connects to a Ray cluster or starts one, without Ray's output, and disconnects again."""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import warnings
from collections.abc import Iterator

import ray
from ray.exceptions import RayError

from indoor_explorers.env.errors import InputError

#: Seconds that the head of a cluster may take to answer.
ANSWER_WITHIN = 5.0
#: Turns off Ray's usage statistics and its messages about accelerators.
QUIET = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0"}
#: The connection preface of HTTP/2, the protocol of a cluster's head, with empty settings (RFC 9113, section 3.4).
GREETING = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0])


@contextlib.contextmanager
def connected(address: str | None = None) -> Iterator[None]:
    """Connect this process to a cluster while the context lasts; see :func:`~.ray_engine.fly_jobs_on_ray`.

    Raises:
        InputError: there is none at ``address``, or it has no CPUs.
    """
    address = address or os.environ.get("RAY_ADDRESS") or None
    check_address(address)
    if ray.is_initialized():
        yield
        return
    _connect(address)
    try:
        if cpus() < 1:
            raise InputError("expected a Ray cluster with CPUs, got one without; add nodes with ray start --address")
        yield
    finally:
        ray.shutdown()


def cpus() -> int:
    """Return how many CPUs the cluster has now."""
    resources: dict[str, float] = ray.cluster_resources()
    return int(resources.get("CPU", 0))


def _connect(address: str | None) -> None:
    with _environment(QUIET), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Ray warns of its own coming changes
        try:
            ray.init(address, include_dashboard=False, log_to_driver=False, logging_level=logging.ERROR)
        except (OSError, ValueError, RuntimeError, RayError, SystemExit) as error:  # without a cluster Ray exits
            raise _no_cluster(address, str(error)) from error


def check_address(address: str | None) -> None:
    """Raise :class:`InputError` unless a server that may be the head of a cluster answers at ``host:port``.

    Ray itself would wait for minutes and then end the process.
    """
    if address in (None, "auto", "local"):
        return
    host, _, port = str(address).rpartition(":")
    try:
        with socket.create_connection((host.strip("[]"), int(port)), ANSWER_WITHIN) as line:
            line.sendall(GREETING)
            answer = line.recv(len(GREETING))
    except (OSError, ValueError, OverflowError) as error:
        raise _no_cluster(address, str(error)) from error
    if answer[3:4] != b"\x04":  # HTTP/2 answers with a frame of settings
        raise _no_cluster(address, "something else answers")


def _no_cluster(address: str | None, why: str) -> InputError:
    where = f"at {address}" if address is not None else "here"
    return InputError(
        f"expected the host:port of a Ray cluster's head, such as 10.0.0.1:6379, got no cluster {where} "
        f"({' '.join(why.split())[:200]}); start one with ray start --head, join it from "
        "this machine, and set RAY_AUTH_MODE=token here if it asks for one"
    )


@contextlib.contextmanager
def _environment(variables: dict[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.__setitem__(name, value)
