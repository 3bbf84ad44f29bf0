"""``python -m echoplan`` is ``echoplan``."""

from echoplan.cli.main import main

if __name__ == "__main__":
    main()
