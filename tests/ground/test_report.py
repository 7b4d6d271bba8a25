"""Figures and report of a flight whose errors are known by construction."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import numpy as np
import pytest

from halfroll.errors import InputError
from halfroll.results.evaluation import evaluate
from halfroll.results.log import read_log
from halfroll.results.logged_flight import LoggedFlight
from halfroll.results.pictures import save_comparison, save_picture
from halfroll.results.report import report_json, write_report
from halfroll.results.report_pdf import write_pdf
from halfroll.vehicle import load_vehicle

START_S = 3.0
VEHICLE = load_vehicle("mit-vp")


@pytest.fixture
def judged(tmp_path, fly_circle, circle):
    def judge(vehicle=VEHICLE, **flight):
        return evaluate(circle, START_S, read_log(fly_circle(tmp_path / "f.ulg", **flight)), vehicle)

    return judge


def holds(figures):
    return {check.what: check.holds for check in figures.checks}


def test_a_constant_offset_of_3_cm_is_an_rms_of_3_cm(judged):
    figures = judged(offset=(0.01, 0.02, 0.02))
    assert figures.tracking_rms_m == pytest.approx(0.03, abs=1e-9)
    assert figures.tracking_max_m == pytest.approx(0.03, abs=1e-9)
    assert figures.waypoint_miss_max_m == pytest.approx(0.03, abs=1e-9)
    assert len(figures.waypoint_miss_m) == 5


def test_the_approach_and_the_landing_do_not_count(judged):
    assert judged().tracking_max_m == pytest.approx(0.0, abs=1e-9)


def test_a_flight_late_by_10_ms_misses_each_waypoint_by_its_way_in_10_ms(tmp_path, fly_circle, circle):
    log = read_log(fly_circle(tmp_path / "f.ulg"))
    late = evaluate(circle, START_S - 0.01, log, VEHICLE)
    speed = np.linalg.norm(circle.at(np.array([2.0 - 1e-4]))[0, :3] - circle.at(np.array([2.0 + 1e-4]))[0, :3]) / 2e-4
    assert late.waypoint_miss_m[2] == pytest.approx(0.01 * speed, rel=1e-2)


def test_rotor_extremes_are_those_of_the_commands_in_the_planned_part(judged):
    figures = judged(thrust_peak=2.5)
    assert figures.rotor_max_N == pytest.approx([2.5] * 4, abs=1e-5)
    assert figures.rotor_min_N == pytest.approx([0.3] * 4, abs=1e-5)


def test_saturation_is_the_share_of_time_in_which_a_rotor_is_at_a_limit(judged):
    figures = judged(thrust_peak=3.2)  # each of four beyond 3 N for acos(1.6 / 1.8) / pi of the turn
    assert figures.rotor_saturated == pytest.approx(4 * np.arccos(1.6 / 1.8) / np.pi, abs=0.005)
    assert figures.as_json()["rotor_saturated"] == figures.rotor_saturated
    assert judged(thrust_peak=2.5).rotor_saturated == 0.0


def test_a_plan_without_margin_may_be_at_the_limit_for_longer(judged, circle):
    assert "allowed 5 %" in failures(judged(thrust_peak=3.02))
    circle.rotor_max = (3.0,) * 4
    assert failures(judged(thrust_peak=3.02)) == ""


def failures(figures):
    return "; ".join(f"{check.what}, allowed {check.allowed}" for check in figures.checks if not check.holds)


def test_times_are_by_the_vehicles_clock(judged):
    figures = judged(hand_back_s=7.03, disarm_s=9.5)
    assert figures.T_planned_s == 4.0
    assert figures.T_flown_s == pytest.approx(4.03, abs=0.002)
    assert figures.flight_s == pytest.approx(8.5, abs=0.004)


def test_a_good_flight_is_within_limits(judged):
    assert judged().within_limits


@pytest.mark.parametrize(
    ("flight", "broken"),
    [
        ({"offset": (0.0, 0.6, 0.0)}, {"distance from the plan", "distance from waypoints when due"}),
        ({"thrust_peak": 3.2}, {"rotor at its limit"}),
        ({"hand_back_s": 5.0}, {"plan flown to its end"}),
        ({"disarm_s": 99.0}, {"landed and disarmed"}),
    ],
)
def test_what_is_out_of_limits_is_named(judged, flight, broken):
    figures = judged(**flight)
    assert {what for what, good in holds(figures).items() if not good} == broken
    assert not figures.within_limits


def test_a_log_that_ends_before_the_plan_began_is_refused(tmp_path, fly_circle, circle):
    log = read_log(fly_circle(tmp_path / "f.ulg"))
    with pytest.raises(InputError, match=r"the plan began at 50\.00 s, but the log covers 0\.00 to 10\.00 s"):
        evaluate(circle, 50.0, log, VEHICLE)


@pytest.fixture
def flown(tmp_path, fly_circle, circle):
    """A flight whose log says nothing of its plan: that is given."""

    def fly(judged=True, outcome=None, name="f.ulg", **flight):
        log = read_log(fly_circle(tmp_path / name, **flight))
        figures = evaluate(circle, START_S, log, VEHICLE) if judged else None
        command = "halfroll fly 'a<b>.plan' --seed 7"
        plan, start_s = (circle, START_S) if judged else (None, None)
        return LoggedFlight(log, "a<b>.plan", command, plan, start_s, VEHICLE, figures, outcome or {})

    return fly


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.links, self.text = [], [], [], ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.links += [value for name, value in attributes if name in ("src", "href", "xlink:href")]
        if tag not in ("meta", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, text):
        self.text += text


@pytest.fixture
def written(tmp_path):
    def write(flight):
        write_report(tmp_path / "report.html", flight)
        return (tmp_path / "report.html").read_text(encoding="utf-8")

    return write


@pytest.fixture
def page(flown, written):
    return written(flown(offset=(0.0, 0.03, 0.0)))


def test_the_report_is_one_file_that_loads_nothing_else(page):
    parsed = Page(page)
    assert parsed.open == []
    assert all(link.startswith("#") for link in parsed.links)
    assert "script" not in parsed.tags
    assert not re.search(r"url\((?!#)|@import", page)


def test_the_report_shows_the_verdict_the_figures_and_how_to_repeat_them(page):
    text = Page(page).text
    for shown in ("Flown within limits", "30 mm", "4.00 s", "2.50 N", "halfroll fly 'a<b>.plan' --seed 7", "ab" * 32):
        assert shown in text
    assert page.count("<svg") == 5


def test_every_colour_of_a_picture_is_one_of_the_pages_own_so_that_it_suits_dark_and_light(page):
    pictures = "".join(re.findall(r"<svg.*?</svg>", page, re.DOTALL))
    assert set(re.findall(r"(?:fill|stroke): ?([^;\"]+)", pictures)) <= {
        "none", *(f"var(--{name})" for name in ("ink", "faint", "flown", "planned", "alert", "x", "y", "z")),
    }  # fmt: skip
    assert "prefers-color-scheme: dark" in page


def test_the_same_flight_gives_the_same_report(flown, written):
    assert written(flown()) == written(flown())


def test_a_bad_flight_is_reported_as_bad(flown, written):
    assert "Out of limits: distance from the plan: 0.600 m, allowed 0.5 m" in written(flown(offset=(0.0, 0.6, 0.0)))


def test_verdict_and_cause_come_before_all_figures(flown, written):
    outcome = {"error": {"kind": "flight", "message": "the vehicle landed early, at item 4; it said: Fence breached"}}
    page = written(flown(outcome=outcome, disarm_s=8.0))
    assert page.index("Failed: the vehicle landed early, at item 4") < page.index('class="tiles"')
    assert page.index("Failed:") < page.index("<svg")


def test_a_flight_without_a_plan_is_drawn_as_far_as_its_log_goes(flown, written):
    page = written(flown(judged=False))
    assert page.count("<svg") == 5
    assert "Flown without a plan" in page
    assert "NaN" not in page


def test_the_numbers_of_the_report_are_those_for_programs(flown):
    good, bad = (report_json(flown(offset=offset)) for offset in ((0.0, 0.0, 0.0), (0.0, 0.6, 0.0)))
    assert (good["good"], bad["good"]) == (True, False)
    assert bad["flown"]["tracking_max_m"] == pytest.approx(0.6)
    assert bad["failed"] == ["distance from the plan", "distance from waypoints when due"]
    assert good["plan"]["T_s"] == 4.0


def test_the_mode_that_flew_is_named_as_the_autopilot_does(page):
    text = Page(page).text
    assert "offboard" in text
    assert "mission" in text


def test_the_picture_is_a_png(tmp_path, flown):
    save_picture(tmp_path / "f.png", flown())
    assert (tmp_path / "f.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_of_another_kind_is_refused_by_name(tmp_path, flown):
    with pytest.raises(InputError, match=r"f\.bmp: pictures are written as \.png, \.pdf, \.svg"):
        save_picture(tmp_path / "f.bmp", flown())


def test_the_pdf_has_a_page_of_words_and_one_for_each_picture(tmp_path, flown):
    write_pdf(tmp_path / "r.pdf", flown())
    pdf = (tmp_path / "r.pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", pdf)) == 6
    write_pdf(tmp_path / "again.pdf", flown())
    assert (tmp_path / "again.pdf").read_bytes() == pdf


def test_two_flights_are_drawn_together(tmp_path, flown):
    save_comparison(tmp_path / "both.png", [flown(), flown(name="g.ulg", offset=(0.1, 0.0, 0.0))])
    assert (tmp_path / "both.png").read_bytes().startswith(b"\x89PNG")
