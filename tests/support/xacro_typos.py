"""Descriptions with one slip each: name, then description, rule, line in it (from 1), a word of message or help.

Beside each stands more.yaml, a file that may be included.
"""

from __future__ import annotations

_PART = "parts: {p: {links: {l: {}}, joints: {j: {type: fixed, parent: mount, child: l}}}}\n"
_USED = "links: {b: {}}\nuse: {x: {part: p, parent: b}}\n"
_LINK = "links: {b: {visual: [{sphere: {radius: RADIUS}}]}}\n"


def _part(body: str) -> str:
    """Return a description that uses a part with one more thing in it."""
    return _USED + _PART.replace("{p: {", f"{{p: {{{body}, ")


def _use(more: str) -> str:
    """Return a description that uses a part with something more said."""
    return f"{_PART}links: {{b: {{}}}}\nuse: {{x: {{part: p, parent: b, {more}}}}}\n"


def _unused(body: str) -> str:
    """Return a description with a part that nothing uses."""
    return f"links: {{b: {{}}}}\nparts: {{p: {{{body}}}}}\n"


TYPOS: dict[str, tuple[str, str, int, str]] = {
    # keys
    "key of the description": ("lniks: {b: {}}\nlinks: {b: {}}\n", "unknown-key", 1, "links"),
    "key of a link": ("links: {b: {visaul: []}}\n", "unknown-key", 1, "visual"),
    "key of a shape": ("links: {b: {visual: [{shpere: {radius: 1}}]}}\n", "unknown-key", 1, "sphere"),
    "key of a joint": (
        "links: {a: {}, b: {}}\njoints: {j: {type: fixed, parent: a, child: b, xzy: [0, 0, 0]}}\n",
        "unknown-key",
        2,
        "xyz",
    ),
    "key of an argument": ("links: {b: {}}\nargs: {a: {typ: length, default: 1}}\n", "unknown-key", 2, "type"),
    "key of an include": ("links: {b: {}}\ninclude: [{file: more.yaml, arg: {}}]\n", "unknown-key", 2, "args"),
    "key of an output": ("links: {b: {}}\noutputs2: {}\n", "unknown-key", 2, "outputs"),
    "key of a part": (_part("linsk: {m: {}}"), "unknown-key", 3, "links"),
    "key of a link in a part": (_part("sensors: {s: {type: imu, parent: l, frmae: f}}"), "unknown-key", 3, "frame"),
    "key of a parameter": (_part("params: {a: {type: length, defualt: 1}}"), "unknown-key", 3, "default"),
    "only key of a parameter": (_part("params: {a: {typ: length}}"), "unknown-key", 3, "type"),
    "key of a use": (_use("wiht: {}"), "unknown-key", 3, "with"),
    "key of the content of a use": (_use("content: {linsk: {}}"), "unknown-key", 3, "links"),
    "key of a link in content": (_use("content: {links: {m: {visaul: []}}}"), "unknown-key", 3, "visual"),
    "key of an unused part": (_unused("linsk: {m: {}}"), "unknown-key", 2, "links"),
    "key of a file of a package": ("links: {b: {}}\nuse: {x: {part: wrong/p}}\n", "unknown-part", 2, "wrong"),
    "key for of an entry": ('links: {b: {}, "c${i}": {fro: {i: [1]}}}\n', "unknown-key", 1, '"for"'),
    # kinds of values
    "list for a mapping of parts": ("links: {b: {}}\nparts: [p]\n", "wrong-type", 2, "parts"),
    "list for a mapping of uses": (f"{_PART}links: {{b: {{}}}}\nuse: [p]\n", "wrong-type", 3, "use"),
    "list for parameters": (_part("params: [a]"), "wrong-type", 3, "params"),
    "list for named values": (_part("let: [a]"), "wrong-type", 3, "let"),
    "list for uses in a part": (_part("use: [a]"), "wrong-type", 3, "use"),
    "list for poses in a part": (_part("poses: [a]"), "wrong-type", 3, "poses"),
    "mapping for edges in a part": (_part("edges: {a: 1}"), "wrong-type", 3, "edges"),
    "text for sensors in a part": (_part("let: {t: text}, sensors: '${t}'"), "wrong-type", 3, "sensors"),
    "list for content": (_use("content: [m]"), "wrong-type", 3, "content"),
    "list for links in content": (_use("content: {links: [m]}"), "wrong-type", 3, "links"),
    "list for with": (_use("with: [a]"), "wrong-type", 3, "with"),
    "two numbers for a pose": (_use("xyz: [1, 2]"), "wrong-type", 3, "three numbers"),
    "mass for a position": (_use("xyz: [1 kg, 2, 0]"), "wrong-unit", 3, "1 kg is a mass (kg)"),
    "length for an angle": (_use("rpy: [0, 0, 5 mm]"), "wrong-unit", 3, "5 mm is a length (m)"),
    "list for a prefix": (_use("prefix: [a]"), "wrong-type", 3, "prefix"),
    "axis for a plane": (_use("mirror: xy"), "wrong-value", 3, "x, y, z"),
    "list for arguments of an include": (
        "links: {b: {}}\ninclude: [{file: more.yaml, args: [x]}]\n",
        "wrong-type",
        2,
        "args",
    ),
    "number for a condition": ("links: {b: {}, c: {if: 1}}\n", "wrong-type", 1, "true or false"),
    "number for a loop": ('links: {b: {}, "c${i}": {for: {i: 3}}}\n', "wrong-type", 1, "list"),
    # names
    "type of a parameter": (_part("params: {a: {type: lenght, default: 1}}"), "wrong-value", 3, "length"),
    "argument of a part": (_use("with: {size: 1}"), "unknown-argument", 3, "size"),
    "argument of an include": (
        "links: {b: {}}\ninclude: [{file: more.yaml, args: {x: 1}}]\n",
        "unknown-argument",
        2,
        '"x"',
    ),
    "argument of a sensor": (
        "links: {b: {}}\nsensors: {s: {type: imu, parent: b, frame: f, with: {orientaton: true}}}\n",
        "unknown-argument",
        2,
        "orientation",
    ),
    "part": (f"{_PART}links: {{b: {{}}}}\nuse: {{x: {{part: pp, parent: b}}}}\n", "unknown-part", 3, '"p"'),
    "frame of a use": (
        f"{_PART}links: {{base: {{}}}}\nuse: {{x: {{part: p, parent: bsae}}}}\n",
        "unknown-link",
        3,
        "base",
    ),
    "named value": (_LINK.replace("RADIUS", '"${raduis}"') + "let: {radius: 1}\n", "expression", 1, "radius"),
    "function": (_LINK.replace("RADIUS", '"${sqr(2)}"'), "expression", 1, "sqrt"),
    "unit": (_LINK.replace("RADIUS", "2 mn"), "wrong-type", 1, "mn"),
    "entry of a table": (
        "let: {t: {radius: 1}}\n" + _LINK.replace("RADIUS", '"${t.raduis}"'),
        "expression",
        2,
        "radius",
    ),
    # in what nothing needs
    "unused value": ("links: {b: {}}\nlet: {radius: 1, area: '${raduis**2}'}\n", "expression", 2, "radius"),
    "unused value of a part": (_part("let: {radius: 1, area: '${raduis**2}'}"), "expression", 3, "radius"),
    "unused default of a parameter": (_part("params: {area: {default: '${raduis**2}'}}"), "expression", 3, "raduis"),
    "expression in an unused part": (_unused("links: {l: {visual: ['${1 +}']}}"), "expression", 2, "not an expression"),
    "name in an unused part": (
        _unused("params: {radius: {}}, links: {l: {visual: [{sphere: {radius: '${raduis}'}}]}}"),
        "expression",
        2,
        "radius",
    ),
    "value of an unused part": (_unused("let: {a: '${nope + 1}'}"), "expression", 2, "nope"),
}
