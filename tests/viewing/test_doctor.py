from importlib.metadata import version

import pytest

from handsim.viewing import doctor as doctor_module
from handsim.viewing.doctor import can_render, doctor
from handsim.viewing.opengl.backend import ProbeResult


def with_backends(monkeypatch: pytest.MonkeyPatch, *working: str) -> None:
    def probe(backend: str, seconds: float) -> ProbeResult:
        if backend in working:
            return ProbeResult(backend, True, "llvmpipe", 123.4)
        return ProbeResult(backend, False, reason="no library")

    monkeypatch.setattr(doctor_module, "probe", probe)


def test_rows_name_versions_drivers_and_remedies(monkeypatch: pytest.MonkeyPatch) -> None:
    with_backends(monkeypatch, "osmesa")
    rows = {row.name: row for row in doctor()}
    assert rows["mujoco"].detail == version("mujoco")
    assert rows["gl osmesa"].ok
    assert "llvmpipe, 123 frames/s" in rows["gl osmesa"].detail
    assert not rows["gl egl"].ok
    assert rows["gl egl"].detail == "no library"
    assert "install" in rows["gl egl"].remedy
    assert rows["ffmpeg"].ok
    assert all(row.ok or row.remedy for row in rows.values())


@pytest.mark.parametrize(
    ("working", "enough"), [(("egl",), True), (("osmesa",), True), ((), False)]
)
def test_one_backend_is_enough(
    monkeypatch: pytest.MonkeyPatch, working: tuple[str, ...], enough: bool
) -> None:
    with_backends(monkeypatch, *working)
    assert can_render(doctor()) is enough


def test_without_an_encoder_no_video_can_be_made(monkeypatch: pytest.MonkeyPatch) -> None:
    with_backends(monkeypatch, "egl")
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/nowhere/ffmpeg")
    findings = doctor()
    assert not can_render(findings)
    assert findings[-1].remedy.startswith("pip install")


def test_a_package_that_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    with_backends(monkeypatch)
    monkeypatch.setattr(doctor_module, "PACKAGES", ("no-such-package",))
    row = next(row for row in doctor() if row.name == "no-such-package")
    assert not row.ok
    assert row.remedy == "pip install no-such-package"
