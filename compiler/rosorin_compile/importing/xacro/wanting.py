"""Wanting: what a xacro asks for and is not there, all of it: packages, arguments, variables of the environment.

In the child process. xacro ends at the first thing that is missing. Then the file is gone through once more, with
something in the place of each, only to hear what else it asks for.
"""

from __future__ import annotations

import os
from contextlib import suppress
from typing import Any

from .tracing import Place, here

PACKAGE, ARGUMENT, VARIABLE = "package", "argument", "variable"

# Stands for a value that is missing; no name that has it is asked for by anybody.
_NOTHING = "\ufffc"


class MissingPackage(Exception):
    """A package that is nowhere."""


class Wanting:
    """Hears what is asked for; ``gathered`` goes through a file to its end."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], Place | None] = {}
        self._going_on = False

    def package(self, name: str) -> str:
        """Return a folder in the place of a package that is missing. Raises MissingPackage."""
        if not self._going_on:
            raise MissingPackage(name)
        return self._stand_in(PACKAGE, name)

    def _stand_in(self, kind: str, name: str) -> str:
        if _NOTHING not in name:
            self._found.setdefault((kind, name), here())
        return _NOTHING

    def watch(self, substitutions: Any) -> None:
        """Hear which arguments and variables ``xacro.substitution_args`` is asked for."""
        argument, variable = substitutions._eval_arg, substitutions._eval_env

        def eval_arg(name: str, args: Any) -> Any:
            if self._going_on and name not in args:
                return self._stand_in(ARGUMENT, name)
            return argument(name, args)

        def eval_env(name: str) -> Any:
            if name not in os.environ and self._going_on:
                return self._stand_in(VARIABLE, name)
            return variable(name)

        substitutions._eval_arg, substitutions._eval_env = eval_arg, eval_env
        substitutions._eval_dict["env"] = eval_env

    def gathered(self, xacro: Any, file: str, arguments: dict[str, str]) -> list[tuple[str, str, Place | None]]:
        """Return the kind, the name and the place of everything that is missing, in the order of the file."""
        self._going_on = True
        kept = list(xacro.filestack or []), list(xacro.macrostack or []), list(xacro.all_includes)
        _forgive(xacro)
        with suppress(Exception, SystemExit, KeyboardInterrupt):
            xacro.init_stacks(file)
            xacro.process_doc(xacro.parse(None, file), mappings=arguments)
        read = [name for name in xacro.all_includes if name not in kept[2]]
        xacro.all_includes[:] = [*kept[2], *(name for name in read if _NOTHING not in str(name))]
        return [(kind, name, place) for (kind, name), place in self._found.items()]


def _forgive(xacro: Any) -> None:
    """Let xacro go on after whatever it cannot do, leaving out the element or the text that it is at."""
    own_text, own_call, own_include = xacro.eval_text, xacro.handle_macro_call, xacro.process_include

    def text(value: str, symbols: Any) -> Any:
        try:
            return own_text(value, symbols)
        except RecursionError:
            raise
        except Exception:
            return _NOTHING

    def call(node: Any, macros: Any, symbols: Any) -> Any:
        try:
            return own_call(node, macros, symbols)
        except RecursionError:
            raise
        except Exception:
            for value in list(node.attributes.values()):
                text(value.value, symbols)
            return _leave_out(node)

    def include(node: Any, macros: Any, symbols: Any, through: Any) -> Any:
        depth = len(xacro.filestack)
        try:
            return own_include(node, macros, symbols, through)
        except RecursionError:
            raise
        except Exception:
            del xacro.filestack[depth:]
            return _leave_out(node)

    xacro.eval_text, xacro.handle_macro_call, xacro.process_include = text, call, include
    xacro.get_boolean_value = _yes(xacro.get_boolean_value)


def _leave_out(node: Any) -> bool:
    if node.parentNode is not None:
        node.parentNode.removeChild(node)
    return True


def _yes(own: Any) -> Any:
    """Return a function that says whether a condition holds; what depends on something missing does not."""

    def boolean(value: Any, condition: Any) -> Any:
        try:
            return own(value, condition)
        except Exception:
            if condition is None:  # a property that is read: another text is no boolean
                raise
            return False

    return boolean
