"""Prints a reference of the command b2b from its help texts."""

import os
import re
import subprocess
import sys

ENVIRONMENT = {**os.environ, "COLUMNS": "100"}


def help_of(*command):
    arguments = [sys.executable, "-m", "building2building", *command, "--help"]
    return subprocess.run(arguments, env=ENVIRONMENT, check=True, capture_output=True, text=True).stdout


def commands(page):
    """Returns the names of the commands that a page lists."""
    listed = re.findall(r"^  ([a-z]+)  ", page, flags=re.MULTILINE)
    return [name for name in listed if name not in ("b2b", "help")]


def section(command, level):
    page = help_of(*command)
    print(f"{'#' * level} `b2b {' '.join(command)}`\n\n```text\n{page.rstrip()}\n```\n")
    if "\nCommands:\n" in page:
        for name in commands(page.split("\nCommands:\n")[1].split("\n\n")[0]):
            section([*command, name], level + 1)


def main():
    """Prints the front page and every command."""
    front = help_of()
    print(f"# Commands\n\n```text\n{front.rstrip()}\n```\n")
    for name in commands(front):
        section([name], 2)


if __name__ == "__main__":
    main()
