"""How a scene travels: volumes, labels and maps of light apart from it, each once to each worker, and known there by what they
hold."""

from __future__ import annotations

import copy
import hashlib
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lumivox.labels import Labels
from lumivox.light import EnvironmentMap
from lumivox.rendering import Plan
from lumivox.volume import Volume

MOST_RESIDENT = 16
"""Volumes, labels and maps that a worker keeps after their job, the last used."""

Heavy = Volume | Labels | EnvironmentMap


@dataclass(frozen=True)
class Shared:
    """A volume, labels or a map under the hash of all that is in it."""

    key: str
    content: Heavy

    def __dask_tokenize__(self) -> tuple[str, str]:
        return ("lumivox", self.key)


@dataclass(frozen=True)
class Ref:
    """Where a scene has a volume, labels or a map."""

    key: str


_keys: OrderedDict[int, tuple[object, str]] = OrderedDict()


def key_of(content: Heavy) -> str:
    """The hash of all that is in a volume, labels or a map."""
    native = content.native
    known = _keys.get(id(native))
    if known is not None and known[0] is native:
        return known[1]
    digest = hashlib.blake2b(digest_size=16)
    array = np.ascontiguousarray(content.array)
    digest.update(repr((type(content).__name__, array.shape, array.dtype.str)).encode())
    if isinstance(content, Volume):
        place = content.patient_from_voxel.tolist()
        digest.update(repr((content.slope, content.intercept, place, content.modality, content.unit)).encode())
    if isinstance(content, Labels):
        digest.update(repr((content.patient_from_voxel.tolist(), content.labels)).encode())
    digest.update(array.data.cast("B"))
    key = digest.hexdigest()
    # What is kept alive here cannot be mistaken for another at its address.
    _keys[id(native)] = (native, key)
    while len(_keys) > MOST_RESIDENT:
        _keys.popitem(last=False)
    return key


def detach(plan: Plan) -> tuple[Plan, list[Shared]]:
    """A plan without what is heavy in it, and that."""
    shared: dict[str, Shared] = {}

    def ref(content: Heavy) -> Any:
        key = key_of(content)
        if isinstance(content, Volume):
            # What was found in it stays behind: what that hid is hidden already.
            content = Volume(content.native.bare())
        shared.setdefault(key, Shared(key, content))
        return Ref(key)

    return _each(plan, ref, (Volume, Labels, EnvironmentMap)), list(shared.values())


def _each(plan: Plan, change: Callable[[Any], Any], kinds: Any) -> Plan:
    """A plan with something else in place of all that is of some kinds."""

    def changed(thing: Any, *names: str) -> Any:
        # Not by `replace`: what stands in for a volume is none, and would be refused.
        made = copy.copy(thing)
        for name in names:
            if isinstance(value := getattr(thing, name), kinds):
                object.__setattr__(made, name, change(value))
        return made

    instances = []
    for instance in plan.scene.volumes:
        made = changed(instance, "volume", "labels")
        if instance.peel is not None:
            object.__setattr__(made, "peel", changed(instance.peel, "depth"))
        instances.append(made)
    scene = copy.copy(plan.scene)
    object.__setattr__(scene, "volumes", tuple(instances))
    object.__setattr__(scene, "environment", changed(scene.environment, "source"))
    return replace(plan, scene=scene)


_resident: OrderedDict[str, Heavy] = OrderedDict()


def attach(plan: Plan, shared: tuple[Shared, ...]) -> Plan:
    """The plan with what is heavy in it: the same objects for each part, so that the GPU has them already."""
    for one in shared:
        _resident.setdefault(one.key, one.content)
        _resident.move_to_end(one.key)
    keys = {one.key for one in shared}
    while len(_resident) > max(MOST_RESIDENT, len(keys)):
        _resident.popitem(last=False)
    found: dict[str, Any] = {key: _resident[key] for key in keys}
    return _each(plan, lambda ref: found[ref.key], Ref)
