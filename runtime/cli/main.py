"""The command's entry: subcommands by name, and every error as an exit status and one line.

Importing this must stay cheap, so that `bladesmith --help` is instant: click and the standard library only.
"""

from __future__ import annotations

import logging
import sys
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NoReturn

import click

from ..codegen.errors import BladeError, BladesmithError, InputError, KindError, suggest
from ..codegen.version import __version__

COMMANDS = {
    "demo": "Do everything once, on bundled inputs, into a web page.",
    "render": "Render a scene file into an image.",
    "mesh": "Write a scene's surfaces as triangle meshes.",
    "view": "Write a scene as an interactive page.",
    "register": "Lay a model of points, lines, planes, .. on another one.",
    "simulate": "Simulate rigid bodies with loads and constraints.",
    "kinematics": "Say what a robot can do, draw it, move it.",
    "export": "Write kernels, algebras or robots as C, C++, Rust, JavaScript or GLSL.",
    "generate": "Write an algebra's sources, or check that they are up to date.",
    "check": "Test a spec's kernels against 50 digits, on every target.",
    "report": "Measure error against run time, with plots.",
    "doctor": "Say what this machine has: compiler, targets, cache, threads.",
    "cache": "List or clear the compiled kernels of this user.",
}

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130  # the last as shells report it


@dataclass
class Options:
    """Options of the command itself, before the subcommand."""

    debug: bool = False


class LazyCommands(click.Group):
    """A group whose subcommands are modules of this package, each with a `command`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(f".{cmd_name}", __package__).command
        command.name = cmd_name
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and args[0] not in COMMANDS:
            raise click.UsageError(f"No such command {args[0]!r}{suggest(args[0], COMMANDS)}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands of the table above: help imports no subcommand."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.command(
    cls=LazyCommands,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Example: bladesmith render scene.toml -o image.png",
)
@click.version_option(__version__, prog_name="bladesmith")
@click.option("--verbose", "-v", is_flag=True, help="Say what is compiled, and how long it takes.")
@click.option("--debug", is_flag=True, help="Show the traceback of any error.")
@click.pass_obj
def group(options: Options, verbose: bool, debug: bool) -> None:
    """Geometric algebra for 3D geometry, compiled."""
    options.debug = debug
    logging.getLogger("bladesmith.compiling").setLevel(logging.ERROR)  # commands say what they do, or are silenced
    if verbose:
        logging.basicConfig(format="%(message)s")
        logging.getLogger("bladesmith").setLevel(logging.INFO)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command and leave the process with its exit status."""
    sys.exit(run(arguments))


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    arguments
        Without the command's own name. Default: those of the process.

    Returns
    -------
    int
        0 done; 1 the work failed; 2 bad arguments or input; 130 interrupted.
    """
    options = Options()
    try:
        result: Any = group.main(
            arguments if arguments is None else list(arguments),
            prog_name="bladesmith",
            standalone_mode=False,
            obj=options,
        )
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except click.ClickException as error:
        error.show()
        return FAILED if type(error) is click.ClickException else BAD_INPUT
    except Exception as error:
        if options.debug:
            traceback.print_exc()
        click.echo(_line(error), err=True)
        return BAD_INPUT if isinstance(error, InputError | KindError | BladeError) else FAILED
    return result if type(result) is int else DONE  # click hands on the status of ctx.exit()


def _line(error: Exception) -> str:
    """One line about an error: ours say what to do, the system's name the file, others are faults of ours."""
    if isinstance(error, BladesmithError):
        text = f"{type(error).__name__}: {error}"
    elif isinstance(error, OSError) and error.strerror:
        text = f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    else:
        text = f"internal error: {type(error).__name__}: {error}. `bladesmith --debug ...` shows where."
    return " ".join(text.split())
