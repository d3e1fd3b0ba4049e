"""The documents' sentences are as short as they should be, and what is too long is found."""

from __future__ import annotations

import pytest

from tools import prose

PAGE = """# Five words that are nothing

Push the knob, then let go. It stays `where it is`, at 0.5 rad
or [near it](there.md).

- One item
- Another item: it has five

| a | table of five words |
|---|---|

    code that is not counted

```python
neither = is_this
```
<!-- begin: printed -->
| many | more |
<!-- end: printed -->
"""


def test_sentences_are_those_of_the_text_alone() -> None:
    assert prose.sentences(PAGE) == [
        "Push the knob, then let go.",
        "It stays Code, at 0.5 rad or near it.",
        "One item",
        "Another item: it has five",
    ]
    # 6 + 9 + 2 + 5 words; with heading and table 5 + 5 more.
    assert prose.measure(PAGE) == (32, 22 / 4, 0.0)


@pytest.mark.parametrize(
    ("measured", "words"),
    [
        (prose.Measure(700, 10.0, 0.0), "700 words; at most 600"),
        (prose.Measure(500, 15.5, 0.0), "15.5 words a sentence"),
        (prose.Measure(500, 10.0, 0.06), "6.0% of the sentences"),
    ],
)
def test_page_that_is_too_long_is_named(measured: prose.Measure, words: str) -> None:
    (complaint,) = prose.complaints({"README.md": measured})
    assert words in complaint
    (complaint,) = prose.complaints({"docs/how-to/a.md": prose.Measure(451, 10.0, 0.0)})
    assert "451 words; at most 450" in complaint
    long = {f"docs/{number}.md": prose.Measure(10_000, 10.0, 0.0) for number in range(5)}
    assert prose.complaints(long) == ["all pages: 50000 words; at most 45000"]


def test_readme_comes_to_its_first_command_within_sixty_words() -> None:
    before, command, _ = (prose.TREE / "README.md").read_text("utf-8").partition("./dev demo")
    assert command
    assert len(before.split()) <= 60


@pytest.mark.parametrize("mark", ["  //", "x = 1  #", '"' * 3, " *"])
def test_comment_that_is_read_twice_is_named(mark: str) -> None:
    assert prose._COMMENT.search(f"{mark} The lag is that of the coil.")
    assert not prose._COMMENT.search(f"{mark} The lag is the coil's.")
    assert not prose._COMMENT.search('CHECK(told == "the lag is that of the coil");')
