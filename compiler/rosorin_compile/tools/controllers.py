"""check --controllers: a controllers.yaml that people have, held against the tables and against a description.

Which controller a node is, the controller_manager says (``NAME.type``), or the node itself (``type``, which the spawner
reads), or a controller of the description of the same name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ..diagnostics import ERROR, WARNING, Diagnostic, Span, arrange, did_you_mean, error, has_errors
from ..diagnostics.registry import CONTROL, Rule
from ..diagnostics.wording import counted, listed
from .parameter_files import Node, ParameterFile, Value, matches, of_node, read
from .robots import Run
from .understanding import understood
from .usage import FINE, PROBLEMS

if TYPE_CHECKING:
    from ..formats.controllers.checking import Finding
    from ..formats.controllers.tables import Table
    from ..project import Description
    from ..rules.case import Case

RULES = (
    Rule(
        "controllers-file",
        "A file of controllers names none. A warning: parameters stand under a name or a namespace that no controller "
        "of the file has.",
        "`controller_manager: {ros__parameters: {NAME: {type: TYPE}}}`, and the parameters under `NAME`.",
        CONTROL,
    ),
)


class Declared(NamedTuple):
    """A controller of a file: its name, the namespace that it is started in, its type, and where that is said."""

    name: str
    namespace: str
    type: Value

    @property
    def node(self) -> str:
        """The full name of its node."""
        return f"{self.namespace}/{self.name}"


def check_controllers(run: Run, description: Description) -> int:
    """Hold files of controllers against one robot; return the exit code."""
    from ..frontend.load import LoadError

    known = understood(run.given, description, run.console)
    if known is None:
        return PROBLEMS
    try:
        files = [read(Path(name)) for name in run.options.controllers]
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    distribution = _distribution(run.options.distribution, known.case)
    held = _Held(known.case, files, distribution)
    told = arrange([*(one for file in files for one in file.diagnostics), *held.diagnostics()])
    run.console.show(told)
    severities = Counter(one.severity for one in told)
    found = listed(counted(severities[one], one) for one in (ERROR, WARNING, "note") if severities[one])
    names = ", ".join(run.options.controllers)
    what = f"{counted(len(held.declared), 'controller')} in {names}, for {distribution.capitalize()}"
    run.console.say(f"{description.name}: {what}: {found or 'nothing to say'}")
    return PROBLEMS if has_errors(told) else FINE


def _distribution(asked: str | None, case: Case) -> str:
    """Return the distribution that is asked for, else the one of the outputs, if they have one; Jazzy by default."""
    from ..formats.controllers import FORMAT
    from ..formats.distributions import JAZZY

    of_outputs = [str(o.options.get("distribution", JAZZY)) for o in case.robot.outputs if o.backend == FORMAT.name]
    return asked or (of_outputs[0] if len(set(of_outputs)) == 1 else JAZZY)


class _Held:
    """Files held against a robot."""

    def __init__(self, case: Case, files: Sequence[ParameterFile], distribution: str) -> None:
        from ..formats.controllers.tables import MANAGER, manager, of_names, other
        from ..formats.distributions import known

        self.case = case
        self.files = files
        self.distribution = known(distribution)
        self.manager_name = MANAGER
        self.tables = manager(self.distribution), manager(other(self.distribution))
        self.names = of_names(self.distribution), of_names(other(self.distribution))
        self.nodes = [node for file in files for node in file.nodes]
        self.declared = self._declared()

    def _declared(self) -> dict[str, Declared]:
        """Return the controllers of the files by their names."""
        found: dict[str, Declared] = {}
        for node in self.nodes:
            for key, value in node.values.items():
                name, dot, rest = key.partition(".")
                is_manager = node.base == self.manager_name or (node.is_pattern and "/" in str(value.value))
                if is_manager and dot and rest == "type" and isinstance(value.value, str):
                    space = "" if node.is_pattern else node.name.rpartition("/")[0]
                    found[name] = Declared(name, space, value)
        for node in self.nodes:
            own = node.values.get("type")
            if own is not None and isinstance(own.value, str) and node.base != self.manager_name:
                found.setdefault(node.base, Declared(node.base, node.name.rpartition("/")[0], own))
        described = {one.name: one.type for one in self.case.robot.controllers}
        for node in self.nodes:
            if node.base in described and node.base not in found:
                kind = Value(described[node.base], node.span, node.span, node.name)
                found[node.base] = Declared(node.base, node.name.rpartition("/")[0], kind)
        return found

    def diagnostics(self) -> Iterator[Diagnostic]:
        """Yield what is wrong with the files."""
        if not self.declared and self.nodes:
            message = "no controller stands here: nothing says the type of one"
            help = f"{self.manager_name}: {{ros__parameters: {{NAME: {{type: TYPE}}}}}}"
            yield error("controllers-file", message, self.nodes[0].span, help)
            return
        for node in self.nodes:
            if node.base == self.manager_name:
                yield from self._manager(node)
            elif not node.base.startswith("*"):
                yield from self._homeless(node)
        for one in self.declared.values():
            yield from self._controller(one)

    def _manager(self, node: Node) -> Iterator[Diagnostic]:
        """Yield what is wrong with the parameters of the controller_manager."""
        from ..formats.controllers.checking import against_table

        sections = {key.partition(".")[0] for key in self.tables[0].names()}
        own: dict[str, Value] = {}
        of_names: dict[str, dict[str, Value]] = {}
        for key, value in node.values.items():
            name, dot, rest = key.partition(".")
            if dot and name not in sections and (name in self.declared or self._of_a_name(rest)):
                of_names.setdefault(name, {})[rest] = value
            else:
                own[key] = value
        plain = _plain(own)
        for found in against_table(f"the {self.manager_name}", *self.tables, plain, self.distribution):
            yield self._placed(found, own, node)
        for name, values in of_names.items():
            for found in against_table(f'controller "{name}"', *self.names, _plain(values), self.distribution):
                yield self._placed(found, values, node)

    def _of_a_name(self, key: str) -> bool:
        """Say whether a parameter is one that the controller_manager has of each controller, or nearly so."""
        return key in self.names[0] or did_you_mean(key, self.names[0].names()).startswith("did")

    def _homeless(self, node: Node) -> Iterator[Diagnostic]:
        """Yield a warning about parameters that no controller of the files gets, though they seem to be for one."""
        if node.base in self.declared:
            wanted = self.declared[node.base].node
            if not matches(node.name, wanted):
                message = f"these parameters are for {node.name}, and the controller is {wanted}: it does not get them"
                help = "a controller has the namespace of its controller_manager; or write /**/" + node.base
                yield Diagnostic("controllers-file", WARNING, message, node.span, (), help)
            return
        near = did_you_mean(node.base, self.declared)
        if near.startswith("did"):
            message = f'no controller is called "{node.base}": nobody reads these parameters'
            yield Diagnostic("controllers-file", WARNING, message, node.span, (), near)

    def _controller(self, one: Declared) -> Iterator[Diagnostic]:
        """Yield what is wrong with a controller and its parameters."""
        from ..formats.controllers.checking import against_robot, against_table, missing, of_type, tables_of
        from ..formats.controllers.known import known
        from ..formats.controllers.tables import full
        from ..model.control import Controller

        name, robot, said = f'controller "{one.name}"', self.case.robot, str(one.type.value)
        values = self._values(one)
        wrong = of_type(one.name, said, self.distribution)
        if wrong is not None:
            yield self._placed(wrong, {"type": one.type}, None)
        plain = _plain(values)
        kind = full(said)
        table, other = tables_of(kind, self.distribution)
        knows = known(robot, Controller(one.name, kind, plain), kind)
        own = {key: value for key, value in plain.items() if self._is_own(values[key], table, key)}
        for found in against_table(name, table, other, own, self.distribution):
            yield self._placed(found, values, one)
        every = {**plain, **{key: value.value for key, value in values.items()}}
        for found in missing(name, table, every, ""):
            yield self._placed(found, values, one)
        for found in against_robot(name, kind, plain, knows, robot, ERROR):
            yield self._placed(found, values, one)

    def _values(self, one: Declared) -> dict[str, Value]:
        """Return the parameters that reach a controller, those of its name whatever the namespace."""
        elsewhere = [node for node in self.nodes if node.base == one.name and not matches(node.name, one.node)]
        values = {key: value for node in elsewhere for key, value in node.values.items()}
        return values | of_node(self.files, one.node)

    @staticmethod
    def _is_own(value: Value, table: Table | None, key: str) -> bool:
        """Say whether a parameter is meant for the controller: under a pattern stands what other nodes read as well."""
        return "*" not in value.by.rpartition("/")[2] or (table is not None and key in table)

    def _placed(self, found: Finding, values: Mapping[str, Value], where: Declared | Node | None) -> Diagnostic:
        from ..formats.controllers.checking import diagnostic

        value = values.get(found.key)
        span: Span | None = None
        if value is not None:
            span = value.key if found.at_key else value.span
        elif isinstance(where, Declared):
            nodes = [node.span for node in self.nodes if node.base == where.name]
            span = nodes[0] if nodes else where.type.span
        elif where is not None:
            span = where.span
        related = []
        if found.rule == "controller-differs":
            related = [self.case.related("the drive of the robot", ("drive",), key=True)]
        return diagnostic(found, span, related)


def _plain(values: Mapping[str, Value]) -> dict[str, object]:
    """Return the values of parameters, without those that a launch file puts in."""
    return {key: value.value for key, value in values.items() if not value.substituted}
