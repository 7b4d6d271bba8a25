"""A flight as one HTML file that opens anywhere. Why: a replay is sent to people who have nothing installed, so the
viewer is inside it and nothing is fetched.
"""

from __future__ import annotations

from itertools import pairwise

from halfroll.viewer.moments import Recording
from halfroll.viewer.replay_figures import with_figures
from halfroll.viewer.server import LocalServer
from halfroll.viewer.stage import Stage

FRAMES_HZ, LONGEST_FRAMES = 25.0, 3000


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
        stage.show(frames.moments[0])
        recorder = server.get_scene_serializer()
        for moment, after in pairwise(frames.moments):
            stage.show(moment)
            recorder.insert_sleep(max(after.t_s - moment.t_s, 0.0))
        stage.show(frames.moments[-1])
        return with_figures(recorder.as_html(dark_mode=dark), recording.setting, frames.moments, dark)
    finally:
        server.stop()
