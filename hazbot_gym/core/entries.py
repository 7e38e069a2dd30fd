"""People who come in as recorded: one record serves one person after another.

A world then needs records for as many people as are there at once, not for all who ever come. Who
they are stands with the place: each has a route, a time of entry and a speed, in order of entry.
"""

from __future__ import annotations

from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import GONE, WAITING, PersonRecord, Place, Records

PATIENCE_S = 5.0  # how long somebody waits for room to come in
REST_S = 1.0  # between two people in a record, so that the tracker takes nobody for somebody else


@scalar
def seat(me: PersonRecord, place: Place, entry: int, start_s: float) -> None:
    """Let a record be the person of an entry, waiting to come in.

    Args:
        me: PERSON record, changed; its reaction is kept.
        place: With the entries.
        entry: Row of the entry and of its route.
        start_s: Moment of the recording at which the episode began [s].
    """
    me.status, me.route, me.s = WAITING, entry, 0.0
    me.enters_s = place.entry_times_s[entry] - start_s
    me.x, me.y = place.routes[entry, 0, 0], place.routes[entry, 0, 1]
    me.desired_speed = place.entry_speeds_mps[entry]


@scalar
def pass_on(people: Records, i: int, place: Place, now_s: float) -> None:
    """Let the record of a person who is gone be the next who comes in, if there is one.

    Who finds no room for too long turns away: a robot that stands in an entrance would otherwise
    keep ever more people waiting there, who would all come in at once.
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
