"""What a person reads about the damage of a log."""

import pytest

from record.log.damage import Damage, damage_words


def test_a_sound_log_has_no_sentence() -> None:
    assert damage_words((), 0) == ""


@pytest.mark.parametrize(
    ("count", "named", "more"), [(1, 1, ""), (4, 4, ""), (5, 3, "2"), (60, 3, "57")]
)
def test_of_many_places_the_first_are_named_and_the_others_counted(
    count: int, named: int, more: str
) -> None:
    damages = [
        Damage(1000 * k, 64, k * 10**9, (k + 1) * 10**9, "a damaged chunk") for k in range(count)
    ]
    words = damage_words(damages, 0)
    assert words.startswith(
        "cut or damaged: a damaged chunk (at byte 0, 64 bytes; from 0.00 s to 1.00 s)"
    )
    assert words.count("a damaged chunk") == named
    assert ("more places" in words) == bool(more)
    if more:
        assert words.endswith(f"; and {more} more places, which bigant log info lists")
