"""What the authoring schema has beside the plain one: parts, their uses, named values, includes, types of sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..language import Language

Schema = dict[str, Any]

# A name that an expression can use: letters of any script, digits, underscores. \w would be ASCII alone in an editor.
_NAME = r"[^\s!-/0-9:-@\[-^`{-~][^\s!-/:-@\[-^`{-~]*"
_IDENTIFIER = f"^{_NAME}$"
_CALLED = rf"^{_NAME}(\(({_NAME}(, *{_NAME})*)?\))?$"  # name, or name(first, second)
_BOUNDS = {
    "min": {"description": "The smallest value that is allowed."},
    "max": {"description": "The largest value that is allowed."},
}
_SOME = r"\$\{"
_WHOLE = r"^\$\{[\s\S]*\}$"

_CONTROLS: Schema = {
    "for": {
        "type": "object",
        "description": 'A loop: the entry is made for each value. {side: [left, right]}, {i: "${range(4)}"}; '
        '"name, x" takes rows apart; several names are nested loops, the last one fastest.',
        "minProperties": 1,
        "additionalProperties": {
            "type": ["array", "object", "string"],
            "description": "A list, or a table: its keys.",
        },
    },
    "if": {
        "type": ["boolean", "string"],
        "description": "A condition: without it the entry is left out. ${with_arm}, ${n > 2 and not slim}.",
        "pattern": _WHOLE,
    },
}


def _ref(name: str, description: str = "") -> Schema:
    return {"$ref": f"#/definitions/{name}", **({"description": description} if description else {})}


def added_sections(sections: Schema) -> Schema:
    """Return the sections of a file that the plain tree has no more, given those that it has."""
    return {
        "help": {"type": "string", "description": "A file of parts: what it is for."},
        "include": {
            **sections["include"],
            "items": _include(),
        },
        "let": _ref("let"),
        "parts": {
            "type": "object",
            "description": "Reusable pieces of a description, by name; use puts them into the robot.",
            "additionalProperties": _ref("part"),
        },
        "use": _ref("uses"),
        "sensor_types": {
            "type": "object",
            "description": "Types of sensors of your own, by name; they go before those of the library.",
            "additionalProperties": _ref("sensor_type"),
        },
    }


def _include() -> Schema:
    """Return the schema of an entry of ``include``: a file of this description, or another one's robot."""
    text: Schema = {"type": "string"}
    return {
        "type": ["string", "object"],
        "description": "A file, or a file with what is said beside it. A .urdf, .xacro or .xml is another one's robot: "
        "it is joined as it is, with its names prefixed, and attached to a frame.",
        "properties": {
            "file": {
                **text,
                "description": "The file, relative to this one, or package://NAME/FILE in a ROS package; with "
                "package, relative to that package.",
            },
            "args": {"type": "object", "description": "Values of arguments, by name: of a file in YAML or a xacro."},
            "package": {**text, "description": "The ROS package that the file is in, wherever that is."},
            "packages": {
                "type": "object",
                "description": "Folders of ROS packages by name, relative to this file; they go before "
                "ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.",
                "additionalProperties": text,
            },
            "lenient": {
                "type": ["boolean", "string"],
                "pattern": _WHOLE,
                "description": "Robot: take what breaks the specification where a robot comes out all the same.",
            },
            "trust": {
                "type": ["boolean", "string"],
                "pattern": _WHOLE,
                "description": "Robot: no effect. Trust comes from the person who runs the command: --trust.",
            },
            "prefix": {**text, "description": "Robot: what is put before the names of its links, joints and so on."},
            "meshes": {
                **text,
                "description": "Robot: what is put before the relative names of its meshes and textures: a folder as "
                "seen from the artifacts, or package://NAME.",
            },
            "parent": _ref("name", "Robot: the frame that its root link is attached to."),
            "xyz": _ref("xyz", "Robot: position of its root link in the parent, in metres."),
            "rpy": _ref("rpy", "Robot: orientation of its root link in the parent, in radians."),
            "joint": _ref("name", "Robot: name of the fixed joint; default is that of its root link and _joint."),
            "publisher": _ref("publisher"),
            "source": _ref("source"),
            **{control: _ref(control) for control in _CONTROLS},
        },
        "required": ["file"],
        "additionalProperties": False,
    }


def definitions(language: Language) -> Schema:
    """Return the definitions of the plain schema, with the ids of the rules that ``accept`` may name."""
    plain = language.schema
    acceptance = plain["$defs"]["acceptance"]
    rule = {"enum": list(language.acceptable), "description": acceptance["properties"]["rule"]["description"]}
    return {**plain["$defs"], "acceptance": {**acceptance, "properties": {**acceptance["properties"], "rule": rule}}}


def added_definitions(language: Language, sections: Schema, arg: Schema) -> Schema:
    """Return the definitions that those sections and every entry refer to; ``arg`` is that of an argument."""
    inside = {name: sections[name] for name in language.in_parts}
    help = {"type": "string", "description": "One sentence for the person who uses it."}
    return {
        **_CONTROLS,
        "let": {
            "type": "object",
            "description": "Named values for expressions: ${name}, or ${name(x)} of name(x): VALUE. Numbers, texts, "
            "lists, whole entries; any order.",
            "propertyNames": {"pattern": _CALLED},
        },
        "params": _params("arg", "What a use may say: name: {type, default, help}, or name: DEFAULT."),
        "bounded_params": _params(
            "bounded_param", "What with may say: name: {type, default, min, max, help}, or DEFAULT."
        ),
        "bounded_param": {**arg, "properties": {**arg["properties"], **_BOUNDS}},
        "part": {
            "type": "object",
            "description": "A reusable piece. Inside it names are short; mount is the frame that it is attached to.",
            "properties": {"help": help, "params": _ref("params"), "let": _ref("let"), "use": _ref("uses"), **inside},
            "additionalProperties": False,
        },
        "uses": {
            "type": "object",
            "description": "Parts that are put into the robot: name: {part: ..., parent: ...}.",
            "additionalProperties": _ref("use"),
        },
        "use": _use(inside, language.mirrors),
        "sensor_type": _sensor_type(help, language),
    }


def _params(entry: str, description: str) -> Schema:
    """Return what declares parameters; what is no mapping is the default of one."""
    return {
        "type": "object",
        "description": description,
        "propertyNames": {"pattern": _IDENTIFIER},
        "additionalProperties": {"anyOf": [_ref(entry), {"not": {"type": "object"}}]},
    }


def _use(inside: Schema, mirrors: Sequence[str]) -> Schema:
    properties = {
        "part": {
            "type": "string",
            "description": "NAME of parts, FILE/NAME of the library, or PACKAGE:FILE/NAME of a Python package.",
        },
        "with": {"type": ["object", "string"], "description": "Values for the params of the part.", "pattern": _WHOLE},
        "prefix": {
            "type": ["string", "null"],
            "description": "What is put before its names; default is the name of this use and _.",
        },
        "parent": _ref("name", "The frame that it is attached to: the mount of the part."),
        "xyz": _ref("xyz", "Position of the mount in the parent, in metres."),
        "rpy": _ref("rpy", "Orientation of the mount in the parent, in radians."),
        "mirror": {
            "description": "The axis of the mount that is reversed: y makes a right side of a left one.",
            "anyOf": [{"enum": list(mirrors)}, {"type": "string", "pattern": _WHOLE}],
        },
        "content": {
            "type": "object",
            "description": "Entries that are put into the part, as if they stood in it.",
            "properties": inside,
            "additionalProperties": False,
        },
        "source": _ref("source"),
        "for": _ref("for"),
        "if": _ref("if"),
    }
    return {
        "type": ["object", "string"],
        "description": "A part put into the robot.",
        "pattern": _WHOLE,
        "properties": properties,
        "patternProperties": {_SOME: True},
        "required": ["part"],
        "additionalProperties": False,
    }


def _sensor_type(help: Schema, language: Language) -> Schema:
    keys = language.schema["$defs"]["sensor"]["properties"]
    return {
        "type": ["object", "null"],
        "description": "What every sensor of this type has, unless it says otherwise.",
        "properties": {
            "help": help,
            "params": _ref("bounded_params"),
            "let": _ref("let"),
            **{key: _of_sensor(key, keys[key]) for key in language.in_types},
        },
        "additionalProperties": False,
    }


def _of_sensor(key: str, said: Schema) -> Schema:
    """Return what a sensor has at a key, where that is defined."""
    reference = said.get("$ref", f"sensor/properties/{key}")
    return {"$ref": f"#/definitions/{reference.removeprefix('#/$defs/')}"}
