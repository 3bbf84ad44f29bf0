"""``python -m echoplan`` is ``echoplan``."""

import _signal  # type: ignore[import-not-found]  # what signal is made of, which itself takes 10 ms to import

__all__ = ["main"]


def main() -> None:
    """Run the command line; an interrupt ends the process without a traceback even while modules are imported."""
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    from echoplan.cli.main import main as run  # noqa: PLC0415 - from here on an interrupt is handled

    run()


if __name__ == "__main__":
    main()
