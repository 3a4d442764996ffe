"""How a scene travels: volumes and maps of light apart from it, each once to each worker, and known there by what they hold."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lumivox.rendering import Plan
from lumivox.scene import EnvironmentMap, Scene
from lumivox.volume import Volume

MOST_RESIDENT = 16
"""Volumes and maps that a worker keeps after their job, the last used."""

Heavy = Volume | EnvironmentMap


@dataclass(frozen=True)
class Shared:
    """A volume or a map under the hash of all that is in it."""

    key: str
    content: Heavy

    def __dask_tokenize__(self) -> tuple[str, str]:
        return ("lumivox", self.key)


@dataclass(frozen=True)
class Ref:
    """Where a scene has a volume or a map."""

    key: str


_keys: OrderedDict[int, tuple[object, str]] = OrderedDict()


def key_of(content: Heavy) -> str:
    """The hash of all that is in a volume or a map."""
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
            # Labels stay behind: what they hid is hidden already.
            content = Volume(content.native)
        shared.setdefault(key, Shared(key, content))
        return Ref(key)

    instances = tuple(replace(instance, volume=ref(instance.volume)) for instance in plan.scene.volumes)
    environment = plan.scene.environment
    if isinstance(environment.source, EnvironmentMap):
        environment = replace(environment, source=ref(environment.source))
    scene = Scene(instances, environment, plan.scene.lights)
    return replace(plan, scene=scene), list(shared.values())


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
    instances = tuple(replace(instance, volume=_at(found, instance.volume)) for instance in plan.scene.volumes)
    environment = plan.scene.environment
    if isinstance(environment.source, Ref):
        environment = replace(environment, source=found[environment.source.key])
    return replace(plan, scene=Scene(instances, environment, plan.scene.lights))


def _at(found: dict[str, Any], ref: Any) -> Any:
    return found[ref.key] if isinstance(ref, Ref) else ref
