"""Processes for the tests of output: they are killed, starved and locked out in place of the test run.

``python output_child.py WHAT FOLDER ...`` works in FOLDER and prints JSON. Those that mount something are run in a
mount namespace of their own, so that nothing stays behind.
"""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from rosorin_compile.output import artifact_set, atomic_files

STAGE = ".rosorin-compile-"
NOTES = "notes/mine.txt"


def make_set(letter: str, first: int, count: int) -> dict[str, str]:
    """Return files whose every line says which set they belong to, of 10 byte to 60 kB, two of them in a folder."""
    names = [f"{'urdf/' if number % 5 == 4 else ''}f{number}.txt" for number in range(first, first + count)]
    return {name: f"{letter}{name}\n" * (1 + 5 * at**3) for at, name in enumerate(names)}


A, B = make_set("A", 0, 12), make_set("B", 4, 12)  # f4 to f11 are in both
OLD, NEW = make_set("O", 3, 3), make_set("N", 3, 3)  # the same names


def encoded(files: dict[str, str]) -> dict[str, bytes]:
    return {name: text.encode() for name, text in files.items()}


def files_in(folder: Path) -> dict[str, bytes]:
    """Return what is in a folder by the plainest means; of a link the place that it names."""
    found = {}
    for where, folders, names in os.walk(folder):
        for path in (Path(where, name) for name in (*names, *folders)):
            name = str(path.relative_to(folder))
            if path.is_symlink():
                found[name] = bytes(path.readlink())
            elif not path.is_dir():
                found[name] = path.read_bytes()
    return found


def state(folder: Path, sets: dict[str, dict[str, str]]) -> str:
    """Return the name of the set that the folder holds exactly, "missing", or what is wrong."""
    if not folder.exists():
        return "missing"
    there = files_in(folder)
    there.pop(NOTES, None)
    for name, files in sets.items():
        if there == encoded(files):
            return name
    return "mixed: " + ", ".join(f"{name}={data[:1]!r}*{len(data)}" for name, data in sorted(there.items()))


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def stages(folder: Path) -> list[str]:
    return [name for name in names(folder.parent) if name.startswith(STAGE)]


def attempt(folder: Path, files: dict[str, str], prune: bool = False) -> dict[str, object]:
    """Write a set and return what came of it in a form that can be printed."""
    try:
        return artifact_set.write_set(folder, files, prune)._asdict()
    except atomic_files.OutputError as problem:
        return vars(problem.diagnostic)


def refused(folder: Path, files: dict[str, str], rule: str, prune: bool = False) -> str:
    """Assert that a set is refused by a rule with a way out and that all is as before; return the message."""
    before = files_in(folder.parent)
    found = attempt(folder, files, prune)
    assert found.get("rule") == rule, found
    assert found["severity"] == "error"
    assert found["help"]
    assert STAGE not in str(found["message"])
    assert files_in(folder.parent) == before
    assert not stages(folder)
    return str(found["message"])


def alternate(folder: Path, seconds: float, least: int = 0) -> int:
    """Write two sets by turns for some time, and ``least`` times however slow the machine is; return how often."""
    end, count = time.monotonic() + seconds, 0
    while time.monotonic() < end or count < least:
        artifact_set.write_set(folder, (A, B)[count % 2], prune=True)
        count += 1
    return count


def no_swap(one: Path, other: Path) -> None:
    raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS), str(one), None, str(other))


def die_at(step: int) -> None:
    """Let this process kill itself at the given one of all its calls to the system that leave a trace on disk."""
    count = 0

    def reached() -> None:
        nonlocal count
        count += 1
        if count == step:
            os.kill(os.getpid(), signal.SIGKILL)

    def stepping(function):
        def wrapped(*arguments):
            reached()
            result = function(*arguments)
            reached()
            return result

        return wrapped

    def heard(event: str, _: object) -> None:
        if event.startswith(("os.", "open", "fcntl.")):
            reached()

    os.fsync = stepping(os.fsync)
    atomic_files.exchange = stepping(atomic_files.exchange)
    sys.addaudithook(heard)


def each_step(folder: Path, how: str) -> list[dict[str, object]]:
    """Kill a write of NEW over OLD at its first step, at its second step and so on; return what was found each time."""
    found: list[dict[str, object]] = []
    if how == "one by one":
        atomic_files.exchange = no_swap
    while not found or found[-1]["exit"] != 0:
        shutil.rmtree(folder.parent, ignore_errors=True)
        folder.parent.mkdir()
        if how != "first":
            artifact_set.write_set(folder, OLD)
            (folder / NOTES).parent.mkdir()
            (folder / NOTES).write_text("mine")
        process = os.fork()
        if process == 0:
            die_at(len(found) + 1)
            artifact_set.write_set(folder, NEW)
            os._exit(0)
        code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        seen = {"exit": code, "state": state(folder, {"old": OLD, "new": NEW}), "left": len(stages(folder))}
        artifact_set.write_set(folder, {**NEW, "f3.txt": "next"})
        seen["healed"] = state(folder, {"next": {**NEW, "f3.txt": "next"}}) == "next" and not stages(folder)
        seen["notes"] = (folder / NOTES).exists()
        found.append(seen)
    return found


def mount(*command: object) -> None:
    subprocess.run([str(part) for part in command], check=True, stdout=sys.stderr)


def on_full_disk(base: Path) -> dict[str, object]:
    """Write a set that does not fit, then one that does."""
    mount("mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", base)
    artifact_set.write_set(base / "out", OLD)
    found = {"big": attempt(base / "out", {**OLD, "big.txt": "x" * 400_000})}
    found["state"] = {"set": state(base / "out", {"old": OLD}), "left": stages(base / "out")}
    return {**found, "small": attempt(base / "out", NEW)}


def on_read_only_disk(base: Path) -> dict[str, object]:
    """Write to a disk that is mounted read-only: another set, and the same one."""
    mount("mount", "-t", "tmpfs", "tmpfs", base)
    artifact_set.write_set(base / "out", OLD)
    mount("mount", "-o", "remount,bind,ro", base)
    return {"other": attempt(base / "out", NEW), "same": attempt(base / "out", OLD), "set": files_in_text(base / "out")}


def files_in_text(folder: Path) -> dict[str, str]:
    return {name: data.decode() for name, data in files_in(folder).items()}


def on_mount_points(base: Path) -> dict[str, object]:
    """Write to a folder that is a mount point, and to one that holds a mount point; of another disk and of the same."""
    found: dict[str, object] = {}
    (base / "elsewhere").mkdir()
    (base / "elsewhere" / "precious.txt").write_text("precious")
    for kind, arguments in {"disk": ("-t", "tmpfs", "tmpfs"), "bind": ("--bind", base / "elsewhere")}.items():
        for where in ("out", "out/inside"):
            artifact_set.write_set(base / "out", OLD)
            (base / where).mkdir(exist_ok=True)
            mount("mount", *arguments, base / where)
            found[f"{kind} {where}"] = attempt(base / "out", {**NEW, "sub/more.txt": "more"}, prune=where == "out")
            mount("umount", base / where)
            found[f"{kind} {where} set"] = state(base / "out", {"old": OLD})
    return {**found, "left": stages(base / "out"), "elsewhere": files_in_text(base / "elsewhere")}


def locked_out(folder: Path, *places: str) -> dict[str, object]:
    """Become a user without rights, then write and read."""
    import ctypes  # noqa: F401  (must be there before the rights are gone)

    if os.geteuid() == 0:
        os.setgroups([])
        os.setgid(65534)
        os.setuid(65534)
    found: dict[str, object] = {name: attempt(folder / name, NEW) for name in places}
    for name in places:
        try:
            found[f"read {name}"] = len(artifact_set.read_set(folder / name))
        except atomic_files.OutputError as problem:
            found[f"read {name}"] = problem.diagnostic.rule
    return found


if __name__ == "__main__":
    what = {"alternate": lambda folder, seconds: alternate(folder, float(seconds), least=6)}.get(sys.argv[1])
    print(json.dumps((what or globals()[sys.argv[1]])(Path(sys.argv[2]), *sys.argv[3:])))
