"""Compare two compiled models of MuJoCo object by object, in each array of mjModel that ``mujoco.introspect`` has.

Equal for MuJoCo, and therefore no difference, are: added sites and bodies without mass (a link is a body and a site), a
site that became a body, a visual added to a collision shape, both signs of a quaternion, other principal axes, and the
origin to which MuJoCo moves a mesh. This runs in the child process.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from .compiled_model import (
    BALL,
    FREE,
    HFIELD,
    KINDS,
    MESH,
    PIECES,
    REFERENCES,
    SDF,
    SLIDE,
    Model,
    Names,
    match,
    rotation,
)

# Fields that follow from others or from the first pose, and those that methods of ``Comparison`` compare.
_DERIVED = re.compile(
    r"body_(rootid|weldid|treeid|simple|sameframe|subtreemass|invweight0|margin|contype|conaffinity)"
    r"|dof_(bodyid|jntid|parentid|treeid|invweight0|M0|length)|D_diag|jnt_actuatorid|geom_(sameframe|aabb|rbound)"
    r"|site_sameframe|(cam|light)_(poscom0|pos0|mat0|dir0)|mesh_(extrema|scale)|pair_signature|actuator_ctrlspec"
    r"|tendon_(actuatorid|treeid|length0|invweight0)|actuator_(acc0|length0)|flex_(vert0|node0|size|rigid|centered)"
    r"|flex_(elemedge|elemlayer|shell)|flexedge_(invweight0|rigid)|.*_rownnz|.*(?<!ctrl|.out|.act)num|.*adr"
)
_BY_METHODS = re.compile(
    r"body_(parentid|pos|quat|mass|ipos|iquat|inertia|mocapid)|jnt_(bodyid|pos|axis)|(geom|site|cam|light)_bodyid"
    r"|(geom|site|cam|mesh)_(pos|quat)|light_(pos|dir)|geom_(size|group|rgba|matid)|key_(q|c|a|m).*|wrap_prm"
)

# A field that has no effect unless another one is set.
_GATES = {
    **dict.fromkeys(("jnt_solref", "jnt_solimp", "jnt_margin", "jnt_range"), "jnt_limited"),
    "jnt_actfrcrange": "jnt_actfrclimited",
    "tendon_range": "tendon_limited",
    "tendon_actfrcrange": "tendon_actfrclimited",
    "actuator_ctrlrange": "actuator_ctrllimited",
    "actuator_forcerange": "actuator_forcelimited",
    "actuator_actrange": "actuator_actlimited",
}
_OF_CONTACTS = (
    "condim",
    "priority",
    "solmix",
    "solref",
    "solimp",
    "friction",
    "margin",
    "gap",
    "surfacevel",
    "adhesion",
)

_SIZES = {2: 1, 3: 2, 5: 2}  # numbers of geom_size that mean something: of spheres, capsules, cylinders
_WELD, _JOINED = 1, 1  # mjEQ_WELD, mjWRAP_JOINT
_FILTER_PARENT = 1 << 10  # mjDSBL_FILTERPARENT
_VIEWER = ("global_", "headlight", "map", "quality", "rgba", "scale")  # groups of mjVisual
_CHOSEN = 2  # mjSLEEP_AUTO_ALLOWED: up to this, MuJoCo chose the policy itself
NO_MASS = 1e-12  # kg: what MuJoCo needs where there is none
_NUMBER, _RELATIVE = 1e-12, 1e-9  # MuJoCo turns degrees, quaternions and axes into others
POSE, SINGLE, SIMULATED = 1e-9, 1e-6, 1e-6
_SHOWN = 20  # numbers in a message


class Difference(NamedTuple):
    """A difference: the kind of object, its field ("" for the object itself), and both values in words."""

    kind: str
    field: str
    text: str


class Comparison:
    """Two models, which object is which in them, and the differences."""

    def __init__(self, source: Model, ours: Model, given: Names) -> None:
        self.source, self.ours = source, ours
        self.maps = match(source, ours, given)
        self.given = given
        self.found: list[Difference] = []

    def run(self, statistic: Any = None) -> list[Difference]:
        """Compare everything; ``statistic`` is the <statistic> of the source's mjSpec, nan where it has no value."""
        self._settings(statistic)
        self._objects()
        for field in import_module("mujoco.introspect.structs").STRUCTS["mjModel"].fields:
            extent = str(field.array_extent[0]) if getattr(field, "array_extent", None) else ""
            if extent and not _DERIVED.fullmatch(field.name) and not _BY_METHODS.fullmatch(field.name):
                self._array(field.name, extent)
        for one, other in self.maps["body"].items():
            self._body(one, other)
        for one, other in self.maps["joint"].items():
            self._joint(one, other)
        self._geoms()
        for kind in ("site", "camera", "light"):
            for one, other in self.maps[kind].items():
                self._frame(kind, one, other)
        for one, other in self.maps["mesh"].items():
            self._mesh(one, other)
        for one, other in self.maps["key"].items():
            self._key(one, other)
        self._order()
        self._touching()
        return self.found

    def tell(self, kind: str, index: int, field: str, text: str) -> None:
        """Report that an object of the source differs."""
        self.found.append(Difference(kind, field, f"{self.source.called(kind, index)}: {text}"))

    def values(self, kind: str, index: int, field: str, one: Any, other: Any, what: str = "") -> None:
        """Report two values that differ."""
        if not close(one, other):
            self.tell(kind, index, field, f"{what or field} {in_words(one, other)}")

    def _settings(self, statistic: Any) -> None:
        one, other = self.source.mj, self.ours.mj
        groups = [("option", one.opt, other.opt), ("size", one, other)]
        groups += [("viewer", getattr(one.vis, name), getattr(other.vis, name)) for name in _VIEWER]
        groups += [("viewer", one.stat, other.stat)] if statistic is not None else []
        for kind, theirs, own in groups:
            for field in ("nuserdata", "njmax", "nconmax") if kind == "size" else _numbers_of(theirs):
                if theirs is one.stat and not np.isfinite(getattr(statistic, field)).all():
                    continue
                if not close(getattr(theirs, field), getattr(own, field)):
                    text = f"{field} {in_words(getattr(theirs, field), getattr(own, field))}"
                    self.found.append(Difference(kind, field, text))

    def _objects(self) -> None:
        """Report what is missing in ours, has another name, or is in ours alone and makes a difference."""
        ours = self.ours
        for kind, names in self.source.names.items():
            for index, name in enumerate(names):
                other = self.maps[kind].get(index)
                if other is None:
                    if not (kind == "material" and self.source.is_colour(index)):
                        self.tell(kind, index, "", "is not in ours")
                elif name and kind not in ("mesh", "hfield", "texture", "material"):
                    own = ours.names[kind][other]
                    if own not in (name, self.given.get(kind, {}).get(index)):
                        self.tell(kind, index, "name", f"is called {own or 'nothing'} in ours")
        for kind in (
            "body",
            "joint",
            "geom",
            "pair",
            "equality",
            "tendon",
            "actuator",
            "sensor",
            "key",
            "flex",
            "skin",
        ):
            for index in sorted(set(range(len(ours.names[kind]))) - set(self.maps[kind].values())):
                is_harmless = (
                    (kind == "geom" and not ours.collides(index))
                    or (kind == "body" and ours.mj.body_mass[index] <= NO_MASS)
                    or (kind == "key" and ours.names["key"][index] == "home")  # every robot of ours has one
                )
                if not is_harmless:
                    self.found.append(Difference(kind, "", f"{ours.called(kind, index)} is in ours alone"))

    def _array(self, array: str, extent: str) -> None:
        """Compare an array of mjModel, object by object."""
        kinds = {count: kind for kind, (_, count) in KINDS.items()} | {"nv": "joint"}
        kind = PIECES[extent][0] if extent in PIECES else kinds.get(extent, "")
        field = array.partition("_")[2]
        if extent.startswith(("nflex", "nskin")):
            self._whole(array)
        elif array.endswith("_plugin"):
            for one, other in self.maps[kind].items():
                plugins = _plugin(self.source.mj, array, one), _plugin(self.ours.mj, array, other)
                if plugins[0] != plugins[1]:
                    self.tell(kind, one, "plugin", f"plugin {plugins[0]} in the source, {plugins[1]} in ours")
        elif array in REFERENCES:
            for one, other in self.maps[kind].items():
                self._reference(kind, array, extent, one, other)
        elif kind:
            for one, other in self.maps[kind].items():
                if not self._is_void(kind, array, field, one, other):
                    self._value(kind, array, extent, one, other)

    def _is_void(self, kind: str, array: str, field: str, one: int, other: int) -> bool:
        """Return True if a field of an object has no effect."""
        source, ours = self.source, self.ours
        if array in _GATES:
            gate, extent = _GATES[array], "nu" if array == "actuator_ctrlrange" else ""
            return not (source.value(gate, extent, one).all() and ours.value(gate, extent, other).all())
        if kind == "geom" and field in _OF_CONTACTS:
            return not source.collides(one)  # a pair that names it has its own
        if array in ("tendon_rgba", "tendon_width"):
            return bool(source.mj.wrap_type[source.mj.tendon_adr[one]] == _JOINED)  # is not drawn
        is_frame = kind == "site" and ours.names["site"][other] in ours.names["body"]  # as all bodies have one
        return is_frame and field in ("type", "size", "rgba", "group")

    def _value(self, kind: str, array: str, extent: str, one: int, other: int) -> None:
        theirs, own = self.source.value(array, extent, one), self.ours.value(array, extent, other)
        if array.endswith("_user"):
            size = max(len(theirs), len(own))
            theirs, own = np.pad(theirs, (0, size - len(theirs))), np.pad(own, (0, size - len(own)))
        if array == "eq_data" and self.source.mj.eq_type[one] == _WELD:
            theirs, own = (np.concatenate([row[:6], rotation(row[6:10]).ravel(), row[10:]]) for row in (theirs, own))
        if array == "actuator_lengthrange" and np.allclose(theirs, own, rtol=SIMULATED, atol=SIMULATED):
            return  # found by a simulation
        self.values(kind, one, array.partition("_")[2], theirs, own)

    def _reference(self, kind: str, array: str, extent: str, one: int, other: int) -> None:
        theirs, own = self.source.references(array, extent, one), self.ours.references(array, extent, other)
        if array == "wrap_objid":  # the site at the side of a solid is a number among others
            for mine, model, index in ((theirs, self.source, one), (own, self.ours, other)):
                prm = model.value("wrap_prm", extent, index)
                mine += [("site" if of == "geom" else "", n) for (of, _), n in zip(mine, prm, strict=True)]
        if len(theirs) != len(own) or not all(map(self._is_same, theirs, own)):
            texts = [
                ", ".join("none" if n < 0 else model.called(of, int(n)) if of else f"{n:g}" for of, n in pairs)
                for model, pairs in ((self.source, theirs), (self.ours, own))
            ]
            field = array.partition("_")[2]
            what = f"{field} {texts[0] or 'nothing'} in the source, {texts[1] or 'nothing'} in ours"
            self.tell(kind, one, field, what)

    def _is_same(self, theirs: tuple[str, Any], own: tuple[str, Any]) -> bool:
        (kind, one), (other_kind, other) = theirs, own
        if kind != other_kind or one < 0 or not kind:
            return kind == other_kind and close(one, other)
        expected = self.maps[kind].get(int(one))
        if expected is None:
            return kind == "material" and self.source.is_colour(int(one))
        if kind == "body" and other >= 0 and self._is_rigid(expected, int(other)):
            pos, turn = self.ours.seen_from(expected, int(other), np.zeros(3), np.eye(3))
            return near(pos, np.zeros(3)) and near(turn, np.eye(3))
        if kind == "mesh":  # it may be in ours in several forms
            pairs = self.maps["geom"].items()
            forms = {int(self.ours.mj.geom_dataid[b]) for a, b in pairs if self.source.mj.geom_dataid[a] == one}
            return other in {expected, *forms}
        return bool(expected == other)

    def _whole(self, array: str) -> None:
        """Compare an array of all flexible bodies or skins as one piece: few robots have them."""
        theirs, own = np.asarray(getattr(self.source.mj, array)), np.asarray(getattr(self.ours.mj, array))
        if array in REFERENCES:
            of = self.maps[REFERENCES[array]]
            theirs = np.array([of.get(int(number), -2) if number >= 0 else -1 for number in theirs])
        kind, _, field = array.partition("_")
        if (own.size or not theirs.size) and not close(theirs, own):
            self.found.append(Difference(kind[:4], field, f"{array} {in_words(theirs, own)}"))

    def _is_rigid(self, one: int, other: int) -> bool:
        """Return True if no joint of ours moves two bodies against each other."""
        return bool(self.ours.mj.body_weldid[one] == self.ours.mj.body_weldid[other])

    def _body(self, one: int, other: int) -> None:
        theirs, own = self.source.mj, self.ours.mj
        is_captured, mine = bool(theirs.body_mocapid[one] >= 0), bool(own.body_mocapid[other] >= 0)
        self.values("body", one, "mocapid", is_captured, mine, "motion capture")
        self.values("body", one, "sleep", _sleep_policy(theirs, one), _sleep_policy(own, other), "sleep policy")
        if not one:
            return
        above = next(body for body in self.source.above(one)[1:] if body in self.maps["body"])
        base = self.maps["body"][above]
        if base in self.ours.above(other):
            place = np.zeros(3), np.eye(3)
            self._poses(
                "body", one, self.source.seen_from(above, one, *place), self.ours.seen_from(base, other, *place)
            )
        else:
            self.tell("body", one, "parentid", f"is not in {self.ours.called('body', base)} in ours")
        masses = float(theirs.body_mass[one]), float(own.body_mass[other])
        if max(masses) <= NO_MASS:
            return
        self.values("body", one, "mass", *masses)
        if not near(theirs.body_ipos[one], own.body_ipos[other]):
            places = in_words(theirs.body_ipos[one], own.body_ipos[other])
            self.tell("body", one, "ipos", f"centre of mass {places}")
        a, b = (_inertia(mj, body) for mj, body in ((theirs, one), (own, other)))
        if np.abs(a - b).max() > max(np.trace(a) * 1e-8, 1e-14):
            moments = in_words(np.diag(a), np.diag(b))
            self.tell("body", one, "inertia", f"inertia {moments}, along the axes of the body")

    def _poses(self, kind: str, index: int, theirs: tuple[Any, Any], own: tuple[Any, Any]) -> None:
        if not near(theirs[0], own[0]):
            self.tell(kind, index, "pos", f"position {in_words(theirs[0], own[0])}")
        if not near(theirs[1], own[1]):
            self.tell(kind, index, "quat", f"orientation differs by {np.abs(theirs[1] - own[1]).max():.2g}")

    def _frame(self, kind: str, one: int, other: int) -> None:
        """Compare where something is in its body, which may be fixed to the body of the source in ours."""
        base, holds = self.maps["body"].get(self.source.body_of(kind, one)), self.ours.body_of(kind, other)
        if base is not None and not self._is_rigid(base, holds):
            self.tell(kind, one, "bodyid", f"is on {self.ours.called('body', holds)} in ours")
        elif base is not None:
            own = self.ours.seen_from(base, holds, *self.ours.frame(kind, other))
            self._poses(kind, one, self.source.frame(kind, one), own)

    def _joint(self, one: int, other: int) -> None:
        source, ours, theirs, own = self.source, self.ours, self.source.mj, self.ours.mj
        kind = int(theirs.jnt_type[one])
        if kind != own.jnt_type[other]:
            return
        body, moved = source.body_of("joint", one), ours.body_of("joint", other)
        base = self.maps["body"].get(body)
        above = self.maps["body"].get(int(theirs.body_parentid[body]), 0)
        if base is not None and (moved not in ours.above(base) or moved in ours.above(above)):
            self.tell("joint", one, "bodyid", f"moves {ours.called('body', moved)} in ours")
        elif base is not None:
            anchor, turn = ours.seen_from(base, moved, own.jnt_pos[other], np.eye(3))
            axis = turn @ own.jnt_axis[other]
            if kind not in (FREE, BALL) and not near(theirs.jnt_axis[one], axis):
                self.tell("joint", one, "axis", f"axis {in_words(theirs.jnt_axis[one], axis)}")
            if kind not in (FREE, SLIDE) and not near(theirs.jnt_pos[one], anchor):
                self.tell("joint", one, "pos", f"anchor {in_words(theirs.jnt_pos[one], anchor)}")
        models = ((source, one), (ours, other))
        springs = any(np.any(m.mj.jnt_stiffness[i]) or np.any(m.mj.jnt_stiffnesspoly[i]) for m, i in models)
        for field, what in (("qpos0", "first position"), ("qpos_spring", "rest of the spring")):
            values = [getattr(model.mj, field)[model.positions(joint)] for model, joint in models]
            if (field == "qpos0" or springs) and not _same_position(*values):
                self.tell("joint", one, field, f"{what} {in_words(*values)}")

    def _geoms(self) -> None:
        theirs, own, twins = self.source.mj, self.ours.mj, self._twins()
        for one, other in self.maps["geom"].items():
            kind = int(theirs.geom_type[one])
            if kind != own.geom_type[other]:
                continue
            self._frame("geom", one, other)
            if kind not in (MESH, SDF, HFIELD):
                count = _SIZES.get(kind, 3)
                self.values("geom", one, "size", theirs.geom_size[one][:count], own.geom_size[other][:count])
            groups = theirs.geom_group[one], own.geom_group[other]
            if groups[1] not in (groups[0], *((0, 3) if self.source.collides(one) else (1, 2))):
                self.values("geom", one, "group", *groups)
            material, seen = int(theirs.geom_matid[one]), twins.get(other, other)
            expected = self.maps["material"].get(material, -1)
            of_ours = (int(own.geom_matid[geom]) for geom in (other, seen))
            if (
                expected >= 0
                and not self.source.is_colour(material)
                and not any(_same_material(own, number, expected) for number in of_ours)
            ):
                self.tell("geom", one, "matid", f"has not {self.source.called('material', material)} in ours")
            if not close(self.source.colour(one), self.ours.colour(other)):
                self.values("geom", one, "rgba", self.source.colour(one), self.ours.colour(seen), what="colour")

    def _twins(self) -> dict[int, int]:
        """Return the visual that ours has at the place of a collision shape, by the number of that."""
        mj, known = self.ours.mj, set(self.maps["geom"].values())

        def solid(geom: int) -> Any:
            numbers = (*mj.geom_pos[geom], *mj.geom_quat[geom], *mj.geom_size[geom])
            return (int(mj.geom_bodyid[geom]), int(mj.geom_type[geom]), int(mj.geom_dataid[geom]), *numbers)

        waiting: dict[Any, list[int]] = {}
        for geom in range(mj.ngeom):
            if geom not in known and not self.ours.collides(geom):
                waiting.setdefault(solid(geom), []).append(geom)
        pairs = ((geom, waiting.get(solid(geom), [])) for geom in sorted(known))
        return {geom: same.pop(0) if len(same) > 1 else same[0] for geom, same in pairs if same}

    def _mesh(self, one: int, other: int) -> None:
        if other < 0:
            return
        theirs, own = self.source.mesh(one), self.ours.mesh(other)
        for what, a, b in zip(("vertices", "normals"), theirs[:2], own[:2], strict=True):
            if a.shape != b.shape or np.abs(a - b).max(initial=0) > 1e-5 * max(1e-3, np.abs(a).max(initial=0)):
                self.tell("mesh", one, what, f"{what} differ")
        if theirs[2] and theirs[2] != own[2]:  # only a mesh that collides has a hull
            self.tell("mesh", one, "graph", f"vertices of the hull {in_words(theirs[2], own[2])}")

    def _key(self, one: int, other: int) -> None:
        source, ours = self.source, self.ours
        for joint, mine in self.maps["joint"].items():
            if source.mj.jnt_type[joint] != ours.mj.jnt_type[mine]:
                continue
            name = source.called("joint", joint)
            values = source.mj.key_qpos[one][source.positions(joint)], ours.mj.key_qpos[other][ours.positions(mine)]
            if not _same_position(*values):
                self.tell("key", one, "qpos", f"position of {name} {in_words(*values)}")
            values = source.mj.key_qvel[one][source.dofs(joint)], ours.mj.key_qvel[other][ours.dofs(mine)]
            self.values("key", one, "qvel", *values, what=f"speed of {name}")
        for actuator, mine in self.maps["actuator"].items():
            name = source.called("actuator", actuator)
            values = (
                source.mj.key_ctrl[one][source.piece("nu", actuator)],
                ours.mj.key_ctrl[other][ours.piece("nu", mine)],
            )
            self.values("key", one, "ctrl", *values, what=f"control of {name}")
            values = (
                source.mj.key_act[one][source.activations(actuator)],
                ours.mj.key_act[other][ours.activations(mine)],
            )
            self.values("key", one, "act", *values, what=f"activation of {name}")
        for body, mine in self.maps["body"].items():
            captured = int(source.mj.body_mocapid[body]), int(ours.mj.body_mocapid[mine])
            if min(captured) < 0:
                continue
            rows = list(zip((source.mj, ours.mj), (one, other), captured, strict=True))
            places = [np.reshape(mj.key_mpos[key], (-1, 3))[at] for mj, key, at in rows]
            turns = [np.reshape(mj.key_mquat[key], (-1, 4))[at] for mj, key, at in rows]
            self.values("key", one, "mpos", places[0], places[1], f"place of {source.called('body', body)}")
            if not near(rotation(turns[0]), rotation(turns[1])):
                self.tell("key", one, "mquat", f"orientation of {source.called('body', body)} {in_words(*turns)}")

    def _order(self) -> None:
        """Compare the order of joints, controls and measurements, and which keys come first: programs count them."""
        keys = [other for _, other in sorted(self.maps["key"].items())]
        if keys != list(range(len(keys))):
            self.found.append(
                Difference("order", "key", "the keys of the source are not the first ones, in their order")
            )
        for kind, field in (("joint", "jnt_qposadr"), ("actuator", "actuator_ctrladr"), ("sensor", "sensor_adr")):
            places = [int(getattr(self.ours.mj, field)[other]) for _, other in sorted(self.maps[kind].items())]
            if places != sorted(places):
                self.found.append(Difference("order", kind, f"the {kind}s are in another order in ours"))

    def _touching(self) -> None:
        """Compare which bodies may touch."""
        source, geoms = self.source, list(self.maps["geom"])
        theirs, own = may_touch(source.mj, geoms), may_touch(self.ours.mj, list(self.maps["geom"].values()))
        texts = set()
        for a, b in zip(*np.nonzero(np.triu(theirs != own)), strict=True):
            bodies = sorted(int(source.mj.geom_bodyid[geoms[at]]) for at in (a, b))
            names = " and ".join(source.called("body", body) for body in bodies)
            texts.add(f"{names} may touch in {'the source' if theirs[a, b] else 'ours'} alone")
        self.found += [Difference("contact", "", text) for text in sorted(texts)]


def _numbers_of(struct: Any) -> Iterator[str]:
    return (name for name in dir(struct) if not name.startswith("_") and not callable(getattr(struct, name)))


def _sleep_policy(mj: Any, body: int) -> int:
    """Return the policy that the file has for the tree of a body; 0 is what MuJoCo chose."""
    tree = int(mj.body_treeid[body])
    policy = int(mj.tree_sleep_policy[tree]) if tree >= 0 else 0
    return policy if policy > _CHOSEN else 0


def _inertia(mj: Any, body: int) -> Any:
    """Return the moments of inertia along the axes of a body, about its centre of mass (kg*m^2), 3x3."""
    turn = rotation(mj.body_iquat[body])
    return turn @ np.diag(mj.body_inertia[body]) @ turn.T


def _same_position(one: Any, other: Any) -> bool:
    """Return True if two positions of a joint are equal: the quaternion of a ball or free joint has two signs."""
    if len(one) == 1:
        return near(one, other)
    return near(one[:-4], other[:-4]) and near(rotation(one[-4:]), rotation(other[-4:]))


def _same_material(mj: Any, one: int, other: int) -> bool:
    """Return True if two materials of a model look the same: ours may have one twice."""
    if one < 0 or other < 0:
        return one == other
    fields = [name for name in dir(mj) if name.startswith("mat_") and name != "mat_texid"]
    textured = [bool((mj.mat_texid[index] >= 0).any()) for index in (one, other)]
    return textured[0] == textured[1] and all(close(getattr(mj, f)[one], getattr(mj, f)[other]) for f in fields)


def _plugin(mj: Any, array: str, index: int) -> str:
    """Return which plugin an object has, with its settings; empty for none."""
    instance = int(np.ravel(getattr(mj, array))[index])
    if instance < 0:
        return ""
    ends = [*np.ravel(mj.plugin_attradr)[1:], mj.npluginattr]
    raw = mj.plugin_attr
    data = raw if isinstance(raw, bytes) else np.asarray(raw).astype(np.uint8).tobytes()
    settings = data[int(np.ravel(mj.plugin_attradr)[instance]) : int(ends[instance])].decode("utf-8", "replace")
    return f"{int(np.ravel(mj.plugin)[instance])}: {settings!r}"


def may_touch(mj: Any, geoms: Sequence[int]) -> Any:
    """Return for which pairs of geoms MuJoCo would look for contacts, as a matrix: masks, parents, excludes, pairs."""
    index = np.array(geoms, dtype=int)
    kind, affinity, body = mj.geom_contype[index], mj.geom_conaffinity[index], mj.geom_bodyid[index]
    weld = mj.body_weldid[body]
    above = mj.body_weldid[mj.body_parentid[weld]]
    touch = ((kind[:, None] & affinity[None, :]) | (kind[None, :] & affinity[:, None])) != 0
    touch &= weld[:, None] != weld[None, :]
    if not mj.opt.disableflags & _FILTER_PARENT:
        child = (weld[:, None] == above[None, :]) & (weld[:, None] != 0) & (weld[None, :] != 0)
        touch &= ~(child | child.T)
    low, high = np.minimum(body[:, None], body[None, :]), np.maximum(body[:, None], body[None, :])
    touch &= ~np.isin((low << 16) + high, mj.exclude_signature)
    place = {int(geom): at for at, geom in enumerate(index)}
    for one, other in zip(mj.pair_geom1, mj.pair_geom2, strict=True):
        if int(one) in place and int(other) in place:
            touch[place[int(one)], place[int(other)]] = touch[place[int(other)], place[int(one)]] = True
    return touch


def close(one: Any, other: Any) -> bool:
    """Return True if two values of one shape are equal within rounding error."""
    a, b = np.asarray(one), np.asarray(other)
    return a.shape == b.shape and bool(_equal(a, b).all())


def _equal(a: Any, b: Any) -> Any:
    if "f" not in a.dtype.kind + b.dtype.kind:
        return a == b
    is_single = np.float32 in (a.dtype, b.dtype)
    relative, absolute = (SINGLE, SINGLE) if is_single else (_RELATIVE, _NUMBER)
    return np.isclose(a, b, relative, absolute, equal_nan=True)


def near(one: Any, other: Any) -> bool:
    """Return True if two positions, or two rotation matrices, are equal within rounding error."""
    return bool(np.abs(np.asarray(one, dtype=float) - other).max(initial=0) <= POSE)


def in_words(one: Any, other: Any) -> str:
    """Return two values in words; of long ones how many differ, and the first of those."""
    a, b = np.ravel(one), np.ravel(other)
    if np.shape(one) == np.shape(other) and a.size > _SHOWN:
        differ = np.flatnonzero(~_equal(a, b))
        first = int(differ[0]) if len(differ) else 0
        return f"differs in {len(differ)} of {a.size} numbers: {in_words(a[first], b[first])}"
    if max(a.size, b.size) > _SHOWN:
        return f"has {a.size} numbers in the source, {b.size} in ours"
    texts = [" ".join(f"{n:.6g}" if abs(n) > _NUMBER else "0" for n in array.tolist()) for array in (a, b)]
    if texts[0] == texts[1]:
        texts = [" ".join(map(repr, array.tolist())) for array in (a, b)]
    return f"{texts[0] or 'nothing'} in the source, {texts[1] or 'nothing'} in ours"
