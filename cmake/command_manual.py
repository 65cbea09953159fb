#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Makes manual pages, and completions for bash, zsh and fish, from the programs' own --help.

command_manual.py --version V PROGRAMS_FOLDER SHARE_FOLDER NAME...: SHARE_FOLDER gets the folders man/man1,
bash-completion, zsh and fish, as in /usr/share. The programs print help from the option tables that they parse with, so nothing
is repeated here. An unknown line of help is an error.
"""
import argparse
import gzip
import pathlib
import re
import subprocess
import sys
from dataclasses import dataclass, field

OPTION = re.compile(r"(?:(?P<short>-\w),)?(?P<long>--[\w-]+)(?P<value> .*)?")
SECTION = re.compile(r"(Positionals|Options|Subcommands):", re.IGNORECASE)
GROUP = re.compile(r"[A-Z][\w ]*:")  # of options, where lines of options follow


@dataclass
class Entry:
    name: str
    text: str
    group: str = ""  # of options

    @property
    def option(self):
        return OPTION.fullmatch(self.name)

    @property
    def spellings(self):
        return [s for s in (self.option["short"], self.option["long"]) if s]

    @property
    def value(self):
        """The name of the option's value; empty for a flag."""
        value = (self.option["value"] or "").replace(" REQUIRED", "").removesuffix(" ...").strip()
        # `TEXT:{a,b}=a` and `INT:INT in [0 - 9]`; but `A:B` is a name.
        return re.sub(r"(:\{|:[A-Z]{2,}|=).*", "", value)

    @property
    def choices(self):
        listed = re.search(r":\{([^}]*)\}", self.name)
        return listed[1].split(",") if listed else []

    @property
    def default(self):
        given = re.search(r"(?:^|[\w}\]])=(\S+)", self.name)
        return given[1] if given else ""


@dataclass
class Command:
    words: list
    summary: str = ""
    usage: str = ""
    positionals: list = field(default_factory=list)
    options: list = field(default_factory=list)
    commands: list = field(default_factory=list)  # entries
    below: list = field(default_factory=list)  # commands
    notes: str = ""

    @property
    def name(self):
        return "-".join(self.words)


def parse(words, text):
    """Parses the help of one command; the help of a second command inside it adds its options."""
    command = Command(words)
    lines = text.splitlines()
    widths = [(at, re.match(r"  -h,--help +", line).end()) for at, line in enumerate(lines)
              if line.startswith("  -h,--help ")]
    if not widths:
        sys.exit(f"command_manual.py: `{' '.join(words)} --help` has no line for --help")
    section, group = None, ""
    notes, summary = [], []
    at = 0
    while at < len(lines):
        line = lines[at]
        at += 1
        if SECTION.fullmatch(line):
            section, group = line[:-1].lower(), ""
            column = next((width for place, width in widths if place >= at - 1), widths[-1][1])
        elif GROUP.fullmatch(line) and at < len(lines) and lines[at].startswith("  -"):
            section, group = "options", line[:-1]
        elif section and line.startswith("  "):
            below = at < len(lines) and lines[at].startswith(" " * column) and lines[at].strip()
            name, told = (line, lines[at]) if below else (line[:column], line[column:])
            at += 1 if below else 0
            entry = Entry(name.strip(), told.strip(), group)
            if not below and line[column - 1:column].strip():
                sys.exit(f"command_manual.py: cannot read this line of `{' '.join(words)} --help`: {line}")
            if section == "options" and not entry.option:
                sys.exit(f"command_manual.py: `{entry.name}` is not understood as an option")
            known = {"positionals": command.positionals, "options": command.options, "subcommands": command.commands}[section]
            if entry.name not in [other.name for other in known]:
                known.append(entry)
        elif line.startswith("Usage: "):
            command.usage = command.usage or line.removeprefix("Usage: ")
        elif not command.usage:
            summary.append(line)
        else:
            section = None
            notes.append(line)
    command.summary = " ".join(summary).strip()
    command.notes = re.sub(r"\n{3,}", "\n\n", "\n".join(notes)).strip()
    return command


def read(folder, words):
    run = subprocess.run([folder / words[0], *words[1:], "--help"], capture_output=True, text=True, check=True)
    command = parse(words, run.stdout)
    command.below = [read(folder, words + [entry.name]) for entry in command.commands]
    return command


def roff(text):
    escaped = text.replace("\\", "\\e").replace("-", "\\-").replace("…", "...")
    return re.sub(r"^([.'])", r"\\&\1", escaped, flags=re.MULTILINE)


def manual(command, version):
    """Returns the page of one command in the format of man(7)."""
    full = " ".join(command.words)
    out = [f'.TH {command.name.upper()} 1 "" "OpenFab {version}" "OpenFab"', ".SH NAME"]
    out.append(f"{roff(command.name)} \\- {roff(command.summary.split('. ')[0].rstrip('.'))}")
    out += [".SH SYNOPSIS", f".B {roff(full)}", roff(command.usage.removeprefix(full).strip())]
    out += [".SH DESCRIPTION", roff(command.summary)]
    for title, entries in (("ARGUMENTS", command.positionals), ("OPTIONS", command.options)):
        if entries:
            out.append(f".SH {title}")
        group = ""
        for entry in entries:
            if entry.group != group:
                group = entry.group
                out.append(f".SS {roff(group)}")
            name = entry.name.replace(" REQUIRED", "").replace(" ...", "...")
            if entry.option:
                value = f" {entry.value}" if entry.value else ""
                told = entry.text.rstrip(".")
                told += f"; one of {', '.join(entry.choices)}" if entry.choices else ""
                told += f"; default {entry.default}" if entry.default else ""
                bold = ", ".join(entry.spellings)
                out += [".TP", f"\\fB{roff(bold)}\\fR{roff(value)}", roff(told)]
            else:
                out += [".TP", f"\\fB{roff(name.split(' ')[0])}\\fR", roff(entry.text)]
    if command.commands:
        out.append(".SH COMMANDS")
        for entry in command.commands:
            out += [".TP", f"\\fB{roff(entry.name)}\\fR", roff(entry.text)]
    if command.notes:
        out += [".SH NOTES", ".nf", roff(command.notes), ".fi"]
    others = [below.name for below in command.below] + (["-".join(command.words[:-1])] if len(command.words) > 1 else [])
    others += [name for name in ("openfab", "openflc") if name not in others + [command.name]]
    out += [".SH SEE ALSO", ", ".join(f"\\fB{roff(other)}\\fR(1)" for other in others)]
    return "\n".join(out) + "\n"


def quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def bash(program):
    out = [f"# bash completion of {program.name}, made from its --help.", f"_{identifier(program)}() {{",
           "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} command= word words="]
    if program.below:
        out += ['    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do', "        case $word in",
                f"            {'|'.join(c.words[-1] for c in program.below)}) command=$word; break ;;", "        esac", "    done"]
    out.append('    case "$command $prev" in')
    for command in [program] + program.below:
        key = command.words[-1] if command is not program else ""
        for option in command.options:
            if option.choices:
                where = "|".join(quoted(f"{key} {spelling}") for spelling in option.spellings)
                out.append(f'        {where}) mapfile -t COMPREPLY < <(compgen -W {quoted(" ".join(option.choices))} -- "$cur"); return ;;')
    out += ["    esac", "    case $command in"]
    for command in program.below + [program]:
        words = [spelling for option in command.options for spelling in option.spellings]
        key = command.words[-1] if command is not program else "*"
        out.append(f"        {key}) words={quoted(' '.join(words))} ;;")
    out.append("    esac")
    if program.below:
        names = quoted(" ".join(c.words[-1] for c in program.below))
        out.append(f'    if [[ -z $command && $cur != -* ]]; then mapfile -t COMPREPLY < <(compgen -W {names} -- "$cur"); return; fi')
    out += ["    # What is not an option is a file; `complete -o default` knows those.", "    COMPREPLY=()",
            '    if [[ $cur == -* ]]; then mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur"); fi', "}",
            f"complete -o default -F _{identifier(program)} {program.name}"]
    return "\n".join(out) + "\n"


def identifier(program):
    return program.name.replace("-", "_")


def zsh(program):
    def argument(option):
        def safe(text):
            return re.sub(r"([\[\]:\\])", r"\\\1", text)
        value = ""
        if option.value:
            what = f"({' '.join(option.choices)})" if option.choices else "_files"
            value = f":{safe(option.value)}:{what}"
        more = "*" if option.name.endswith("...") else ""
        return [quoted(f"{more}{spelling}[{safe(option.text)}]{value}") for spelling in option.spellings]

    def arguments(command, indent):
        rows = [row for option in command.options for row in argument(option)] + [quoted("*:file:_files")]
        return (" \\\n" + indent + "    ").join(["_arguments"] + rows)

    out = [f"#compdef {program.name}", f"# zsh completion of {program.name}, made from its --help.", ""]
    if not program.below:
        return "\n".join(out + [arguments(program, ""), ""])
    listed = [quoted(f"{c.words[-1]}:{entry.text}") for c, entry in zip(program.below, program.commands)]
    out += ["local -a commands=(", *[f"    {row}" for row in listed], ")", "if ((CURRENT == 2)); then",
            "    _describe command commands", "    return", "fi", "local command=$words[2]",
            "shift words", "((--CURRENT))", "case $command in"]
    for command in program.below:
        out += [f"    {command.words[-1]})", f"        {arguments(command, '        ')}", "        ;;"]
    return "\n".join(out + ["esac", ""])


def fish(program):
    out = [f"# fish completion of {program.name}, made from its --help."]
    names = " ".join(c.words[-1] for c in program.below)
    for entry in program.commands:
        out.append(f"complete -c {program.name} -f -n {quoted(f'not __fish_seen_subcommand_from {names}')} "
                   f"-a {entry.name} -d {quoted(entry.text)}")
    for command in [program] + program.below:
        where = ""
        if command is not program:
            where = f" -n {quoted(f'__fish_seen_subcommand_from {command.words[-1]}')}"
        elif program.below:
            where = f" -n {quoted(f'not __fish_seen_subcommand_from {names}')}"
        for option in command.options:
            row = f"complete -c {program.name}{where} -l {option.option['long'][2:]}"
            if option.option["short"]:
                row += f" -s {option.option['short'][1:]}"
            if option.value:
                row += " -r"
            if option.choices:
                row += f" -f -a {quoted(' '.join(option.choices))}"
            out.append(f"{row} -d {quoted(option.text)}")
    return "\n".join(out) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--version", required=True)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("share", type=pathlib.Path)
    parser.add_argument("names", nargs="+")
    arguments = parser.parse_args()
    share = arguments.share

    def write(path, text):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def write_pages(command):
        page = share / "man/man1" / f"{command.name}.1.gz"
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_bytes(gzip.compress(manual(command, arguments.version).encode(), 9, mtime=0))
        for below in command.below:
            # `openfab texture` is a program of its own, whose page has the same name.
            if below.name not in arguments.names:
                write_pages(below)

    for name in arguments.names:
        program = read(arguments.programs, [name])
        write_pages(program)
        write(share / "bash-completion/completions" / name, bash(program))
        write(share / "zsh/vendor-completions" / f"_{name}", zsh(program))
        write(share / "fish/vendor_completions.d" / f"{name}.fish", fish(program))


if __name__ == "__main__":
    main()
