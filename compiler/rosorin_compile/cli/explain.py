"""rosorin-compile explain: print the pose of a frame, and the position in YAML of each of its numbers."""

from __future__ import annotations

from rosorin_compile.source.diagnostics import ERROR, RequestError, UnknownName, has_errors
from rosorin_compile.source.project import Description, NoDescription, all_here

from .answer import PROBLEMS
from .command import Options, command, pose_option, robot_options, words_argument
from .run import Run, find_robot, take_stdin


@command("explain", exits="0 printed, 1 the description has errors")
@words_argument(
    "[ROBOT] NAME ...",
    "the robot, and names of frames, links, joints, sensors, parts, arguments, named values or numbers (z, mass)",
    required=True,
    offers=("robot", "thing"),
)
@pose_option("also print the frames in a named pose")
@robot_options
def run(options: Options) -> int:
    """Explain frames of one robot."""
    from rosorin_compile import api

    run = Run.of(options)
    take_stdin(run.words)
    description, names = _requested(run.words)
    try:
        found = api.explain(run.request(description), names, pose=options.pose)
    except UnknownName as problem:
        raise RequestError(f"{description.name}: {problem}") from None
    if has_errors(found.diagnostics):
        run.console.show([one for one in found.diagnostics if one.severity == ERROR])
        run.console.warn(f"{description.name}: a description with errors has no meaning to explain")
        return PROBLEMS
    return run.give(list(found.answers), lambda: str(found))


def _requested(words: list[str]) -> tuple[Description, list[str]]:
    """Return the robot and the names: of several words the first is the robot if it can be."""
    if len(words) > 1:
        try:
            return Description.find(words[:1])[0], words[1:]
        except NoDescription as problem:
            if not all_here():
                raise RequestError(str(problem)) from None
    return find_robot("", f"rosorin-compile explain ROBOT {' '.join(words)}"), words
