"""Buildings by their address, as people write it."""

import pytest

from frontage.catalog import find_building
from frontage.errors import InputError

STREET = {
    "B01": ["11 rue Soufflot"],
    "B02": ["13 Rue Soufflot, 75005 Paris"],
    "B03": ["13 bis rue Soufflot"],
    "B04": ["Hauptstraße 7"],
    "B05": ["7a Hauptstr."],
    "B06": ["15-19 avenue de l'Observatoire", "2 rue d'Assas"],
    "B07": [],
    "B08": ["Straße des 17. Juni 135, 10623 Berlin"],
    "B09": ["12 rue du 8 Mai 1945"],
    "B10": ["Hauptstraße 7, 1010 Wien", "Neue Gasse 1"],
}


@pytest.mark.parametrize(
    ("asked", "building"),
    [
        ("13 rue Soufflot", "B02"),
        ("Rue Soufflot 13", "B02"),
        ("rue  SOUFFLOT,13", "B02"),
        ("13, rue Soufflot, Paris", "B02"),
        ("13bis rue soufflot", "B03"),
        ("13 BIS, Rue Soufflot", "B03"),
        ("7 Hauptstrasse", "B04"),
        ("Hauptstr. 7", "B04"),
        ("Hauptstr. 7, Wien", "B10"),
        ("Strasse des 17. Juni 135", "B08"),
        ("135 Straße des 17. Juni Berlin", "B08"),
        ("12 rue du 8 mai 1945", "B09"),
        ("12, rue du 8 mai 1945", "B09"),
        ("Hauptstraße 7 A", "B05"),
        ("17 Av. de l’Observatoire", "B06"),
        ("avenue de l'Observatoire", "B06"),
        ("2 rue d'Assas", "B06"),
        ("B07", "B07"),
        ("b02", "B02"),
    ],
)
def test_an_address_finds_its_building(asked: str, building: str) -> None:
    assert find_building(asked, STREET) == building


@pytest.mark.parametrize(
    "asked", ["16 avenue de l'Observatoire", "9 rue Soufflot", "13 rue de Vaugirard", "3"]
)
def test_a_wrong_number_or_street_names_the_most_similar(asked: str) -> None:
    with pytest.raises(InputError, match="the most similar is") as told:
        find_building(asked, STREET)
    assert str(told.value).count(";") == 1


def test_the_most_similar_address_is_named() -> None:
    with pytest.raises(InputError, match=r'the most similar is "13 Rue Soufflot, 75005 Paris" \(B02\)'):
        find_building("13 rue Soufflott, Paris", STREET)


def test_an_ambiguous_address_names_the_candidates() -> None:
    with pytest.raises(InputError, match=r"matches 3 buildings: B01 \(11 rue Soufflot\), B02 .*B03"):
        find_building("rue Soufflot", STREET)


def test_the_exact_address_wins_over_one_with_more() -> None:
    known = {"B01": ["12 Church Street, Upper Town"], "B02": ["12 Church St"]}
    assert find_building("12 church street", known) == "B02"
    with pytest.raises(InputError, match="matches 2"):
        find_building("12 church street", {"B01": known["B01"], "B02": ["12 Church St, Lower Town"]})


def test_a_run_without_addresses_says_how_to_name_them() -> None:
    with pytest.raises(InputError, match=r"\[addresses\].*B01, B02"):
        find_building("13 rue Soufflot", {"B01": [], "B02": []})
    with pytest.raises(InputError, match="none yet"):
        find_building("13 rue Soufflot", {})
