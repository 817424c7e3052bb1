"""Values of flags: what a text means, and what is refused."""

import pytest

from steadyload.cli.readers import duration, half_share, milliseconds, positive, setting, share


@pytest.mark.parametrize(
    ("reads", "text", "value"),
    [
        (duration, "90", 90.0), (duration, "90s", 90.0), (duration, "20m", 1200.0),
        (duration, "1.5h", 5400.0),
        (milliseconds, "5ms", 5.0), (milliseconds, "0.01s", 10.0), (milliseconds, "300us", 0.3),
        (share, "0.95", 0.95), (share, "95%", 0.95), (share, "1", 1.0), (share, ".5", 0.5),
        (half_share, "0", 0.0), (half_share, "0.5", 0.5),
        (positive, "1e-3", 1e-3), (setting, "hidden=100", ("hidden", "100")),
        (setting, "a=b=c", ("a", "b=c")),
    ],
)  # fmt: skip
def test_a_text_is_a_value(reads, text, value):
    assert reads(text) == pytest.approx(value) if isinstance(value, float) else reads(text) == value


@pytest.mark.parametrize(
    ("reads", "text"),
    [
        (duration, "0"), (duration, "5 s"), (duration, "-5"), (duration, "5d"), (duration, ""),
        (milliseconds, "5"), (milliseconds, "0ms"), (milliseconds, "5m"),
        (share, "0"), (share, "1.01"), (share, "101%"), (share, "x"),
        (half_share, "0.51"), (half_share, "-0.1"), (half_share, "nan"),
        (positive, "0"), (positive, "inf"), (positive, "nan"),
        (setting, "hidden"), (setting, "=1"), (setting, "hidden="),
    ],
)  # fmt: skip
def test_what_is_no_value_is_refused_with_what_is_allowed(reads, text):
    with pytest.raises(ValueError, match=r"allowed: |not a number"):
        reads(text)
