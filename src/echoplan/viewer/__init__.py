"""Pictures of maps and of how they came about: figures, drawings to scale, reports."""

from echoplan.viewer.pictures import paper_pictures
from echoplan.viewer.plan import Plan
from echoplan.viewer.sections import Definitions, Picture, Section, Text, flattened
from echoplan.viewer.svg import plan_svg

__all__ = ["Definitions", "Picture", "Plan", "Section", "Text", "flattened", "paper_pictures", "plan_svg"]
