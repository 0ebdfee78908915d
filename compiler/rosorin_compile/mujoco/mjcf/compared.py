"""Compared: whether two compiled models are one robot to MuJoCo, field by field of mjModel, told by feature.

What differs by right is no difference: a link is a body and a site, so sites and bodies without mass may be added; a
frame of a site may have become a body; visuals may be added to what collides; quaternions have two signs, inertias
several principal axes, meshes an origin that MuJoCo moves.

``compared_fields`` says of each field how it is compared, ``matched`` what is which. It runs in the child process.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from .compared_drives import actuators, keys, order, tendons
from .compared_fields import BODY_IDS, GATES, KINDS, MATERIAL_IDS, OF_DOFS, REFERENCES, WHOLE
from .compared_values import (
    both,
    close,
    colour,
    dofs,
    hull,
    inertia,
    is_mocap,
    may_touch,
    near,
    near_pose,
    padded,
    plugin,
    public,
    same_material,
    same_solid,
    shape_frame,
    sleep_policy,
    value,
    vertices,
)
from .matched import (
    BALL,
    CAPSULE,
    CYLINDER,
    FREE,
    HFIELD,
    MESH,
    SDF,
    SLIDE,
    SPHERE,
    Model,
    Told,
    kind_of_joined,
    kind_of_object,
    kind_of_target,
    match,
    rotation,
)

WELD = 1  # mjEQ_WELD
JOINED = 1  # mjWRAP_JOINT
NO_MASS = 1e-12  # kg: what MuJoCo has to have where there is none

LOST = {
    "body": "bodies",
    "joint": "types of joints",
    "mesh": "shapes",
    "height field": "shapes",
    "texture": "textures",
    "material": "shine",
    "geom": "shapes",
    "site": "sites",
    "camera": "cameras",
    "light": "lights",
    "pair": "contact pairs",
    "equality": "equalities",
    "tendon": "tendons",
    "actuator": "actuators",
    "sensor": "sensors",
    "number": "numbers and texts",
    "text": "numbers and texts",
    "tuple": "numbers and texts",
    "key": "keys",
    "flex": "flexible bodies",
    "skin": "skins",
}


# Nobody asks for those by name; what has them is compared.
_NAMES_OF_FILES = ("mesh", "height field", "texture", "material")
SIZES = {SPHERE: 1, CAPSULE: 2, CYLINDER: 2}  # how many a geom has; what stands behind them means nothing
GROUPS = ("global_", "headlight", "map", "quality", "rgba", "scale")  # of the settings of the viewer
WRAPPED = {1: "joint", 3: "site", 4: "geom", 5: "geom"}  # what a tendon goes along, by mjtWrap


class Difference(NamedTuple):
    """What differs: its feature, and in words, such as "joint knee: damping 0.1 in the source, 0 in ours"."""

    feature: str
    text: str


def compare(mujoco: Any, source: Any, ours: Any, told: Told, said: Any = None) -> list[Difference]:
    """Return how two models differ; ``said`` is the <statistic> of the source's mjSpec, nan where it says nothing."""
    return Comparison(Model(mujoco, source), Model(mujoco, ours), told).run(said)


class Comparison:
    """Two models, what is which in them, and the differences found so far."""

    def __init__(self, source: Model, ours: Model, told: Told) -> None:
        self.source, self.ours = source, ours
        self.told = told
        self.maps = match(source, ours, told)
        self.found: list[Difference] = []

    def run(self, said: Any = None) -> list[Difference]:
        """Compare everything."""
        self._options(said)
        self._missing()
        self._added()
        for kind, entry in KINDS.items():
            for feature, fields in entry.fields.items():
                for field in fields.split():
                    self._plain(kind, feature, f"{entry.prefix}_{field}")
        for field in REFERENCES:
            self._reference(field)
        self._bodies()
        self._joints()
        self._geoms()
        self._meshes()
        self._placed()
        tendons(self)
        actuators(self)
        keys(self)
        order(self)
        self._touching()
        self._whole()
        return self.found

    def tell(self, feature: str, kind: str, index: int, what: str) -> None:
        """Say that an object of the source differs."""
        self.found.append(Difference(feature, f"{self.source.called(kind, index)}: {what}"))

    def differ(self, feature: str, text: str) -> None:
        """Say that the models differ in what is of no single object."""
        self.found.append(Difference(feature, text))

    def numbers(self, feature: str, kind: str, index: int, what: str, one: Any, other: Any) -> None:
        """Say that two values differ, if they do."""
        if not close(one, other):
            self.tell(feature, kind, index, f"{what} {both(one, other)}")

    def _options(self, said: Any) -> None:
        one, other = self.source.mj, self.ours.mj
        pairs = [("options", one.opt, other.opt)]
        pairs += [("settings of the viewer", getattr(one.vis, name), getattr(other.vis, name)) for name in GROUPS]
        for feature, theirs, own in pairs:
            for field in public(theirs):
                if not close(getattr(theirs, field), getattr(own, field)):
                    text = f"{field} {both(getattr(theirs, field), getattr(own, field))}"
                    self.found.append(Difference(feature, text))
        for field in public(one.stat) if said is not None else ():
            if np.isfinite(getattr(said, field)).all() and not close(
                getattr(one.stat, field), getattr(other.stat, field)
            ):
                text = f"{field} {both(getattr(one.stat, field), getattr(other.stat, field))}"
                self.found.append(Difference("settings of the viewer", text))
        for field in ("nuserdata", "njmax", "nconmax"):
            if getattr(one, field) != getattr(other, field):
                self.found.append(Difference("sizes", f"{field} {both(getattr(one, field), getattr(other, field))}"))

    def _missing(self) -> None:
        """Say what of the source is not there, or under another name than the one that the import told."""
        for kind, feature in LOST.items():
            for index, name in enumerate(self.source.names[kind]):
                at = self.maps[kind].get(index)
                if at is None:
                    if not (kind == "material" and self._is_colour(index)):
                        self.tell(feature, kind, index, "is not in ours")
                elif name and kind not in _NAMES_OF_FILES:
                    mine = self.ours.names[kind][at]
                    if mine not in (name, self.told.get(kind, {}).get(index)):
                        self.tell("names", kind, index, f"is called {mine or 'nothing'} in ours")

    def _is_colour(self, material: int) -> bool:
        """Say whether a material of the source is nothing but a colour, which its geoms have too."""
        mj = self.source.mj
        usual = {"emission": 0, "specular": 0.5, "shininess": 0.5, "reflectance": 0, "metallic": -1, "roughness": -1}
        usual |= {"texuniform": 0, "texrepeat": 1, "texid": -1}
        return all(
            close(getattr(mj, f"mat_{f}")[material], np.full_like(getattr(mj, f"mat_{f}")[material], v))
            for f, v in usual.items()
        )

    def _added(self) -> None:
        """Say what ours has that the source has not, and that makes a difference."""
        mj = self.ours.mj
        for kind in (
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
            "body",
        ):
            known = set(self.maps[kind].values())
            for index in range(len(self.ours.names[kind])):
                if index in known:
                    continue
                if kind == "geom" and not (mj.geom_contype[index] or mj.geom_conaffinity[index]):
                    continue
                if kind == "body" and mj.body_mass[index] <= NO_MASS:
                    continue
                if kind == "key" and self.ours.names[kind][index] == "home":
                    continue  # every robot of ours has one
                text = f"{self.ours.called(kind, index)} is in ours alone"
                self.found.append(Difference(LOST[kind], text))

    def _plain(self, kind: str, feature: str, field: str) -> None:
        for one, other in self.maps[kind].items():
            if feature == "contact" and not (self.source.mj.geom_contype[one] or self.source.mj.geom_conaffinity[one]):
                continue  # it touches nothing; a pair that names it says how
            if (
                field in ("tendon_rgba", "tendon_width")
                and self.source.mj.wrap_type[self.source.mj.tendon_adr[one]] == JOINED
            ):
                continue  # a tendon of joints is not drawn
            if feature == "looks of sites" and self.ours.names[kind][other] in self.ours.names["body"]:
                continue  # it marks a frame, as all bodies have one
            if field in GATES and not (
                self.is_set(self.source, GATES[field], one) and self.is_set(self.ours, GATES[field], other)
            ):
                continue
            theirs, own = value(self.source.mj, field, one), value(self.ours.mj, field, other)
            if field.endswith("_user"):
                theirs, own = padded(theirs, own)
            if field == "eq_data" and self.source.mj.eq_type[one] == WELD:
                theirs, own = (
                    np.concatenate([row[:6], rotation(row[6:10]).ravel(), row[10:]]) for row in (theirs, own)
                )
            self.numbers(feature, kind, one, field.partition("_")[2], theirs, own)

    def is_set(self, model: Model, field: str, index: int) -> bool:
        return bool(np.all(value(model.mj, field, index)))

    def _reference(self, field: str) -> None:
        """Compare which other objects are named."""
        how, feature = REFERENCES[field]
        owners = (kind for kind, entry in KINDS.items() if field.startswith(f"{entry.prefix}_"))
        kind = next(owners, "tendon")  # wrap_objid
        for one, other in self.maps[kind].items():
            theirs = list(np.atleast_1d(value(self.source.mj, field, one)))
            own = list(np.atleast_1d(value(self.ours.mj, field, other)))
            if how == "plugin":
                made = plugin(self.source.mj, theirs[0]), plugin(self.ours.mj, own[0])
                if made[0] != made[1]:
                    self.tell(feature, kind, one, f"plugin {made[0]} in the source, {made[1]} in ours")
                continue
            kinds = list(self._kinds(how, one, len(theirs)))
            if len(theirs) != len(own) or not all(map(self._is_same, kinds, theirs, own)):
                names = [self._list(model, kinds, ids) for model, ids in ((self.source, theirs), (self.ours, own))]
                self.tell(feature, kind, one, f"{field.partition('_')[2]} {names[0]} in the source, {names[1]} in ours")

    def _kinds(self, how: str, index: int, count: int) -> Iterator[str]:
        """Yield the kind of each object that is named."""
        mj = self.source.mj
        if how == "actuator_trntype":
            yield from [kind_of_target(self.source, index)] * count
        elif how == "eq_type":
            yield kind_of_joined(self.source, index)
        elif how == "geom_type":
            yield {HFIELD: "height field", MESH: "mesh", SDF: "mesh"}.get(int(mj.geom_type[index]), "")
        elif how == "wrap_type":
            yield from (WRAPPED.get(int(number), "") for number in value(mj, how, index))
        elif how in KINDS:
            yield from [how] * count
        else:
            yield from (kind_of_object(self.source, int(n)) for n in np.resize(value(mj, how, index), count))

    def _is_same(self, kind: str, one: Any, other: Any) -> bool:
        if one < 0 or not kind:
            return bool(one == other)
        expected = self.maps[kind].get(int(one))
        if expected is None and kind == "material" and self._is_colour(int(one)):
            return True
        if kind == "body" and expected is not None and other >= 0 and self.ours.is_rigid(expected, int(other)):
            pos, turn = self.ours.seen_from(expected, int(other), np.zeros(3), np.eye(3))
            return near(pos, np.zeros(3)) and near(turn, np.eye(3))
        return expected == other or (kind == "mesh" and other in self._meshes_of(int(one)))

    def _meshes_of(self, mesh: int) -> set[int]:
        """Return the meshes of ours that are a mesh of the source: it may be there in several forms."""
        pairs = self.maps["geom"].items()
        return {int(self.ours.mj.geom_dataid[other]) for one, other in pairs if self.source.mj.geom_dataid[one] == mesh}

    def _list(self, model: Model, kinds: Sequence[str], ids: Iterable[Any]) -> str:
        texts = []
        for kind, index in zip(kinds, ids, strict=False):
            named = kind and 0 <= index < len(model.names[kind])
            texts.append(model.called(kind, int(index)) if named else "none" if index < 0 else str(index))
        return ", ".join(texts) or "nothing"

    def _bodies(self) -> None:
        for one, other in self.maps["body"].items():
            theirs, own = self.source.mj, self.ours.mj
            if one:
                self._place_of_body(one, other)
                self._masses(one, other)
            for what, feature, of in (
                ("motion capture", "motion capture", is_mocap),
                ("sleep policy", "sleep", sleep_policy),
            ):
                if of(theirs, one) != of(own, other):
                    self.tell(feature, "body", one, f"{what} {both(of(theirs, one), of(own, other))}")

    def _place_of_body(self, one: int, other: int) -> None:
        above = next(body for body in self.source.above(one)[1:] if body in self.maps["body"])
        base = self.maps["body"][above]
        if base not in self.ours.above(other):
            self.tell("bodies", "body", one, f"does not stand in {self.ours.called('body', base)} in ours")
            return
        theirs = self.source.seen_from(above, one, np.zeros(3), np.eye(3))
        own = self.ours.seen_from(base, other, np.zeros(3), np.eye(3))
        self._pose("places of bodies", "body", one, theirs, own)

    def _pose(self, feature: str, kind: str, index: int, theirs: tuple[Any, Any], own: tuple[Any, Any]) -> None:
        if not near(theirs[0], own[0]):
            self.tell(feature, kind, index, f"position {both(*theirs[:1], *own[:1])}")
        if not near(theirs[1], own[1]):
            self.tell(feature, kind, index, f"orientation differs by {np.abs(theirs[1] - own[1]).max():.2g}")

    def _masses(self, one: int, other: int) -> None:
        theirs, own = self.source.mj, self.ours.mj
        mass, mine = float(theirs.body_mass[one]), float(own.body_mass[other])
        if max(mass, mine) <= NO_MASS:
            return
        self.numbers("masses", "body", one, "mass", mass, mine)
        if not near(theirs.body_ipos[one], own.body_ipos[other]):
            self.tell("masses", "body", one, f"centre of mass {both(theirs.body_ipos[one], own.body_ipos[other])}")
        a, b = inertia(theirs, one), inertia(own, other)
        if np.abs(a - b).max() > max(np.trace(a) * 1e-8, 1e-14):
            self.tell("masses", "body", one, f"inertia {both(np.diag(a), np.diag(b))}, along the axes of the body")

    def _joints(self) -> None:
        for one, other in self.maps["joint"].items():
            theirs, own = self.source.mj, self.ours.mj
            if theirs.jnt_type[one] != own.jnt_type[other]:
                continue
            self._axis(one, other)
            kind = int(theirs.jnt_type[one])
            at, mine = int(theirs.jnt_qposadr[one]), int(own.jnt_qposadr[other])
            size = {FREE: 7, BALL: 4}.get(kind, 1)
            if size == 1:
                rests, places = (
                    (theirs_at[at], own_at[mine])
                    for theirs_at, own_at in ((theirs.qpos_spring, own.qpos_spring), (theirs.qpos0, own.qpos0))
                )
            else:
                rests = theirs.qpos_spring[at : at + size], own.qpos_spring[mine : mine + size]
                places = theirs.qpos0[at : at + size], own.qpos0[mine : mine + size]
            if theirs.jnt_limited[one] and own.jnt_limited[other]:
                self.numbers("ranges of joints", "joint", one, "range", theirs.jnt_range[one], own.jnt_range[other])
            if not (near_pose(*places) if size > 1 else near(*places)):
                self.tell("places of bodies", "joint", one, f"first position {both(*places)}")
            springs = any(
                np.any(mj.jnt_stiffness[i]) or np.any(mj.jnt_stiffnesspoly[i])
                for mj, i in ((theirs, one), (own, other))
            )
            if springs and not (near_pose(*rests) if size > 1 else near(*rests)):
                self.tell("springs", "joint", one, f"rest of the spring {both(*rests)}")
            for feature, fields in OF_DOFS.items():
                for field in fields.split():
                    values = (dofs(mj, f"dof_{field}", joint) for mj, joint in ((theirs, one), (own, other)))
                    self.numbers(feature, "joint", one, field, *values)

    def _axis(self, one: int, other: int) -> None:
        """Compare where a joint is and what it moves."""
        theirs, own = self.source.mj, self.ours.mj
        body, moved = int(theirs.jnt_bodyid[one]), int(own.jnt_bodyid[other])
        base = self.maps["body"].get(body)
        if base is None:
            return
        above = self.maps["body"].get(int(theirs.body_parentid[body]), 0)
        if moved not in self.ours.above(base) or moved in self.ours.above(above):
            self.tell("types of joints", "joint", one, f"moves {self.ours.called('body', moved)} in ours")
            return
        anchor, turn = self.ours.seen_from(base, moved, own.jnt_pos[other], np.eye(3))
        kind = int(theirs.jnt_type[one])
        if kind not in (FREE, BALL) and not near(theirs.jnt_axis[one], turn @ own.jnt_axis[other]):
            self.tell("types of joints", "joint", one, f"axis {both(theirs.jnt_axis[one], turn @ own.jnt_axis[other])}")
        if kind not in (FREE, SLIDE) and not near(theirs.jnt_pos[one], anchor):
            self.tell("types of joints", "joint", one, f"anchor {both(theirs.jnt_pos[one], anchor)}")

    def _geoms(self) -> None:
        theirs, own = self.source.mj, self.ours.mj
        twins = self._twins()
        for one, other in self.maps["geom"].items():
            kind = int(theirs.geom_type[one])
            if kind != own.geom_type[other]:
                continue
            poses = [shape_frame(model, geom) for model, geom in ((self.source, one), (self.ours, other))]
            self._in_body("shapes", "geom", one, other, poses)
            sizes = (mj.geom_size[geom][: SIZES.get(kind, 3)] for mj, geom in ((theirs, one), (own, other)))
            if kind not in (MESH, SDF, HFIELD):
                self.numbers("shapes", "geom", one, "size", *sizes)
            collides = bool(theirs.geom_contype[one] or theirs.geom_conaffinity[one])
            by_right = (0, 3) if collides else (1, 2)
            if own.geom_group[other] not in (theirs.geom_group[one], *by_right):
                self.numbers("groups", "geom", one, "group", theirs.geom_group[one], own.geom_group[other])
            material, seen = int(theirs.geom_matid[one]), twins.get(other, other)
            mine = self.maps["material"].get(material, -1)
            says_more = mine >= 0 and not self._is_colour(material)
            if says_more and not any(same_material(own, int(own.geom_matid[at]), mine) for at in (other, seen)):
                self.tell("shine", "geom", one, f"has not {self.source.called('material', material)} in ours")
            if not close(colour(theirs, one), colour(own, other)):
                self.numbers("colours", "geom", one, "colour", colour(theirs, one), colour(own, seen))

    def _twins(self) -> dict[int, int]:
        """Return the visual that ours has for a shape that collides, where it is seen too."""
        mj, known = self.ours.mj, set(self.maps["geom"].values())
        waiting: dict[Any, list[int]] = {}
        for geom in range(mj.ngeom):
            if geom not in known and not (mj.geom_contype[geom] or mj.geom_conaffinity[geom]):
                waiting.setdefault(same_solid(mj, geom), []).append(geom)
        found = {}
        for geom in sorted(known):
            same = waiting.get(same_solid(mj, geom))
            if same:
                found[geom] = same.pop(0) if len(same) > 1 else same[0]
        return found

    def _in_body(self, feature: str, kind: str, one: int, other: int, poses: Sequence[tuple[Any, Any]]) -> None:
        """Compare places in bodies; what stands in a body that is fixed to that one, stands in it."""
        prefix = KINDS[kind].prefix
        body = int(getattr(self.source.mj, f"{prefix}_bodyid")[one])
        holds = int(getattr(self.ours.mj, f"{prefix}_bodyid")[other])
        base = self.maps["body"].get(body)
        if base is None:
            return
        if not self.ours.is_rigid(base, holds):
            self.tell(feature, kind, one, f"is on {self.ours.called('body', holds)} in ours")
            return
        self._pose(feature, kind, one, poses[0], self.ours.seen_from(base, holds, *poses[1]))

    def _meshes(self) -> None:
        pairs = {(one, other) for one, other in self.maps["mesh"].items() if other >= 0}
        for one, other in sorted(pairs):
            theirs, own = vertices(self.source, one), vertices(self.ours, other)
            for word, a, b in zip(("vertices", "normals"), theirs, own, strict=True):
                if a.shape != b.shape or np.abs(a - b).max(initial=0) > 1e-5 * max(1e-3, np.abs(a).max(initial=0)):
                    self.tell("shapes", "mesh", one, f"{word} differ")
            hulls = hull(self.source.mj, one), hull(self.ours.mj, other)
            if hulls[0] and hulls[0] != hulls[1]:  # a mesh has a hull where something that collides is of it
                self.tell("shapes", "mesh", one, f"vertices of the hull {both(*hulls)}")

    def _placed(self) -> None:
        """Compare where sites, cameras and lights are."""
        for kind, feature in (("site", "sites"), ("camera", "cameras"), ("light", "lights")):
            prefix = KINDS[kind].prefix
            for one, other in self.maps[kind].items():
                poses = []
                for mj, index in ((self.source.mj, one), (self.ours.mj, other)):
                    pos = getattr(mj, f"{prefix}_pos")[index]
                    turn = (
                        rotation(getattr(mj, f"{prefix}_quat")[index])
                        if kind != "light"
                        else mj.light_dir[index][:, None]
                    )
                    poses.append((pos, turn))
                self._in_body(feature, kind, one, other, poses)

    def _touching(self) -> None:
        """Compare which bodies may touch."""
        ours, source = self.ours, self.source
        geoms = [one for one, other in self.maps["geom"].items()]
        theirs = may_touch(source.mj, geoms)
        own = may_touch(ours.mj, [self.maps["geom"][one] for one in geoms])
        told = set()
        for a, b in zip(*np.nonzero(np.triu(theirs != own)), strict=True):
            bodies = sorted(int(source.mj.geom_bodyid[geoms[at]]) for at in (a, b))
            both = " and ".join(source.called("body", body) for body in bodies)
            where = "the source" if theirs[a, b] else "ours"
            told.add(f"{both} may touch in {where} alone")
        self.found += [Difference("touching", text) for text in sorted(told)]

    def _whole(self) -> None:
        for feature, fields in WHOLE.items():
            for field in fields.split():
                theirs, own = np.asarray(getattr(self.source.mj, field)), np.asarray(getattr(self.ours.mj, field))
                if field in BODY_IDS:
                    theirs = np.array([self.maps["body"].get(int(body), -2) if body >= 0 else -1 for body in theirs])
                elif field in MATERIAL_IDS:
                    theirs = np.array([self.maps["material"].get(int(m), -2) if m >= 0 else -1 for m in theirs])
                if theirs.size and not own.size:
                    continue  # it is told that none is there
                if not close(theirs, own):
                    self.found.append(Difference(feature, f"{field} {both(theirs, own)}"))
