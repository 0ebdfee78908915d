"""Static transforms of launch files in Python, as people write them: read where they are plain, and never guessed."""

from __future__ import annotations

import pytest

from rosorin_compile.ros.package.launch_files import Call, calls

ENDS = "['--frame-id', 'base_link', '--child-frame-id', 'laser']"
READ = ("--x", "0.1", "--frame-id", "base_link", "--child-frame-id", "laser")
NODE = "Node(executable='static_transform_publisher', arguments="


@pytest.mark.parametrize(
    "text",
    [
        f"def tf(x):\n    args = ['--x', x] + {ENDS}\n    return {NODE}args)\ntf('0.1')",
        f"def tf(x):\n    ends = {ENDS}\n    return {NODE}['--x', x] + ends)\ntf(x='0.1')",
        f"x = '7'\ndef tf(x):\n    return {NODE}['--x', x] + {ENDS})\ntf('0.1')",
        f"x: str = '0.1'\n\n\n{NODE}['--x', x] + {ENDS})",
        f"POSES = {{'laser': ['0.1', '0']}}\n\n\n{NODE}['--x', POSES['laser'][0]] + {ENDS})",
        f"\n\n\n{NODE}'--x 0.1 --frame-id base_link --child-frame-id laser'.split())",
        f"\n\n\n{NODE}'--x,0.1,--frame-id,base_link,--child-frame-id,laser'.split(','))",
        f"def tf(text): return {NODE}text.split())\n\n\ntf('--x 0.1 --frame-id base_link --child-frame-id laser')",
    ],
)
def test_plain_values_are_read(text: str) -> None:
    (call,) = calls("a.launch.py", text)
    assert call.arguments == READ
    assert call.line >= 4


DECLARED = "DeclareLaunchArgument('prefix', default_value='base_')"
PREFIXED = f"{NODE}['--x', '0.1', '--frame-id', [prefix, 'link'], '--child-frame-id', ['las', 'er']])"


@pytest.mark.parametrize(
    ("text", "arguments"),
    [
        (f"{DECLARED}\nprefix = LaunchConfiguration('prefix')\n{PREFIXED}", READ),
        (f"def f():\n    prefix = LaunchConfiguration('prefix')\n    return [{DECLARED}, {PREFIXED}]", READ),
        (f"{DECLARED}\n{PREFIXED.replace('[prefix', '[LaunchConfiguration(' + repr('prefix') + ')')}", READ),
        (f"prefix = LaunchConfiguration('prefix')\n{PREFIXED}", None),
        (f"DeclareLaunchArgument('prefix')\nprefix = LaunchConfiguration('prefix')\n{PREFIXED}", None),
        (f"{DECLARED}\n{DECLARED}\nprefix = LaunchConfiguration('prefix')\n{PREFIXED}", None),
        (f"{DECLARED}\nprefix = LaunchConfiguration(name)\n{PREFIXED}", None),
        (f"{DECLARED}\nprefix = LaunchConfiguration(7)\n{PREFIXED}", None),
    ],
)
def test_an_argument_in_pieces_has_the_default_of_the_launch_argument(text: str, arguments: object) -> None:
    assert [call.arguments for call in calls("a.launch.py", text)] == [arguments]


@pytest.mark.parametrize(
    "text",
    [
        f"x = '0'\ndef tf(x):\n    return {NODE}['--x', x] + {ENDS})",
        f"x = '0'\nx = '1'\n{NODE}['--x', x] + {ENDS})",
        f"a = ['--x', '0']\na += {ENDS}\n{NODE}a)",
        f"a = ['--x', '0']\na.extend({ENDS})\n{NODE}a)",
        f"a = ['--x', '0']\na[1] = '1'\n{NODE}a)",
        f"def tf(x):\n    x = offset(x)\n    return {NODE}['--x', x] + {ENDS})\ntf('0.1')",
        f"x = '0'\nfor x in '12':\n    {NODE}['--x', x] + {ENDS})",
        f"{NODE}POSES['laser'])",
        f"P = {{}}\n{NODE}P['laser'])",
        f"{NODE}'a b'.split(' ', 1))",
        f"{NODE}'a b'.split(sep))",
        f"{NODE}'a,b c'.split(sep=','))",
        f"P = {{'laser': ['0'], **more}}\n{NODE}P['laser'])",
    ],
)
def test_what_is_known_only_at_run_time_is_never_guessed(text: str) -> None:
    assert [call.arguments for call in calls("a.launch.py", text)] == [None]


@pytest.mark.parametrize("call", ["*WORDS", "'n', **WORDS", "'n', *WORDS, x='1'"])
def test_a_call_that_unpacks_is_left_unknown(call: str) -> None:
    """Neither the defaults of the helper nor names of the file stand in for what is unpacked."""
    text = f"""\
x = '0.1'
def static_tf(name, x='0', child='laser'):
    return Node(executable='static_transform_publisher', arguments=['--x', x, '--child-frame-id', child])
static_tf({call})
"""
    assert calls("a.launch.py", text) == [Call(4, None)]
