"""Parts of pages that the package itself writes, so that no page can lag behind the code.

A line ``<!-- made: NAME ARGUMENT... -->`` of a page is replaced by what ``MAKERS[NAME]`` returns.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import io
import re
import textwrap
import tokenize
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from typing import Any

import animations
import full_record
import full_summary
import results
import study_report
import table_text
import typer
from sphinx.application import Sphinx

from hazbot_gym.cli import app as commands
from hazbot_gym.config import SCENARIOS, Clock, Config, RewardWeights, make_config
from hazbot_gym.core.gas_sensor import GAS_SENSORS, threshold_of
from hazbot_gym.core.state import REACTION_NAMES
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, full_id
from hazbot_gym.evaluation.metrics import PATCH_M
from hazbot_gym.policies.base import REGISTER
from hazbot_gym.task import reward
from hazbot_gym.task.observation import GAS_FIELDS, markdown_table
from hazbot_gym.utils.files import read_json
from hazbot_gym.utils.json_object import JsonObject

LINE = re.compile(r"<!-- made: (\w+)((?: [\w.:-]+)*) -->")
BOUNDS = {"Ge": ">=", "Gt": ">", "Le": "<=", "Lt": "<"}  # of annotated types


def environment_gallery() -> str:
    """Return a card for each registered id."""
    cards = [
        f"::::{{grid-item-card}} {name}\n:link: {_anchor(name)}\n:link-type: ref\n\n"
        f"{animations.html(name, sentence)}\n\n:::{{card-footer}}\n{sentence}\n:::\n::::\n"
        for name, (sentence, _) in ENVIRONMENTS.items()
    ]
    return ":::::{grid} 1 1 2 2\n:gutter: 3\n\n" + "\n".join(cards) + "\n:::::"


def environment_sections() -> str:
    """Return a section for each registered id: its sentence, and in what it differs."""
    sections = []
    for name, (sentence, preset) in ENVIRONMENTS.items():
        config = hazbot_config(preset)
        rows = [
            ("place", f"`{config.place}`"),
            ("people", f"`{config.people.model}`, {_count(config)}"),
            ("walking pattern of the first person", f"`{config.people.family}`"),
            ("horizon", f"{config.max_episode_steps} decisions of {config.clock.decision_s:g} s"),
        ]
        if config.people.model == "social_force":
            rows.insert(3, ("people who do not yield", _unyielding(config)))
        if config.gas is not None:
            share = f"{config.gas.leak_share:.0%}".replace("%", " %")
            rows.append(("[gas](gas.md)", f"a leak in {share} of episodes"))
        table = "\n".join(f"| {what} | {value} |" for what, value in rows)
        sections.append(
            f"({_anchor(name)})=\n### {name}\n\n{sentence}\n\n| | |\n|---|---|\n{table}\n\n"
            f'```python\nenv = gymnasium.make("{full_id(name)}")\n```\n'
        )
    return "\n".join(sections)


def hazbot_config(preset: Mapping[str, Any]) -> Config:
    """Return the config of a preset."""
    return make_config(preset=preset)


def _count(config: Config) -> str:
    low, high = config.people.count
    return f"{low} to {high}" if low != high else str(low)


def _unyielding(config: Config) -> str:
    shares = config.people.reaction_shares
    return f"{shares[REACTION_NAMES.index('blind')] / sum(shares):.0%}".replace("%", " %")


def _anchor(name: str) -> str:
    return f"env-{name.lower()}"


def environment_text(*titles: str) -> str:
    """Return sections of the docstring of the environment's class, by the words of their titles."""
    text = inspect.cleandoc(CorridorEnv.__doc__ or "")
    text = text.replace("{observation_table}", "").replace("{{", "{").replace("}}", "}")
    parts = dict(re.findall(r"^## (.+?)\n+(.*?)(?=^## |\Z)", text, re.DOTALL | re.MULTILINE))
    return "\n\n".join(parts[title.replace("_", " ")].strip() for title in titles)


def observation_table() -> str:
    """Return the field table of the tiers ``tracks`` and ``privileged``."""
    # Numbers stay with their units: "2 rad/s" is not broken.
    return re.sub(r"(?<=\| )([\d.]+) (\S+)(?= \|)", "\\1\u00a0\\2", markdown_table("tracks"))


def gas_fields() -> str:
    """Return the field table of the gas sensor."""
    lines = [
        f"| `{each.name}` | {each.low:g} to {each.high:g} | {each.unit} | {each.meaning} |"
        for each in GAS_FIELDS
    ]
    return "\n".join(["| observation | range | unit | meaning |", "|---|---|---|---|", *lines])


def gas_sensors() -> str:
    """Return the table of gas sensors, with what follows from their numbers."""
    lines = []
    for name, each in GAS_SENSORS.items():
        threshold = threshold_of(each, Clock().decision_s)
        ppm = each.half_ppm * ((1.0 + threshold) ** (1.0 / each.exponent) - 1.0)
        numbers = (each.rise_s, each.decay_s, each.half_ppm, each.exponent, each.noise)
        cells = [f"`{name}`", *(f"{value:g}" for value in numbers)]
        cells += [f"{each.false_alarms_per_h:g}", f"{threshold:.3f}", f"{ppm:.2g}"]
        lines.append(f"| {' | '.join(cells)} | {PATCH_M / each.rise_s:.2f} |")
    head = (
        "| sensor | $\\tau_\\mathrm{rise}$ [s] | $\\tau_\\mathrm{decay}$ [s] | $c_0$ [ppm] | $b$ | "
        "$\\sigma$ | false alarms per hour | $T$ | alarm from [ppm] | inspects at [m/s] |"
    )
    return "\n".join([head, "|---" + "|---:" * 9 + "|", *lines])


def animation(name: str, *words: str) -> str:
    """Return an animation that is not of an id, described in some words."""
    return animations.html(name, " ".join(words))


def reward_table() -> str:
    """Return the table of the reward's docstring, with the default weights."""
    rows = re.findall(r"^\| (\w+) \| (.+?) \| (.+) \|$", reward.__doc__ or "", re.MULTILINE)
    weights = RewardWeights()._asdict()
    lines = [
        f"| `{name}` | {where} | {weights[name]:g} | {meaning} |"
        for name, where, meaning in rows
        if name in weights
    ]
    assert len(lines) == len(weights)
    return "\n".join(["| term | range | weight | meaning |", "|---|---|---:|---|", *lines])


def scenario_list() -> str:
    """Return the names of the scenarios."""
    return ", ".join(f"`{name}`" for name in SCENARIOS)


def of_study(make: Callable[[JsonObject], str]) -> Callable[[], str]:
    """Return a maker of what the studies of the shipped policy show."""
    return lambda: make(read_json(study_report.STUDY))


def full_answer() -> str:
    """Return the answer of the study of every algorithm to the paper's question."""
    return full_summary.answer(read_json(full_record.FULL), read_json(study_report.STUDY))


def results_figure(name: str, *words: str) -> str:
    """Return a figure drawn from a record, described in some words."""
    return results.html(name, " ".join(words))


def robots_table() -> str:
    """Return what happens to several robots, by their number and policy."""
    record = read_json(results.RECORDS / "robots.json")
    titles = (
        "robots", "policy", "delay [s]", "contacts with robots", "contacts with people", "deadlocks"
    )  # fmt: skip
    rows = [_robots_row(record, run) for run in record["runs"]]
    return table_text.markdown_table(titles, rows, wordy=("policy",))


def browser_rates() -> str:
    """Return how fast the scenes of the front page run in a browser, and their size."""
    record = read_json(results.RECORDS / "browser.json")
    fullest = max(record["scenes"].values(), key=lambda scene: scene["mean_people"])
    chromium, machine = record["versions"]["chromium"].partition(".")[0], record["machine"]
    return (
        f"In headless Chromium {chromium} on one core of a busy machine ({machine['processor']}), "
        f"the doorway, with {fullest['mean_people']:.1f} people present on average, takes "
        f"{fullest['steps_per_s']:,.0f} decisions a second, where real time is 10. The file has "
        f"{record['bytes']['page'] / 1000:.0f} kB."
    )


def _robots_row(record: Any, run: Any) -> tuple[str, ...]:
    percent = 100.0 / (run["robots"] * record["episodes"])
    robots = run["outcomes"].get("contact_robot", 0)
    people = run["contacts_with_people_by_robot"]
    return (
        str(run["robots"]), f"`{run['policy']}`", f"{run['delay_s']:.1f}",
        f"{percent * robots:.1f}", f"{percent * people:.1f}",
        f"{run['episodes_with_deadlock']} of {record['episodes']}",
    )  # fmt: skip


def robots_stuck() -> str:
    """Return what is near the robots of the fuzzy expert that stand at the horizon."""
    record = read_json(results.RECORDS / "robots.json")
    near = Counter[str]()
    for run in record["runs"]:
        if run["policy"] == "fuzzy_expert":
            near.update(run["stuck_near"])
    robots, all_of_them = near["robot"] + near["both"], near.total()
    shares = [100.0 * count / all_of_them for count in (robots, near["person"], near["nothing"])]
    return (
        f"Of the {all_of_them:,} robots with the fuzzy expert that stand at the horizon, "
        f"{shares[0]:.1f} % have another robot within {record['sensitive_m']:g} m, "
        f"{shares[1]:.1f} % a person, and {shares[2]:.1f} % neither."
    )


def policy_table() -> str:
    """Return the policies of the library, with their options."""
    lines = [
        f"| `{name}` | {entry.description.replace('|', ' or ')} |"
        for name, entry in REGISTER.items()
    ]
    return "\n".join(["| policy | what it does; options |", "|---|---|", *lines])


def policy_classes() -> str:
    """Return directives of reStructuredText for the classes of the library's policies."""
    names = dict.fromkeys(entry.factory.replace(":", ".") for entry in REGISTER.values())
    return "\n".join(f".. autoclass:: {name}\n" for name in names)


def fields(*classes: str) -> str:
    """Return tables of the fields of config classes: type, default, and the comment beside each."""
    names = {each.partition(":")[2] for each in classes}
    return "\n\n".join(_fields_of(each, names) for each in classes)


def _fields_of(path: str, names: Collection[str]) -> str:
    """Return the table of a class; ``names`` are the classes that have one."""
    module_name, _, name = path.partition(":")
    kind = getattr(importlib.import_module(module_name), name)
    source = textwrap.dedent(inspect.getsource(kind))
    tree = ast.parse(source).body[0]
    assert isinstance(tree, ast.ClassDef)
    comments = _comments(source)
    rows = []
    for item in tree.body:
        if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
            assert item.end_lineno is not None
            default = ast.unparse(item.value) if item.value else "required"
            near = [comments.pop(n, "") for n in range(item.lineno - 1, item.end_lineno + 1)]
            about = " ".join(filter(None, near))
            rows.append((item.target.id, _plain_type(item.annotation), default, about))
    lines = [
        f"| `{field}` | {_cell(kind_)} | {_default(default, kind_, names)} | {_text(about)} |"
        for field, kind_, default, about in rows
    ]
    head = ["| field | type | default | meaning |", "|---|---|---|---|"]
    if not any(about for *_, about in rows):
        lines = [line.removesuffix("  |") for line in lines]
        head = ["| field | type | default |", "|---|---|---|"]
    summary = (inspect.getdoc(kind) or "").splitlines()[0]
    return "\n".join([f"(config-{name.lower()})=", f"### {name}", "", summary, "", *head, *lines])


def _comments(source: str) -> dict[int, str]:
    """Return the comments of a source by line; one on a line of its own counts for the next."""
    found = {}
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            text = token.string.lstrip("# ").strip()
            if not text.startswith(("noqa", "type:", "fmt:")):
                found[token.start[0]] = text
    return found


def _plain_type(annotation: ast.expr) -> str:
    """Return an annotation without its bounds."""
    if isinstance(annotation, ast.Subscript) and ast.unparse(annotation.value) == "Annotated":
        assert isinstance(annotation.slice, ast.Tuple)
        bounds = [
            f"{BOUNDS[each.func.id]} {ast.unparse(each.args[0])}"
            for each in annotation.slice.elts[1:]
            if isinstance(each, ast.Call)
            and isinstance(each.func, ast.Name)
            and each.func.id in BOUNDS
        ]
        return ", ".join([_plain_type(annotation.slice.elts[0]), *bounds])
    if isinstance(annotation, ast.Subscript) and ast.unparse(annotation.value) == "Literal":
        return ast.unparse(annotation.slice).strip("()").replace(", ", " | ")
    if isinstance(annotation, ast.BinOp):
        return f"{_plain_type(annotation.left)} | {_plain_type(annotation.right)}"
    return ast.unparse(annotation)


def _text(comment: str) -> str:
    """Return a comment for a cell."""
    return comment.replace("|", "\\|")


def _default(code: str, kind_: str, names: Collection[str]) -> str:
    """Return a default for a cell; one that is another section, or may be one, is a link to it."""
    if section := re.fullmatch(r"(\w+)\(\)", code):
        return _link(section[1])
    optional = kind_.removesuffix(" | None")
    return (
        f"`None`, or {_link(optional)}" if optional != kind_ and optional in names else _cell(code)
    )


def _link(section: str) -> str:
    return f"[{section}](#config-{section.lower()})"


def _cell(code: str) -> str:
    """Return code for a cell of a table."""
    code = code if len(code) <= 60 else f"{code[:57]}..."
    return f"`{code.replace('|', chr(92) + '|')}`"


def command_sections() -> str:
    """Return a section for each command of ``hazbot``, from its own help."""
    group = typer.main.get_command(commands)
    assert hasattr(group, "commands")
    return "\n\n".join(
        _command(name, command) for name, command in group.commands.items() if not command.hidden
    )


def _command(name: str, command: Any) -> str:
    context = command.make_context(name, [], resilient_parsing=True)
    arguments = [
        (param.metavar or param.name).upper()
        for param in command.params
        if param.param_type_name == "argument"
    ]
    usage = " ".join(["hazbot", name, *arguments, "[OPTIONS]"])
    rows = []
    for param in command.params:
        if getattr(param, "hidden", False) or param.name == "help":
            continue
        record = param.get_help_record(context)
        if record:
            what, about = (re.sub(r"\s+", " ", part).replace("|", "\\|") for part in record)
            rows.append(f"| `{what}` | {about} |")
    table = ["| option | meaning |", "|---|---|", *rows] if rows else []
    text = inspect.cleandoc(command.help or "").replace("\f", "")
    return "\n".join([f"## hazbot {name}", "", f"`{usage}`", "", text, "", *table])


MAKERS: dict[str, Callable[..., str]] = {
    make.__name__: make
    for make in (
        environment_gallery,
        environment_sections,
        environment_text,
        observation_table,
        gas_fields,
        gas_sensors,
        animation,
        reward_table,
        scenario_list,
        robots_stuck,
        robots_table,
        browser_rates,
        full_answer,
        results_figure,
        policy_table,
        policy_classes,
        fields,
        command_sections,
    )
} | {
    make.__name__: of_study(make)
    for make in (
        study_report.shipped_table,
        study_report.shipped_prices,
        study_report.shipped_gain,
        study_report.shield_table,
        study_report.many_table,
    )
}


def fill(_: Sphinx, __: str, source: list[str]) -> None:
    """Put in what the package writes."""
    source[0] = LINE.sub(lambda found: MAKERS[found[1]](*found[2].split()), source[0])


def shorten(_: Sphinx, __: str, name: str, *rest: Any) -> None:
    """Leave of the environment's docstring, which is Markdown, its first line."""
    lines = rest[-1]
    if name == "hazbot_gym.envs.corridor.CorridorEnv":
        lines[1:] = ["", "The whole of its documentation is the page :doc:`/environments`.", ""]


def skip(_: Sphinx, __: str, ___: str, member: Any, *rest: Any) -> bool | None:
    """Leave out fields of named tuples about which there is nothing to read."""
    is_bare = str(getattr(member, "__doc__", "")).startswith("Alias for field number")
    return True if is_bare else None


def setup(app: Sphinx) -> dict[str, Any]:
    """Fill pages as they are read."""
    app.connect("source-read", fill)
    app.connect("autodoc-process-docstring", shorten)
    app.connect("autodoc-skip-member", skip)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
