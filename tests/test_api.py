"""`import frontage`: what it promises, how fast it is, and that its functions work together."""

import subprocess
import sys
from pathlib import Path

import pytest

import frontage
from frontage.errors import InputError
from frontage.model import Facade


def test_the_promise_is_typed_and_documented() -> None:
    assert set(frontage.__all__) <= set(dir(frontage))
    for name in set(frontage.__all__) - {"__version__"}:
        function = getattr(frontage, name)
        assert function.__doc__ and "return" in function.__annotations__, name
    with pytest.raises(AttributeError, match="no attribute 'find_everything'"):
        frontage.find_everything  # noqa: B018


def test_importing_the_package_loads_no_library() -> None:
    code = (
        "import sys, frontage; print([m for m in ('numpy', 'scipy', 'cv2', 'pydantic') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_step_by_step_from_a_scan_to_a_valid_model(simulated: Path) -> None:
    scan = frontage.read_scans(*sorted((simulated / "scans").glob("S*.e57")), crs="EPSG:25832")
    photos = frontage.read_photos(simulated / "photos", scan, cameras=simulated / "cameras")
    buildings = frontage.find_buildings(scan, simulated / "lod2.city.json").buildings
    assert len(buildings) >= 1
    facade = frontage.find_facades(scan, buildings[0])[0]
    assert isinstance(facade, Facade) and facade.sigma_plane < 0.01
    ortho = frontage.make_ortho(facade, scan, photos, gsd=0.05)
    assert ortho and ortho.gsd == 0.05 and ortho.photos > 0
    found = frontage.find_openings(facade, scan)
    assert found and len(found.openings) > 3
    barred = frontage.find_bars(facade, found, scan, photos)
    windows = [o for o in barred.elements.openings if o.kind == "window"]
    assert any(o.photos for o in windows) and all(o.glazing is not None for o in windows)
    alone = frontage.find_bars(facade, found, scan)
    assert not any(view.views for view in alone.windows)
    model = frontage.build_model(buildings[0], [(facade, barred)])
    assert model and frontage.validate(model.built[0].solid) == ()


def test_a_run_is_asked_by_address_or_id(simulated_run: Path) -> None:
    run = frontage.open_run(simulated_run)
    elements = run.openings(run.facades[0])
    assert elements is not None
    opening = elements.openings[0]
    assert frontage.locate(simulated_run, opening.id).id == frontage.locate(run, opening.id).id == opening.id
    with pytest.raises(InputError, match="at least one scan"):
        frontage.read_scans()
