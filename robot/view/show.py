"""``bigant show``: a log as table and pictures, and as a film if one is asked for.

What draws films is loaded only for a film: it takes 40 MB.
"""

import sys

from model.errors import ConfigError
from robot.console.exit_codes import ExitCode
from robot.requests.recorded import ShowRequest


def show(request: ShowRequest) -> ExitCode:
    """Summarise a log, and make the film that is asked for.

    Raises:
        RecordError: The log cannot be read, or a file cannot be written.
        ConfigError: A file is of no kind that we write, or what writes it is not installed.
    """
    from robot.report.show import show_log  # and with it what draws pages

    video = request.video
    if video is None:
        if request.fps is not None or request.speed is not None:
            raise ConfigError("--fps and --speed", "are of a film; add --video FILE")
        return show_log(request)
    from robot.view.film import check_log_film, film_log

    check_log_film(video)
    code = show_log(request)
    print(film_log(request, video), file=sys.stderr if request.json else sys.stdout)
    return code
