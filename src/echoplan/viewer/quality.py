"""Whether a map can be trusted, as people read it: on the terminal, at the head of a report and on a drawing."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from types import MappingProxyType

from echoplan.model import Quality, Verdict
from echoplan.viewer.markup import element

__all__ = ["headline", "quality_element", "quality_lines", "warning_of"]

_HEADLINES: Mapping[Verdict, str] = MappingProxyType(
    {
        Verdict.GOOD: "Good map: the echoes fit together.",
        Verdict.DOUBTFUL: "Doubtful map: parts of it may be wrong.",
        Verdict.FAILED: "Failed map: it does not show the room.",
    }
)


def headline(quality: Quality) -> str:
    """Say in one sentence whether a map can be trusted."""
    return _HEADLINES[quality.verdict]


def quality_lines(quality: Quality) -> tuple[str, ...]:
    """Say whether a map can be trusted, why not, and what to do, a line each.

    Parameters
    ----------
    quality : Quality
        Of a map.

    Returns
    -------
    tuple of str
        The verdict first.

    Examples
    --------
    >>> quality_lines(Quality(verdict=Verdict.GOOD))
    ('Good map: the echoes fit together.',)
    """
    step = (f"Next step: {quality.next_step}",) if quality.next_step else ()
    return (headline(quality), *quality.reasons, *step)


def quality_element(quality: Quality) -> ET.Element:
    """Make the paragraphs that say so at the head of a page."""
    first, *rest = quality_lines(quality)
    lines = [element("p", element("strong", text=first)), *(element("p", text=line) for line in rest)]
    return element("div", *lines, class_=f"quality {quality.verdict}", role="note")


def warning_of(quality: Quality | None) -> str:
    """Return the words that a drawing of a map must carry; empty if the map is good or was not assessed."""
    return "" if quality is None or quality.verdict is Verdict.GOOD else headline(quality)
