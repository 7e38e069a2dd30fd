"""Commands of one policy: ``train``, ``eval``, ``dataset``, ``watch``, ``play``, ``export``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from hazbot_gym.cli.application import app
from hazbot_gym.cli.shared import (
    CORRIDOR,
    AllowCode,
    AllowPickle,
    Changes,
    ConfigFile,
    EnvId,
    PolicySpec,
    ScenarioName,
    WatchedPolicies,
    overrides_of,
)
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils import terminal


@app.command()
def train(
    config: ConfigFile = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results; default results/train/NAME.")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Seed of weights, worlds and exploration.")
    ] = None,
    steps: Annotated[int | None, typer.Option(help="Number of decisions in total.")] = None,
    engine: Annotated[
        str | None, typer.Option(help="batched (default), or pymunk, the reference.")
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Resume from the last checkpoint in the folder.")
    ] = False,
    allow_code: AllowCode = False,
    allow_pickle: AllowPickle = False,
) -> None:
    """Train a policy and export the best one. Resumable."""
    from hazbot_gym.policies import Permissions
    from hazbot_gym.training.config import load_training

    plan = load_training(config, seed=seed, steps=steps, engine=engine)
    folder = out or Path("results", "train", config.stem if config else plan.algorithm)

    from hazbot_gym.training import run as training

    result = training.train(
        plan,
        folder,
        resume=resume,
        console=terminal.progress_console(),
        allowed=Permissions(allow_pickle, allow_code),
    )
    console = terminal.output_console()
    for name, value in result.best.items():
        console.print(f"{name:24} {'-' if value is None else f'{value:10.4g}'}")
    console.print(f"The best policy on validation: {result.policy}", soft_wrap=True)


@app.command(name="eval")
def evaluate(
    policy: PolicySpec,
    env: EnvId = CORRIDOR,
    episodes: Annotated[int, typer.Option(help="Number of episodes.")] = 20,
    seed: Annotated[int, typer.Option(help="Root of all seeds.")] = 0,
    scenario: ScenarioName = None,
    change: Changes = None,
    engine: Annotated[str, typer.Option(help="batched, or pymunk, the reference.")] = "batched",
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
    allow_pickle: AllowPickle = False,
) -> None:
    """Evaluate one policy in one environment."""
    from hazbot_gym.evaluation import metrics, rollout
    from hazbot_gym.study import summary, terminal_tables

    overrides = overrides_of(change, scenario)
    rows = rollout.evaluate(
        policy,
        env,
        episodes=episodes,
        seed=seed,
        overrides=overrides,
        engine=engine,
        allow_pickle=allow_pickle,
    )
    if as_json:
        head = {"policy": policy, "env": env, "episodes": episodes, "seed": seed}
        typer.echo(json.dumps({**head, "metrics": metrics.means(rows)}, allow_nan=False))
    else:
        result = summary.summarise_one(rows, seed=seed)
        terminal.output_console().print(
            terminal_tables.set_table(scenario or env, {policy: result})
        )


@app.command()
def dataset(
    policy: PolicySpec,
    out: Annotated[Path, typer.Option(help="New folder; its name is the data set's id.")],
    env: EnvId = CORRIDOR,
    episodes: Annotated[int, typer.Option(help="Number of episodes.")] = 100,
    seed: Annotated[int, typer.Option(help="Root of all seeds, as in eval.")] = 0,
    scenario: ScenarioName = None,
    change: Changes = None,
    allow_pickle: AllowPickle = False,
) -> None:
    """Write a policy's episodes as a Minari data set for offline learning."""
    from hazbot_gym.evaluation import minari_dataset

    with terminal.progress_bar(terminal.progress_console()) as progress:
        task = progress.add_task("episodes", total=episodes)
        written = minari_dataset.write_dataset(
            policy,
            env,
            out,
            episodes=episodes,
            seed=seed,
            overrides=overrides_of(change, scenario),
            allow_pickle=allow_pickle,
            on_progress=lambda: progress.advance(task),
        )
    console = terminal.output_console()
    console.print(f"{written.episodes} episodes, {written.decisions} decisions")
    console.print(f"mean return {written.mean_return:.1f}")
    console.print(f"Saved: {out}", soft_wrap=True)


@app.command()
def watch(
    policy: WatchedPolicies,
    env: EnvId = CORRIDOR,
    episodes: Annotated[int, typer.Option(help="Number of episodes.")] = 1,
    seed: Annotated[int, typer.Option(help="Root of all seeds, as in eval.")] = 0,
    scenario: ScenarioName = None,
    change: Changes = None,
    speed: Annotated[float, typer.Option(help="Playback speed relative to real time.")] = 1.0,
    file: Annotated[
        Path | None, typer.Option("--save", help="Video or picture: FILE.mp4, .gif or .png.")
    ] = None,
    at: Annotated[
        float | None, typer.Option(help="Episode time of a .png in seconds; default the end.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace FILE if it exists.")] = False,
    allow_pickle: AllowPickle = False,
) -> None:
    """Watch policies in a window, or save them. The window shows its keys."""
    from hazbot_gym.viewer import watch as viewer

    overrides = overrides_of(change, scenario)
    show = viewer.Show(
        policy[0], env, episodes, seed, overrides, speed, allow_pickle, tuple(policy[1:])
    )
    if file is None:
        if at is not None:
            raise InvalidInput(f"at: given {at}, but nothing is saved; give --save FILE.png")
        rows = viewer.watch_live(show)
    else:
        rows = viewer.save(show, file, at_s=at, is_replacing=force)
    terminal.output_console().print(viewer.table(rows))
    if file is not None:
        terminal.output_console().print(f"Saved: {file}", soft_wrap=True)


@app.command()
def play(
    policy: Annotated[
        str | None, typer.Option(help="Who drives first; you take over with an arrow key.")
    ] = None,
    env: Annotated[str | None, typer.Option(help="Environment id.")] = None,
    link: Annotated[
        str | None, typer.Option(help="A link copied from the page, or its part behind the ?.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port on this machine; 0: any that is free.")] = 8765,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Print the address, and open no browser.")
    ] = False,
) -> None:
    """Drive the robot in a browser, drag people, and swap policies while it drives."""
    from hazbot_gym.live import launch

    launch.play(launch.settings_of(link, env=env, policy=policy), port, opens=not no_browser)


@app.command()
def export(
    policy: PolicySpec,
    format: Annotated[str, typer.Option(help="onnx, or c: C99 for a microcontroller.")],
    out: Annotated[Path, typer.Option(help="Folder of the files.")],
    tier: Annotated[
        str | None, typer.Option(help="Tier of the observations; default the policy's, or tracks.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that exist.")] = False,
) -> None:
    """Export a policy for a robot's own software, with golden vectors."""
    from hazbot_gym.export.write import export as write_export

    files = write_export(policy, format, out, tier=tier, overwrite=force)
    for file in files:
        terminal.output_console().print(f"{file.stat().st_size:>9,} bytes  {file}", soft_wrap=True)
