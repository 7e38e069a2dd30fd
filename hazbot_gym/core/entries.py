"""Entries of recorded people: reuse of one record by consecutive people.

A world then needs only as many records as people present at once. The place holds the entries:
route, time and speed of each person, in order of entry.
"""

from __future__ import annotations

from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import GONE, WAITING, PersonRecord, Place, Records

PATIENCE_S = 5.0  # longest wait for room at the entry
REST_S = 1.0  # gap between two people in a record, so that the tracker separates them


@scalar
def seat(me: PersonRecord, place: Place, entry: int, start_s: float) -> None:
    """Assign a record to the person of an entry, waiting to enter.

    Args:
        me: PERSON record, changed; its reaction is kept.
        place: Place with entries.
        entry: Row of the entry and of its route.
        start_s: Time of the recording at the start of the episode [s].
    """
    me.status, me.route, me.s = WAITING, entry, 0.0
    me.enters_s = place.entry_times_s[entry] - start_s
    me.x, me.y = place.routes[entry, 0, 0], place.routes[entry, 0, 1]
    me.desired_speed = place.entry_speeds_mps[entry]


@scalar
def pass_on(people: Records, i: int, place: Place, now_s: float) -> None:
    """Assign the record of a departed person to the next entry, if any.

    A person without room to enter gives up after some time: otherwise a robot in an entrance would
    accumulate waiting people, who would all enter at once.
    """
    me = people[i]
    if me.status == WAITING and now_s > me.enters_s + PATIENCE_S:
        me.status, me.left_s = GONE, now_s
    if me.status != GONE or now_s < me.left_s + REST_S:
        return
    entry = 0
    for j in range(people.shape[0]):
        entry = max(entry, people[j].route + 1)
    if entry < place.entry_times_s.shape[0]:
        seat(me, place, entry, place.entry_times_s[me.route] - me.enters_s)
