"""Types of controllers: short words for them, and what is wrong with one that somebody wrote."""

from __future__ import annotations

from collections.abc import Mapping

from rosorin_compile.source.diagnostics import NOTE, WARNING, Suggestion, listed, nearest

from ..parameters.checking import Finding
from ..parameters.tables import DISTRIBUTIONS, plugins
from ..ports import facts

# Short words for types; each means the same in every distribution that has it.
SHORT: Mapping[str, str] = facts("ros2_ports")["controllers"]["short"]


def full(kind: str) -> str:
    """Return the type of a controller that a short word stands for, or the word itself."""
    return SHORT.get(kind, kind)


def of_type(name: str, kind: str, distribution: str) -> Finding | None:
    """Return what is wrong with the type of a controller in a distribution, any of them if it is empty."""
    known, wanted = plugins(distribution), full(kind)
    if wanted in known:
        return None
    said, where = (
        f'the controller "{name}" is of type "{kind}"',
        f" on {distribution.capitalize()}" if distribution else "",
    )
    if wanted in plugins(""):
        others = listed(one.capitalize() for one in DISTRIBUTIONS if wanted in plugins(one))
        message = f"{said}, which {distribution.capitalize()} does not have; {others} has it"
        return Finding("controller-type", message, "type", "take another type, or ask for that distribution")
    words = [*known, *(word for word, of in SHORT.items() if of in known)]
    package = kind.partition("/")[0]
    if "/" not in kind or package in _packages():
        help = Suggestion(kind, words, instead=_listed(known, package))
        return Finding("controller-type", f"{said}, which there is not{where}", "type", help)
    message = f"{said}, of a package that is not known: its parameters are not checked"
    meant = nearest(package, _packages())  # vendors call theirs after those that they know
    if meant and abs(len(meant) - len(package)) < 2 and nearest(kind, words):
        return Finding("controller-type", message, "type", Suggestion(kind, words), WARNING)
    return Finding("controller-type", message, "type", "", NOTE)


def _packages() -> set[str]:
    every = plugins("")
    return {*every.values(), *(plugin.partition("/")[0] for plugin in every)}


def _listed(known: Mapping[str, str], package: str) -> str:
    of = [one for one, its in known.items() if its == package]
    return f"{package} has {listed(of)}" if of else f"short words: {', '.join(SHORT)}; any other is PACKAGE/CLASS"
