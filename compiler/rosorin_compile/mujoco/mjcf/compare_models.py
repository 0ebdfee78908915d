"""Compare two compiled models of MuJoCo in each array of mjModel that ``mujoco.introspect`` has.

Objects are matched by name, or by the name that the import gave them; those without a name by what they refer to and
by their place. Frames are compared where MuJoCo puts them in the body of the source, in the first pose and in a random
one.

Equal for MuJoCo, and therefore no difference, are: added sites and bodies without mass (a link is a body and a site), a
site that became a body, a visual added to a collision shape, both signs of a quaternion, other principal axes, and the
origin to which MuJoCo moves a mesh. This runs in the child process.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

# Each kind of object with the prefix of its arrays in mjModel, those that are named by others first.
_PREFIXES = {"joint": "jnt", "texture": "tex", "material": "mat", "camera": "cam", "equality": "eq"}
_KINDS = """body joint mesh hfield texture material geom site camera light pair flex skin tendon equality actuator
sensor numeric text tuple key"""
KINDS = {kind: _PREFIXES.get(kind, kind) for kind in _KINDS.split()}
_KIND_OF_EXTENT = {f"n{prefix}": kind for kind, prefix in KINDS.items()}
# Long arrays in which an object has a piece, by their length: the kind, where the piece begins, and its size.
_PIECE_TABLE = """nq joint jnt_qposadr
nv joint jnt_dofadr
nmocap body body_mocapid
nmeshface mesh mesh_faceadr mesh_facenum
nmeshtexcoord mesh mesh_texcoordadr mesh_texcoordnum
nhfielddata hfield hfield_adr hfield_nrow hfield_ncol
ntexdata texture tex_adr tex_height tex_width tex_nchannel
nnumericdata numeric numeric_adr numeric_size
ntextdata text text_adr text_size
ntupledata tuple tuple_adr tuple_size
nu actuator actuator_ctrladr actuator_ctrlnum
nout actuator actuator_outadr actuator_outnum
na actuator actuator_actadr actuator_actnum
nwrap tendon tendon_adr tendon_num"""
_PIECES = {extent: piece for extent, *piece in map(str.split, _PIECE_TABLE.splitlines())}
_COORDINATES = {"nq": {0: 7, 1: 4}, "nv": {0: 6, 1: 3}}  # of free joints and balls
# Fields with the number of another object: its kind, or the field and the enumeration that decide the kind.
_REFERENCE_TABLE = """site_matid:material site_dataid:mesh tendon_matid:material mat_texid:texture
cam_targetbodyid:body light_targetbodyid:body light_texid:texture pair_geom1:geom pair_geom2:geom
eq_obj1id:eq_type:mjtEq eq_obj2id:eq_type:mjtEq actuator_trnid:actuator_trntype:mjtTrn
sensor_objid:sensor_objtype:mjtObj sensor_refid:sensor_reftype:mjtObj tuple_objid:tuple_objtype:mjtObj
wrap_objid:wrap_type:mjtWrap"""
_REFERENCES = {field: by for field, *by in (entry.split(":") for entry in _REFERENCE_TABLE.split())}
# The kinds of types that are not called like them: what drives, what tendons wrap around.
_KIND_OF_TYPE = {"jointinparent": "joint", "slidercrank": "site", "so3": "site", "xbody": "body"}
_KIND_OF_TYPE |= {"sphere": "geom", "cylinder": "geom"}
# Where MuJoCo puts objects: position and rotation in mjData.
_FRAMES = {kind: (f"{kind[:4]}_xpos", f"{kind[:4]}_xmat") for kind in ("geom", "site")}
_FRAMES |= {"body": ("xpos", "xmat"), "joint": ("xanchor", "xaxis"), "camera": ("cam_xpos", "cam_xmat")}
_FRAMES["light"] = ("light_xpos", "light_xdir")
# Fields that follow from others or from the first pose, and those that methods of ``Comparison`` compare.
_DERIVED = re.compile(
    r"body_(rootid|weldid|treeid|simple|sameframe|subtreemass|invweight0|margin|contype|conaffinity)"
    r"|dof_(bodyid|jntid|parentid|treeid|invweight0|M0|length)|D_diag|jnt_actuatorid|geom_(sameframe|aabb|rbound)"
    r"|site_sameframe|(cam|light)_(poscom0|pos0|mat0|dir0)|mesh_(extrema|scale)|pair_signature|actuator_ctrlspec"
    r"|tendon_(actuatorid|treeid|length0|invweight0)|actuator_(acc0|length0)|flex_(vert0|node0|size|rigid|centered)"
    r"|flex_(elemedge|elemlayer|shell)|(flex|skin)_\w*(bodyid|matid)|flexedge_(invweight0|rigid)|.*_rownnz|.*(?<!ctrl|.out|.act)num|.*adr"
)
_BY_METHODS = re.compile(
    r"body_(parentid|pos|quat|mass|ipos|iquat|inertia|mocapid)|jnt_(bodyid|pos|axis)|(geom|site|cam|light)_bodyid"
    r"|(geom|site|cam|mesh)_(pos|quat)|light_(pos|dir)|geom_(group|rgba|matid|dataid)|key_(q|c|a|m).*|wrap_prm"
)
# Fields that have no effect unless another one is set.
_GATED = re.compile(r"(jnt|tendon|actuator)_(solref|solimp|margin|range|actfrcrange|ctrlrange|forcerange|actrange)")
_GATES = {"actfrcrange": "actfrclimited", "ctrlrange": "ctrllimited", "forcerange": "forcelimited"}
_GATES["actrange"] = "actlimited"
_OF_CONTACTS = re.compile(r"geom_(condim|priority|solmix|solref|solimp|friction|margin|gap|surfacevel|adhesion)")
_WORDS = {"qpos0": "first position", "qpos_spring": "rest of the spring"}
_OF_KEYS = (
    *(("qpos", "nq", "position"), ("qvel", "nv", "speed"), ("ctrl", "nu", "control"), ("act", "na", "activation")),
    *(("mpos", "nmocap", "place"), ("mquat", "nmocap", "orientation")),
)
# Objects that change a simulation if ours alone has them.
_MATTER = ("body", "joint", "geom", "pair", "equality", "tendon", "actuator", "sensor", "key", "flex", "skin")

SLIDE, BALL, FREE = 2, 1, 0  # mjtJoint
_MESH, _SDF = 7, 8  # mjtGeom
_SIZES = {2: 1, 3: 2, 5: 2, 1: 0, 7: 0, 8: 0}  # numbers of sizes that mean something: of spheres, capsules, cylinders
_WELD, _JOINED = 1, 1  # mjEQ_WELD, mjWRAP_JOINT
_FILTER_PARENT = 1 << 10  # mjDSBL_FILTERPARENT
_VIEWER = ("global_", "headlight", "map", "quality", "rgba", "scale")  # groups of mjVisual
_NO_COLOUR = np.array([0.5, 0.5, 0.5, 1.0], dtype=np.float32)  # a geom of this colour has that of its material
_NO_MASS = 1e-12  # kg: what MuJoCo needs where there is none
_NUMBER, _RELATIVE = 1e-12, 1e-9  # MuJoCo turns degrees, quaternions and axes into others
_POSE, _SINGLE, _SIMULATED = 1e-9, 1e-6, 1e-6
_VERTEX = 1e-5  # of the size of a mesh
_SHOWN = 20  # numbers in a message

STATES = 20
_TOLERANCE = 1e-6  # m, an entry of a rotation, and a share of the largest acceleration
# Differences that no motion shows: kinds of objects, and fields; a missing scene touches nothing.
_STILL = re.compile(
    r"(camera|light|texture|material|numeric|text|tuple|sensor|key|skin|viewer) .*|site (type|size)"
    r"|\w+ (name|group|rgba|matid|user|castshadow|nuserdata|njmax|nconmax)"
)
_GONE = ("geom", "mesh", "hfield", "site")

Names = Mapping[str, Mapping[int, str]]  # that the import gave, by kind and number in the source


class Difference(NamedTuple):
    """A difference: the kind of object, its field ("" for the object itself), and both values in words."""

    kind: str
    field: str
    text: str


class Model:
    """A compiled model with the names of its objects, and ``data`` in which kinematics are computed."""

    def __init__(self, mujoco: Any, model: Any) -> None:
        self.mujoco, self.mj, self.data = mujoco, model, mujoco.MjData(model)
        self.names = {
            kind: [
                mujoco.mj_id2name(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), index) or ""
                for index in range(getattr(model, f"n{prefix}"))
            ]
            for kind, prefix in KINDS.items()
        }

    def value(self, field: str, extent: str, index: int) -> Any:
        """Return the row of an object in an array of mjModel, or its piece of a long one."""
        array = getattr(self.mj, field)
        data = np.frombuffer(array, np.uint8) if isinstance(array, bytes) else np.asarray(array)
        return data[self.piece(extent, index)] if extent in _PIECES else data[index]

    def piece(self, extent: str, index: int) -> slice:
        """Return where an object has its piece of long arrays."""
        _, address, *sizes = _PIECES[extent]
        start = int(np.ravel(getattr(self.mj, address))[index])
        count = int(np.prod([np.ravel(getattr(self.mj, size))[index] for size in sizes]))
        if extent in _COORDINATES:
            count = _COORDINATES[extent].get(int(self.mj.jnt_type[index]), 1)
        return slice(start, start + count) if start >= 0 else slice(0, 0)

    def references(self, field: str, extent: str, index: int) -> list[tuple[str, float]]:
        """Return the objects that a field names, each with its kind; the kind of a plain number is empty."""
        numbers: list[float] = np.atleast_1d(self.value(field, extent, index)).tolist()
        by, *enumerations = _REFERENCES[field]
        if not enumerations:
            return [(by, number) for number in numbers]
        types = np.resize(self.value(by, extent, index), len(numbers)).tolist()
        kinds = [self._kind(enumerations[0], number) for number in types]
        if by == "eq_type" and not kinds[0]:  # two bodies or two sites
            kinds = [self._kind("mjtObj", int(self.mj.eq_objtype[index]))]
        found = list(zip(kinds, numbers, strict=True))
        if field == "wrap_objid":  # the site at the side of a solid is a number among others
            sides = self.value("wrap_prm", extent, index).tolist()
            found += [("site" if kind == "geom" else "", side) for kind, side in zip(kinds, sides, strict=True)]
        return found

    def _kind(self, enumeration: str, number: int) -> str:
        try:
            word = getattr(self.mujoco, enumeration)(number).name.rpartition("_")[2].lower()
        except ValueError:
            return ""
        return _KIND_OF_TYPE.get(word, word if word in KINDS else "")

    def called(self, kind: str, index: int) -> str:
        name = self.names[kind][index]
        if name or kind not in _FRAMES or kind == "body":
            return f"{kind} {name or index}"
        return f"{kind} {index} of {self.called('body', self.body_of(kind, index))}"

    def body_of(self, kind: str, index: int) -> int:
        return int(getattr(self.mj, "body_parentid" if kind == "body" else f"{KINDS[kind]}_bodyid")[index])

    def frame(self, kind: str, index: int) -> tuple[Any, Any]:
        """Return position and rotation of an object in the world; the direction of a light, the axis of a joint."""
        pos, turn = (getattr(self.data, name)[index] for name in _FRAMES[kind])
        return pos, turn.reshape(3, -1)

    def place(self, kind: str, index: int) -> Any:
        """Return numbers that are alike for objects at one place."""
        if kind not in ("geom", "site", "camera", "light"):
            return np.zeros(0)
        sizes = self.mj.geom_size[index] if kind == "geom" else ()
        return np.concatenate([self.frame(kind, index)[0], sizes])

    def mesh_of(self, geom: int) -> int:
        return int(self.mj.geom_dataid[geom]) if self.mj.geom_type[geom] in (_MESH, _SDF) else -1

    def vertices(self, geom: int) -> Any:
        """Return the vertices (m) of the mesh of a geom in the world."""
        mesh, (pos, turn) = self.mesh_of(geom), self.frame("geom", geom)
        start = int(self.mj.mesh_vertadr[mesh])
        return self.mj.mesh_vert[start : start + int(self.mj.mesh_vertnum[mesh])] @ turn.T + pos

    def collides(self, geom: int) -> bool:
        return bool(self.mj.geom_contype[geom] or self.mj.geom_conaffinity[geom])

    def colour(self, geom: int) -> Any:
        """Return the colour in which a geom is seen: that of its material, unless it has its own."""
        own, material = self.mj.geom_rgba[geom], int(self.mj.geom_matid[geom])
        return self.mj.mat_rgba[material] if material >= 0 and np.allclose(own, _NO_COLOUR, 1e-6, 1e-6) else own

    def is_colour(self, material: int) -> bool:
        """Return True if a material is nothing but a colour."""
        usual = {"emission": 0, "specular": 0.5, "shininess": 0.5, "reflectance": 0, "metallic": -1, "roughness": -1}
        values = (usual | {"texuniform": 0, "texrepeat": 1, "texid": -1}).items()
        return all(np.all(getattr(self.mj, f"mat_{field}")[material] == value) for field, value in values)


class Comparison:
    """Two models, which object is which in them (``maps``: by kind, from source to ours), and the differences."""

    def __init__(self, mujoco: Any, source: Any, ours: Any, given: Names) -> None:
        self.mujoco, self.given = mujoco, given
        self.source, self.ours = Model(mujoco, source), Model(mujoco, ours)
        self.maps: dict[str, dict[int, int]] = {}
        self.found: list[Difference] = []
        self.place(None)
        for kind in KINDS:
            self._match(kind)

    def run(self, statistic: Any = None) -> list[Difference]:
        """Compare everything; ``statistic`` is the <statistic> of the source's mjSpec, nan where it has no value."""
        self._settings(statistic)
        self._objects()
        for field, extent in _arrays():
            if not _BY_METHODS.fullmatch(field):
                self._array(field, extent)
        for one, other in self.maps["body"].items():
            self._body(one, other)
        self._frames()
        for one, other in self.maps["geom"].items():
            self._geom(one, other)
        self._keys()
        self._order()
        self._touching()
        return self.found

    def report(self, kind: str, index: int, field: str, text: str) -> None:
        self.found.append(Difference(kind, field, f"{self.source.called(kind, index)}: {text}"))

    def values(self, kind: str, index: int, field: str, one: Any, other: Any, word: str = "") -> None:
        if not close(one, other):
            self.report(kind, index, field, f"{word or field} {in_words(one, other)}")

    def place(self, chance: Any) -> None:
        """Put both models into their first pose, or with a generator into the same random one.

        Joints are then within their limits, or half a radian or metre around.
        """
        source, first, second = self.source, self.source.data, self.ours.data
        first.qpos[:], second.qpos[:] = source.mj.qpos0, self.ours.mj.qpos0
        for one, other in self.maps.get("joint", {}).items() if chance else ():
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

    def moves_alike(self) -> bool:
        """Return True if the models must move in the same way in spite of the differences found."""
        return all(
            _STILL.fullmatch(f"{one.kind} {one.field}") or (one.kind in _GONE and one.text.endswith(": is not in ours"))
            for one in self.found
        )

    def motion(self) -> dict[str, Any]:
        """Return the largest difference of frames and accelerations in random states, under random controls, and where.

        Frames differ by m or an entry of a rotation, accelerations by a share of the largest one. If they differ, both
        are compared without constraints: of two meshes deep in each other a contact comes and goes by one bit, and
        constraints that exclude each other have no single solution. The fields of contacts, limits and equalities are
        compared in any case. Geoms that ours does not have (``scene``) touch nothing.
        """
        models = self.source.mj, self.ours.mj
        scene = [geom for geom in range(models[0].ngeom) if geom not in self.maps["geom"]]
        models[0].geom_contype[scene] = models[0].geom_conaffinity[scene] = 0
        largest, where, constraints = self._motion()
        if largest > _TOLERANCE and constraints:
            for model in models:
                model.opt.disableflags |= int(self.mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
            largest, where, constraints = self._motion()
        found = {"largest": largest, "where": where, "constraints": constraints, "scene": len(scene)}
        return {**found, "states": STATES, "differs": largest > _TOLERANCE}

    def _motion(self) -> tuple[float, str, int]:
        source, ours, first, second = self.source, self.ours, self.source.data, self.ours.data
        chance, constraints, found = np.random.default_rng(1), 0, [(0.0, "")]
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
            constraints += int(first.nefc)
            for one, other in self.maps["body"].items():
                pairs = zip(source.frame("body", one), ours.frame("body", other), strict=True)
                found.append((max(float(np.abs(a - b).max()) for a, b in pairs), source.called("body", one)))
            scale = max(1.0, float(np.abs(first.qacc).max(initial=0)))
            for one, other in self.maps["joint"].items():
                apart = np.abs(first.qacc[source.piece("nv", one)] - second.qacc[ours.piece("nv", other)]).max()
                found.append((float(np.nan_to_num(apart, nan=np.inf)) / scale, source.called("joint", one)))
        return *max(found, key=lambda one: one[0]), constraints

    def _match(self, kind: str) -> None:
        """Find the object of ours for each of the source: by name, else the nearest one that refers to the same."""
        source, ours = self.source, self.ours
        by_name = {name: index for index, name in enumerate(ours.names[kind]) if name}
        found = self.maps[kind] = {0: 0} if kind == "body" else {}
        for index, own in enumerate(source.names[kind]):
            name = self.given.get(kind, {}).get(index, "") or own
            other = by_name.get(name)
            if other is None and name and kind in ("material", "texture"):  # ours begin with the name of the robot
                longer = [mine for mine in by_name if mine.endswith(f"_{name}")]
                other = by_name[min(longer, key=len)] if longer else None
            if other is not None and index not in found and other not in found.values():
                found[index] = other
        waiting: dict[Any, list[int]] = {}
        for index in sorted(set(range(len(ours.names[kind]))) - set(found.values())):
            waiting.setdefault(self._signature(ours, kind, index), []).append(index)
        for index, name in enumerate(source.names[kind]):
            if index in found or kind in ("mesh", "hfield", "material") or (kind == "texture" and name):
                continue
            same = waiting.get(self._signature(source, kind, index), [])
            if same:
                place = source.place(kind, index)
                apart = [round(float(np.abs(place - ours.place(kind, at)).max(initial=0)), 9) for at in same]
                found[index] = same.pop(apart.index(min(apart)))
        for one, other in found.items():  # the names of meshes are made up again
            if kind == "geom" and (source.mesh_of(one) >= 0) == (ours.mesh_of(other) >= 0):
                data = int(source.mj.geom_dataid[one]), int(ours.mj.geom_dataid[other])
                if min(data) >= 0:
                    self.maps["mesh" if source.mesh_of(one) >= 0 else "hfield"][data[0]] = data[1]
            if kind == "material":
                for theirs, mine in zip(source.mj.mat_texid[one], ours.mj.mat_texid[other], strict=True):
                    if theirs >= 0 and mine >= 0:
                        self.maps["texture"].setdefault(int(theirs), int(mine))

    def _signature(self, model: Model, kind: str, index: int) -> Any:
        """Return what an object has in common with its match, in the numbers of ours: types, and what it refers to."""

        def mapped(of: str, number: float) -> float:
            is_ours = model is self.ours or number < 0 or not of
            return number if is_ours else self.maps.get(of, {}).get(int(number), -2 - number)

        prefix, values = KINDS[kind], list[Any]()
        if kind in _FRAMES:
            values.append(mapped("body", model.body_of(kind, index)))
        for field, extent in _arrays() if kind != "body" else ():
            if extent == f"n{prefix}" and field in _REFERENCES and not field.endswith("matid"):
                values += [mapped(*one) for one in model.references(field, extent, index)]
            elif field in (f"{prefix}_type", f"{prefix}_mode"):
                values.append(int(getattr(model.mj, field)[index]))
        if kind == "geom":
            mesh = model.mesh_of(index)
            values.append(model.collides(index))
            values += [int(model.mj.mesh_vertnum[mesh]), int(model.mj.mesh_facenum[mesh])] if mesh >= 0 else []
        return frozenset(values) if kind == "pair" else tuple(values)

    def _settings(self, statistic: Any) -> None:
        one, other = self.source.mj, self.ours.mj
        groups = [("option", one.opt, other.opt), ("size", one, other)]
        groups += [("viewer", getattr(one.vis, name), getattr(other.vis, name)) for name in _VIEWER]
        groups += [("viewer", one.stat, other.stat)] if statistic is not None else []
        for kind, theirs, own in groups:
            for field in ("nuserdata", "njmax", "nconmax") if kind == "size" else _numbers_of(theirs):
                is_set = theirs is not one.stat or np.isfinite(getattr(statistic, field)).all()
                if is_set and not close(getattr(theirs, field), getattr(own, field)):
                    text = f"{field} {in_words(getattr(theirs, field), getattr(own, field))}"
                    self.found.append(Difference(kind, field, text))

    def _objects(self) -> None:
        ours = self.ours
        for kind, names in self.source.names.items():
            for index, name in enumerate(names):
                other = self.maps[kind].get(index)
                if other is None:
                    if not (kind == "material" and self.source.is_colour(index)):
                        self.report(kind, index, "", "is not in ours")
                elif name and kind not in ("mesh", "hfield", "texture", "material"):
                    own = ours.names[kind][other]
                    if own not in (name, self.given.get(kind, {}).get(index)):
                        self.report(kind, index, "name", f"is called {own or 'nothing'} in ours")
        for kind in _MATTER:
            for index in sorted(set(range(len(ours.names[kind]))) - set(self.maps[kind].values())):
                is_harmless = (
                    (kind == "geom" and not ours.collides(index))
                    or (kind == "body" and ours.mj.body_mass[index] <= _NO_MASS)
                    or (kind == "key" and ours.names["key"][index] == "home")  # every robot of ours has one
                )
                if not is_harmless:
                    self.found.append(Difference(kind, "", f"{ours.called(kind, index)} is in ours alone"))

    def _array(self, array: str, extent: str) -> None:
        """Compare an array of mjModel, object by object; those of flexible bodies, skins and plugins as one piece."""
        kind = _PIECES[extent][0] if extent in _PIECES else _KIND_OF_EXTENT.get(extent, "")
        if extent.startswith(("nflex", "nskin", "nplugin")):
            theirs, own = (np.asarray(getattr(model.mj, array)) for model in (self.source, self.ours))
            if (own.size or not theirs.size) and not close(theirs, own):
                found, _, field = array.partition("_")
                self.found.append(Difference(found, field, f"{array} {in_words(theirs, own)}"))
            return
        for one, other in self.maps[kind].items() if kind else ():
            if array in _REFERENCES:
                self._reference(kind, array, extent, one, other)
            elif not self._is_void(kind, array, one, other):
                self._value(kind, array, extent, one, other)

    def _is_void(self, kind: str, array: str, one: int, other: int) -> bool:
        source, ours = self.source, self.ours
        gated = _GATED.fullmatch(array)
        if gated and array != "tendon_margin":
            gate, extent = f"{gated[1]}_{_GATES.get(gated[2], 'limited')}", "nu" if gated[2] == "ctrlrange" else ""
            return not (source.value(gate, extent, one).all() and ours.value(gate, extent, other).all())
        if array == "qpos_spring":
            models = ((source.mj, one), (ours.mj, other))
            return not any(np.any(mj.jnt_stiffness[i]) or np.any(mj.jnt_stiffnesspoly[i]) for mj, i in models)
        if _OF_CONTACTS.fullmatch(array):
            return not source.collides(one)  # a pair that names it has its own
        if array in ("tendon_rgba", "tendon_width"):
            return bool(source.mj.wrap_type[source.mj.tendon_adr[one]] == _JOINED)  # is not drawn
        is_frame = kind == "site" and ours.names["site"][other] in ours.names["body"]  # as all bodies have one
        return is_frame and array in ("site_type", "site_size", "site_rgba", "site_group")

    def _value(self, kind: str, array: str, extent: str, one: int, other: int) -> None:
        theirs, own = self.source.value(array, extent, one), self.ours.value(array, extent, other)
        if array in ("geom_size", "site_size"):
            count = _SIZES.get(int(getattr(self.source.mj, f"{kind}_type")[one]), 3)
            theirs, own = theirs[:count], own[:count]
        if array.endswith("_user"):
            size = max(len(theirs), len(own))
            theirs, own = np.pad(theirs, (0, size - len(theirs))), np.pad(own, (0, size - len(own)))
        if array == "eq_data" and self.source.mj.eq_type[one] == _WELD:
            theirs, own = (np.concatenate([row[:6], rotation(row[6:10]).ravel(), row[10:]]) for row in (theirs, own))
        if array == "actuator_lengthrange" and np.allclose(theirs, own, rtol=_SIMULATED, atol=_SIMULATED):
            return  # found by a simulation
        if extent != "nq":
            self.values(kind, one, array.partition("_")[2], theirs, own)
        elif not _same_position(theirs, own):
            self.report(kind, one, array, f"{_WORDS[array]} {in_words(theirs, own)}")

    def _reference(self, kind: str, array: str, extent: str, one: int, other: int) -> None:
        theirs, own = self.source.references(array, extent, one), self.ours.references(array, extent, other)
        if len(theirs) != len(own) or not all(map(self._is_same, theirs, own)):
            texts = [
                ", ".join("none" if n < 0 else model.called(of, int(n)) if of else f"{n:g}" for of, n in pairs)
                for model, pairs in ((self.source, theirs), (self.ours, own))
            ]
            field = array.partition("_")[2]
            text = f"{field} {texts[0] or 'nothing'} in the source, {texts[1] or 'nothing'} in ours"
            self.report(kind, one, field, text)

    def _is_same(self, theirs: tuple[str, float], own: tuple[str, float]) -> bool:
        (kind, one), (other_kind, other) = theirs, own
        if kind != other_kind or one < 0 or not kind:
            return kind == other_kind and close(one, other)
        expected = self.maps[kind].get(int(one))
        if expected is None:
            return kind == "material" and self.source.is_colour(int(one))
        if kind == "body" and other >= 0 and self._is_rigid(expected, int(other)):
            return all(map(near, self.ours.frame("body", expected), self.ours.frame("body", int(other))))
        return expected == other

    def _is_rigid(self, one: int, other: int) -> bool:
        """Return True if no joint of ours moves two bodies against each other."""
        return bool(self.ours.mj.body_weldid[one] == self.ours.mj.body_weldid[other])

    def _body(self, one: int, other: int) -> None:
        theirs, own = self.source.mj, self.ours.mj
        captured = bool(theirs.body_mocapid[one] >= 0), bool(own.body_mocapid[other] >= 0)
        self.values("body", one, "mocapid", *captured, "motion capture")
        masses = float(theirs.body_mass[one]), float(own.body_mass[other])
        if not one or max(masses) <= _NO_MASS:
            return
        self.values("body", one, "mass", *masses)
        if not near(theirs.body_ipos[one], own.body_ipos[other]):
            places = in_words(theirs.body_ipos[one], own.body_ipos[other])
            self.report("body", one, "ipos", f"centre of mass {places}")
        a, b = (_inertia(mj, body) for mj, body in ((theirs, one), (own, other)))
        if np.abs(a - b).max() > max(np.trace(a) * 1e-8, 1e-14):
            moments = in_words(np.diag(a), np.diag(b))
            self.report("body", one, "inertia", f"inertia {moments}, along the axes of the body")

    def _frames(self) -> None:
        """Compare where objects are in their bodies, in the first pose; of bodies and joints in a random one, too."""
        for chance in (None, np.random.default_rng(1)):
            self.place(chance)
            before = {difference.text.partition(":")[0] for difference in self.found} if chance else set()
            for kind in ("body", "joint") if chance else _FRAMES:
                for one, other in self.maps[kind].items():
                    if (one or kind != "body") and self.source.called(kind, one) not in before:
                        self._frame(kind, one, other)

    def _frame(self, kind: str, one: int, other: int) -> None:
        """Compare an object in the frame of its body; of a mesh the vertices: MuJoCo moves the origins of meshes."""
        source, ours = self.source, self.ours
        base = source.body_of(kind, one)
        while base not in self.maps["body"]:
            base = source.body_of("body", base)
        there = self.maps["body"][base]
        if kind not in ("body", "joint") and not self._is_rigid(there, ours.body_of(kind, other)):
            self.report(kind, one, "bodyid", f"is on {ours.called('body', ours.body_of(kind, other))} in ours")
            return
        origins = source.frame("body", base), ours.frame("body", there)
        if kind == "geom" and source.mesh_of(one) >= 0 and ours.mesh_of(other) >= 0:
            meshes = source.vertices(one), ours.vertices(other)
            a, b = ((corners - pos) @ turn for (pos, turn), corners in zip(origins, meshes, strict=True))
            scale = _VERTEX * max(1e-3, float(np.abs(a).max(initial=0)))
            if a.shape != b.shape or np.ptp(a - b, axis=0).max(initial=0) > scale:
                self.report("mesh", source.mesh_of(one), "vertices", "vertices differ")
            elif np.abs(a - b).max(initial=0) > scale:
                self.report("geom", one, "pos", f"position {in_words(*np.round((a[0], b[0]), 7))}")
            return
        (x, a), (y, b) = (
            (turn.T @ (place[0] - pos), turn.T @ place[1])
            for (pos, turn), place in zip(origins, (source.frame(kind, one), ours.frame(kind, other)), strict=True)
        )
        word = "position"
        if kind == "joint":
            types, word = (int(source.mj.jnt_type[one]), int(ours.mj.jnt_type[other])), "anchor"
            if types[0] != types[1]:
                return
            if types[0] not in (FREE, BALL) and not near(a, b):
                self.report(kind, one, "axis", f"axis {in_words(a, b)}")
            a, y = b, x if types[0] in (FREE, SLIDE) else y
        if not near(x, y):
            self.report(kind, one, "pos", f"{word} {in_words(x, y)}")
        if not near(a, b):
            self.report(kind, one, "quat", f"orientation differs by {np.abs(a - b).max():.2g}")

    def _geom(self, one: int, other: int) -> None:
        theirs, own, collides = self.source.mj, self.ours.mj, self.source.collides(one)
        if theirs.geom_type[one] != own.geom_type[other]:
            return
        groups = theirs.geom_group[one], own.geom_group[other]
        if groups[1] not in (groups[0], *((0, 3) if collides else (1, 2))):
            self.values("geom", one, "group", *groups)
        if not collides:  # what is seen of a collision shape may be a visual in ours
            self.values("geom", one, "rgba", self.source.colour(one), self.ours.colour(other), "colour")

    def _keys(self) -> None:
        for key, (field, extent, word) in ((key, of) for key in self.maps["key"].items() for of in _OF_KEYS):
            width, kind = {"mpos": 3, "mquat": 4}.get(field, 1), _PIECES[extent][0]
            rows = [
                np.reshape(getattr(model.mj, f"key_{field}")[index], (-1, width))
                for model, index in zip((self.source, self.ours), key, strict=True)
            ]
            for at, mine in self.maps[kind].items():
                theirs = rows[0][self.source.piece(extent, at)].ravel()
                own = rows[1][self.ours.piece(extent, mine)].ravel()
                is_turn = field in ("qpos", "mquat") and len(theirs) == len(own) > 0
                if not (_same_position(theirs, own) if is_turn else close(theirs, own)):
                    text = f"{word} of {self.source.called(kind, at)} {in_words(theirs, own)}"
                    self.report("key", key[0], field, text)

    def _order(self) -> None:
        keys = [other for _, other in sorted(self.maps["key"].items())]
        if keys != list(range(len(keys))):
            text = "the keys of the source are not the first ones, in their order"
            self.found.append(Difference("order", "key", text))
        for kind, field in (("joint", "jnt_qposadr"), ("actuator", "actuator_ctrladr"), ("sensor", "sensor_adr")):
            places = [int(getattr(self.ours.mj, field)[other]) for _, other in sorted(self.maps[kind].items())]
            if places != sorted(places):
                self.found.append(Difference("order", kind, f"the {kind}s are in another order in ours"))

    def _touching(self) -> None:
        source, geoms = self.source, list(self.maps["geom"])
        theirs, own = may_touch(source.mj, geoms), may_touch(self.ours.mj, list(self.maps["geom"].values()))
        texts = set()
        for a, b in zip(*np.nonzero(np.triu(theirs != own)), strict=True):
            bodies = sorted(int(source.mj.geom_bodyid[geoms[at]]) for at in (a, b))
            names = " and ".join(source.called("body", body) for body in bodies)
            texts.add(f"{names} may touch in {'the source' if theirs[a, b] else 'ours'} alone")
        self.found += [Difference("contact", "", text) for text in sorted(texts)]


@cache
def _arrays() -> Sequence[tuple[str, str]]:
    """Return the name and the first extent of each array of mjModel that does not follow from others."""
    fields = import_module("mujoco.introspect.structs").STRUCTS["mjModel"].fields
    extents = {field.name: str(field.array_extent[0]) for field in fields if getattr(field, "array_extent", None)}
    return [(name, extent) for name, extent in extents.items() if not _DERIVED.fullmatch(name)]


def rotation(quaternion: Any) -> Any:
    """Return the rotation matrix of a quaternion (w, x, y, z)."""
    made, numbers = np.zeros(9), np.asarray(quaternion, dtype=float)
    import_module("mujoco").mju_quat2Mat(made, numbers / (np.linalg.norm(numbers) or 1.0))
    return made.reshape(3, 3)


def _numbers_of(struct: Any) -> list[str]:
    return [name for name in dir(struct) if not name.startswith("_") and not callable(getattr(struct, name))]


def _inertia(mj: Any, body: int) -> Any:
    """Return the moments of inertia along the axes of a body, about its centre of mass (kg*m^2), 3x3."""
    turn = rotation(mj.body_iquat[body])
    return turn @ np.diag(mj.body_inertia[body]) @ turn.T


def _same_position(one: Any, other: Any) -> bool:
    """Return True if two positions of a joint are equal: the quaternion of a ball or free joint has two signs."""
    if len(one) < 4:
        return near(one, other)
    return near(one[:-4], other[:-4]) and near(rotation(one[-4:]), rotation(other[-4:]))


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
    relative, absolute = (_SINGLE, _SINGLE) if is_single else (_RELATIVE, _NUMBER)
    return np.isclose(a, b, relative, absolute, equal_nan=True)


def near(one: Any, other: Any) -> bool:
    """Return True if two positions, or two rotation matrices, are equal within rounding error."""
    return bool(np.abs(np.asarray(one, dtype=float) - other).max(initial=0) <= _POSE)


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
