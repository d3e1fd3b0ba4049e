"""Scenes, local models and experiments of a knob."""

from __future__ import annotations

from collections.abc import Iterable, Sized
from itertools import islice

from torsio import _torsio
from torsio.common import checks
from torsio.errors import StiffnessWarning
from torsio.knob.recording import KnobRecording
from torsio.knob.warnings import unlikely, warn
from torsio.printed.scenes import Effect, Excitation, Scene
from torsio.printed.told import Limits, StableStiffness

__all__ = ["KnobScenes"]

_MAX_EFFECTS = 16


class KnobScenes:
    """The part that a `torsio.Knob` has for what it plays."""

    def __init__(self, knob: _torsio.Knob, recording: KnobRecording) -> None:
        self._knob = knob
        self._recording = recording

    def play(self, scene: Scene) -> None:
        """Play a scene in place of the one before, all of it from the same tick on.

        Parameters
        ----------
        scene
            One effect, or an iterable of up to 16. An effect with the same place and the same
            values as before goes on playing. Any other starts anew. The knob must be armed to be
            felt.

        Raises
        ------
        InvalidArgument
            Names effect, field, value and range; nothing was sent and the old scene goes on.
        Refused
            The device said no; the old scene goes on.

        Warns
        -----
        StiffnessWarning
            The scene plays, but a free knob may swing in it for ever, or one that is leant on may
            hum. Together its effects are too stiff, damp too much, have too much inertia, or
            switch too much within a count. ``"calibrated"`` bounds what depends on the angle, but
            not if you change the same effects four times in a row.
        SceneWarning
            It plays; a torque is more than the knob gives, or an angle may be meant in degrees.

        Notes
        -----
        A wall that keeps moving, and a streamed spring that does, may swing. Keep them below a
        quarter of `stable_stiffness`, and move them slower than a hand moves.
        """
        if isinstance(scene, Effect):
            effects = [scene]
        else:
            if isinstance(scene, Iterable) and not isinstance(scene, Sized):
                # It may have no end: one effect too many is enough to refuse it.
                scene = list(islice(scene, _MAX_EFFECTS + 1))
            effects = list(scene) if isinstance(scene, Iterable) else [scene]
        swings, is_disarmed = self._knob.play(scene)
        self._recording.played(effects, is_disarmed=is_disarmed)
        if swings:
            warn(StiffnessWarning(swings))
        for odd in unlikely(effects, lambda: Limits(**self._knob.limits())):
            warn(odd)

    def stable_stiffness(self) -> StableStiffness:
        """Ask how stiff a spring the knob's parts can render, by its configuration.

        Beyond that the knob may swing for ever in a spring or wall, at the motor's full torque,
        unless the law is ``"calibrated"``. One that is leant on may hum from half of it on. It
        includes a board's current loop, its supply and the encoder's steps. It trusts the
        configuration. `torsio.stability` has the map over damping.
        """
        return StableStiffness(**self._knob.stable_stiffness())

    def stream_local_model(
        self,
        *,
        torque_nm: float = 0.0,
        angle_rad: float = 0.0,
        stiffness_nm_per_rad: float = 0.0,
        damping_nm_s_per_rad: float = 0.0,
        deadline_s: float = 0.02,
    ) -> None:
        """Send a torque, a spring and a damper for the device to render at its own rate.

        They act on top of the scene until the next ones come. Does not wait for the device,
        except that a first stiff model asks for its configuration. Past the deadline the device
        fails passive. A deadline of 0 ends the stream in good order.

        Raises
        ------
        Refused
            If the knob is known not to be armed. A later refusal by the device only counts in
            :meth:`statistics`.

        Warns
        -----
        StiffnessWarning
            As `play` does, of model and scene together; for a model that is stiffer or damps more
            than all since the scene began. It takes the model for one that you move, which no law
            bounds.
        """
        swings = self._knob.stream_local_model(
            checks.number("torque_nm", torque_nm),
            checks.number("angle_rad", angle_rad),
            checks.number("stiffness_nm_per_rad", stiffness_nm_per_rad),
            checks.number("damping_nm_s_per_rad", damping_nm_s_per_rad),
            checks.number("deadline_s", deadline_s),
        )
        if swings:
            warn(StiffnessWarning(swings))

    def excite(self, excitation: Excitation) -> None:
        """Play a bounded experiment in place of scene and law: commands of motor and brake.

        The next one goes on from where this one is; whatever leaves its bounds, or comes to its
        end, disarms. For calibration.

        Raises
        ------
        InvalidArgument
            Names field, value and range.
        Refused
            Unless armed by this library.
        """
        checks.kind("excitation", excitation, Excitation, "a torsio.Excitation")
        self._knob.excite(excitation)
