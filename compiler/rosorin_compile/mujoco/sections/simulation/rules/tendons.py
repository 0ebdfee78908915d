"""Whether tendons go along joints or have a path, and which."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from rosorin_compile.model import Cylinder, Sphere
from rosorin_compile.rules.case import Case, number
from rosorin_compile.rules.simulated import several
from rosorin_compile.source.diagnostics import Diagnostic, listed
from rosorin_compile.source.rule_registry import Heading, rule
from rosorin_compile.source.tree import Path


@rule(
    "tendon-path",
    "A tendon has neither joints nor a path, or both, or its path is none: less than two sites, a stop that is two "
    "things, a shape or a pulley where MuJoCo takes none.",
    "As the message says.",
    Heading.SIMULATED,
)
def tendons(case: Case) -> Iterator[Diagnostic]:
    """Tendons that MuJoCo would not build."""
    section, turning = case.tree.get("tendons") or {}, several(case)
    for tendon in case.robot.tendons:
        path: Path = ("tendons", tendon.name)
        called = f'tendon "{tendon.name}"'
        if bool(tendon.joints) == bool(tendon.path):
            what = "joints and a path" if tendon.joints else "neither joints nor a path"
            help = "leave one of them out" if tendon.joints else "write joints: {NAME: 1}, or path: [{site: NAME}, ...]"
            yield case.problem("tendon-path", f"{called} has {what}", path, help, key=True)
            continue
        for joint in tendon.joints:
            if joint in turning:
                message = f'{called} goes along joint "{joint}", which is {turning[joint]} and has no single position'
                yield case.problem("tendon-path", message, (*path, "joints", joint), "name a joint with one", key=True)
        yield from _springs(case, called, path, section[tendon.name])
        drawn = [word for word in ("width", "rgba", "material") if tendon.joints and word in section[tendon.name]]
        for word in drawn:
            message = f"{called} goes along joints and is not drawn: it has no {word}"
            yield case.problem("tendon-path", message, (*path, word), "leave it out", key=True)
        yield from _path(case, called, path, section[tendon.name].get("path") or ())


def _springs(case: Case, called: str, path: Path, entry: Mapping[str, Any]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the lengths of a tendon."""
    lengths: list[float] = entry.get("spring_length") or []
    if len(lengths) == 2 and lengths[0] > lengths[1]:
        message = f"the spring_length of {called} goes from {number(lengths[0])} to {number(lengths[1])}"
        yield case.problem("tendon-path", message, (*path, "spring_length"), "give the smaller length first")
    if (entry.get("mjcf") or {}).get("limited") is True and "range" not in entry:
        message = f"{called} is limited and has no range"
        yield case.problem("tendon-path", message, (*path, "mjcf", "limited"), "write range: [..., ...]", key=True)
    if (entry.get("mjcf") or {}).get("actuatorfrclimited") is True and "force" not in entry:
        message = f"the force of {called} is limited and has no range"
        place = (*path, "mjcf", "actuatorfrclimited")
        yield case.problem("tendon-path", message, place, "write force: [..., ...]", key=True)
    force: list[float] = entry.get("force") or []
    if len(force) == 2 and not force[0] <= 0 <= force[1]:
        message = f"the force of {called} goes from {number(force[0])} to {number(force[1])}, and MuJoCo wants 0 within"
        yield case.problem("tendon-path", message, (*path, "force"), "let the range include 0")
    wraps = [index for index, stop in enumerate(entry.get("path") or ()) if "shape" in stop]
    if wraps and entry.get("armature"):
        message = f"{called} goes around a shape and has an armature, which MuJoCo does not take together"
        yield case.problem("tendon-path", message, (*path, "armature"), "leave it out", key=True)
    for index in wraps:
        name = entry["path"][index]["shape"]
        if not _is_round(case, name):
            message = f'{called} goes around "{name}", which is no sphere and no cylinder'
            yield case.problem("tendon-path", message, (*path, "path", index, "shape"), "name a shape that is round")


def _is_round(case: Case, name: str) -> bool:
    """Say whether a tendon goes around a shape; one that nobody knows here is known to elements of MJCF."""
    for link in case.robot.links:
        for purpose in ("collision", "visual"):
            solids = [solid for shape in getattr(link, purpose) for solid in shape.solids()]
            for index, solid in enumerate(solids, start=1):
                if name in (solid.name, f"{link.name}_{purpose}_{index}"):
                    return isinstance(solid.geometry, (Sphere, Cylinder))
    return True


def _path(case: Case, called: str, path: Path, stops: Sequence[Mapping[str, object]]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the path of a tendon: each branch runs from a site to a site."""
    kinds: list[str] = []
    for index, stop in enumerate(stops):
        said = [word for word in ("site", "shape", "pulley") if word in stop]
        at = (*path, "path", index)
        if len(said) != 1:
            what = f"is {listed(said)}" if said else "says nothing"
            help = "write one of them: {site: NAME}, {shape: NAME} or {pulley: 2}"
            yield case.problem("tendon-path", f"a stop of {called} {what}", at, help)
            return
        if said == ["pulley"] and not float(str(stop["pulley"])) > 0:
            message = f"a pulley of {called} divides by {stop['pulley']}"
            yield case.problem("tendon-path", message, (*at, "pulley"), "write a number above zero")
        if "side_site" in stop and said != ["shape"]:
            message = f"a stop of {called} has a side_site and no shape"
            yield case.problem("tendon-path", message, (*at, "side_site"), "name the shape that it goes around")
        kinds += said
    branches = " ".join(kinds).split("pulley")
    for branch in branches:
        words = branch.split()
        help = "begin and end at a site, and pass one between two shapes"
        if len(words) < 2 and kinds:
            message = f"{called} has a branch of {len(words)} stops" if len(branches) > 1 else f"{called} has one stop"
            yield case.problem("tendon-path", message, (*path, "path"), "write at least two sites", key=True)
            return
        same = [one for one, other in pairwise(stops) if "site" in one and one.get("site") == other.get("site")]
        if same:
            message = f'{called} passes the site "{same[0]["site"]}" twice in succession'
            yield case.problem("tendon-path", message, (*path, "path"), "leave one of them out", key=True)
            return
        shapes = [n for n, word in enumerate(words) if word == "shape"]
        if any(n in (0, len(words) - 1) or words[n + 1] == "shape" for n in shapes):
            message = f"{called} goes around a shape that has no site before it and behind it"
            yield case.problem("tendon-path", message, (*path, "path"), help, key=True)
            return
