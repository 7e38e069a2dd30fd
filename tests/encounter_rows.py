"""Encounters of people with a robot, as rows of a file."""

from __future__ import annotations

from pathlib import Path

HEAD = "scene,scenario,robot,behaviour,encounter,t_s,agent,x_m,y_m,yaw_rad\n"


def rows(
    *,
    scene: int = 1,
    encounter: int = 1,
    robot: str = "hsr",
    steps: int = 60,
    lateral_m: float = 0.6,
) -> list[str]:
    """Return the rows of a robot and a person who pass each other."""
    front = f"{scene},frontal,{robot},compliant,{encounter}"
    found = []
    for k in range(steps):
        t = 0.1 * k
        found.append(f"{front},{t:.2f},robot,{0.5 * t:.3f},0.000,0.000")
        found.append(f"{front},{t:.2f},1,{6.0 - 1.2 * t:.3f},{lateral_m:.3f},")
    return found


def written(path: Path, lines: list[str], head: str = HEAD) -> Path:
    path.write_text(head + "\n".join(lines) + "\n")
    return path
