"""The program of the child process: load a file with MuJoCo and write the compiled model as JSON.

MuJoCo's writer expands includes, replicas and attached models and writes angles in radians, but it leaves out
attributes that an element has from its default class. ``apply_classes`` adds them.
"""

import json
import os
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from rosorin_compile.source import files

_WRITTEN_FOR = 4  # major version of MuJoCo that a generated MJCF requires
MAX_MEMORY = 16 * 2**30  # bytes of address space: MuJoCo reserves more than it uses

# For each kind of object: its name in mjtObj, the prefix of its arrays in mjModel, and the arrays to return.
_TABLES = {
    "bodies": ("BODY", "body", "parentid pos quat mass ipos iquat inertia"),
    "joints": ("JOINT", "jnt", "bodyid type pos axis limited range qposadr dofadr actfrclimited actfrcrange"),
    "geoms": ("GEOM", "geom", "bodyid pos quat type size contype conaffinity group rgba matid dataid"),
    "sites": ("SITE", "site", "bodyid pos quat"),
    "cameras": ("CAMERA", "cam", "bodyid pos quat"),
    "lights": ("LIGHT", "light", "bodyid pos dir"),
    "materials": ("MATERIAL", "mat", "rgba texid"),
    "meshes": ("MESH", "mesh", "pos quat scale"),
    "equalities": ("EQUALITY", "eq", "type obj1id obj2id active0 data solref solimp"),
    "actuators": ("ACTUATOR", "actuator", "trnid gaintype biastype gainprm gear forcelimited forcerange ctrladr"),
    "keys": ("KEY", "key", "qpos ctrl"),
}
# Objects inside bodies: the name of their list in MjSpec, and their tags in XML.
HELD = {"joints": ("joint", "freejoint"), "geoms": ("geom",), "sites": ("site",), "cameras": ("camera",)}
HELD["lights"] = ("light",)
_LISTED = {"tendons": "tendon", "equalities": "equality", "actuators": "actuator", "sensors": "sensor"}
_WHOLE = ("extension", "size", "visual", "statistic", "custom", "deformable")  # sections that are copied unchanged
_NO_NAME = "rosorin-compile without name "  # prefix of temporary names for objects without a name
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|[-+]?(inf|nan)", re.IGNORECASE)
# Lists that replace the list of the default class, even if they are shorter. See ``_merged`` for all others.
_OPEN = ("user", "data", "qpos", "qvel", "act", "ctrl", "mpos", "mquat", "vertex", "face")


def main(job: str, request_file: str, answer: str, cpu_seconds: int) -> None:
    """Run the job "load", "prove" or "read" on the JSON file ``request_file``, and write a JSON file ``answer``."""
    _limit(cpu_seconds)
    request, here = json.loads(Path(request_file).read_text("utf-8")), Path(answer).parent
    if job == "load":
        made: Any = load(request["text"], request["folder"])
    elif job == "prove":
        with quiet() as mujoco:
            made = _proof(mujoco, request, here)
    else:
        made = read(import_module("mujoco"), Path(request["path"]), here)
    Path(answer).write_text(json.dumps(made), encoding="utf-8")


def read(mujoco: Any, path: Path, here: Path) -> dict[str, Any]:
    """Compile an MJCF and return a dict: the compiled model or the error ("refused"), and MuJoCo's "warnings"."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            spec = _spec(mujoco, path, here)
            _resolve_files(spec)
            unnamed = (thing for kind in (*HELD, "bodies", "pairs", *_LISTED) for thing in getattr(spec, kind))
            for number, thing in enumerate(one for one in unnamed if not one.name):  # temporary, to find elements
                thing.name = f"{_NO_NAME}{number}"
            made = _facts(mujoco, spec, spec.compile())
        except Exception as problem:  # MuJoCo raises several types of errors
            made = {"refused": re.sub(rf"{_NO_NAME}\d+", "", reason(mujoco, problem)[0])}
    return {**made, "warnings": [str(warning.message) for warning in caught]}


@contextmanager
def quiet() -> Iterator[Any]:
    """Import MuJoCo and suppress its warnings, which it would also write to a log in the working directory."""
    mujoco: Any = import_module("mujoco")
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield mujoco
    finally:
        mujoco.set_mju_user_warning(None)


def load(text: str, folder: str) -> tuple[str, bool]:
    """Compile an MJCF with paths relative to ``folder``; return (error or "", True if this MuJoCo is too old)."""
    with quiet() as mujoco:
        try:
            spec = mujoco.MjSpec.from_string(text)
            spec.modelfiledir = folder
            spec.compile()
            return "", False
        except Exception as problem:
            why, outdated = reason(mujoco, problem)
            return why or type(problem).__name__, outdated


def reason(mujoco: Any, problem: Exception) -> tuple[str, bool]:
    """Return (message, True if the installed MuJoCo is too old for a generated MJCF) for an error of MuJoCo."""
    why, version, is_unknown = str(problem), mujoco.__version__, "unrecognized" in str(problem)
    is_new = int(version.partition(".")[0]) >= _WRITTEN_FOR
    if not is_new and (is_unknown or isinstance(problem, AttributeError)):
        return f"MuJoCo {version} is too old for it, MuJoCo {_WRITTEN_FOR} may know it: {why}", True
    is_gone = is_new and is_unknown and "composite" in why
    return (f"MuJoCo {version} no longer reads <composite>, MuJoCo 3 does: {why}" if is_gone else why), False


def _proof(mujoco: Any, request: dict[str, Any], here: Path) -> dict[str, Any]:
    """Compare an imported file with the MJCF generated from it, and return the differences as JSON."""
    from .compare_models import STATES, TOLERANCE, Comparison

    given = {kind: {int(index): name for index, name in names.items()} for kind, names in request["names"].items()}
    source = _spec(mujoco, Path(request["path"]), here).compile()
    try:
        ours = mujoco.MjSpec.from_string(request["text"])
        ours.modelfiledir = str(Path(request["path"]).parent)
        for asset in (*ours.meshes, *ours.textures, *ours.hfields, *ours.skins):
            asset.file = request["files"].get(asset.file, asset.file)
        for texture in ours.textures:
            texture.cubefiles = [request["files"].get(file, file) for file in texture.cubefiles]
        made = ours.compile()
    except Exception as problem:  # MuJoCo raises several types of errors
        return {"refused": " ".join(str(problem).split())}
    comparison = Comparison(mujoco, source, made, given)
    differences: list[tuple[str, str, str]] = list(comparison.run())
    if not comparison.moves_alike():
        return {"differences": differences}
    largest, where = comparison.motion()
    if largest > TOLERANCE:
        differences.insert(0, ("motion", "", f"frames or accelerations differ by {largest:.2g} ({where})"))
    return {"differences": differences, "motion": f"in {STATES} random states: largest difference {largest:.2g}"}


def _spec(mujoco: Any, path: Path, here: Path) -> Any:
    if path.suffix == ".xml":
        spec = mujoco.MjSpec.from_file(str(path))
    else:
        os.chdir(path.parent)  # from_string resolves includes in the working directory
        try:
            spec = mujoco.MjSpec.from_string(files.read_text(path))
        finally:
            os.chdir(here)  # MuJoCo writes its log there
        spec.modelfiledir = str(path.parent)
    # These options remove fixed bodies and visuals for speed, but the description needs them.
    spec.compiler.fusestatic = spec.compiler.discardvisual = False
    return spec


def _resolve_files(spec: Any) -> None:
    """Prepend ``meshdir`` or ``texturedir`` to the file names of assets, as MuJoCo does."""

    def path(file: str, folder: str) -> str:
        file, folder = file.replace("\\", "/"), folder.replace("\\", "/").rstrip("/")
        file = file.rpartition("/")[2] if spec.strippath else file
        return f"{folder}/{file}" if file and folder and not Path(file).is_absolute() else file

    for word, assets in (("meshdir", (*spec.meshes, *spec.hfields, *spec.skins)), ("texturedir", spec.textures)):
        for asset in assets:
            folder = getattr(asset.compiler, word, "") or getattr(spec.compiler, word, "") or ""
            asset.file = path(asset.file, folder)
            if word == "texturedir":
                asset.cubefiles = [path(file, folder) for file in asset.cubefiles]
    for compiler in (spec.compiler, *(asset.compiler for asset in (*spec.meshes, *spec.hfields, *spec.textures))):
        compiler.meshdir = compiler.texturedir = ""
    spec.strippath = False


def _limit(cpu_seconds: int) -> None:
    try:
        import resource
    except ImportError:
        return
    for kind, most in ((resource.RLIMIT_CPU, cpu_seconds), (resource.RLIMIT_AS, MAX_MEMORY), (resource.RLIMIT_CORE, 0)):
        _, allowed = resource.getrlimit(kind)  # the hard limit, which cannot be raised
        least = most if allowed == resource.RLIM_INFINITY else min(most, allowed)
        grace = kind == resource.RLIMIT_CPU and least != allowed  # the hard limit is 1 s above the soft limit
        resource.setrlimit(kind, (least, least + grace))


def _facts(mujoco: Any, spec: Any, model: Any) -> dict[str, Any]:
    """Return the compiled model and the elements of the file as JSON, with MuJoCo's field names."""
    has_digits = hasattr(spec.compiler, "savecompiled")
    if has_digits:  # MuJoCo 3.12 and older lack this option and write only six digits
        spec.compiler.savecompiled = False
    elements = _elements(ElementTree.fromstring(spec.to_xml()))  # noqa: S314 - written by MuJoCo
    made: dict[str, Any] = {"name": spec.modelname, "elements": elements}
    made["rounded_by"] = "" if has_digits else mujoco.__version__
    for word, (kind, prefix, fields) in _TABLES.items():
        columns = {field: getattr(model, f"{prefix}_{field}").tolist() for field in fields.split()}
        if word == "actuators":  # an actuator can have several controls: use the range of the first
            for field in ("ctrllimited", "ctrlrange"):
                values = getattr(model, f"actuator_{field}").tolist()
                columns[field] = [values[at] for at in columns["ctrladr"]]
        count = len(next(iter(columns.values())))
        names = [mujoco.mj_id2name(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), at) or "" for at in range(count)]
        columns["name"] = ["" if name.startswith(_NO_NAME) else name for name in names]
        if word == "bodies" or word in HELD:
            nothing, by_name = {"tag": "", "attributes": {}, "inner": []}, elements.pop(word)
            columns["element"] = [by_name.get(name, nothing) for name in names]
        made[word] = [{key: column[index] for key, column in columns.items()} for index in range(count)]
    for word in ("exclude_signature", "qpos0", "dof_damping", "dof_armature", "dof_frictionloss"):
        made[word] = getattr(model, word).ravel().tolist()
    made["integrator"] = ("Euler", "RK4", "implicit", "implicitfast")[int(model.opt.integrator)]  # mjtIntegrator
    for word in ("bodies", *HELD):
        for thing in getattr(spec, word):
            entry = made[word][thing.id]
            entry["line"] = int(re.sub(r"\D", "", thing.info) or 0)
            if word == "geoms":
                entry["class"] = thing.classname.name if thing.classname else ""
            elif word == "bodies" and thing.explicitinertial:
                full = thing.fullinertia.tolist()  # nan if the element has no fullinertia
                entry["written"] = {"pos": thing.ipos.tolist(), "full": full if full[0] == full[0] else None}
    usual = type(spec)().add_mesh().inertia
    for mesh in spec.meshes:
        entry = made["meshes"][mesh.id]
        entry["file"] = mesh.file
        entry["taken"] = "" if mesh.inertia == usual else mesh.inertia.name.rpartition("_")[2].lower()
        entry["reference"] = {"pos": mesh.refpos.tolist(), "quat": mesh.refquat.tolist()}
    assets = [*spec.meshes, *spec.hfields, *spec.textures]
    made["assets"] = list(dict.fromkeys(asset.file for asset in assets if asset.file))
    textures = {texture.id: texture.file for texture in spec.textures}
    for entry in made["materials"]:
        entry["texture"] = next(filter(None, map(textures.get, entry["texid"])), "")
    return made


def apply_classes(root: Any, complete_lists: bool = True) -> None:
    """Copy the attributes of default classes to the elements below ``root``, an ``ElementTree.Element``.

    Like MuJoCo, complete lists of numbers that are shorter than in the class, unless ``complete_lists`` is false.
    """
    join = _merged if complete_lists else lambda usual, own: {**usual, **own}
    classes: dict[str, dict[str, Mapping[str, str]]] = {}

    def define(default: Any, above: Mapping[str, Mapping[str, str]], name: str) -> None:
        own = {**above, **{one.tag: join(above.get(one.tag, {}), one.attrib) for one in default}}
        classes[default.get("class") or name] = own
        for inner in default.findall("default"):
            define(inner, own, "")

    for default in root.findall("default"):
        define(default, {}, "main")
    for section in (one for one in root if one.tag != "default"):
        kind = section.tag if section.tag in ("equality", "tendon") else ""
        waiting = [(one, "main") for one in section]
        while waiting:
            element, childclass = waiting.pop()
            childclass = element.get("childclass") or childclass
            usual = classes.get(element.get("class") or childclass, {}).get(kind or element.tag, {})
            made = join(usual, element.attrib)
            element.attrib.clear()
            element.attrib.update(made)
            waiting += [(one, childclass) for one in element] if section.tag == "worldbody" else []


def _elements(root: Any) -> dict[str, Any]:
    """Convert MuJoCo's XML to nodes (see ``convert``): bodies and their contents by name, sections as lists."""
    apply_classes(root)
    made: dict[str, Any] = {kind: {} for kind in (*HELD, "bodies")}
    kind_of = {tag: kind for kind, tags in HELD.items() for tag in tags}

    def add_body(element: Any, name: str) -> None:
        held = made["bodies"].setdefault(name, {"tag": "body", "attributes": {}, "inner": []})
        held["attributes"] |= _node(element)["attributes"]
        waiting = list(element)
        while waiting:
            child = waiting.pop(0)
            if child.tag == "frame":
                waiting[:0] = list(child)
            elif child.tag == "body":
                add_body(child, child.get("name", ""))
            elif child.tag in kind_of:
                made[kind_of[child.tag]][child.get("name", "")] = _node(child)
            elif child.tag != "inertial":
                held["inner"].append(_node(child))

    for world in root.findall("worldbody"):
        add_body(world, "world")
    paths = {word: f"{section}/*" for word, section in _LISTED.items()} | {"pairs": "contact/pair"}
    paths |= {f"{tag}_assets": f"asset/{tag}" for tag in ("material", "texture", "mesh", "hfield")}
    made |= {word: [_node(one) for one in root.iterfind(path)] for word, path in paths.items()}
    made["options"] = {key: value for option in root.findall("option") for key, value in option.attrib.items()}
    for flag in root.iterfind("option/flag"):
        made["options"] |= {f"flag {key}": value for key, value in flag.attrib.items()}
    made["keys"] = [dict(key.attrib) for key in root.iterfind("keyframe/*")]
    made["whole"] = [_node(one) for tag in _WHOLE for one in root.findall(tag)]
    return made


def _node(element: Any) -> dict[str, Any]:
    without = ("class", "childclass", *(("rgba", "width", "material") if element.tag == "fixed" else ()))
    attributes = {key: value for key, value in element.attrib.items() if key not in without}
    if attributes.get("name", _NO_NAME).startswith(_NO_NAME) or not attributes["name"]:
        attributes.pop("name", None)
    return {"tag": element.tag, "attributes": attributes, "inner": [_node(child) for child in element]}


def _merged(usual: Mapping[str, str], own: Mapping[str, str]) -> dict[str, str]:
    """Update the attributes ``usual`` with ``own``; a shorter list of numbers replaces only the first numbers."""
    made = dict(usual)
    for key, value in own.items():
        words, before = value.split(), made.get(key, "").split()
        is_few = key not in _OPEN and len(words) < len(before) and all(map(_NUMBER.fullmatch, (*words, *before)))
        made[key] = " ".join([*words, *before[len(words) :]]) if is_few else value
    return made
