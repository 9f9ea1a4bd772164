"""The tab "Certificate": what it draws is the certificate's own, and it follows edits and assumptions."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fuzzy.files.fisfile import write_fis
from fuzzy.system import Linear
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.plugins.certificates.badge import PLANES, badge, drawn
from robotics.plugins.certificates.loopmodel import LoopModel
from tests.fuzzy.plugins.designer.conftest import browser as browser
from tests.fuzzy.plugins.designer.conftest import server as server
from tests.fuzzy.plugins.designer.served import PATIENCE, Server, Watched
from tests.robotics.world.vehicle.etsro import ETSRO

NARROW = LoopModel(speed_low=0.3, speed_high=0.32, curvature=0.2)
CORRECTING = load_rule_base("correcting")


def test_the_region_drawn_is_that_of_the_certificate() -> None:
    told, found = drawn(CORRECTING, "etsro", NARROW), badge(CORRECTING, ETSRO, NARROW).found
    assert found is not None
    assert told["certified"]
    assert told["half_widths"] == pytest.approx(found.half_widths())
    for pair, outlines, errors in zip(PLANES, told["outlines"], told["errors"], strict=True):
        widths = found.half_widths()[list(pair)]
        np.testing.assert_allclose(np.abs(outlines[0]).max(axis=0), widths, rtol=2e-3)
        # No shadow of a point within is outside the shadow, and the end's lies within the region's
        shadow = np.linalg.inv(np.linalg.inv(found.P)[np.ix_(pair, pair)])
        assert np.einsum("...i,ij,...j->...", np.array(errors), shadow, np.array(errors)).max() <= found.region * 1.001
        np.testing.assert_allclose(
            np.einsum("...i,ij,...j->...", np.array(outlines), shadow, np.array(outlines)),
            np.array([[found.region], [found.ultimate]]) * np.ones(91),
        )
    assert (told["left"], told["starts"]) == (0, 24)


def test_wheels_that_do_more_than_was_measured_certify_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotics.plugins.certificates.badge.wheels_in_region", lambda found, robot: "they slip")
    assert drawn(CORRECTING, "etsro", NARROW) == {"certified": False, "why": "they slip"}


@pytest.mark.long
def test_the_badge_follows_edits_and_assumptions(server: Server, browser: Any) -> None:
    dv, bend = CORRECTING.outputs
    terms = {n: Linear([-s for s in t.slopes], t.constant) for n, t in bend.terms.items()}
    write_fis(CORRECTING, server.folder / "right.fis")
    write_fis(replace(CORRECTING, outputs=[dv, replace(bend, terms=terms)]), server.folder / "wrong.fis")
    write_fis(load_rule_base("tracking"), server.folder / "ahead.fis")
    context = browser.new_context(viewport={"width": 1600, "height": 1100})
    tab = Watched(context, server)

    def said(words: str) -> None:
        page.wait_for_function(
            "(words) => document.querySelector('.fd-certificate')?.innerText.includes(words)",
            arg=words,
            timeout=2 * PATIENCE,
        )

    for name, words in (("wrong", "Not certified"), ("ahead", "not those that drive towards a target ahead")):
        page = tab.open(f"{server.address}&file={name}.fis")
        page.get_by_role("tab", name="Certificate").click()
        said(words)
    page = tab.open(f"{server.address}&file=right.fis")
    page.get_by_role("tab", name="Certificate").click()
    said("A robot that starts in the region")
    assert page.locator(".fd-certificate svg.pn-plot path.ce-error").count() == 2 * 24
    # A term that no longer overlaps its neighbours leaves errors at which no rule fires
    for place, value in (("right shoulder", "0.02"), ("right foot", "0.03")):
        page.get_by_label(f"{place} of level", exact=True).fill(value)
        page.get_by_label(f"{place} of level", exact=True).press("Enter")
    said("Not certified")
    page.get_by_role("button", name="Undo").click()  # the foot is where it was
    said("A robot that starts in the region")
    page.locator(".fd-certificate details.pn-line").evaluate("(sheet) => { sheet.open = true; }")
    page.get_by_label("Least speed [m/s]").fill("0.5")
    page.get_by_label("Least speed [m/s]").press("Enter")
    said("speed_low must be at most speed_high")
    page.locator(".fd-certificate select").select_option("mir100")
    said("Not certified")
    assert tab.wrong == []
    context.close()
