"""A compiled model of MuJoCo: names, frames and pieces of its arrays, and which object is which in two models.

Objects are matched by name, or by the name that the import gave them; those without a name by type and place. This runs
in the child process.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

# Each kind of object with the prefix of its arrays and their length, those that are named by others first.
KINDS = {
    "body": ("body", "nbody"),
    "joint": ("jnt", "njnt"),
    "mesh": ("mesh", "nmesh"),
    "hfield": ("hfield", "nhfield"),
    "texture": ("tex", "ntex"),
    "material": ("mat", "nmat"),
    "geom": ("geom", "ngeom"),
    "site": ("site", "nsite"),
    "camera": ("cam", "ncam"),
    "light": ("light", "nlight"),
    "pair": ("pair", "npair"),
    "flex": ("flex", "nflex"),
    "skin": ("skin", "nskin"),
    "tendon": ("tendon", "ntendon"),
    "equality": ("eq", "neq"),
    "actuator": ("actuator", "nactuator"),
    "sensor": ("sensor", "nsensor"),
    "numeric": ("numeric", "nnumeric"),
    "text": ("text", "ntext"),
    "tuple": ("tuple", "ntuple"),
    "key": ("key", "nkey"),
}

# Long arrays in which an object has a piece, by their length: the kind, where the piece begins, and what its size is.
PIECES = {
    "nmeshface": ("mesh", "mesh_faceadr", "mesh_facenum"),
    "nmeshtexcoord": ("mesh", "mesh_texcoordadr", "mesh_texcoordnum"),
    "nhfielddata": ("hfield", "hfield_adr", "hfield_nrow hfield_ncol"),
    "ntexdata": ("texture", "tex_adr", "tex_height tex_width tex_nchannel"),
    "nnumericdata": ("numeric", "numeric_adr", "numeric_size"),
    "ntextdata": ("text", "text_adr", "text_size"),
    "ntupledata": ("tuple", "tuple_adr", "tuple_size"),
    "nu": ("actuator", "actuator_ctrladr", "actuator_ctrlnum"),
    "nout": ("actuator", "actuator_outadr", "actuator_outnum"),
    "nwrap": ("tendon", "tendon_adr", "tendon_num"),
}

# Fields with the number of another object: its kind, or the field that decides it.
REFERENCES = {
    "geom_dataid": "geom_type",
    "site_matid": "material",
    "site_dataid": "mesh",
    "tendon_matid": "material",
    "mat_texid": "texture",
    "cam_targetbodyid": "body",
    "light_targetbodyid": "body",
    "light_texid": "texture",
    "pair_geom1": "geom",
    "pair_geom2": "geom",
    "eq_obj1id": "eq_type",
    "eq_obj2id": "eq_type",
    "actuator_trnid": "actuator_trntype",
    "sensor_objid": "sensor_objtype",
    "sensor_refid": "sensor_reftype",
    "tuple_objid": "tuple_objtype",
    "wrap_objid": "wrap_type",
    "flex_nodebodyid": "body",
    "flex_vertbodyid": "body",
    "flex_matid": "material",
    "skin_bonebodyid": "body",
    "skin_matid": "material",
}
# What objects without a name have in common with their match, besides being the nearest one.
_SIGNATURES = {
    "joint": ("jnt_bodyid", "jnt_type"),
    "geom": ("geom_bodyid", "geom_type"),
    "site": ("site_bodyid", "site_type"),
    "camera": ("cam_bodyid", "cam_mode"),
    "light": ("light_bodyid", "light_mode"),
    "pair": ("pair_geom1", "pair_geom2"),
    "equality": ("eq_type", "eq_obj1id", "eq_obj2id"),
    "tendon": ("tendon_type", "tendon_num"),
    "actuator": ("actuator_trntype", "actuator_trnid"),
    "sensor": ("sensor_type", "sensor_objid"),
    "texture": ("tex_type", "tex_height", "tex_width"),
}
SLIDE, BALL, FREE = 2, 1, 0  # mjtJoint
HFIELD, MESH, SDF = 1, 7, 8  # mjtGeom

Names = Mapping[str, Mapping[int, str]]  # that the import gave, by kind and number in the source
Maps = dict[str, dict[int, int]]  # the number in ours by that in the source, by kind


class Model:
    """A compiled model with the names of its objects, and the frames of its bodies at the first pose.

    ``mesh_frames`` has the frame (position, rotation) of meshes with ``refpos`` or ``refquat``.
    """

    def __init__(self, mujoco: Any, model: Any, spec: Any = None) -> None:
        self.mj = model
        self.mesh_frames = {
            mesh.id: (np.asarray(mesh.refpos) * mesh.scale, rotation(mesh.refquat))
            for mesh in (spec.meshes if spec is not None else ())
            if any(mesh.refpos) or any(mesh.refquat[1:])
        }
        self.kind_of = {int(getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")): kind for kind in KINDS}
        objects = {kind: number for number, kind in self.kind_of.items()}
        self.kind_of[int(mujoco.mjtObj.mjOBJ_XBODY)] = "body"
        self.names = {
            kind: [mujoco.mj_id2name(model, objects[kind], index) or "" for index in range(getattr(model, count))]
            for kind, (_, count) in KINDS.items()
        }
        trn, eq, wrap = mujoco.mjtTrn, mujoco.mjtEq, mujoco.mjtWrap
        joints, sites = (trn.mjTRN_JOINT, trn.mjTRN_JOINTINPARENT), (trn.mjTRN_SITE, trn.mjTRN_SLIDERCRANK)
        self.targets = {
            "actuator_trntype": {
                **dict.fromkeys(map(int, joints), "joint"),
                **dict.fromkeys(map(int, sites), "site"),
                **{int(number): "site" for name, number in trn.__members__.items() if name == "mjTRN_SO3"},
                int(trn.mjTRN_TENDON): "tendon",
                int(trn.mjTRN_BODY): "body",
            },
            "eq_type": {int(eq.mjEQ_JOINT): "joint", int(eq.mjEQ_TENDON): "tendon", int(eq.mjEQ_FLEX): "flex"},
            "geom_type": {HFIELD: "hfield", MESH: "mesh", SDF: "mesh"},
            "wrap_type": {
                int(wrap.mjWRAP_JOINT): "joint",
                int(wrap.mjWRAP_SITE): "site",
                int(wrap.mjWRAP_SPHERE): "geom",
                int(wrap.mjWRAP_CYLINDER): "geom",
            },
        }
        self.turn, self.at = np.zeros((model.nbody, 3, 3)), np.zeros((model.nbody, 3))
        for body in range(model.nbody):
            above, turn = model.body_parentid[body], rotation(model.body_quat[body])
            self.turn[body] = self.turn[above] @ turn if body else turn
            self.at[body] = self.at[above] + self.turn[above] @ model.body_pos[body] if body else model.body_pos[body]

    def value(self, field: str, extent: str, index: int) -> Any:
        """Return the row of an object in an array of mjModel, or its piece of a long one."""
        array = getattr(self.mj, field)
        data = np.frombuffer(array, np.uint8) if isinstance(array, bytes) else np.asarray(array)
        if extent == "nv":
            return data[self.dofs(index)]
        return data[self.piece(extent, index)] if extent in PIECES else data[index]

    def piece(self, extent: str, index: int) -> slice:
        """Return where an object has its piece of long arrays."""
        _, address, sizes = PIECES[extent]
        start = int(np.ravel(getattr(self.mj, address))[index])
        count = int(np.prod([np.ravel(getattr(self.mj, size))[index] for size in sizes.split()]))
        return slice(start, start + count) if start >= 0 else slice(0, 0)

    def dofs(self, joint: int) -> slice:
        """Return where a joint has its degrees of freedom."""
        start = int(self.mj.jnt_dofadr[joint])
        return slice(start, start + {FREE: 6, BALL: 3}.get(int(self.mj.jnt_type[joint]), 1))

    def positions(self, joint: int) -> slice:
        """Return where a joint has its position."""
        start = int(self.mj.jnt_qposadr[joint])
        return slice(start, start + {FREE: 7, BALL: 4}.get(int(self.mj.jnt_type[joint]), 1))

    def activations(self, actuator: int) -> slice:
        """Return where an actuator has its activations."""
        start, count = int(self.mj.actuator_actadr[actuator]), int(self.mj.actuator_actnum[actuator])
        return slice(start, start + count) if start >= 0 else slice(0, 0)

    def references(self, field: str, extent: str, index: int) -> list[tuple[str, int]]:
        """Return the objects that a field names, each with its kind; the kind of a plain number is empty."""
        numbers = [int(number) for number in np.atleast_1d(self.value(field, extent, index))]
        by = REFERENCES[field]
        if by in KINDS:
            return [(by, number) for number in numbers]
        types = np.resize(self.value(by, extent, index), len(numbers)).tolist()
        if by == "eq_type" and types[:1] and types[0] not in self.targets[by]:
            types, by = [int(self.mj.eq_objtype[index])], "eq_objtype"
        kinds = self.targets.get(by, self.kind_of)
        return [(kinds.get(int(which), ""), number) for which, number in zip(types, numbers, strict=True)]

    def seen_from(self, base: int, body: int, pos: Any, turn: Any) -> tuple[Any, Any]:
        """Return position and rotation in the frame of one body of what has those in the frame of another."""
        back = self.turn[base].T
        return back @ (self.at[body] + self.turn[body] @ pos - self.at[base]), back @ self.turn[body] @ turn

    def above(self, body: int) -> list[int]:
        """Return a body and all that hold it, the world last."""
        way = [body]
        while way[-1]:
            way.append(int(self.mj.body_parentid[way[-1]]))
        return way

    def called(self, kind: str, index: int) -> str:
        """Return what to call an object in a message."""
        name = self.names[kind][index]
        if name or kind not in ("geom", "site", "joint", "camera", "light"):
            return f"{kind} {name or index}"
        return f"{kind} {index} of {self.called('body', self.body_of(kind, index))}"

    def body_of(self, kind: str, index: int) -> int:
        """Return the body of a geom, site, joint, camera or light."""
        return int(getattr(self.mj, f"{KINDS[kind][0]}_bodyid")[index])

    def frame(self, kind: str, index: int) -> tuple[Any, Any]:
        """Return position and rotation of an object in its body; of a geom with a mesh, the frame of the file."""
        mj, prefix = self.mj, KINDS[kind][0]
        pos = getattr(mj, f"{prefix}_pos")[index]
        turn = mj.light_dir[index][:, None] if kind == "light" else rotation(getattr(mj, f"{prefix}_quat")[index])
        mesh = int(mj.geom_dataid[index]) if kind == "geom" and mj.geom_type[index] in (MESH, SDF) else -1
        if mesh >= 0:
            turn = turn @ rotation(mj.mesh_quat[mesh]).T
            pos = pos - turn @ mj.mesh_pos[mesh]
            shift, rows = self.mesh_frames.get(mesh, (np.zeros(3), np.eye(3)))
            turn = turn @ rows.T
            pos = pos - turn @ shift
        return pos, turn

    def mesh(self, mesh: int) -> tuple[Any, Any, int]:
        """Return the vertices (m) and normals of a mesh as its file has them, and the vertices of its hull (or 0)."""
        mj, turn = self.mj, rotation(self.mj.mesh_quat[mesh])
        start, count = int(mj.mesh_vertadr[mesh]), int(mj.mesh_vertnum[mesh])
        first, many = int(mj.mesh_normaladr[mesh]), int(mj.mesh_normalnum[mesh])
        shift, rows = self.mesh_frames.get(mesh, (np.zeros(3), np.eye(3)))
        places = (mj.mesh_vert[start : start + count] @ turn.T + mj.mesh_pos[mesh]) @ rows.T + shift
        graph = int(mj.mesh_graphadr[mesh])
        hull = int(mj.mesh_graph[graph]) if graph >= 0 else 0
        return places, mj.mesh_normal[first : first + many] @ turn.T @ rows.T, hull

    def collides(self, geom: int) -> bool:
        """Return True if a geom can touch others by its masks."""
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


_NO_COLOUR = np.array([0.5, 0.5, 0.5, 1.0], dtype=np.float32)  # a geom of this colour has that of its material


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


def match(source: Model, ours: Model, given: Names) -> Maps:
    """Return which object of ours is which of the source."""
    maps: Maps = {}
    for kind in KINDS:
        by_name = {name: index for index, name in enumerate(ours.names[kind]) if name}
        found = maps[kind] = {0: 0} if kind == "body" else {}
        for index, name in enumerate(source.names[kind]):
            wanted = given.get(kind, {}).get(index, "") or name
            other = by_name.get(wanted)
            if other is None and kind in ("material", "texture"):  # ours begin with the name of the robot
                longer = [own for own in by_name if own.endswith(f"_{wanted}")]
                other = by_name[min(longer, key=len)] if longer else None
            if other is not None and index not in found and other not in found.values():
                found[index] = other
        _match_nameless(source, ours, kind, maps)
        if kind == "geom":  # the names of meshes are made up again
            for one, other in found.items():
                for of, types in (("mesh", (MESH, SDF)), ("hfield", (HFIELD,))):
                    if source.mj.geom_type[one] in types and ours.mj.geom_type[other] in types:
                        maps[of][int(source.mj.geom_dataid[one])] = int(ours.mj.geom_dataid[other])
        for one, other in found.items() if kind == "material" else ():
            for theirs, own in zip(source.mj.mat_texid[one], ours.mj.mat_texid[other], strict=True):
                if theirs >= 0 and own >= 0:
                    maps["texture"].setdefault(int(theirs), int(own))
    return maps


def _match_nameless(source: Model, ours: Model, kind: str, maps: Maps) -> None:
    """Match what has no counterpart by name with the nearest one of the same signature, in order."""
    found = maps[kind]
    taken = set(found.values())
    if kind in ("mesh", "material", "hfield"):
        return  # their geoms decide
    if kind == "body":
        for index in range(source.mj.nbody):
            above = found.get(int(source.mj.body_parentid[index]))
            free = [b for b in range(1, ours.mj.nbody) if ours.mj.body_parentid[b] == above and b not in taken]
            if index not in found and free:
                found[index] = free[0]
                taken.add(free[0])
        return
    waiting: dict[Any, list[int]] = {}
    for index in range(len(ours.names[kind])):
        if index not in taken:
            waiting.setdefault(_signature(ours, kind, index, None), []).append(index)
    for index, name in enumerate(source.names[kind]):
        same = waiting.get(_signature(source, kind, index, maps), [])
        if index not in found and same and not (kind == "texture" and name):
            place = _place(source, kind, index)
            nearest = min(
                same, key=lambda other: round(float(np.abs(place - _place(ours, kind, other)).max(initial=0)), 9)
            )
            same.remove(nearest)
            found[index] = nearest


def _signature(model: Model, kind: str, index: int, maps: Maps | None) -> Any:
    """Return what an object has in common with its match, in the numbers of ours."""

    def mapped(of: str, number: int) -> int:
        return number if maps is None or number < 0 or not of else maps.get(of, {}).get(number, -2 - number)

    values: list[Any] = []
    for field in _SIGNATURES.get(kind, ()):
        if field in REFERENCES:
            values.append(mapped(*model.references(field, KINDS[kind][1], index)[0]))
        elif field.endswith("_bodyid"):
            values.append(mapped("body", model.body_of(kind, index)))
        else:
            values.append(int(np.ravel(getattr(model.mj, field))[index]))
    if kind == "geom":
        mesh = int(model.mj.geom_dataid[index]) if model.mj.geom_type[index] in (MESH, SDF) else -1
        sizes = (int(model.mj.mesh_vertnum[mesh]), int(model.mj.mesh_facenum[mesh])) if mesh >= 0 else ()
        return (*values, model.collides(index), *sizes)
    return frozenset(values) if kind == "pair" else tuple(values)


def _place(model: Model, kind: str, index: int) -> Any:
    """Return where something is at the first pose, and its sizes; empty for what has no place."""
    if kind not in ("geom", "site", "camera", "light"):
        return np.zeros(0)
    body, pos = model.body_of(kind, index), getattr(model.mj, f"{KINDS[kind][0]}_pos")[index]
    sizes = model.mj.geom_size[index] if kind == "geom" else ()
    return np.concatenate([model.at[body] + model.turn[body] @ pos, sizes])
