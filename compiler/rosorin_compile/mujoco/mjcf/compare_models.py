"""Compare two compiled MuJoCo models: every array of mjModel that affects the simulation.

The first model is the imported MJCF ("the source"), the second is the MJCF generated from the import ("ours").
Objects are matched by name, or by the name that the import assigned. Objects without a name are matched by type,
references and position. Not compared: appearance, added sites, massless bodies, geoms without contacts, quaternion
signs, principal axes and the origins of meshes.
"""

import re
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from itertools import product
from typing import Any, NamedTuple

import numpy as np

# Kinds of objects, sorted so that each kind comes after the kinds that it refers to.
_KINDS = "body joint mesh hfield geom site camera pair flex tendon equality actuator sensor numeric text tuple key"
KINDS = {kind: kind for kind in _KINDS.split()} | {"joint": "jnt", "camera": "cam", "equality": "eq"}
_KIND_OF_EXTENT = {f"n{prefix}": kind for kind, prefix in KINDS.items()}
# Arrays with a slice for each object: length of the array, kind of object, fields with start and size of the slice.
_PIECE_TABLE = """nq joint jnt_qposadr
nv joint jnt_dofadr
nmocap body body_mocapid
nmeshface mesh mesh_faceadr mesh_facenum
nhfielddata hfield hfield_adr hfield_nrow hfield_ncol
nnumericdata numeric numeric_adr numeric_size
ntextdata text text_adr text_size
ntupledata tuple tuple_adr tuple_size
nu actuator actuator_ctrladr actuator_ctrlnum
nout actuator actuator_outadr actuator_outnum
na actuator actuator_actadr actuator_actnum
nwrap tendon tendon_adr tendon_num"""
_PIECES = {extent: piece for extent, *piece in map(str.split, _PIECE_TABLE.splitlines())}
_COORDINATES = {"nq": {0: 7, 1: 4}, "nv": {0: 6, 1: 3}}  # slice sizes by mjtJoint: free 0, ball 1
# FIELD:KIND for fields with object ids. FIELD:TYPE_FIELD:ENUMERATION if TYPE_FIELD has the kind of the object.
_REFERENCE_TABLE = """cam_targetbodyid:body pair_geom1:geom pair_geom2:geom site_dataid:mesh
eq_obj1id:eq_type:mjtEq eq_obj2id:eq_type:mjtEq actuator_trnid:actuator_trntype:mjtTrn
sensor_objid:sensor_objtype:mjtObj sensor_refid:sensor_reftype:mjtObj tuple_objid:tuple_objtype:mjtObj
wrap_objid:wrap_type:mjtWrap wrap_prm:wrap_type:mjtWrap"""
_REFERENCES = {field: by for field, *by in (entry.split(":") for entry in _REFERENCE_TABLE.split())}
# Kind of object for values of mjtTrn and mjtWrap that are not named like the kind.
_KIND_OF_TYPE = {"jointinparent": "joint", "slidercrank": "site", "so3": "site", "xbody": "body"}
_KIND_OF_TYPE |= {"sphere": "geom", "cylinder": "geom"}
# Fields of mjData with the position and the rotation of an object.
_FRAMES = {"body": ("xpos", "xmat"), "joint": ("xanchor", "xaxis"), "camera": ("cam_xpos", "cam_xmat")}
_FRAMES |= {kind: (f"{kind}_xpos", f"{kind}_xmat") for kind in ("geom", "site")}
# Fields that MuJoCo derives from other fields or from qpos0.
DERIVED = re.compile(
    r"body_(rootid|weldid|treeid|simple|sameframe|subtreemass|invweight0|margin|contype|conaffinity)"
    r"|dof_(bodyid|jntid|parentid|treeid|invweight0|M0|length)|D_diag|jnt_actuatorid|geom_(sameframe|aabb|rbound)"
    r"|site_sameframe|cam_(poscom0|pos0|mat0)|mesh_(extrema|scale)|pair_signature|actuator_ctrlspec"
    r"|tendon_(actuatorid|treeid|length0|invweight0)|actuator_(acc0|length0)|flex_(vert0|node0|size|rigid|centered)"
    r"|flex_(elemedge|elemlayer|shell)|flex_\w*(bodyid|matid)|flexedge_(invweight0|rigid)"
    r"|.*_rownnz|.*(?<!ctrl|.out|.act)num|.*adr"
)
APPEARANCE = re.compile(r"(mat|tex|light|skin)_.*|.*_(rgba|matid|group|texcoord)|tendon_width")
_BY_METHODS = re.compile(  # fields that ``Comparison`` compares in separate methods
    r"body_(parentid|pos|quat|mass|ipos|iquat|inertia|mocapid)|jnt_(bodyid|pos|axis)|(geom|site|cam)_bodyid"
    r"|(geom|site|cam|mesh)_(pos|quat)|geom_dataid|key_(q|c|a|m).*"
)
_OF_CONTACTS = re.compile(r"geom_(condim|priority|solmix|solref|solimp|friction|margin|gap|surfacevel|adhesion)")
_OF_KEYS = {"qpos": "nq", "qvel": "nv", "ctrl": "nu", "act": "na", "mpos": "nmocap", "mquat": "nmocap"}

_SLIDE, _BALL, _FREE = 2, 1, 0  # mjtJoint
_MESH, _SDF = 7, 8  # mjtGeom
_SIZES = {2: 1, 3: 2, 5: 2, 1: 0, 7: 0, 8: 0}  # number of sizes that MuJoCo uses, by mjtGeom
_WELD = 1  # mjEQ_WELD
_FILTER_PARENT = 1 << 10  # mjDSBL_FILTERPARENT
_NO_MASS = 1e-12  # kg: a body with a smaller mass counts as massless, because MuJoCo requires a mass
_NUMBER, _RELATIVE = 1e-12, 1e-9  # absolute and relative tolerance for numbers that MuJoCo converts
_POSE, _SINGLE, _SIMULATED = 1e-8, 1e-6, 1e-6
_VERTEX = 1e-5  # tolerance relative to the size of a mesh
_SHOWN = 20  # maximum number of values in a message

STATES = 20
TOLERANCE = 1e-6  # for positions (m), elements of rotation matrices, and relative accelerations
# Pattern of the differences ("KIND FIELD") that do not affect motion.
_STILL = re.compile(r"(camera|numeric|text|tuple|sensor|key) .*|site (type|size)|\w+ (name|user|nuserdata)")
_SCENE = ("geom", "mesh", "hfield", "site")


class Difference(NamedTuple):
    """A difference between two models, with the values in ``text``; ``field`` is "" if an object is missing."""

    kind: str
    field: str
    text: str


class Model:
    """A compiled model (``mj``) with its MjData (``data``) and the names of its objects by kind and id."""

    def __init__(self, mujoco: Any, model: Any) -> None:
        self.mujoco, self.mj, self.data = mujoco, model, mujoco.MjData(model)
        self.names: dict[str, list[str]] = {}
        for kind, prefix in KINDS.items():
            of, count = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), getattr(model, f"n{prefix}")
            self.names[kind] = [mujoco.mj_id2name(model, of, index) or "" for index in range(count)]

    def value(self, field: str, extent: str, index: int) -> Any:
        """Return the values of an object in the array ``field`` of mjModel, whose first dimension is ``extent``."""
        array = getattr(self.mj, field)
        data = np.frombuffer(array, np.uint8) if isinstance(array, bytes) else np.asarray(array)
        return data[self.piece(extent, index)] if extent in _PIECES else data[index]

    def piece(self, extent: str, index: int) -> slice:
        """Return the slice for an object in arrays of mjModel whose first dimension is ``extent``, such as "nq"."""
        _, address, *sizes = _PIECES[extent]
        start = int(np.ravel(getattr(self.mj, address))[index])
        count = int(np.prod([np.ravel(getattr(self.mj, size))[index] for size in sizes]))
        count = _COORDINATES[extent].get(int(self.mj.jnt_type[index]), 1) if extent in _COORDINATES else count
        return slice(start, start + count) if start >= 0 else slice(0, 0)

    def references(self, field: str, extent: str, index: int) -> list[tuple[str, float]]:
        """Return (kind, id) for each object that ``field`` of an object refers to, or ("", number) for a number."""
        numbers: list[float] = np.atleast_1d(self.value(field, extent, index)).tolist()
        by, *enumerations = _REFERENCES[field]
        if not enumerations:
            return [(by, number) for number in numbers]
        kinds = []
        for number in np.resize(self.value(by, extent, index), len(numbers)).tolist():
            word = getattr(self.mujoco, enumerations[0])(number).name.rpartition("_")[2].lower()
            kinds.append(_KIND_OF_TYPE.get(word, word if word in KINDS else ""))
        if by == "eq_type" and not kinds[0]:  # eq_objtype has the kind of both objects
            kinds = [self.mujoco.mjtObj(int(self.mj.eq_objtype[index])).name.rpartition("_")[2].lower()]
        if field == "wrap_prm":  # a geom that a tendon wraps around stores the id of its side site here
            kinds = ["site" if kind == "geom" else "" for kind in kinds]
        return list(zip(kinds, numbers, strict=True))

    def name_of(self, kind: str, index: int) -> str:
        if (name := self.names[kind][index]) or kind not in _FRAMES or kind == "body":
            return f"{kind} {name or index}"
        return f"{kind} {index} of {self.name_of('body', self.body_of(kind, index))}"

    def body_of(self, kind: str, index: int) -> int:
        return int(getattr(self.mj, "body_parentid" if kind == "body" else f"{KINDS[kind]}_bodyid")[index])

    def frame(self, kind: str, index: int) -> tuple[Any, Any]:
        """Return (position in m, rotation matrix) of an object in the world; for a joint, (anchor in m, axis)."""
        pos, turn = (getattr(self.data, name)[index] for name in _FRAMES[kind])
        return pos, turn.reshape(3, -1)

    def mesh_of(self, geom: int) -> int:
        return int(self.mj.geom_dataid[geom]) if self.mj.geom_type[geom] in (_MESH, _SDF) else -1

    def vertices(self, geom: int) -> Any:
        """Return the vertices (n, 3) of the mesh of a geom, in world coordinates (m)."""
        mesh, (pos, turn) = self.mesh_of(geom), self.frame("geom", geom)
        start = int(self.mj.mesh_vertadr[mesh])
        return self.mj.mesh_vert[start : start + int(self.mj.mesh_vertnum[mesh])] @ turn.T + pos

    def collides(self, geom: int) -> bool:
        return bool(self.mj.geom_contype[geom] or self.mj.geom_conaffinity[geom])

    def inertia(self, body: int) -> Any:
        """Return the inertia matrix (3, 3) in kg*m^2 of a body, about its centre of mass and along the body axes."""
        turn = rotation(self.mj.body_iquat[body])
        return turn @ np.diag(self.mj.body_inertia[body]) @ turn.T


class Comparison:
    """A comparison of two models. ``names`` are the names that the import assigned, by kind and id in the source."""

    def __init__(self, mujoco: Any, source: Any, ours: Any, names: Mapping[str, Mapping[int, str]]) -> None:
        self.mujoco, self.names = mujoco, names
        self.source, self.ours = Model(mujoco, source), Model(mujoco, ours)
        self.maps: dict[str, dict[int, int]] = {}  # by kind: id in our model for each id in the source
        self.differences: list[Difference] = []
        self.place(None)
        for kind in KINDS:
            self._match(kind)

    def run(self) -> list[Difference]:
        theirs, own = self.source.mj, self.ours.mj
        for field in (name for name in dir(theirs.opt) if not name.startswith("_")):
            self.values("option", -1, field, getattr(theirs.opt, field), getattr(own.opt, field))
        self.values("size", -1, "nuserdata", theirs.nuserdata, own.nuserdata)
        self._objects()
        for field, extent in arrays():
            kind = _PIECES[extent][0] if extent in _PIECES else _KIND_OF_EXTENT.get(extent, "")
            if extent.startswith(("nflex", "nplugin")):  # compare the arrays of all flexes and plugins at once
                self.values(extent[1:5], -1, field, np.asarray(getattr(theirs, field)), np.asarray(getattr(own, field)))
            elif kind and not _BY_METHODS.fullmatch(field):
                for pair in self.maps[kind].items():
                    self._field(kind, field, extent, *pair)
        for one, other in self.maps["body"].items():
            self.values("body", one, "mocapid", bool(theirs.body_mocapid[one] >= 0), bool(own.body_mocapid[other] >= 0))
            masses = float(theirs.body_mass[one]), float(own.body_mass[other])
            if not one or max(masses) <= _NO_MASS:
                continue
            self.values("body", one, "mass", *masses)
            if not near(theirs.body_ipos[one], own.body_ipos[other]):
                self.values("body", one, "ipos", theirs.body_ipos[one], own.body_ipos[other])
            a, b = self.source.inertia(one), self.ours.inertia(other)
            if np.abs(a - b).max() > max(np.trace(a) * 1e-8, 1e-14):
                moments = in_words(np.diag(a), np.diag(b))
                self.report("body", one, "inertia", f"inertia {moments}, along the axes of the body")
        self._frames()
        self._keys_and_order()
        geoms, texts = list(self.maps["geom"]), set[str]()
        touching, ours = may_touch(theirs, geoms), may_touch(own, list(self.maps["geom"].values()))
        for a, b in zip(*np.nonzero(np.triu(touching != ours)), strict=True):
            bodies = sorted(int(theirs.geom_bodyid[geoms[at]]) for at in (a, b))
            names = " and ".join(self.source.name_of("body", body) for body in bodies)
            texts.add(f"{names} may touch only in {'the source' if touching[a, b] else 'ours'}")
        self.differences += [Difference("contact", "", text) for text in sorted(texts)]
        return self.differences

    def report(self, kind: str, index: int, field: str, text: str) -> None:
        """Add a difference for an object of the source, or for the model if ``index`` is -1."""
        name = "" if index < 0 else f"{self.source.name_of(kind, index)}: "
        self.differences.append(Difference(kind, field, f"{name}{text}"))

    def values(self, kind: str, index: int, field: str, one: Any, other: Any) -> None:
        if not callable(one) and not close(one, other):
            self.report(kind, index, field, f"{field} {in_words(one, other)}")

    def place(self, chance: Any) -> None:
        """Move both models to qpos0, or to the same random joint positions if ``chance`` is a generator."""
        source, first, second = self.source, self.source.data, self.ours.data
        first.qpos[:], second.qpos[:] = source.mj.qpos0, self.ours.mj.qpos0
        for one, other in self.maps["joint"].items() if chance else ():
            here, there = source.piece("nq", one), self.ours.piece("nq", other)
            numbers = source.mj.qpos0[here] + chance.uniform(-0.5, 0.5, here.stop - here.start)
            if len(numbers) == 1 and source.mj.jnt_limited[one]:
                numbers[0] = chance.uniform(*source.mj.jnt_range[one])
            if len(numbers) > 1:
                numbers[-4:] /= np.linalg.norm(numbers[-4:])
            first.qpos[here] = second.qpos[there][:] = numbers
        for model in (source, self.ours):
            for step in ("mj_kinematics", "mj_comPos", "mj_camlight"):
                getattr(self.mujoco, step)(model.mj, model.data)

    def _match(self, kind: str) -> None:
        """Match the objects of a kind by name, else by signature and distance."""
        source, ours = self.source, self.ours
        by_name = {name: index for index, name in enumerate(ours.names[kind]) if name}
        found = self.maps[kind] = {0: 0} if kind == "body" else {}
        for index, name in enumerate(source.names[kind]):
            other = by_name.get(self.names.get(kind, {}).get(index, "") or name)
            if other is not None and index not in found and other not in found.values():
                found[index] = other
        if kind in ("mesh", "hfield"):
            return
        waiting: dict[Any, list[int]] = {}
        for index in sorted(set(range(len(ours.names[kind]))) - set(found.values())):
            waiting.setdefault(self._signature(ours, kind, index), []).append(index)
        for index in sorted(set(range(len(source.names[kind]))) - set(found)):
            candidates, apart = waiting.get(self._signature(source, kind, index), []), [0.0]
            if candidates and kind == "geom":
                pos, size = source.data.geom_xpos[index], source.mj.geom_size[index]
                gaps = ours.data.geom_xpos[candidates] - pos, ours.mj.geom_size[candidates] - size
                apart = np.abs(np.hstack(gaps)).max(axis=1).round(9).tolist()
            if candidates:
                found[index] = candidates.pop(apart.index(min(apart)))
        for one, other in found.items() if kind == "geom" else ():  # the import renames meshes, so match by geom
            is_mesh = source.mesh_of(one) >= 0
            data = int(source.mj.geom_dataid[one]), int(ours.mj.geom_dataid[other])
            if is_mesh == (ours.mesh_of(other) >= 0) and min(data) >= 0:
                self.maps["mesh" if is_mesh else "hfield"][data[0]] = data[1]

    def _signature(self, model: Model, kind: str, index: int) -> Any:
        """Return a key that is equal for objects of the same type with the same references."""
        prefix, values, named = KINDS[kind], list[Any](), list[tuple[str, float]]()
        named += [("body", model.body_of(kind, index))] if kind in _FRAMES else []
        for field, extent in arrays() if kind != "body" else ():
            if extent == f"n{prefix}" and field in _REFERENCES:
                named += model.references(field, extent, index)
            elif field in (f"{prefix}_type", f"{prefix}_mode"):
                values.append(int(getattr(model.mj, field)[index]))
        if kind == "geom":
            mesh = model.mesh_of(index)
            values.append(model.collides(index))
            values += [int(model.mj.mesh_vertnum[mesh]), int(model.mj.mesh_facenum[mesh])] if mesh >= 0 else []
        for of, number in named:
            is_ours = model is self.ours or number < 0 or not of
            values.append(number if is_ours else self.maps.get(of, {}).get(int(number), -2 - number))
        return frozenset(values) if kind == "pair" else tuple(values)

    def _objects(self) -> None:
        ours = self.ours
        for kind, index, name in ((kind, *one) for kind, own in self.source.names.items() for one in enumerate(own)):
            other = self.maps[kind].get(index)
            found = ours.names[kind][other] if other is not None else ""
            if other is None:
                self.report(kind, index, "", "is not in ours")
            elif name and kind not in ("mesh", "hfield") and found not in (name, self.names.get(kind, {}).get(index)):
                self.report(kind, index, "name", f"is called {found or 'nothing'} in ours")
        # Do not report added objects without effect, such as the key "home" of every generated MJCF.
        heavy, solid = ours.mj.body_mass > _NO_MASS, ours.mj.geom_contype | ours.mj.geom_conaffinity
        matters: dict[str, Any] = {"body": heavy, "geom": solid, "key": [name != "home" for name in ours.names["key"]]}
        for kind in ("body", "joint", "geom", "pair", "equality", "tendon", "actuator", "sensor", "key", "flex"):
            for index in sorted(set(range(len(ours.names[kind]))) - set(self.maps[kind].values())):
                if kind not in matters or matters[kind][index]:
                    self.report(kind, -1, "", f"{ours.name_of(kind, index)} is only in ours")

    def _field(self, kind: str, array: str, extent: str, one: int, other: int) -> None:
        """Compare one array for a pair of matching objects, unless MuJoCo ignores the value."""
        source, ours, field = self.source, self.ours, array if extent == "nq" else array.partition("_")[2]
        if array in _REFERENCES:
            named = source.references(array, extent, one), ours.references(array, extent, other)
            if [(of, self.maps[of].get(int(n), -2) if of and n >= 0 else n) for of, n in named[0]] != named[1]:
                texts = [
                    ", ".join("none" if n < 0 else model.name_of(of, int(n)) if of else f"{n:g}" for of, n in pairs)
                    for model, pairs in zip((source, ours), named, strict=True)
                ]
                text = f"{field} {texts[0] or 'nothing'} in the source, {texts[1] or 'nothing'} in ours"
                self.report(kind, one, field, text)
            return
        theirs, own = source.value(array, extent, one), ours.value(array, extent, other)
        gate = re.sub(r"range$|(?<=jnt_)(solref|solimp|margin)$", "limited", array)
        if gate != array and hasattr(source.mj, gate):
            of = "nu" if array == "actuator_ctrlrange" else ""
            has_effect = source.value(gate, of, one).all() and ours.value(gate, of, other).all()
        elif array == "qpos_spring":
            models = ((source.mj, one), (ours.mj, other))
            has_effect = any(np.any(mj.jnt_stiffness[i]) or np.any(mj.jnt_stiffnesspoly[i]) for mj, i in models)
        elif _OF_CONTACTS.fullmatch(array):
            has_effect = source.collides(one)  # no effect on a geom that cannot collide
        elif array in ("site_type", "site_size"):  # no effect on the sites that the export adds
            has_effect = ours.names["site"][other] not in ours.names["body"]
        else:  # MuJoCo computes length ranges by simulation, so compare them with a larger tolerance
            has_effect = array != "actuator_lengthrange" or not np.allclose(theirs, own, _SIMULATED, _SIMULATED)
        if array in ("geom_size", "site_size"):
            count = _SIZES.get(int(getattr(source.mj, f"{kind}_type")[one]), 3)
            theirs, own = theirs[:count], own[:count]
        if array == "eq_data" and source.mj.eq_type[one] == _WELD:
            theirs, own = (np.concatenate([row[:6], rotation(row[6:10]).ravel(), row[10:]]) for row in (theirs, own))
        if has_effect and not (extent == "nq" and _same_position(theirs, own)):
            self.values(kind, one, field, theirs, own)

    def _frames(self) -> None:
        """Compare all poses at qpos0 and at random positions, except below a body whose pose already differs."""
        moved, reported = set[int](), {("body", 0)}
        for chance in (None, np.random.default_rng(1)):
            self.place(chance)
            for kind, one, other in ((of, *pair) for of in _FRAMES for pair in sorted(self.maps[of].items())):
                above = self.source.body_of(kind, one)
                body = one if kind == "body" else above
                if kind == "body" and above in moved:
                    moved.add(body)
                if body not in moved and (kind, one) not in reported and not self._same_frame(kind, one, other):
                    reported.add((kind, one))
                    moved |= {body} if kind in ("body", "joint") else set()

    def _same_frame(self, kind: str, one: int, other: int) -> bool:
        """Return True if two objects, or the vertices of their meshes, have the same pose; else report it."""
        source, ours, before = self.source, self.ours, len(self.differences)
        (x, a), (y, b) = source.frame(kind, one), ours.frame(kind, other)
        if kind == "geom" and source.mesh_of(one) >= 0 and ours.mesh_of(other) >= 0:
            v, w = source.vertices(one), ours.vertices(other)
            scale = _VERTEX * max(1e-3, float(np.abs(v).max(initial=0)))
            if v.shape != w.shape or np.ptp(v - w, axis=0).max(initial=0) > scale:
                self.report("mesh", source.mesh_of(one), "vertices", "vertices differ")
            elif np.abs(v - w).max(initial=0) > scale:
                self.report("geom", one, "pos", f"pos {in_words(*np.round((v[0], w[0]), 7))}")
            return len(self.differences) == before
        if kind == "joint":
            if (joint := int(source.mj.jnt_type[one])) != int(ours.mj.jnt_type[other]):
                return False  # ``_field`` reports different types
            if joint not in (_FREE, _BALL) and not near(a, b):
                self.report(kind, one, "axis", f"axis {in_words(a, b)}")
            a, y = b, x if joint in (_FREE, _SLIDE) else y
        if not near(x, y):
            self.report(kind, one, "pos", f"pos {in_words(x, y)}")
        if not near(a, b):
            self.report(kind, one, "quat", f"orientation differs by {np.abs(a - b).max():.2g}")
        return len(self.differences) == before

    def _keys_and_order(self) -> None:
        for (key, at), (field, extent) in product(self.maps["key"].items(), _OF_KEYS.items()):
            width, kind = {"mpos": 3, "mquat": 4}.get(field, 1), _PIECES[extent][0]
            first = np.reshape(getattr(self.source.mj, f"key_{field}")[key], (-1, width))
            second = np.reshape(getattr(self.ours.mj, f"key_{field}")[at], (-1, width))
            for one, other in self.maps[kind].items():
                theirs = first[self.source.piece(extent, one)].ravel()
                own = second[self.ours.piece(extent, other)].ravel()
                is_turn = field in ("qpos", "mquat") and len(theirs) == len(own) > 0
                if not (_same_position(theirs, own) if is_turn else close(theirs, own)):
                    text = f"{field} of {self.source.name_of(kind, one)} {in_words(theirs, own)}"
                    self.report("key", key, field, text)
        keys = [other for _, other in sorted(self.maps["key"].items())]
        if keys != list(range(len(keys))):
            self.report("order", -1, "key", "the keys of the source are not the first ones, in their order")
        for kind, field in (("joint", "jnt_qposadr"), ("actuator", "actuator_ctrladr"), ("sensor", "sensor_adr")):
            places = [int(getattr(self.ours.mj, field)[other]) for _, other in sorted(self.maps[kind].items())]
            if places != sorted(places):
                self.report("order", -1, kind, f"the {kind}s are in another order in ours")

    def moves_alike(self) -> bool:
        """Return True if none of the reported differences affects the motion of the robot."""
        lost = [one for one in self.differences if one.kind in _SCENE and one.text.endswith(": is not in ours")]
        return all(one in lost or _STILL.fullmatch(f"{one.kind} {one.field}") for one in self.differences)

    def motion(self) -> tuple[float, str]:
        """Compute poses and accelerations of both models in random states, and compare them.

        Return (largest error, name of the object). Errors of poses are in m or elements of a rotation matrix, errors of
        joint accelerations are relative to the largest acceleration.
        """
        source, ours, first, second = self.source, self.ours, self.source.data, self.ours.data
        chance, found = np.random.default_rng(1), [(0.0, "")]
        for model in (source, ours):
            model.mj.opt.disableflags |= int(self.mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        for _ in range(STATES):
            self.place(chance)
            for one, other in self.maps["joint"].items():
                here, there = source.piece("nv", one), ours.piece("nv", other)
                first.qvel[here] = second.qvel[there] = chance.uniform(-1, 1, here.stop - here.start)
            for one, other in self.maps["actuator"].items():
                here, there = source.piece("nu", one), ours.piece("nu", other)
                limited = source.mj.actuator_ctrllimited[here][:, None]
                limits = np.where(limited, source.mj.actuator_ctrlrange[here], (-0.5, 0.5))
                first.ctrl[here] = second.ctrl[there] = chance.uniform(limits[:, 0], limits[:, 1])
                here, there = source.piece("na", one), ours.piece("na", other)
                first.act[here] = second.act[there] = chance.uniform(0, 1, here.stop - here.start)
            for model in (source, ours):
                self.mujoco.mj_forward(model.mj, model.data)
            for one, other in self.maps["body"].items():
                pairs = zip(source.frame("body", one), ours.frame("body", other), strict=True)
                found.append((max(float(np.abs(a - b).max()) for a, b in pairs), source.name_of("body", one)))
            scale = max(1.0, float(np.abs(first.qacc).max(initial=0)))
            for one, other in self.maps["joint"].items():
                apart = np.abs(first.qacc[source.piece("nv", one)] - second.qacc[ours.piece("nv", other)]).max()
                found.append((float(np.nan_to_num(apart, nan=np.inf)) / scale, source.name_of("joint", one)))
        return max(found)


@cache
def arrays() -> Sequence[tuple[str, str]]:
    """Return (name, first dimension such as "nbody") of each array of mjModel that affects the simulation."""
    fields = import_module("mujoco.introspect.structs").STRUCTS["mjModel"].fields
    extents = {field.name: str(field.array_extent[0]) for field in fields if getattr(field, "array_extent", None)}
    return [(name, of) for name, of in extents.items() if not (DERIVED.fullmatch(name) or APPEARANCE.fullmatch(name))]


def rotation(quaternion: Any) -> Any:
    """Return the rotation matrix (3, 3) of a quaternion (w, x, y, z) of any length."""
    made, numbers = np.zeros(9), np.asarray(quaternion, dtype=float)
    import_module("mujoco").mju_quat2Mat(made, numbers / (np.linalg.norm(numbers) or 1.0))
    return made.reshape(3, 3)


def _same_position(one: Any, other: Any) -> bool:
    if len(one) < 4:
        return near(one, other)
    return near(one[:-4], other[:-4]) and near(rotation(one[-4:]), rotation(other[-4:]))


def may_touch(mj: Any, geoms: Sequence[int]) -> Any:
    """Return a boolean matrix (n, n) that is True where two of the n geoms can be in contact.

    The contact bits, MuJoCo's parent filter, and <exclude> and <pair> elements are taken into account.
    """
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
    """Return True if two arrays have the same shape and the same values, except for rounding errors."""
    a, b = np.asarray(one), np.asarray(other)
    if a.shape != b.shape or "f" not in a.dtype.kind + b.dtype.kind:
        return a.shape == b.shape and bool((a == b).all())
    relative, absolute = (_SINGLE, _SINGLE) if np.float32 in (a.dtype, b.dtype) else (_RELATIVE, _NUMBER)
    return bool(np.isclose(a, b, relative, absolute, equal_nan=True).all())


def near(one: Any, other: Any) -> bool:
    """Return True if two positions (m) or two rotation matrices are equal, except for rounding errors."""
    return bool(np.abs(np.asarray(one, dtype=float) - other).max(initial=0) <= _POSE)


def in_words(one: Any, other: Any) -> str:
    """Format two different values for a message; long arrays are replaced by their lengths."""
    a, b = np.ravel(one), np.ravel(other)
    if max(a.size, b.size) > _SHOWN:
        return f"differs: {a.size} numbers in the source, {b.size} in ours"
    texts = [" ".join(f"{n:.6g}" if abs(n) > _NUMBER else "0" for n in array.tolist()) for array in (a, b)]
    texts = [" ".join(map(repr, array.tolist())) for array in (a, b)] if texts[0] == texts[1] else texts
    return f"{texts[0] or 'nothing'} in the source, {texts[1] or 'nothing'} in ours"
