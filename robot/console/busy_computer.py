"""Whether the computer kept up with real time in a run, and what to do where it did not."""

MISSED_LIMIT = 0.02  # of the periods of a run


def busy_words(missed: int, ticks: int, *, virtual: bool) -> str:
    """Return one line for a run in real time that missed many periods; empty where it kept up.

    Args:
        missed: Periods that never ran.
        ticks: Periods that ran.
        virtual: Whether the devices are virtual, so that the run can leave real time.
    """
    periods = ticks + missed
    if missed <= MISSED_LIMIT * periods:
        return ""
    advice = "see what holds it up with: bigant doctor"
    if virtual:
        advice = f"use --virtual-time, or {advice}"
    return (
        f"warning: this computer was too busy for real time: {missed} of {periods} periods "
        f"never ran; {advice}"
    )
