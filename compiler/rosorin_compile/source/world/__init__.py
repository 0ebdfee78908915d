"""The world: the one door to files, the environment and what is installed, which notes what was asked and answered.

A run is a function of what it was told. Whoever reads asks here, and while ``noting`` is open, each question is taken
down with its answer: a run whose questions would all be answered the same is the same run. So nothing of the program
asks the system itself, but for the modules that write, and this room.

    instead of                                    write
    Path.read_bytes, open(path, "rb").read()      read(path), of a regular file; OSError for all else, a pipe too
    Path.read_text("utf-8")                       text(path); OSError, UnicodeDecodeError
    open(path, "rb").read(80)                     head(path, 80)
    open(path, "rb"), read in pieces              stream(path), in bytes; such a run is not remembered
    read_text of what a child has answered with  own_text(path): a file that the run itself has made needs no note
    exists, is_file, is_dir, os.path.isfile, ...  kind(path): FILE, FOLDER, OTHER (a pipe, a device), ABSENT (false)
    os.path.lexists                               stands(path): if only a link that leads nowhere
    is_symlink, readlink                          link(path): where it leads as it is written; "" for what is no link
    Path.stat().st_size, .st_mode                 size(path), mode(path); OSError
    iterdir, listdir, scandir, os.walk            names(folder): kinds by names, sorted, links followed; OSError
    [n for n in listdir(folder) if n.endswith(".x")]  ending(folder, (".x",)): names, sorted; OSError
    glob, rglob("*.yaml")                         matching(folder, pattern), "**/*.yaml": paths, sorted
    Path.resolve, os.path.realpath                real(path), as far as there is one
    times of a file, to see a next version        version(path): one text; such a run is not remembered; OSError
    Path.samefile                                 is_same(path, other); false where one is absent
    os.environ.get(name, ""), os.getenv           variable(name)
    name in os.environ                            is_set(name)
    os.environ as a value                         environment(): notes each name that is asked; listed, all of them
    Path.cwd, os.getcwd                           here(); OSError where it is gone
    importlib.util.find_spec                      package(name): its folders, or the file of a module; () for none

Paths and folders are texts or Paths, and what comes back is Paths (``matching``, ``real``, ``here``) or texts (names).
Links are followed everywhere but in ``link`` and ``stands``.
A name that no file can have (with a NUL, too long) is absent: ``kind`` and the like say so, ``read`` raises OSError.
Times are told by nobody. What belongs to the tool itself (``data_folder``) needs no note, and is read in the same way.

What a process has worked out of files, and uses again for the next robot, carries its notes along: ``asked_again`` here
instead of ``lru_cache``. What another process asked is noted by ``note_all`` or ``note_read``; what code of others
opens, by ``listening``; what the run itself has written, by ``note_written``. Whatever cannot be noted (a pipe, the
file of somebody else, an answer that has changed meanwhile) goes to ``spoil``: the notes are good for no answer.
"""

from __future__ import annotations

from .. import system
from ..cache import shown
from .asking import (
    answer,
    ending,
    environment,
    head,
    here,
    is_same,
    is_set,
    kind,
    link,
    matching,
    mode,
    names,
    note_contents,
    note_read,
    note_tool,
    note_written,
    now,
    own_text,
    package,
    read,
    real,
    size,
    stands,
    stream,
    text,
    tool_is,
    variable,
    version,
)
from .disk import ABSENT, FILE, FOLDER, OTHER
from .memory import asked_again
from .notes import Notes, note_all, noting, spoil

__all__ = [
    "ABSENT",
    "FILE",
    "FOLDER",
    "OTHER",
    "Notes",
    "World",
    "asked_again",
    "ending",
    "environment",
    "head",
    "here",
    "is_same",
    "is_set",
    "kind",
    "link",
    "matching",
    "mode",
    "names",
    "note_all",
    "note_contents",
    "note_read",
    "note_written",
    "noting",
    "now",
    "own_text",
    "package",
    "read",
    "real",
    "shown",
    "size",
    "spoil",
    "stands",
    "stream",
    "text",
    "tool_is",
    "variable",
    "version",
    "world",
]


class World:
    """Files, the environment and what is installed, as whoever stands beside the core asks for them: see the table.

    Beside them what this system can do: how many ``cores`` there are, whether a process ``can_fork``, ``lock`` and
    ``hard_link`` of files, whose one is (``is_own``), and what a run ``needs`` and goes on without.
    """

    ABSENT, FILE, FOLDER, OTHER = ABSENT, FILE, FOLDER, OTHER
    ending = staticmethod(ending)
    environment = staticmethod(environment)
    head = staticmethod(head)
    here = staticmethod(here)
    is_same = staticmethod(is_same)
    is_set = staticmethod(is_set)
    kind = staticmethod(kind)
    link = staticmethod(link)
    matching = staticmethod(matching)
    mode = staticmethod(mode)
    names = staticmethod(names)
    now = staticmethod(now)
    own_text = staticmethod(own_text)
    package = staticmethod(package)
    read = staticmethod(read)
    real = staticmethod(real)
    shown = staticmethod(shown)
    size = staticmethod(size)
    stands = staticmethod(stands)
    stream = staticmethod(stream)
    text = staticmethod(text)
    variable = staticmethod(variable)
    version = staticmethod(version)
    noting = noting
    note_read = staticmethod(note_read)
    note_tool = staticmethod(note_tool)
    answer = staticmethod(answer)
    spoil = staticmethod(spoil)
    can_fork = system.HAS_FORK
    cores = staticmethod(system.cores)
    hard_link = staticmethod(system.link)
    is_own = staticmethod(system.is_own)
    lock = staticmethod(system.lock)
    needs = staticmethod(system.needs)
    NO_LIMITS = system.NO_LIMITS


world = World()
