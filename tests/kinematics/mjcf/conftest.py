import pytest

from bladesmith.kinematics import load_mjcf


@pytest.fixture
def load(tmp_path):
    def loaded(text, *arguments, **options):
        path = tmp_path / "robot.xml"
        path.write_text(text)
        return load_mjcf(path, *arguments, **options)

    return loaded
