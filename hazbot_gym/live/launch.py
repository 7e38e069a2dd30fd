"""Start of the server: from options to a page in the browser."""

from __future__ import annotations

import urllib.parse
import webbrowser
from collections.abc import Mapping

from pydantic import ValidationError

from hazbot_gym.config.section import first_error
from hazbot_gym.errors import InvalidInput
from hazbot_gym.live import server
from hazbot_gym.live.policies import Policies
from hazbot_gym.live.settings import Settings
from hazbot_gym.utils.terminal import output_console
from hazbot_gym.utils.yaml_loader import parse_yaml


def settings_of(
    link: str | None = None, *, env: str | None = None, policy: str | None = None
) -> Settings:
    """Return the settings of a link, and of options, which prevail.

    Raises:
        InvalidInput: The link or an option cannot be used.
    """
    words = dict(urllib.parse.parse_qsl((link or "").partition("?")[2] or (link or "")))
    words |= {name: value for name, value in (("env", env), ("policy", policy)) if value}
    are_words = {name for name, value in Settings() if isinstance(value, str)}
    values = {
        name: text if name in are_words else parse_yaml(text, f"link: {name}")
        for name, text in words.items()
    }
    try:
        return Settings.model_validate(values)
    except ValidationError as error:
        raise InvalidInput(first_error(error, Settings)) from None


def link_of(settings: Settings) -> str:
    """Return the part of a link behind its question mark."""
    unusual: Mapping[str, object] = settings.model_dump(exclude_defaults=True)
    return urllib.parse.urlencode(unusual)


def play(settings: Settings, port: int, *, opens: bool) -> None:
    """Serve the page until interrupted.

    Args:
        settings: Of the first run.
        port: On this machine; 0 is any that is free.
        opens: Whether to open the browser.

    Raises:
        InvalidInput: The port is in use, or the settings cannot be used.
    """
    policies = Policies(settings.policy, settings.ghost)
    listening = server.listen(port)
    with listening:
        server.warm_up(policies, settings)
        live = server.Live(policies, listening.getsockname()[1])
        address = server.address(live, listening, link_of(settings))
        output_console().print(f"Drive at {address}", soft_wrap=True)
        output_console().print("The address is secret. Ctrl+C stops.")
        if opens:
            webbrowser.open(address)
        server.server_of(live).run(sockets=[listening])
