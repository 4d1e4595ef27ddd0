"""``bigant`` and ``python -m bigant``: where the command starts."""

from robot.cli.main import main

if __name__ == "__main__":
    main()
