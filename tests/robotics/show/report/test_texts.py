"""The texts of reports: found by their keys, filled in, and refused where there are none."""

import pytest
from matplotlib.figure import Figure

from robotics.show.report.texts import ReportTexts

PAGE = ReportTexts("robotics.show.report")


def test_values_stand_in_their_places() -> None:
    picture = PAGE.picture(
        "sine-metrics", Figure, key="metrics", name="sine", runs="3 runs", better="", count=2, who="x"
    )
    assert picture.name == "sine-metrics"
    assert picture.caption.startswith("Metrics on sine: a dot for each of the 3 runs, ")
    assert picture.alt == "Strip charts of 2 metrics on sine for x; the table above has the same numbers."


def test_a_chapter_and_its_tables_have_their_words_from_the_file() -> None:
    thesis = ReportTexts("robotics.plugins.thesis")
    chapter = thesis.chapter("teams", tables=[thesis.grid("teams.table-5-6", [("1", "a", "b")])])
    assert (chapter.title[:6], len(chapter.text), chapter.folded[:6]) == ("Teams:", 2, "Tables")
    assert chapter.tables[0].head == ("rule", "as printed", "as driven here")
    assert thesis.chapter("avoidance").folded == "More tables"


@pytest.mark.parametrize("key", ["no-such", "metrics.no-such"])
def test_an_unknown_key_is_an_error_that_names_it(key: str) -> None:
    with pytest.raises(KeyError, match=f"has no text '{key}'"):
        PAGE.text(key)


def test_a_value_that_is_missing_is_an_error() -> None:
    with pytest.raises(KeyError, match="better"):
        PAGE.text("verdicts.caption")
