"""Tables of what a run measured: layers for maps, and the schedule of openings."""

from frontage.exports.tables.layers import survey_tables
from frontage.exports.tables.schedule import Schedule, opening_pictures, schedule

__all__ = ["Schedule", "opening_pictures", "schedule", "survey_tables"]
