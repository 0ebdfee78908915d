"""rosorin-compile explain: print the pose of a frame, and the position in YAML of each of its numbers."""

from rosorin_compile import api
from rosorin_compile.source.diagnostics import ERROR, RequestError, UnknownName, has_errors
from rosorin_compile.source.project import Description, NoDescription, all_here

from .command import Options, command, option, robot_options, words_argument
from .console import PROBLEMS
from .run import Run, take_stdin


@command("explain", exits="0 printed, 1 the description has errors")
@words_argument(
    "[ROBOT] NAME ...",
    "the robot, and names of frames, links, joints, sensors, parts, arguments, named values or numbers (z, mass)",
    required=True,
    offers=("robot", "thing"),
)
@option("--pose POSE", default="", help="also print the frames in a named pose", offers="pose")
@robot_options
def run(options: Options) -> int:
    """Explain frames of one robot."""
    run = Run.from_options(options)
    take_stdin(run.words)
    description, names = _requested(run)
    try:
        found = api.explain(run.request(description), names, pose=options.pose)
    except UnknownName as problem:
        raise RequestError(f"{description.name}: {problem}") from None
    if has_errors(found.diagnostics):
        run.console.show([one for one in found.diagnostics if one.severity == ERROR])
        run.console.warn(f"{description.name}: a description with errors has no meaning to explain")
        return PROBLEMS
    return run.give(found.answers, lambda: str(found))


def _requested(run: Run) -> tuple[Description, list[str]]:
    """Return the robot and the names: of several words the first is the robot if it can be."""
    words = run.words
    if len(words) > 1:
        try:
            return Description.find(words[:1])[0], words[1:]
        except NoDescription as problem:
            if not all_here():
                raise RequestError(str(problem)) from None
    return run.find_robot("", f"ROBOT {' '.join(words)}"), words
