"""Stretches in which readings leave a curve's band, in words."""

from __future__ import annotations

from stiffcal.kinds.departures import Departure, departures_in_words


def test_a_stretch_of_one_reading_is_a_place() -> None:
    stretches = [Departure(0.1, 0.2, 0.5), Departure(1.256, 1.2561, -0.9)]
    text = "".join(str(getattr(word, "value", word)) for word in departures_in_words([("axis1", stretches)], "rad/s"))
    assert "axis1 from 0.1 to 0.2 rad/s" in text
    assert "axis1 at 1.256 rad/s" in text
