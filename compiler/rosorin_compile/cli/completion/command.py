"""rosorin-compile completion: print the script that makes a shell complete commands, options, robots and frames.

The scripts know nothing: each hands the words of the line to ``rosorin-compile complete``, which is no command of the
help, and shows what that answers. A candidate that ends in ``=`` or ``/`` goes on, so no space follows it.
"""

from __future__ import annotations

import argparse
import sys

from ..usage import FINE

_BASH = r"""# Completion of rosorin-compile for bash. In ~/.bashrc:  source <(rosorin-compile completion bash)
_rosorin_compile() {
    local candidate
    COMPREPLY=()
    while IFS= read -r candidate; do
        COMPREPLY+=("$candidate")
    done < <("${1/#\~\//$HOME/}" complete --bash "${COMP_LINE:0:COMP_POINT}" "$COMP_WORDBREAKS" 2>/dev/null </dev/null)
    if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *[=/] ]]; then
        compopt -o nospace 2>/dev/null
    fi
    return 0
}
complete -o bashdefault -o default -F _rosorin_compile rosorin-compile
"""

_ZSH = r"""#compdef rosorin-compile
# Completion of rosorin-compile for zsh. In ~/.zshrc, after compinit:  source <(rosorin-compile completion zsh)
# Or as the file _rosorin-compile in a folder of $fpath.
_rosorin_compile() {
    local -a ends ends_shown more more_shown
    local line word shown program=${(Q)words[1]}
    local -a how
    [[ -z $compstate[quote] && $PREFIX == '~'* ]] && how=(-Q)  # a tilde stays one; all else is quoted as it has to be
    while IFS= read -r line; do
        word=${line%%$'\t'*}
        shown=$word
        [[ $line == *$'\t'?* ]] && shown="${(r:26:)word}  -- ${line#*$'\t'}"
        (( $#word > 26 )) && [[ $line == *$'\t'?* ]] && shown="$word  -- ${line#*$'\t'}"
        (( $#how )) && word="~${(q)word#\~}"
        if [[ $word == *[=/] ]]; then
            more+=("$word") more_shown+=("$shown")
        else
            ends+=("$word") ends_shown+=("$shown")
        fi
    done < <("${program/#\~\//$HOME/}" complete -- "${(@Q)words[2,CURRENT-1]}" "${(Q)PREFIX}" 2>/dev/null </dev/null)
    how+=(-V rosorin-compile -l)
    (( $#ends )) && compadd $how -d ends_shown -a ends
    (( $#more )) && compadd $how -S '' -d more_shown -a more
    (( $#ends + $#more )) || { [[ $PREFIX == *'$'* ]] && _files }
}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then
    _rosorin_compile "$@"
else
    compdef _rosorin_compile rosorin-compile
fi
"""

_FISH = r"""# Completion of rosorin-compile for fish. As a file:
#     rosorin-compile completion fish > ~/.config/fish/completions/rosorin-compile.fish
function __rosorin_compile_complete
    set -l words (commandline -opc)
    set -l program (string replace -r '^~/' "$HOME/" -- $words[1])
    set -e words[1]
    set -l typed (commandline -ct)
    set -l current (string unescape -- "$typed" 2>/dev/null; or string replace -r '^["\']' '' -- "$typed")
    command $program complete -- $words "$current" 2>/dev/null </dev/null
end
complete -c rosorin-compile -f -a '(__rosorin_compile_complete)'
"""

SCRIPTS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    command.add_argument("shell", choices=tuple(SCRIPTS), metavar="SHELL", help="bash, zsh or fish")


def run(options: argparse.Namespace) -> int:
    """Print the script of a shell."""
    sys.stdout.write(SCRIPTS[options.shell])
    return FINE
