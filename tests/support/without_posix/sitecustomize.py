"""Takes away what Windows has not, before anything else is imported: put this folder first in PYTHONPATH.

``WITHOUT`` names it: attributes of os (``geteuid``), of signal (``SIGALRM``), modules (``fcntl``); ``windows`` is all
of it, and what Windows refuses besides: a folder is not opened, a file that is open or in the way is not replaced.
"""

import errno
import os
import signal
import sys
from fcntl import F_GETFL, fcntl

USERS = ("geteuid", "getuid", "getegid", "getgid", "chown", "fchown", "lchown", "fchmod")
FLAGS = ("O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC")
CALLS = ("fork", "forkpty", "killpg", "statvfs", "ST_RDONLY", "memfd_create", "pread", "mkfifo", "nice")
CORES = ("sched_getaffinity", "sched_setaffinity")
MODULES = ("fcntl", "resource", "pwd", "grp", "termios", "tty", "syslog")
SIGNALS = ("SIGALRM", "SIGPROF", "SIGKILL", "SIGHUP", "SIGXCPU", "SIGPIPE", "setitimer", "ITIMER_REAL", "ITIMER_PROF")

asked = os.environ.get("WITHOUT", "").split(",")
gone = {*USERS, *FLAGS, *CALLS, *CORES, *MODULES, *SIGNALS} if "windows" in asked else set(asked)
for name in gone:
    if name in MODULES:
        sys.modules[name] = None
    for module in (os, signal):
        if hasattr(module, name):
            delattr(module, name)


def refused(name):
    return PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(name))


def is_open(place):
    """Say whether this process has a file open, or one below a folder."""
    place = os.path.realpath(place)
    for handle in os.listdir("/proc/self/fd"):
        try:
            what = os.readlink(f"/proc/self/fd/{handle}")
        except OSError:
            continue
        if what == place or what.startswith(place + os.sep):
            return True
    return False


def as_windows():
    """Let os refuse what it refuses on Windows."""
    opens, replaces, syncs = os.open, os.replace, os.fsync

    def opened(path, flags, mode=0o777, *, dir_fd=None):
        if dir_fd is not None:
            raise NotImplementedError("dir_fd unavailable on this platform")
        if os.path.isdir(path):
            raise refused(path)
        return opens(path, flags, mode)

    def rename(source, target, **_):
        if os.path.lexists(target):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(source), None, str(target))
        replace(source, target)

    def replace(source, target, **_):
        if is_open(source) or is_open(target):
            raise refused(source)
        replaces(source, target)

    def fsync(handle):
        number = handle if isinstance(handle, int) else handle.fileno()
        if fcntl(number, F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        syncs(number)

    os.open, os.rename, os.replace, os.fsync = opened, rename, replace, fsync


if "windows" in asked:
    as_windows()
