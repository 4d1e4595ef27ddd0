"""``python -m robot`` is ``bigant``."""

from robot.cli.main import main

if __name__ == "__main__":
    main()
