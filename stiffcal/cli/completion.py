"""Shell completion: a script of plain lists, printed once, that starts no process while a person types.

Why not typer's own completion: it starts stiffcal at every press of the tab key.
"""

from __future__ import annotations

from collections.abc import Mapping

from stiffcal.cli.option_names import OPTIONS, WITH_EVERY_COMMAND

SHELLS = ("bash", "zsh", "fish")

_BASH = """\
# stiffcal completion for bash: stiffcal --show-completion bash >> ~/.bashrc
_stiffcal_completion() {
    local word=${COMP_WORDS[COMP_CWORD]} words=""
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        words="@COMMANDS@"
    elif [[ $word == -* ]]; then
        case ${COMP_WORDS[1]} in
@CASES@
        esac
    fi
    if [ -n "$words" ]; then
        COMPREPLY=($(compgen -W "$words" -- "$word"))
    fi
}
complete -o default -F _stiffcal_completion stiffcal
"""
_BASH_CASE = '        @NAME@) words="@OPTIONS@" ;;'
_ZSH_HEAD = """\
# stiffcal completion for zsh: stiffcal --show-completion zsh >> ~/.zshrc
autoload -Uz compinit bashcompinit
compinit
bashcompinit
"""


def completion_script(shell: str, commands: Mapping[str, str]) -> str:
    """Return the script that a shell reads at its start.

    Parameters
    ----------
    shell : one of `SHELLS`.
    commands : name of each command to its one line of help.
    """
    options = {name: options_of(name) for name in commands}
    if shell == "fish":
        return _fish(commands, options)
    cases = "\n".join(
        _BASH_CASE.replace("@NAME@", name).replace("@OPTIONS@", " ".join(own)) for name, own in options.items()
    )
    script = _BASH.replace("@COMMANDS@", " ".join([*commands, "--help", "--version"])).replace("@CASES@", cases)
    return script if shell == "bash" else _ZSH_HEAD + script.partition("\n")[2]


def options_of(name: str) -> list[str]:
    """Return the long options of a command."""
    return sorted({*OPTIONS[name].split(), *WITH_EVERY_COMMAND.split()})


def _fish(commands: Mapping[str, str], options: Mapping[str, list[str]]) -> str:
    lines = [
        "# stiffcal completion for fish: stiffcal --show-completion fish > ~/.config/fish/completions/stiffcal.fish"
    ]
    for name, summary in commands.items():
        text = summary.replace("\\", "\\\\").replace("'", "\\'")
        lines.append(f"complete -c stiffcal -n __fish_use_subcommand -a {name} -d '{text}'")
        lines += [
            f"complete -c stiffcal -n '__fish_seen_subcommand_from {name}' -l {word.removeprefix('--')}"
            for word in options[name]
        ]
    return "\n".join(lines) + "\n"
