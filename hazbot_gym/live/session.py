"""One page's session: a run, perhaps a ghost beside it, and what the person at the page does."""

from __future__ import annotations

from collections.abc import Iterator

from hazbot_gym.envs.plume import PlumeGrid
from hazbot_gym.errors import HazbotError, InvalidInput
from hazbot_gym.evaluation.driver import driver_of
from hazbot_gym.evaluation.rollout import evaluate, resolve
from hazbot_gym.live import messages, recording, view
from hazbot_gym.live.messages import Received, Sent
from hazbot_gym.live.policies import EXPERT, LEARNED, Policies
from hazbot_gym.live.run import Add, Driver, Edit, Hand, Lead, PolicyDriver, Recorded, Remove, Run
from hazbot_gym.live.settings import NO_GHOST, YOU, Settings

TEN = 10  # scenarios in which a person at the page is compared
Point = tuple[float, float]


class Session:
    """State of one page.

    Messages are answered by ``receive``; ``tick`` takes a decision. Nothing here knows of a
    network or a clock.

    Attributes:
        settings: Of the run.
        run: The run.
        ghost: The second policy's run, if any.
        is_playing: Whether decisions follow each other.
        rate: How fast, relative to real time.
    """

    run: Run
    ghost: Run | None
    _expert: view.ExpertView
    _grid: PlumeGrid | None

    def __init__(self, policies: Policies, settings: Settings | None = None) -> None:
        self._policies = policies
        self.settings = settings or Settings()
        self.is_playing, self.rate = False, 1.0
        self._hand = Hand()
        self._held: dict[int, Point] = {}
        self._pending: list[Edit] = []
        self._own_returns: dict[int, float] = {}
        self._others: dict[str, tuple[float | None, ...]] = {}
        self._begin(self.settings)

    # --- decisions --------------------------------------------------------------------------------

    @property
    def is_over(self) -> bool:
        """True once the robot and the ghost have both come to an end."""
        return self.run.is_over and (self.ghost is None or self.ghost.is_over)

    def tick(self) -> list[Sent]:
        """Take one decision, if the run is not over."""
        if self.is_over:
            return []
        was_over = self.run.is_over
        if not was_over:
            self.run.step(self._edits_now())
            self._expert.see(self.run)
        if self.ghost is not None:
            self.ghost.step(self._edits.get(self.ghost.decision, ()))
        found: list[Sent] = [self.frame()]
        if self.run.is_over and not was_over:
            found += self._finish()
        return found

    def _edits_now(self) -> tuple[Edit, ...]:
        """Return and note the changes before this decision: of a recorded run, and of the page."""
        led = [Lead(person=person, x_m=x, y_m=y) for person, (x, y) in self._held.items()]
        made = (*self._edits.get(self.run.decision, ()), *self._pending, *led)
        self._pending.clear()
        if made:
            self._edits[self.run.decision] = made
        return made

    @property
    def _spec(self) -> str:
        """The policy, at its price."""
        return self._policies.at_price(self.settings.policy, self.settings.price)

    def frame(self) -> messages.Frame:
        """Return the present instant."""
        ghost = None if self.ghost is None else view.ghost_of(self.ghost, self.settings.ghost)
        return view.frame_of(self.run, self._expert, ghost, self._grid)

    def scene(self) -> messages.Scene:
        """Return the fixed part of the run."""
        return view.scene_of(self.run, self.settings, self._grid, self._spec)

    # --- messages ---------------------------------------------------------------------------------

    def receive(self, message: Received) -> list[Sent]:
        """Return the answers to a message; what cannot be done is answered by a line."""
        try:
            return list(self._answer(message))
        except HazbotError as error:
            return [messages.Line(text=str(error), is_error=True)]

    def _answer(self, message: Received) -> Iterator[Sent]:  # noqa: C901  (one case a message)
        match message:
            case messages.Configure(settings=settings):
                yield from self._configure(settings)
            case messages.Play(is_playing=is_playing, rate=rate):
                self.is_playing, self.rate = is_playing, rate
            case messages.Step():
                self.is_playing = False
                yield from self.tick()
            case messages.Restart(by=by):
                episode = max(self.settings.episode + by, 0)
                yield from self._start(self.settings.model_copy(update={"episode": episode}))
            case messages.Throttle(share=share):
                self._hand.share = share
            case messages.Hold(person=person, x_m=x, y_m=y):
                self._held[person] = (x, y)
            case messages.LetGo(person=person):
                self._held.pop(person, None)
            case messages.AddPerson(x_m=x, y_m=y):
                if not self.run.newcomer_has_room(x, y):
                    raise InvalidInput("add: there is no room for a person at this point")
                self._pending.append(Add(x_m=x, y_m=y))
            case messages.RemovePerson(person=person):
                self._held.pop(person, None)
                self._pending.append(Remove(person=person))
            case messages.Export(what=what):
                yield self._export(what)
            case messages.Load(text=text):
                yield from self._load(recording.read(text))
            case messages.Compare():
                yield from self._compare()

    def _configure(self, settings: Settings) -> Iterator[Sent]:
        """Swap the policies in mid-run, or start anew where the scenario is another."""
        if not settings.is_same_scenario(self.settings):
            yield from self._start(settings)
            return
        if self._is_other(settings.policy, settings.price, self.settings.policy):
            self.run.driver = self._driver(settings, settings.policy)
            self._is_by_hand = False
        if self._is_other(settings.ghost, settings.price, self.settings.ghost):
            self.ghost = self._follow(settings)
        self.settings = settings
        yield self.scene()
        yield self.frame()

    def _start(self, settings: Settings, driver: Driver | None = None) -> Iterator[Sent]:
        if not settings.is_same_ten(self.settings):
            self._own_returns, self._others = {}, {}
        self._begin(settings, driver)
        yield self.scene()
        yield self.frame()

    def _begin(self, settings: Settings, driver: Driver | None = None) -> None:
        self.run = Run(settings, driver or self._driver(settings, settings.policy))
        self.settings, self._edits = settings, recording.Edits()
        self._held, self._pending = {}, []
        self._is_by_hand = driver is None and settings.policy == YOU
        self._expert, self._grid = view.ExpertView(), view.grid_of(self.run)
        self._expert.see(self.run)
        self.ghost = self._follow(settings)

    def _driver(self, settings: Settings, policy: str) -> Driver:
        if policy == YOU:
            return self._hand
        config, _ = resolve(settings.scenarios())
        return PolicyDriver(driver_of(self._policies.make(policy, settings.price), config, policy))

    def _is_other(self, policy: str, price: float | None, before: str) -> bool:
        """Return True for another policy than before, or for the same at another price."""
        at_price = self._policies.at_price
        return at_price(policy, price) != at_price(before, self.settings.price)

    def _follow(self, settings: Settings) -> Run | None:
        """Return the ghost, which has taken as many decisions as the run, or is over."""
        if settings.ghost == NO_GHOST:
            return None
        ghost = Run(settings, self._driver(settings, settings.ghost))
        while ghost.decision < self.run.decision and not ghost.is_over:
            ghost.step(self._edits.get(ghost.decision, ()))
        return ghost

    # --- files ------------------------------------------------------------------------------------

    def _export(self, what: str) -> messages.Download:
        place = "".join(letter for letter in self.settings.env.lower() if letter.isalnum())
        name = f"{place}-{self.settings.seed}-{self.settings.episode}"
        if what == "scene":
            return messages.Download(name=f"{name}.yaml", text=self.settings.scene(self._spec))
        text = recording.text_of(self.settings, self.run, self._edits)
        return messages.Download(name=f"{name}.run.json", text=text)

    def _load(self, file: recording.RunFile) -> Iterator[Sent]:
        yield from self._start(file.settings, Recorded(file.actions))
        self._edits = dict(file.edits)
        yield messages.Line(text=f"Playing a recorded run of {len(file.actions)} decisions")

    # --- scores -----------------------------------------------------------------------------------

    def _finish(self) -> Iterator[Sent]:
        """Note the return of a person who drove the whole run without any help."""
        if self._is_by_hand and not self.run.is_edited and self.settings.episode < TEN:
            self._own_returns[self.settings.episode] = view.results_of(self.run)["return"]
            yield self._scores()

    def _compare(self) -> Iterator[Sent]:
        settings = self.settings  # the person may choose others meanwhile
        if not self._others:
            others = {policy: _returns(policy, settings) for policy in (EXPERT, LEARNED)}
            if settings.is_same_ten(self.settings):
                self._others = others
        yield self._scores()

    def _scores(self) -> messages.Scores:
        mine = tuple(self._own_returns.get(episode) for episode in range(TEN))
        return messages.Scores(returns={YOU: mine, **self._others})


def _returns(policy: str, settings: Settings) -> tuple[float | None, ...]:
    """Return a policy's return in each of the ten scenarios."""
    scenarios = settings.scenarios()
    rows = evaluate(
        policy, scenarios.env, episodes=TEN, seed=settings.seed, overrides=scenarios.overrides
    )
    return tuple(round(float(row["return"]), 2) for row in rows)
