"""A flight as one HTML file that opens anywhere. Why: a replay is sent to people who have nothing installed, so the
viewer is inside it and nothing is fetched.
"""

from __future__ import annotations

from itertools import pairwise

from halfroll.viewer.moments import Moment, Recording
from halfroll.viewer.server import LocalServer
from halfroll.viewer.stage import Stage

FRAMES_HZ, LONGEST_FRAMES = 25.0, 3000
_WORDS_EVERY = 5  # frames


def replay_html(recording: Recording, dark: bool = False) -> str:
    """The whole flight, at FRAMES_HZ or, where it is long, in LONGEST_FRAMES."""
    first_s, last_s = recording.span
    rate_Hz = min(FRAMES_HZ, LONGEST_FRAMES / max(last_s - first_s, 1e-3))
    frames = recording.thinned(rate_Hz)
    server = LocalServer(port=0)
    try:
        stage = Stage(server.scene, recording.setting)
        stage.trace(recording.thinned(20.0).moments)
        camera, (place, middle) = server.initial_camera, recording.setting.seat
        camera.position, camera.look_at, camera.up = tuple(place), tuple(middle), (0.0, 0.0, 1.0)
        words = server.scene.add_label("/vehicle/words", "", anchor="bottom-left", font_screen_scale=0.9)
        stage.show(frames.moments[0])
        recorder = server.get_scene_serializer()
        for number, (moment, after) in enumerate(pairwise(frames.moments)):
            stage.show(moment)
            if number % _WORDS_EVERY == 0:
                words.text = words_of(moment)
            recorder.insert_sleep(max(after.t_s - moment.t_s, 0.0))
        stage.show(frames.moments[-1])
        words.text = words_of(frames.moments[-1])
        return recorder.as_html(dark_mode=dark)
    finally:
        server.stop()


def words_of(moment: Moment) -> str:
    words = [f"{moment.t_s:.1f} s", moment.mode, f"{moment.speed:.1f} m/s"]
    if moment.error_m is not None:
        words.append(f"{1e3 * moment.error_m:.0f} mm off")
    return "  ".join(word for word in words if word)
