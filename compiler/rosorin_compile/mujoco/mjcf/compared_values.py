"""What an array of mjModel says of one object, when two such values are equal, and how a difference is said.

It runs in the child process, for ``compared``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from rosorin_compile.compare.proof import Tolerance

from .compared_fields import SLICES
from .matched import BALL, FREE, MESH, SDF, Model, rotation

# Of the larger of two numbers of double precision: MuJoCo turns degrees, quaternions and axes into others.
RELATIVE = 1e-9


def public(struct: Any) -> Iterator[str]:
    """Yield the names of the numbers of a struct of MuJoCo."""
    for name in dir(struct):
        if not name.startswith("_") and not callable(getattr(struct, name)):
            yield name


def value(mj: Any, field: str, index: int) -> Any:
    """Return what a field says of an object: a row, or a piece of a long array."""
    array = getattr(mj, field)
    if field not in SLICES:
        return np.asarray(array)[index]
    return np.asarray(array if not isinstance(array, bytes) else np.frombuffer(array, np.uint8))[
        slice_of(mj, field, index)
    ]


def slice_of(mj: Any, field: str, index: int) -> slice:
    """Return where in a long array an object has its values."""
    address, sizes = SLICES[field]
    start, count = int(np.ravel(getattr(mj, address))[index]), 1
    for size in sizes.split():
        count *= int(np.ravel(getattr(mj, size))[index])
    return slice(start, start + count) if start >= 0 else slice(0, 0)


def dofs(mj: Any, field: str, joint: int) -> Any:
    """Return what a field says of the degrees of freedom of a joint."""
    start = int(mj.jnt_dofadr[joint])
    return getattr(mj, field)[start : start + {FREE: 6, BALL: 3}.get(int(mj.jnt_type[joint]), 1)]


def close(one: Any, other: Any) -> bool:
    """Say whether two values are equal but for rounding; of two arrays of one shape."""
    a, b = np.asarray(one), np.asarray(other)
    if a.shape != b.shape:
        return False
    if a.tobytes() == b.tobytes() and a.dtype == b.dtype:
        return True
    if a.dtype.kind != "f" and b.dtype.kind != "f":
        return bool((a == b).all())
    return bool(np.allclose(a, b, *tolerances(a, b), equal_nan=True))


def tolerances(one: Any, other: Any) -> tuple[float, float]:
    """Return how far two numbers may be apart that only rounding has moved: of the larger one, and at all."""
    if np.float32 in (one.dtype, other.dtype):
        return Tolerance.SINGLE, Tolerance.SINGLE
    return (RELATIVE, Tolerance.NUMBER) if one.dtype.kind == "f" or other.dtype.kind == "f" else (0.0, 0.0)


def near(one: Any, other: Any) -> bool:
    """Say whether two positions, or two rotation matrices, are the same."""
    return bool(np.abs(np.asarray(one, dtype=float) - other).max(initial=0) <= Tolerance.POSE)


def near_pose(one: Any, other: Any) -> bool:
    """Say whether two positions of a ball or free joint are the same: a quaternion has two signs."""
    return near(one[:-4], other[:-4]) and near(rotation(one[-4:]), rotation(other[-4:]))


def padded(one: Any, other: Any) -> tuple[Any, Any]:
    """Return two rows of numbers with zeros after the shorter one."""
    size = max(len(one), len(other))
    return np.pad(one, (0, size - len(one))), np.pad(other, (0, size - len(other)))


def inertia(mj: Any, body: int) -> Any:
    """Return the moments of inertia along the axes of a body, about its centre of mass (kg*m^2), 3x3."""
    turn = rotation(mj.body_iquat[body])
    return turn @ np.diag(mj.body_inertia[body]) @ turn.T


def shape_frame(model: Model, geom: int) -> tuple[Any, Any]:
    """Return the frame of a geom in its body; of a mesh, that of its file."""
    mj = model.mj
    pos, turn = mj.geom_pos[geom], rotation(mj.geom_quat[geom])
    if mj.geom_type[geom] in (MESH, SDF) and mj.geom_dataid[geom] >= 0:
        mesh = int(mj.geom_dataid[geom])
        turn = turn @ rotation(mj.mesh_quat[mesh]).T
        pos = pos - turn @ mj.mesh_pos[mesh]
        if mesh in model.references:
            shift, rows = model.references[mesh]
            turn = turn @ rows.T
            pos = pos - turn @ shift
    return pos, turn


def vertices(model: Model, mesh: int) -> tuple[Any, Any]:
    """Return the vertices and normals of a mesh as its file has them, scaled (m)."""
    mj, turn = model.mj, rotation(model.mj.mesh_quat[mesh])
    start, count = int(mj.mesh_vertadr[mesh]), int(mj.mesh_vertnum[mesh])
    first, many = int(mj.mesh_normaladr[mesh]), int(mj.mesh_normalnum[mesh])
    places = mj.mesh_vert[start : start + count] @ turn.T + mj.mesh_pos[mesh]
    normals = mj.mesh_normal[first : first + many] @ turn.T
    shift, rows = model.references.get(mesh, (np.zeros(3), np.eye(3)))
    return places @ rows.T + shift, normals @ rows.T


def hull(mj: Any, mesh: int) -> int:
    """Return how many vertices the convex hull of a mesh has; none if it has no hull."""
    start = int(mj.mesh_graphadr[mesh])
    return int(mj.mesh_graph[start]) if start >= 0 else 0


_NO_COLOUR = np.array([0.5, 0.5, 0.5, 1.0], dtype=np.float32)  # a geom of this colour has that of its material


def colour(mj: Any, geom: int) -> Any:
    """Return the colour in which a geom is seen."""
    own, material = mj.geom_rgba[geom], int(mj.geom_matid[geom])
    return mj.mat_rgba[material] if material >= 0 and close(own, _NO_COLOUR) else own


def same_solid(mj: Any, geom: int) -> Any:
    """Return what two geoms have in common that are the same solid at the same place."""
    numbers = (*mj.geom_pos[geom], *mj.geom_quat[geom], *mj.geom_size[geom])
    return (int(mj.geom_bodyid[geom]), int(mj.geom_type[geom]), int(mj.geom_dataid[geom]), *numbers)


def same_material(mj: Any, one: int, other: int) -> bool:
    """Say whether two materials of a model look the same: one may be there twice, once as it stood in the source."""
    if one < 0 or other < 0:
        return one == other
    fields = [name for name in dir(mj) if name.startswith("mat_") and name != "mat_texid"]
    textured = [bool((mj.mat_texid[index] >= 0).any()) for index in (one, other)]
    return textured[0] == textured[1] and all(close(getattr(mj, f)[one], getattr(mj, f)[other]) for f in fields)


def plugin(mj: Any, instance: Any) -> str:
    """Return which plugin an instance is, and its settings; empty for none."""
    if instance < 0:
        return ""
    ends = [*np.ravel(mj.plugin_attradr)[1:], mj.npluginattr]
    raw = mj.plugin_attr
    data = raw if isinstance(raw, bytes) else np.asarray(raw).astype(np.uint8).tobytes()
    settings = data[int(np.ravel(mj.plugin_attradr)[instance]) : int(ends[instance])].decode("utf-8", "replace")
    return f"{int(np.ravel(mj.plugin)[instance])}: {settings!r}"


def is_mocap(mj: Any, body: int) -> bool:
    """Say whether motion capture moves a body."""
    return bool(mj.body_mocapid[body] >= 0)


def sleep_policy(mj: Any, body: int) -> int:
    """Return the policy that is said for the tree of a body; what MuJoCo chooses by itself is 0."""
    tree = int(mj.body_treeid[body])
    policy = int(mj.tree_sleep_policy[tree]) if tree >= 0 else 0
    return policy if policy > CHOSEN else 0


CHOSEN = 2  # mjSLEEP_AUTO_ALLOWED


def activation(mj: Any, key: int, actuator: int) -> Any:
    """Return what a key has for the activations of an actuator."""
    start, count = int(mj.actuator_actadr[actuator]), int(mj.actuator_actnum[actuator])
    return mj.key_act[key][start : start + count] if start >= 0 else np.zeros(0)


def may_touch(mj: Any, geoms: Sequence[int]) -> Any:
    """Return which of some geoms MuJoCo would look for contacts of, as a matrix: masks, neighbours, excludes, pairs."""
    index = np.array(geoms, dtype=int)
    kind, affinity = mj.geom_contype[index], mj.geom_conaffinity[index]
    body = mj.geom_bodyid[index]
    weld = mj.body_weldid[body]
    above = mj.body_weldid[mj.body_parentid[weld]]
    touch = ((kind[:, None] & affinity[None, :]) | (kind[None, :] & affinity[:, None])) != 0
    touch &= weld[:, None] != weld[None, :]
    if not mj.opt.disableflags & FILTER_PARENT:
        child = (weld[:, None] == above[None, :]) & (weld[:, None] != 0) & (weld[None, :] != 0)
        touch &= ~(child | child.T)
    low, high = np.minimum(body[:, None], body[None, :]), np.maximum(body[:, None], body[None, :])
    touch &= ~np.isin((low << 16) + high, mj.exclude_signature)
    place = {int(geom): at for at, geom in enumerate(index)}
    for one, other in zip(mj.pair_geom1, mj.pair_geom2, strict=True):
        if int(one) in place and int(other) in place:
            touch[place[int(one)], place[int(other)]] = touch[place[int(other)], place[int(one)]] = True
    return touch


FILTER_PARENT = 1 << 10  # mjDSBL_FILTERPARENT; a test holds it against MuJoCo's


def both(one: Any, other: Any) -> str:
    """Return two values in words; of long ones how many differ, and the first of those."""
    a, b = np.asarray(one), np.asarray(other)
    if a.shape == b.shape and a.size > _FEW:
        relative, absolute = tolerances(a, b)
        differ = np.flatnonzero(~np.isclose(a.ravel(), b.ravel(), relative, absolute, equal_nan=True))
        first = int(differ[0]) if len(differ) else 0
        return f"differs in {len(differ)} of {a.size} numbers: {both(a.ravel()[first], b.ravel()[first])}"
    if a.size > _FEW or b.size > _FEW:
        return f"has {a.size} numbers in the source, {b.size} in ours"
    texts = [" ".join(map(_number, array.ravel().tolist())) or "nothing" for array in (a, b)]
    if texts[0] == texts[1]:
        texts = [" ".join(map(repr, array.ravel().tolist())) or "nothing" for array in (a, b)]
    return f"{texts[0]} in the source, {texts[1]} in ours"


def _number(number: float) -> str:
    return f"{number:.6g}" if abs(number) > Tolerance.NUMBER else "0"


_FEW = 20
