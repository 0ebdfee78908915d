"""Two compiled models side by side: their names and frames, and which object of one is which of the other.

Objects are matched by name, or by the name that the import gave them; those without one by what they are and where
they stand, in order. ``compared`` compares what is matched here. Both run in the child process that has MuJoCo.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .compared_fields import KINDS

Told = Mapping[str, Mapping[int, str]]
"""The names that the import gave, by kind of object and its index in the source."""

HINGE, SLIDE, BALL, FREE = 3, 2, 1, 0
HFIELD, SPHERE, CAPSULE, CYLINDER, MESH, SDF = 1, 2, 3, 5, 7, 8


class Model:
    """A compiled model: the arrays of MuJoCo, names, and the frames of its bodies at the first pose.

    ``references`` is where the vertices of a mesh, scaled, are counted from (position, rotation), where ``refpos`` or
    ``refquat`` say it.
    """

    def __init__(self, mujoco: Any, model: Any, spec: Any = None) -> None:
        self.mujoco, self.mj = mujoco, model
        self.references = {
            mesh.id: (np.asarray(mesh.refpos) * mesh.scale, rotation(mesh.refquat))
            for mesh in (spec.meshes if spec is not None else ())
            if any(mesh.refpos) or any(mesh.refquat[1:])
        }
        self.names = {
            kind: [self._name(entry.obj, index) for index in range(getattr(model, entry.total))]
            for kind, entry in KINDS.items()
        }
        self.turn, self.at = np.zeros((model.nbody, 3, 3)), np.zeros((model.nbody, 3))
        for body in range(model.nbody):
            above, turn = model.body_parentid[body], rotation(model.body_quat[body])
            if body == 0:
                self.turn[0], self.at[0] = turn, model.body_pos[0]
                continue
            self.turn[body] = self.turn[above] @ turn
            self.at[body] = self.at[above] + self.turn[above] @ model.body_pos[body]

    def _name(self, obj: str, index: int) -> str:
        return self.mujoco.mj_id2name(self.mj, getattr(self.mujoco.mjtObj, f"mjOBJ_{obj}"), index) or ""

    def seen_from(self, base: int, body: int, pos: Any, turn: Any) -> tuple[Any, Any]:
        """Return position and rotation in the frame of one body of what has those in the frame of another."""
        back = self.turn[base].T
        return back @ (self.at[body] + self.turn[body] @ pos - self.at[base]), back @ self.turn[body] @ turn

    def is_rigid(self, one: int, other: int) -> bool:
        """Say whether no joint moves two bodies against each other."""
        return bool(self.mj.body_weldid[one] == self.mj.body_weldid[other])

    def above(self, body: int) -> list[int]:
        """Return a body and all that it stands in, the world last."""
        way = [body]
        while way[-1]:
            way.append(int(self.mj.body_parentid[way[-1]]))
        return way

    def called(self, kind: str, index: int) -> str:
        """Return what to call an object in a message."""
        name = self.names[kind][index]
        if name or kind not in ("geom", "site", "joint", "camera", "light"):
            return f"{kind} {name or index}"
        body = int(getattr(self.mj, f"{KINDS[kind].prefix}_bodyid")[index])
        return f"{kind} {index} of {self.called('body', body)}"


def rotation(quaternion: Any) -> Any:
    """Return the rotation matrix of a quaternion (w, x, y, z)."""
    w, x, y, z = np.asarray(quaternion, dtype=float) / (np.linalg.norm(quaternion) or 1.0)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


Maps = dict[str, dict[int, int]]
"""The index in ours by that in the source, by kind."""


def match(source: Model, ours: Model, told: Told) -> Maps:
    """Return which object is which."""
    maps: Maps = {"body": _bodies(source, ours, told.get("body", {}))}
    for kind in KINDS:
        if kind == "body":
            continue
        by_name = {name: index for index, name in enumerate(ours.names[kind]) if name}
        made: dict[int, int] = {}
        maps[kind] = made
        for index, name in enumerate(source.names[kind]):
            wanted = told.get(kind, {}).get(index, "") or name
            found = by_name.get(wanted)
            if found is None and kind in ("material", "texture"):  # ours begin with the name of the robot
                ends = [own for own in by_name if own.endswith(f"_{wanted}")]
                found = by_name[min(ends, key=len)] if ends else None
            if found is not None and found not in made.values():
                made[index] = found
        _in_order(source, ours, kind, maps)
        if kind == "geom":
            _by_geoms(source, ours, maps)
        if kind == "material":
            _by_materials(source, ours, maps)
    return maps


def _bodies(source: Model, ours: Model, told: Mapping[int, str]) -> dict[int, int]:
    by_name = {name: index for index, name in enumerate(ours.names["body"]) if name}
    made = {0: 0}
    for index, name in enumerate(source.names["body"]):
        found = by_name.get(told.get(index) or name) if index else None
        if found:
            made[index] = found
    taken = set(made.values())
    for index in range(source.mj.nbody):
        if index in made:
            continue
        above = made.get(int(source.mj.body_parentid[index]))
        free = (j for j in range(1, ours.mj.nbody) if ours.mj.body_parentid[j] == above and j not in taken)
        found = next(free, None)
        if found is not None:
            made[index] = found
            taken.add(found)
    return made


def _in_order(source: Model, ours: Model, kind: str, maps: Maps) -> None:
    """Match what has no counterpart by name with what is of the same sort, the nearest one, in order."""
    made = maps[kind]
    sort: Sort = _SORTS.get(kind, _any)
    taken = set(made.values())
    waiting: dict[Any, list[int]] = {}
    for index in range(len(ours.names[kind])):
        if index not in taken:
            waiting.setdefault(sort(ours, index, None), []).append(index)
    for index in range(len(source.names[kind])):
        if index not in made and (same := waiting.get(sort(source, index, maps))):
            place = _place(source, kind, index)
            nearest = min(same, key=lambda other: _apart(place, _place(ours, kind, other)))
            same.remove(nearest)
            made[index] = nearest


def _place(model: Model, kind: str, index: int) -> Any:
    """Return where something stands at the first pose, and its sizes; nothing of what stands nowhere."""
    if kind not in ("geom", "site", "camera", "light"):
        return np.zeros(0)
    mj, prefix = model.mj, KINDS[kind].prefix
    body, pos = int(getattr(mj, f"{prefix}_bodyid")[index]), getattr(mj, f"{prefix}_pos")[index]
    sizes = mj.geom_size[index] if kind == "geom" else ()
    return np.concatenate([model.at[body] + model.turn[body] @ pos, sizes])


def _apart(one: Any, other: Any) -> float:
    """Return how far two places are apart, a nanometre being nothing."""
    return round(float(np.abs(one - other).max(initial=0)), 9)


def _by_geoms(source: Model, ours: Model, maps: Maps) -> None:
    """Let meshes and height fields be those of the geoms that have them: their own names are made anew."""
    for kind, types in (("mesh", (MESH, SDF)), ("height field", (HFIELD,))):
        found: dict[int, int] = {}
        for one, other in maps["geom"].items():
            if source.mj.geom_type[one] in types and ours.mj.geom_type[other] in types:
                found.setdefault(int(source.mj.geom_dataid[one]), int(ours.mj.geom_dataid[other]))
        maps[kind] = maps[kind] | found


def _by_materials(source: Model, ours: Model, maps: Maps) -> None:
    """Let textures be those of the materials that have them: those of files have other names in ours."""
    for one, other in maps["material"].items():
        for theirs, own in zip(source.mj.mat_texid[one], ours.mj.mat_texid[other], strict=True):
            if theirs >= 0 and own >= 0:
                maps["texture"].setdefault(int(theirs), int(own))


Sort = Callable[[Model, int, "Maps | None"], Any]
"""What an object is, in terms of ours: of the source with the maps so far."""


def _to(maps: Maps | None, kind: str, index: Any) -> int:
    if maps is None or index < 0:
        return int(index)
    return maps.get(kind, {}).get(int(index), -2 - int(index))


def _any(*_: Any) -> Any:
    return ()


def _by_what_has_it(_model: Model, _index: int, maps: Maps | None) -> Any:
    return "of the source" if maps else "ours"


def _texture(model: Model, index: int, maps: Maps | None) -> Any:
    if maps is not None and model.names["texture"][index]:
        return "of the source"
    return tuple(int(getattr(model.mj, f"tex_{field}")[index]) for field in ("type", "height", "width"))


def _tendon(model: Model, index: int, _maps: Maps | None) -> Any:
    return (int(model.mj.tendon_type[index]), int(model.mj.tendon_num[index]))


def _on_body(prefix: str, *fields: str) -> Sort:
    def sort(model: Model, index: int, maps: Maps | None) -> Any:
        values = (getattr(model.mj, f"{prefix}_{field}")[index].item() for field in fields)
        return (_to(maps, "body", getattr(model.mj, f"{prefix}_bodyid")[index]), *values)

    return sort


def _geom(model: Model, index: int, maps: Maps | None) -> Any:
    collides = bool(model.mj.geom_contype[index] or model.mj.geom_conaffinity[index])
    mesh = int(model.mj.geom_dataid[index]) if model.mj.geom_type[index] in (MESH, SDF) else -1
    sizes = (int(model.mj.mesh_vertnum[mesh]), int(model.mj.mesh_facenum[mesh])) if mesh >= 0 else ()
    return (*_on_body("geom", "type")(model, index, maps), collides, *sizes)


def _pair(model: Model, index: int, maps: Maps | None) -> Any:
    return frozenset(_to(maps, "geom", ids[index]) for ids in (model.mj.pair_geom1, model.mj.pair_geom2))


def _equality(model: Model, index: int, maps: Maps | None) -> Any:
    kind = kind_of_joined(model, index)
    ids = (model.mj.eq_obj1id[index], model.mj.eq_obj2id[index])
    return (int(model.mj.eq_type[index]), *(_to(maps, kind, one) if kind else int(one) for one in ids))


def _actuator(model: Model, index: int, maps: Maps | None) -> Any:
    kind, target = kind_of_target(model, index), int(model.mj.actuator_trnid[index][0])
    return (kind, _to(maps, kind, target) if kind else target)


def _sensor(model: Model, index: int, maps: Maps | None) -> Any:
    kind = kind_of_object(model, int(model.mj.sensor_objtype[index]))
    target = int(model.mj.sensor_objid[index])
    return (int(model.mj.sensor_type[index]), _to(maps, kind, target) if kind in (maps or KINDS) else target)


_SORTS: Mapping[str, Sort] = {
    "joint": _on_body("jnt", "type"),
    "geom": _geom,
    "site": _on_body("site", "type"),
    "camera": _on_body("cam", "mode"),
    "light": _on_body("light", "mode"),
    "mesh": _by_what_has_it,
    "texture": _texture,
    "material": _by_what_has_it,
    "height field": _by_what_has_it,
    "pair": _pair,
    "equality": _equality,
    "tendon": _tendon,
    "actuator": _actuator,
    "sensor": _sensor,
}


def kind_of_object(model: Model, number: int) -> str:
    """Return the kind of object that a number of mjtObj says; empty for none of those that have names."""
    for name, value in model.mujoco.mjtObj.__members__.items():
        if int(value) == number:
            word = name.removeprefix("mjOBJ_").replace("XBODY", "BODY")
            return next((kind for kind, entry in KINDS.items() if entry.obj == word), "")
    return ""


def kind_of_joined(model: Model, equality: int) -> str:
    """Return the kind of object that an equality joins; empty for those that have no names."""
    kinds = model.mujoco.mjtEq
    number = int(model.mj.eq_type[equality])
    if number in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
        return kind_of_object(model, int(model.mj.eq_objtype[equality]))
    if number == kinds.mjEQ_DISTANCE:
        return "geom"
    return {int(kinds.mjEQ_JOINT): "joint", int(kinds.mjEQ_TENDON): "tendon"}.get(number, "flex")


def kind_of_target(model: Model, actuator: int) -> str:
    """Return the kind of object that an actuator acts on."""
    number = int(model.mj.actuator_trntype[actuator])
    names = {int(value): name for name, value in model.mujoco.mjtTrn.__members__.items()}
    word = names.get(number, "").removeprefix("mjTRN_")
    sites = {"SLIDERCRANK": "site", "SITE": "site", "SO3": "site", "JOINTINPARENT": "joint"}
    return sites.get(word, word.lower() if word in ("JOINT", "TENDON", "BODY") else "")
