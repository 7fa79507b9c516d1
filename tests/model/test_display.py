"""What nouns show in a terminal and in a notebook."""

import io
from pathlib import Path

import numpy as np
from PIL import Image

import frontage


def test_nouns_describe_themselves_in_one_line(simulated_run: Path) -> None:
    run = frontage.open_run(simulated_run)
    (name,) = run.facades
    ortho, elements = run.ortho(name), run.openings(name)
    assert ortho is not None and elements is not None
    texts = [repr(run), repr(run.plane(name)), repr(ortho), repr(elements), repr(run.store.cloud())]
    assert all("\n" not in text and len(text) < 200 for text in texts)
    assert f"{len(elements.openings)} openings" in texts[0]
    assert name in texts[1] and "mm" in texts[1]
    assert f"{ortho.size[0]} x {ortho.size[1]} px" in texts[2] and "IMG_0001.jpg" in texts[2]
    assert "window" in texts[3]
    assert "points" in texts[4] and "origins" in texts[4]


def test_a_notebook_shows_pictures(simulated_run: Path) -> None:
    run = frontage.open_run(simulated_run)
    ortho = run.ortho(run.facades[0])
    assert ortho is not None
    shown = np.asarray(Image.open(io.BytesIO(ortho._repr_png_())))
    assert shown.shape[2] == 4 and 100 < max(shown.shape) <= 800
    page = run._repr_html_()
    assert page.count("<img") == len(run.facades) and "data:image/png;base64," in page
    assert run.plane(run.facades[0])._repr_svg_().count("<polygon") == 1
