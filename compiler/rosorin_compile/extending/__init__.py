"""What a package is made of that reads descriptions, writes files or brings a command: the third part of the door.

With ``rosorin_compile`` (the verbs and their records), ``.model`` and ``.diagnostics`` these are all names that stay as
they are; docs/python.md has a line for each. The tools beside the core import nothing else of it. Each name is imported
when it is first asked for, so that importing this module costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..startup.lazily import lazily

if TYPE_CHECKING:
    from ..commands.answer import give_result
    from ..commands.given import Given
    from ..commands.parser import Parser
    from ..commands.registry import service
    from ..commands.robots import is_foreign
    from ..commands.run import Run, for_each
    from ..commands.understanding import mode_states
    from ..commands.usage import FINE, PROBLEMS, WrongUsage
    from ..formats import FORMATS
    from ..formats.format import Importing, InRos, Proving, Writing, by_name
    from ..formats.imported import Comment, Imported, Outputs, ReadOptions
    from ..formats.mesh_files import Places
    from ..formats.mesh_triangles import ExtractProblem, NotThere, TriangleMesh
    from ..formats.static_tf import StaticTransform
    from ..frontend.arguments import Argument
    from ..frontend.expression import ExpressionError, evaluate
    from ..frontend.expression.functions import expression_names
    from ..frontend.language import Language
    from ..frontend.load import LoadError, each_entry, parse_yaml, read_utf8
    from ..frontend.packages import Packages
    from ..frontend.schema import fragment_at
    from ..frontend.tree import Map, Path, Seq, Text
    from ..frontend.yaml_text import Scalar
    from ..meaning.committed import Comparison, TextDifference, compare
    from ..meaning.entities import Change
    from ..meaning.overlay import Overlay
    from ..meaning.proof import Found, Proof, Tolerance
    from ..numbers import exact
    from ..output import OutputError
    from ..output.one_file import write_file
    from ..output.ours import ProtectedFile
    from ..output.placing import Holding, holding
    from ..output.staging import Stage
    from ..output.watch import Inputs
    from ..pipeline import compile_robot, expand_robot
    from ..project import Description, NoDescription, tool_folders
    from ..units import Quantity
    from ..world import world
    from ..xml.markup import Document, Element, MarkupError, Remark

# Each public name and the module that has it.
_HOMES = {
    "Importing": "formats.format",
    "InRos": "formats.format",
    "Proving": "formats.format",
    "Writing": "formats.format",
    "by_name": "formats.format",
    "Argument": "frontend.arguments",
    "Change": "meaning.entities",
    "Comment": "formats.imported",
    "Comparison": "meaning.committed",
    "Description": "project",
    "Document": "xml.markup",
    "Element": "xml.markup",
    "ExpressionError": "frontend.expression",
    "ExtractProblem": "formats.mesh_triangles",
    "FINE": "commands.usage",
    "FORMATS": "formats",
    "Found": "meaning.proof",
    "Given": "commands.given",
    "ProtectedFile": "output.ours",
    "Holding": "output.placing",
    "Imported": "formats.imported",
    "Inputs": "output.watch",
    "Language": "frontend.language",
    "LoadError": "frontend.load",
    "Map": "frontend.tree",
    "MarkupError": "xml.markup",
    "NoDescription": "project",
    "NotThere": "formats.mesh_triangles",
    "OutputError": "output",
    "Outputs": "formats.imported",
    "Overlay": "meaning.overlay",
    "PROBLEMS": "commands.usage",
    "Packages": "frontend.packages",
    "Parser": "commands.parser",
    "Path": "frontend.tree",
    "Places": "formats.mesh_files",
    "Proof": "meaning.proof",
    "Quantity": "units",
    "ReadOptions": "formats.imported",
    "Remark": "xml.markup",
    "Run": "commands.run",
    "Scalar": "frontend.yaml_text",
    "Seq": "frontend.tree",
    "Stage": "output.staging",
    "StaticTransform": "formats.static_tf",
    "Text": "frontend.tree",
    "TextDifference": "meaning.committed",
    "Tolerance": "meaning.proof",
    "TriangleMesh": "formats.mesh_triangles",
    "WrongUsage": "commands.usage",
    "compare": "meaning.committed",
    "compile_robot": "pipeline",
    "each_entry": "frontend.load",
    "evaluate": "frontend.expression",
    "exact": "numbers",
    "expand_robot": "pipeline",
    "expression_names": "frontend.expression.functions",
    "for_each": "commands.run",
    "fragment_at": "frontend.schema",
    "give_result": "commands.answer",
    "holding": "output.placing",
    "is_foreign": "commands.robots",
    "mode_states": "commands.understanding",
    "parse_yaml": "frontend.load",
    "read_utf8": "frontend.load",
    "service": "commands.registry",
    "tool_folders": "project",
    "world": "world",
    "write_file": "output.one_file",
}

__all__ = [
    "FINE",
    "FORMATS",
    "PROBLEMS",
    "Argument",
    "Change",
    "Comment",
    "Comparison",
    "Description",
    "Document",
    "Element",
    "ExpressionError",
    "ExtractProblem",
    "Found",
    "Given",
    "Holding",
    "Imported",
    "Importing",
    "InRos",
    "Inputs",
    "Language",
    "LoadError",
    "Map",
    "MarkupError",
    "NoDescription",
    "NotThere",
    "OutputError",
    "Outputs",
    "Overlay",
    "Packages",
    "Parser",
    "Path",
    "Places",
    "Proof",
    "ProtectedFile",
    "Proving",
    "Quantity",
    "ReadOptions",
    "Remark",
    "Run",
    "Scalar",
    "Seq",
    "Stage",
    "StaticTransform",
    "Text",
    "TextDifference",
    "Tolerance",
    "TriangleMesh",
    "Writing",
    "WrongUsage",
    "by_name",
    "compare",
    "compile_robot",
    "each_entry",
    "evaluate",
    "exact",
    "expand_robot",
    "expression_names",
    "for_each",
    "fragment_at",
    "give_result",
    "holding",
    "is_foreign",
    "mode_states",
    "parse_yaml",
    "read_utf8",
    "service",
    "tool_folders",
    "world",
    "write_file",
]

__getattr__ = lazily(__name__, _HOMES, globals())


def __dir__() -> list[str]:
    return __all__
