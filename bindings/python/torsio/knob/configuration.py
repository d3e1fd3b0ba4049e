"""A knob's configurations, read and changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

from torsio import _torsio
from torsio.common import checks
from torsio.errors import Error
from torsio.knob.recording import KnobRecording
from torsio.printed.config import CONFIGS, Config

if TYPE_CHECKING:
    from torsio.knob import Knob

__all__ = ["KnobConfiguration", "put_back"]

_Config = TypeVar("_Config", bound=Config)

_NAMES: Final[dict[type, str]] = {config: f"{name}_config" for name, config in CONFIGS.items()}
_CONFIG_OF: Final = {field.name: config for config in CONFIGS.values() for field in fields(config)}
assert len(_CONFIG_OF) == sum(len(fields(c)) for c in CONFIGS.values()), "a name has two meanings"


class KnobConfiguration:
    """The part that a `torsio.Knob` has for its configurations."""

    def __init__(self, knob: _torsio.Knob, recording: KnobRecording) -> None:
        self._knob = knob
        self._recording = recording

    def ask(self, kind: type[_Config]) -> _Config:
        """Ask the device for one of `torsio.CONFIGS`: ``knob.config(torsio.ControlConfig)``."""
        if kind not in CONFIGS.values():
            names = ", ".join(f"torsio.{config.__name__}" for config in CONFIGS.values())
            raise TypeError(f"kind must be one of {names}, is {checks.show(kind)}")
        make: Callable[..., _Config] = kind
        return make(**self._knob.config(_NAMES[kind]))

    def configure(self, config: Config) -> None:
        """Set a whole configuration while disarmed.

        Fields that you leave out get their defaults, whatever the device had; `update`
        keeps them. Another encoder's resolution also empties the scene. A saved wiring of the board
        takes effect when the device starts the next time.

        Raises
        ------
        InvalidArgument
            Names field, value and range.
        Refused
            Unless disarmed.
        """
        if type(config) not in _NAMES:
            raise TypeError(
                f"not a configuration: {checks.show(config)}; give torsio.ControlConfig(...)"
            )
        self._knob.configure(_NAMES[type(config)], config)
        self._recording.note("configure", config=config)

    def update(self, /, **changes: Any) -> None:
        """Change fields of a configuration while disarmed, and keep the rest.

        Parameters
        ----------
        changes
            Fields of one of `torsio.CONFIGS`, as in
            ``knob.update(law="compensated", speed_limit_rad_s=40.0)``.

        Raises
        ------
        TypeError
            If no configuration has such a field, or not all are of the same one.
        InvalidArgument, Refused
            As in `configure`; nothing was changed.
        """
        configs = {_config_of(name): name for name in changes}
        if not configs:
            raise TypeError("update() needs a field to change, such as law='compensated'")
        if len(configs) > 1:
            places = " and ".join(f"{name} of {kind.__name__}" for kind, name in configs.items())
            raise TypeError(f"update() changes one configuration at a time, not {places}")
        config = next(iter(configs))
        self.configure(replace(self.ask(config), **changes))

    def dump(self) -> str:
        """Give all of them as `torsio.dump_config` does."""
        return self._knob.dump_config()

    def load(self, text: str) -> None:
        """Set what a text has, as `torsio.load_config` does."""
        self._knob.load_config(text)
        if self._recording.is_under_way:
            for config in self.all():
                self._recording.note("configure", config=config)

    def all(self) -> tuple[Config, ...]:
        """Ask the device for each."""
        return tuple(map(self.ask, CONFIGS.values()))

    def save(self) -> None:
        """Keep the configuration over power-off. Returns when it is safe."""
        self._knob.save()

    def load_defaults(self) -> None:
        """Take the configuration of a new device. Raises `Refused` unless disarmed."""
        self._knob.load_defaults()


def _config_of(name: str) -> type[Config]:
    """Give the configuration that has a field of this name."""
    if name in _CONFIG_OF:
        return _CONFIG_OF[name]
    raise TypeError(checks.no_field(name, CONFIGS.values()))


def put_back(knob: Knob, config: Config, what: str) -> None:
    """Configure a knob as before something. Raises `Error`, in a sentence for people."""
    try:
        knob.configure(config)
    except Error as error:
        raise Error(
            f"the {type(config).__name__} from before {what} could not be restored ({error}); "
            "unplug the knob, or configure it, before you use it"
        ) from error
