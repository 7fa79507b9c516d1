"""The LoD3 model of a building on the page: its host, what is in the solid and what is not."""

from typing import Any

import numpy as np

from frontage.report.numbers import Fact

_HOSTS = {"model": "the city model", "cloud": "blocks behind the measured facades (no city model)"}


def model_facts(about: dict[str, Any]) -> list[Fact]:
    """Lines of the table, from the building's entry in model/report.json."""
    fine = about["lod"] == "3"
    facts = [
        Fact("Model", f"LoD{about['lod']}", "closed solids; LoD2 is in the files too" if fine else ""),
        Fact("Host", _HOSTS[about["host"]]),
        Fact("Openings", f"{about['openings_built']} of {about['openings_found']}", "cut into the solid"),
        Fact(
            "Installations", str(len(about["installations"])), "balconies and the like, solids of their own"
        ),
    ]
    offsets = np.abs(list(about["offsets"].values()))
    if len(offsets):
        text = f"median {1000 * np.median(offsets):.0f} mm, at most {1000 * offsets.max():.0f} mm"
        facts.append(Fact("Offset", text, "from the measured planes to the host's walls"))
    return facts


def model_remarks(about: dict[str, Any]) -> list[str]:
    """What was left out, then what was changed."""
    return [f"{r['code']} {r['message']}" for r in about["refused"]] + list(about["notes"])
