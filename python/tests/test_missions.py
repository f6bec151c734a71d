"""Missions under way."""

import pytest

import hierarq

HUMAN = "anna"


@pytest.fixture(scope="module")
def program():
    from conftest import EXAMPLES

    return hierarq.load(EXAMPLES / "letters.hq")


def ends(mission):
    return max(a["end"] for a in mission.activities)


def test_a_mission_runs_as_planned(program):
    mission = program.mission("letter_h")
    planned = ends(mission)
    assert mission.time == 0.0 and mission.done is None and mission.stranded is None
    assert mission.kind == "layers" and "late" in mission.events
    while mission.done is None:
        mission.advance(mission.time + 60.0)
    assert mission.done == pytest.approx(planned, abs=1e-6)
    assert mission.log and mission._repr_svg_().startswith("<svg")
    assert mission.measure("makespan") == pytest.approx(mission.done)


def test_events_change_the_plan(program):
    mission = program.mission("letter_h")
    before = ends(mission)
    mission.advance(30.0)
    reply = mission.tell("late", HUMAN, by=120.0)
    assert reply.startswith("Noted") and ends(mission) > before - 1e-9
    assert any("120" in text or "2:00" in text or "2 min" in text for _, text in mission.log)
    reply = mission.tell("replan")
    assert reply.startswith("Noted")


def test_people_report(program):
    mission = program.mission("letter_h", reporting=[HUMAN])
    page = mission.page(HUMAN)
    while not (buttons := [b for g in mission.page(HUMAN)["groups"] for b in g["buttons"] if b["enabled"]]):
        mission.advance(mission.time + 30.0)
    assert mission.report(HUMAN, buttons[0]["request"])
    assert page["name"]


def test_what_cannot_happen_is_refused(program):
    mission = program.mission("letter_h")
    state = (mission.time, mission.activities, mission.log)
    for wrong, why in [
        (lambda: mission.tell("exploded", HUMAN), "no event"),
        (lambda: mission.tell("late", "nobody", by=1.0), "no member"),
        (lambda: mission.tell("late", HUMAN, bye=1.0), "no key `bye`"),
        (lambda: mission.tell("late", HUMAN, by="soon"), "."),
        (lambda: mission.tell("late", HUMAN, by=float("nan")), "."),
        (lambda: mission.measure("makespam"), "did you mean `makespan`"),
        (lambda: mission.page(HUMAN), "does not report"),
        (lambda: mission.report(HUMAN, {"what": "done"}), "no page"),
        (lambda: mission.advance(-1.0), "cannot go to"),
        (lambda: program.mission("nothing"), "no mission"),
        (lambda: program.mission("letter_h", reporting=["nobody"]), "no member"),
    ]:
        with pytest.raises(ValueError, match=why):
            wrong()
    assert state == (mission.time, mission.activities, mission.log)
