"""The program of the child process: MuJoCo reads a file, and what it made of it is written as JSON.

It runs in a process of its own: a file that makes MuJoCo's native code crash, hang or eat all memory ends that process
and not the command. ``process`` starts it. Nothing of the package is imported here but what this file says.
"""

from __future__ import annotations

import json
import os
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

from rosorin_compile.source import files

from .resolved import KINDS, is_named, name_all, resolved, without_made_up

_WRITTEN_FOR = 4  # the MuJoCo that our MJCF is written for

MAX_MEMORY = 16 * 2**30  # bytes of address space: MuJoCo reserves more than it uses


def main(job: str, request: str, answer: str, cpu_seconds: int) -> None:
    """Do a job of the file ``request``, and write its answer to the file ``answer``, both as JSON."""
    _limit(cpu_seconds)
    mujoco: Any = import_module("mujoco")
    asked, here = json.loads(Path(request).read_text("utf-8")), Path(answer).parent
    if job == "load":
        made: Any = load(mujoco, asked["text"], asked["folder"])
    elif job == "prove":
        mujoco.set_mju_user_warning(lambda _: None)  # which would go into a file in the working folder
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            made = proof(mujoco, asked["path"], asked, here)
    else:
        made = read(mujoco, Path(asked["path"]), here)
    Path(answer).write_text(json.dumps(made), encoding="utf-8")


def read(mujoco: Any, path: Path, here: Path) -> dict[str, Any]:
    """Return what MuJoCo makes of the MJCF at ``path``, or why it refuses it (``refused``), with its ``warnings``."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            spec = _read(mujoco, path, here)
            # What these would take away of the robot (fixed bodies, visuals) is a matter of the simulation's speed.
            spec.compiler.fusestatic = spec.compiler.discardvisual = False
            _strip_paths(spec)
            name_all(spec)
            made: dict[str, Any] = facts(mujoco, spec, spec.compile())
            if not hasattr(spec.compiler, "savecompiled"):
                made["rounded_by"] = mujoco.__version__
        except Exception as problem:  # whatever the reader refuses is reported, not raised
            made = {"refused": without_made_up(reason(mujoco, problem)[0])}
    return {**made, "warnings": [str(warning.message) for warning in caught]}


def reason(mujoco: Any, problem: Exception) -> tuple[str, bool]:
    """Return why MuJoCo refuses a model, and whether it is too old to know what MuJoCo 4 does."""
    told = str(problem)
    unknown = isinstance(problem, AttributeError) or "unrecognized" in told
    if not unknown or int(mujoco.__version__.partition(".")[0]) >= _WRITTEN_FOR:
        return told, False
    return f"MuJoCo {mujoco.__version__} is too old for it, MuJoCo {_WRITTEN_FOR} may know it: {told}", True


def _strip_paths(spec: Any) -> None:
    """Give files the names by which MuJoCo looks for them, where it is told to pass over their folders."""
    if spec.strippath:
        for asset in (*spec.meshes, *spec.textures, *spec.hfields, *spec.skins):
            asset.file = asset.file.replace("\\", "/").rpartition("/")[2]
        for texture in spec.textures:
            texture.cubefiles = [file.replace("\\", "/").rpartition("/")[2] for file in texture.cubefiles]


def load(mujoco: Any, text: str, folder: str) -> tuple[str, bool]:
    """Return why MuJoCo refuses an MJCF that stands in a folder, and whether it is too old for it.

    The reason is empty if it loads it. A file is read to its end.
    """
    mujoco.set_mju_user_warning(lambda _: None)  # which would go into a file in the working folder
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            spec = mujoco.MjSpec.from_string(text)
            spec.modelfiledir = folder
            spec.compile()
        except Exception as problem:
            told, outdated = reason(mujoco, problem)
            return told or type(problem).__name__, outdated
        finally:
            mujoco.set_mju_user_warning(None)
    return "", False


def proof(mujoco: Any, path: str, asked: dict[str, Any], here: Path) -> dict[str, Any]:
    """Return how the MJCF at ``path`` differs from a text of ours, field by field, and in motion if nothing does.

    ``asked`` has the ``text``, the files of its meshes by the names that it has for them (``files``), and the ``names``
    that the import gave by kind and index.
    """
    from .compare_models import Comparison

    theirs = _read(mujoco, Path(path), here)
    theirs.compiler.fusestatic = theirs.compiler.discardvisual = False
    ours = mujoco.MjSpec.from_string(asked["text"])
    ours.modelfiledir = str(Path(path).parent)
    for asset in (*ours.meshes, *ours.textures, *ours.hfields, *ours.skins):
        asset.file = asked["files"].get(asset.file, asset.file)
    for texture in ours.textures:
        texture.cubefiles = [asked["files"].get(file, file) for file in texture.cubefiles]
    given = {kind: {int(index): name for index, name in names.items()} for kind, names in asked["names"].items()}
    source = theirs.compile()
    try:
        made = ours.compile()
    except Exception as problem:  # whatever MuJoCo has against it
        return {"refused": " ".join(str(problem).split())}
    comparison = Comparison(mujoco, source, made, given)
    found = comparison.run(theirs.stat)
    counts = {kind: len(names) for kind, names in comparison.source.names.items()}
    answer: dict[str, Any] = {"differences": found, "counts": counts}
    if comparison.moves_alike():
        answer["motion"] = comparison.motion()._asdict()
    return answer


def _read(mujoco: Any, path: Path, here: Path) -> Any:
    """Return the MjSpec of a file; MuJoCo itself refuses one whose name does not end in .xml.

    ``here`` is the working folder of this process.
    """
    if path.suffix == ".xml":
        return mujoco.MjSpec.from_file(str(path))
    os.chdir(path.parent)  # where a text's includes are looked for
    try:
        spec = mujoco.MjSpec.from_string(files.read_text(path))
    finally:
        os.chdir(here)  # what MuJoCo logs goes there, not beside the file
    spec.modelfiledir = str(path.parent)
    return spec


def _limit(cpu_seconds: int) -> None:
    """Give this process an end, and no more memory than a robot can need; where the system knows such limits."""
    try:
        import resource
    except ImportError:
        return
    for kind, most in ((resource.RLIMIT_CPU, cpu_seconds), (resource.RLIMIT_AS, MAX_MEMORY), (resource.RLIMIT_CORE, 0)):
        _, allowed = resource.getrlimit(kind)  # which no process may raise
        least = most if allowed == resource.RLIM_INFINITY else min(most, allowed)
        grace = kind == resource.RLIMIT_CPU and least != allowed  # whoever passes the first of the two is told apart
        resource.setrlimit(kind, (least, least + grace))


_INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast")  # mjtIntegrator

_NOTHING: dict[str, Any] = {"tag": "", "attributes": {}, "inner": []}

# What is read of each kind of object: its kind, the prefix of its arrays in mjModel, and our word for each array.
_PLACE = {"body": "bodyid", "pos": "pos", "quat": "quat"}
_TABLES: dict[str, tuple[str, str, dict[str, str]]] = {
    "bodies": (
        "BODY",
        "body",
        {"parent": "parentid", "pos": "pos", "quat": "quat", "mass": "mass", "ipos": "ipos", "iquat": "iquat"}
        | {"inertia": "inertia"},
    ),
    "joints": (
        "JOINT",
        "jnt",
        {"body": "bodyid", "type": "type", "pos": "pos", "axis": "axis", "limited": "limited", "range": "range"}
        | {"address": "qposadr", "dof": "dofadr", "forced": "actfrclimited", "force": "actfrcrange"},
    ),
    "geoms": (
        "GEOM",
        "geom",
        {**_PLACE, "type": "type", "size": "size", "contype": "contype", "conaffinity": "conaffinity"}
        | {"group": "group", "rgba": "rgba", "material": "matid", "data": "dataid"},
    ),
    "sites": ("SITE", "site", _PLACE),
    "cameras": ("CAMERA", "cam", {**_PLACE, "mode": "mode"}),
    "lights": ("LIGHT", "light", {"body": "bodyid", "pos": "pos", "dir": "dir"}),
    "materials": ("MATERIAL", "mat", {"rgba": "rgba", "textures": "texid"}),
    "meshes": ("MESH", "mesh", {"pos": "pos", "quat": "quat", "scale": "scale"}),
    "equalities": (
        "EQUALITY",
        "eq",
        {"type": "type", "first": "obj1id", "second": "obj2id", "active": "active0", "data": "data"}
        | {"solref": "solref", "solimp": "solimp"},
    ),
    "actuators": (
        "ACTUATOR",
        "actuator",
        {"transmission": "trntype", "target": "trnid", "gain": "gaintype", "bias": "biastype", "dynamics": "dyntype"}
        | {"gainprm": "gainprm", "biasprm": "biasprm", "gear": "gear", "forced": "forcelimited", "force": "forcerange"}
        | {"controlled": "ctrllimited", "control": "ctrlrange", "at": "ctrladr"},
    ),
    "keys": ("KEY", "key", {"qpos": "qpos", "ctrl": "ctrl"}),
}


def facts(mujoco: Any, spec: Any, model: Any) -> dict[str, Any]:
    """Return the compiled model as lists of plain values; indices are those of MuJoCo, -1 is none."""
    elements = resolved(spec)
    by_name = {word: elements.pop(word) for word in (*KINDS, "bodies")}
    made: dict[str, Any] = {"name": spec.modelname, "elements": elements}
    for word, (kind, prefix, fields) in _TABLES.items():
        columns = {key: getattr(model, f"{prefix}_{field}").tolist() for key, field in fields.items()}
        for key in ("controlled", "control") if word == "actuators" else ():  # of the first of its controls
            columns[key] = [columns[key][at] for at in columns["at"]]
        count = len(next(iter(columns.values())))
        kind_of_object = getattr(mujoco.mjtObj, f"mjOBJ_{kind}")
        names = [mujoco.mj_id2name(model, kind_of_object, index) or "" for index in range(count)]
        columns["name"] = [name if is_named(name) else "" for name in names]
        if word in by_name:
            columns["element"] = [by_name[word].get(name, _NOTHING) for name in names]
        made[word] = [{key: column[index] for key, column in columns.items()} for index in range(count)]
    made |= {
        "excludes": model.exclude_signature.tolist(),
        "zero": model.qpos0.tolist(),
        "damping": model.dof_damping.ravel().tolist(),
        "armature": model.dof_armature.tolist(),
        "friction": model.dof_frictionloss.tolist(),
        "integrator": _INTEGRATORS[int(model.opt.integrator)],
    }
    _authored(spec, made)
    return made


def _authored(spec: Any, made: dict[str, Any]) -> None:
    """Add what only the file says, and no compiled model: classes, written inertias, files and frames of meshes."""
    for geom in spec.geoms:
        made["geoms"][geom.id]["class"] = geom.classname.name if geom.classname else ""
    for body in spec.bodies:
        if body.explicitinertial:
            full = body.fullinertia.tolist()
            said = {"pos": body.ipos.tolist(), "full": full if full[0] == full[0] else None}
            made["bodies"][body.id]["said"] = said
    usual = type(spec)().add_mesh().inertia
    for mesh in spec.meshes:
        entry = made["meshes"][mesh.id]
        entry["file"] = mesh.file
        entry["folder"] = _folder(mesh.compiler, spec, "meshdir")
        entry["taken"] = "" if mesh.inertia == usual else mesh.inertia.name.rpartition("_")[2].lower()
        entry["reference"] = {"pos": mesh.refpos.tolist(), "quat": mesh.refquat.tolist()}
    files = {texture.id: _joined(texture, spec, "texturedir") for texture in spec.textures}
    kinds = {
        "mesh": ("meshdir", spec.meshes),
        "hfield": ("meshdir", spec.hfields),
        "texture": ("texturedir", spec.textures),
    }
    made["folders"] = {
        kind: {asset.name: _folder(asset.compiler, spec, word) for asset in assets}
        for kind, (word, assets) in kinds.items()
    }
    made["folders"]["skin"] = {"": (spec.compiler.meshdir or "").replace("\\", "/")}
    meshes = [_joined(asset, spec, "meshdir") for asset in (*spec.meshes, *spec.hfields)]
    made["assets"] = [file for file in dict.fromkeys([*meshes, *files.values()]) if file]
    for entry in made["materials"]:
        used = [files.get(index, "") for index in entry.pop("textures")]
        entry["texture"] = next((file for file in used if file), "")


def _folder(compiler: Any, spec: Any, word: str) -> str:
    """Return the folder that files of a kind are looked for in, relative to the main file."""
    return (getattr(compiler, word, "") or getattr(spec.compiler, word, "") or "").replace("\\", "/")


def _joined(asset: Any, spec: Any, word: str) -> str:
    """Return the file of a mesh, height field or texture, relative to the main file; empty if it has none."""
    folder = _folder(asset.compiler, spec, word).rstrip("/")
    return f"{folder}/{asset.file}" if asset.file and folder else asset.file
