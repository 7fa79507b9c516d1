"""Pages for people: report.html."""

from frontage.report.data import (
    BuildingView,
    FacadeView,
    OrientationView,
    OrthoView,
    PictureView,
    RegistrationView,
    ReportData,
    WindowView,
)
from frontage.report.page import render_report

__all__ = [
    "BuildingView",
    "FacadeView",
    "OrientationView",
    "OrthoView",
    "PictureView",
    "RegistrationView",
    "ReportData",
    "WindowView",
    "render_report",
]
