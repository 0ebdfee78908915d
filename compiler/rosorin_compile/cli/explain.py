"""rosorin-compile explain: say where a frame sits, and where each of its numbers was written."""

from __future__ import annotations

from rosorin_compile.source.diagnostics import UnknownName
from rosorin_compile.source.project import Description, NoDescription, all_here

from .answer import give_result
from .command import Options, command
from .options import pose_option, robot_options, words_argument
from .robots import one, take_stdin
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage


@command("explain", exits="0 printed, 1 the description has errors")
@words_argument(
    "[ROBOT] NAME ...",
    "the robot, and names of frames, links, joints, sensors, parts or their values (z, mass)",
    required=True,
    offers=("robot", "thing"),
)
@pose_option("also print the frames in a named pose")
@robot_options
def run(options: Options) -> int:
    """Explain frames of one robot."""
    from rosorin_compile import api
    from rosorin_compile.language.explain.explanation import as_json
    from rosorin_compile.source.diagnostics import ERROR, has_errors

    run = Run.of(options)
    take_stdin(run.words)
    description, names = _requested(run.words)
    try:
        found = api.explain(run.request(description), names, pose=options.pose)
    except UnknownName as problem:
        raise WrongUsage(f"{description.name}: {problem}") from None
    if has_errors(found.diagnostics):
        run.console.show([one for one in found.diagnostics if one.severity == ERROR])
        run.console.warn(f"{description.name}: a description with errors has no meaning to explain")
        return PROBLEMS
    give_result(options, [as_json(answer) for answer in found.answers], lambda: str(found))
    return FINE


def _requested(words: list[str]) -> tuple[Description, list[str]]:
    """Return the robot and the names: of several words the first is the robot if it can be."""
    if len(words) > 1:
        try:
            return Description.find(words[:1])[0], words[1:]
        except NoDescription as problem:
            if not all_here():
                raise WrongUsage(str(problem)) from None
    return one("", f"rosorin-compile explain ROBOT {' '.join(words)}"), words
