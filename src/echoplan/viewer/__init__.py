"""Pictures of maps and of how they came about: figures, drawings to scale, reports."""

from echoplan.viewer.changes import changes_in_words
from echoplan.viewer.decisions import decisions_in_words
from echoplan.viewer.floor_plan import floor_plan_pdf, floor_plan_png
from echoplan.viewer.gallery import Exhibit, Gallery, gallery_html
from echoplan.viewer.learning import learned_in_words
from echoplan.viewer.listening import EchoListener
from echoplan.viewer.locating import localisation_lines
from echoplan.viewer.pictures import PAPER_FIGURES, map_picture, paper_pictures
from echoplan.viewer.plan import Plan
from echoplan.viewer.quality import quality_lines
from echoplan.viewer.report import Report, found_in_words, report_html
from echoplan.viewer.sections import Definitions, Picture, Section, Text, flattened
from echoplan.viewer.stages import SweepStages, sweep_stages
from echoplan.viewer.svg import plan_svg
from echoplan.viewer.tables import opening_table

__all__ = [
    "PAPER_FIGURES",
    "Definitions",
    "EchoListener",
    "Exhibit",
    "Gallery",
    "Picture",
    "Plan",
    "Report",
    "Section",
    "SweepStages",
    "Text",
    "changes_in_words",
    "decisions_in_words",
    "flattened",
    "floor_plan_pdf",
    "floor_plan_png",
    "found_in_words",
    "gallery_html",
    "learned_in_words",
    "localisation_lines",
    "map_picture",
    "opening_table",
    "paper_pictures",
    "plan_svg",
    "quality_lines",
    "report_html",
    "sweep_stages",
]
